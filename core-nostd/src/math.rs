//! The only door to `sin`, `cos`, `tan`, `atan2`, `sqrt` and rounding.
//!
//! Everything but the square root goes to `libm` in single precision on every machine. The standard library's functions
//! differ from one platform to the next in the last bit, and micromath's error (1e-3) would move source pixels by 1.7 px;
//! libm is good to 3e-8 and the remap needs only a handful of calls a frame.
//!
//! Functions called `approximate` are micromath's: software too, the same bits everywhere, several times as quick. They are for
//! where an error of 2e-3 cannot matter, and never on the way of a coordinate or a covariance.

/// Sine and cosine of an angle in radians.
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    (libm::sinf(angle_rad), libm::cosf(angle_rad))
}

/// Sine and cosine of an angle within ±1000 rad, either off by at most [`APPROXIMATE_SIN_COS`].
pub fn approximate_sin_cos(angle_rad: f32) -> (f32, f32) {
    let (sin, cos) = micromath::F32(angle_rad).sin_cos();
    (sin.0, cos.0)
}

/// Most that [`approximate_sin_cos`] is off; measured against double precision by a test, within ±1000 rad.
pub const APPROXIMATE_SIN_COS: f32 = 1.2e-3;

/// Angle of the vector (`x`, `y`), off by at most [`APPROXIMATE_ATAN2`] radians.
pub fn approximate_atan2(y: f32, x: f32) -> f32 {
    micromath::F32(y).atan2(micromath::F32(x)).0
}

/// Most that [`approximate_atan2`] is off, radians; measured against double precision by a test.
pub const APPROXIMATE_ATAN2: f32 = 2.9e-3;

/// Tangent of an angle in radians.
pub fn tan(angle_rad: f32) -> f32 {
    libm::tanf(angle_rad)
}

/// Angle of the vector (`x`, `y`), in (−π, π].
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Arc sine, argument clamped to [−1, 1] so that rounding cannot make a NaN of a vertical nose.
pub fn asin(sine: f32) -> f32 {
    libm::asinf(sine.clamp(-1.0, 1.0))
}

/// Square root; negative arguments give NaN, as in IEEE 754. Correctly rounded, so that the machine's own instruction
/// gives the same bits.
pub fn sqrt(value: f32) -> f32 {
    crate::arch::sqrt(value)
}

/// Length of the vector (`a`, `b`): of two independent sigmas, the sigma of their sum.
pub fn hypot(a: f32, b: f32) -> f32 {
    sqrt(squared(a) + squared(b))
}

/// Sigma of the sum of two independent errors; exactly `sigma` if the other is 0.
pub fn combined_sigma(sigma: f32, other: f32) -> f32 {
    if other > 0.0 { hypot(sigma, other) } else { sigma }
}

/// `x` times itself.
pub fn squared(x: f32) -> f32 {
    x * x
}

/// Nearest integer, halves away from zero.
pub fn round(value: f32) -> f32 {
    libm::roundf(value)
}

/// Largest integer not above `value`.
pub fn floor(value: f32) -> f32 {
    libm::floorf(value)
}

/// Smallest integer not below `value`.
pub fn ceil(value: f32) -> f32 {
    libm::ceilf(value)
}

/// Natural logarithm.
pub fn ln(value: f32) -> f32 {
    libm::logf(value)
}

/// Exponential function.
pub fn exp(value: f32) -> f32 {
    libm::expf(value)
}

#[cfg(test)]
mod tests {
    use super::{APPROXIMATE_ATAN2, APPROXIMATE_SIN_COS, approximate_atan2, approximate_sin_cos};
    use std::println;

    #[test]
    fn approximate_sines_are_off_by_no_more_than_they_say() {
        let mut worst = 0.0f64;
        for step in -2_000_000..=2_000_000i32 {
            let angle = 5e-4 * step as f32;
            let (sin, cos) = approximate_sin_cos(angle);
            let (exact_sin, exact_cos) = f64::from(angle).sin_cos();
            worst = worst.max((f64::from(sin) - exact_sin).abs()).max((f64::from(cos) - exact_cos).abs());
        }
        println!("sine and cosine: at most {worst:.6} off");
        let bound = f64::from(APPROXIMATE_SIN_COS);
        assert!(worst <= bound && worst > 0.8 * bound, "{worst}");
    }

    #[test]
    fn an_approximate_direction_is_off_by_no_more_than_it_says() {
        let mut worst = 0.0f64;
        for step in 0..4_000_000 {
            let exact = core::f64::consts::TAU * (f64::from(step) / 4e6 - 0.5);
            for length in [1e-3, 1.0, 500.0] {
                let (y, x) = ((length * exact.sin()) as f32, (length * exact.cos()) as f32);
                let off = f64::from(approximate_atan2(y, x)) - f64::from(y).atan2(f64::from(x));
                // Half a turn either way is the same direction.
                let off = off - core::f64::consts::TAU * (off / core::f64::consts::TAU).round();
                worst = worst.max(off.abs());
            }
        }
        println!("direction: at most {worst:.6} rad off");
        let bound = f64::from(APPROXIMATE_ATAN2);
        assert!(worst <= bound && worst > 0.8 * bound, "{worst}");
    }
}
