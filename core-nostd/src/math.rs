//! The only door to `sin`, `cos`, `tan`, `atan2`, `sqrt` and rounding.
//!
//! Everything but the square root goes to `libm` in single precision on every machine. The standard library's functions
//! differ from one platform to the next in the last bit, and micromath's error (1e-3) would move source pixels by 1.7 px;
//! libm is good to 3e-8 and the remap needs only a handful of calls a frame.

/// Sine and cosine of an angle in radians.
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    (libm::sinf(angle_rad), libm::cosf(angle_rad))
}

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
