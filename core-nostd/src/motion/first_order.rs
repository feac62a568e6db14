//! Image motion as paper 000 has it: eq. 21 to 25, to first order in the residual angles of a stabilised camera.
//!
//! Axes of the paper: x across, y along the flight, z up; R = Rφ Rω Rκ from image to ground, the flight along Y. Its
//! angular rates on the camera's axes are (ω' cκ − φ' cω sκ, −ω' sκ − φ' cω cκ, κ' + φ' sω) about (x, y, z). Put into
//! the exact derivative of module [`motion`](super), with 1/d = (c3 − c1 x/f − c2 y/f)/H and the velocity (b1, b2, b3)
//! V, this gives eq. 21 when products of two or more of φ, ω, κ are dropped; nothing of x/f and y/f is. What eq. 21
//! drops besides is the second order in time. Beyond some degrees of tilt use [`Flow`](super::Flow).
//!
//! Corrected against the paper: (1,1) of R_v is −f − x²/f (eq. 24 prints −f, which costs 0.003 px RMS in its own
//! example), the vector of R_ωv holds the nine products of angles and rates, and every term carries the time.

/// Stabilised camera in steady flight. Radians, metres and seconds; lengths on the image plane have one unit of the
/// caller's choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stabilised {
    /// Residual angles φ, ω, κ.
    pub angles: [f32; 3],
    /// Their rates.
    pub rates: [f32; 3],
    /// V/H_A, 1/s.
    pub velocity_per_height: f32,
    /// Principal distance f.
    pub focal: f32,
}

impl Stabilised {
    /// Corrected eq. 21: displacement (ex, ey) in `exposure_s` of the image point (`x`, `y`).
    pub fn displacement(&self, x: f32, y: f32, exposure_s: f32) -> (f32, f32) {
        let ([p, w, k], [dp, dw, dk]) = (self.angles, self.rates);
        let (f, v) = (self.focal, self.velocity_per_height);
        let (xx, xy, yy) = (x * x / f, x * y / f, y * y / f);
        let across =
            y * w * dp + xy * k * dp - (f + xx) * k * dw + v * (x * w - f * k) - (f + xx) * dp - xy * dw + y * dk;
        let along = -x * w * dp + (f + yy) * k * dp - xy * k * dw + v * (x * p + 2.0 * y * w)
            - xy * dp
            - (f + yy) * dw
            - x * dk
            - f * v;
        (across * exposure_s, along * exposure_s)
    }
}
