//! Eq. 1 and 5 of paper 003: from heading, pitch, roll and follow-up angle to the rotation, and to the two equivalent
//! angles.

/// A 3 x 3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];

/// Eq. 1: the rotation A from the ground frame (north, up, east) to the camera frame (forward, up, right),
/// `v_m = A v_b`. Angles in radians.
///
/// A = RY(follow-up) RX(roll) RZ(pitch) RY'(heading). The paper prints cos theta and sin theta in the second matrix;
/// its text names the roll there, and as printed the roll would occur nowhere. Heading and follow-up have opposite
/// signs in the paper and here: heading is clockwise from north, the follow-up angle counter-clockwise.
pub fn matrix_a(heading_rad: f64, pitch_rad: f64, roll_rad: f64, follow_up_rad: f64) -> Matrix3 {
    let (sb, cb) = follow_up_rad.sin_cos();
    let (sg, cg) = roll_rad.sin_cos();
    let (st, ct) = pitch_rad.sin_cos();
    let (sp, cp) = heading_rad.sin_cos();
    let by_follow_up = [[cb, 0.0, -sb], [0.0, 1.0, 0.0], [sb, 0.0, cb]];
    let by_roll = [[1.0, 0.0, 0.0], [0.0, cg, sg], [0.0, -sg, cg]];
    let by_pitch = [[ct, st, 0.0], [-st, ct, 0.0], [0.0, 0.0, 1.0]];
    let by_heading = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    product(&by_follow_up, &product(&by_roll, &product(&by_pitch, &by_heading)))
}

/// The follow-up angle that a perfect servo takes, in radians within (-pi, pi]: it makes a13 = 0 with a11 > 0.
///
/// The paper says beta = phi, which is true at level flight only (1.7 degrees off at 10 degrees of tilt).
pub fn follow_up_exact(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> f64 {
    let (sg, cg) = roll_rad.sin_cos();
    let (st, ct) = pitch_rad.sin_cos();
    let (sp, cp) = heading_rad.sin_cos();
    (ct * sp).atan2(cg * cp + sg * st * sp)
}

/// Eq. 5: equivalent pitch and equivalent roll in radians, under the exact follow-up angle.
///
/// With a13 = 0, A is RX(equivalent roll) RZ(equivalent pitch) exactly, not only for small angles.
pub fn equivalent_pitch_roll(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> (f64, f64) {
    let (sb, cb) = follow_up_exact(heading_rad, pitch_rad, roll_rad).sin_cos();
    let (sg, cg) = roll_rad.sin_cos();
    let (st, ct) = pitch_rad.sin_cos();
    let (sp, cp) = heading_rad.sin_cos();
    let equivalent_pitch_rad = (st * cb + ct * sg * sb).asin();
    let equivalent_roll_rad = (sg * cp - cg * st * sp).atan2(ct * cg / equivalent_pitch_rad.cos());
    (equivalent_pitch_rad, equivalent_roll_rad)
}

pub(super) fn product(a: &Matrix3, b: &Matrix3) -> Matrix3 {
    let mut c = [[0.0; 3]; 3];
    for (row, line) in c.iter_mut().enumerate() {
        for (col, value) in line.iter_mut().enumerate() {
            *value = (0..3).map(|k| a[row][k] * b[k][col]).sum();
        }
    }
    c
}

pub(super) fn transpose(a: &Matrix3) -> Matrix3 {
    let [[a11, a12, a13], [a21, a22, a23], [a31, a32, a33]] = *a;
    [[a11, a21, a31], [a12, a22, a32], [a13, a23, a33]]
}

pub(super) fn apply(a: &Matrix3, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}
