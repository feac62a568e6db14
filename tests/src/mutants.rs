//! Known-wrong variants of the equations, in plain `f64`: the paper's misprints as printed, and the mistakes that are
//! easily made. A golden test that one of them passes is worth nothing.
//!
//! Angles are radians, `m`, `n` pixels from the centre (right, forward), `k_h`, `k_v` tangents per pixel.

/// A 3 x 3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];
/// (m, n) or (m', n').
pub type Pixel = (f64, f64);
/// heading, pitch, roll, follow-up angle -> the rotation of eq. 1.
pub type MatrixOfAttitude = fn(f64, f64, f64, f64) -> Matrix3;
/// heading, pitch, roll -> follow-up angle, equivalent pitch, equivalent roll.
pub type FollowUp = fn(f64, f64, f64) -> [f64; 3];
/// Equivalent pitch, equivalent roll, k, (m, n), (m0, n0) -> (m', n').
pub type Simplified = fn(f64, f64, f64, Pixel, Pixel) -> Pixel;
/// Ticks of shutter open and close -> tick of mid-exposure.
pub type Stamp = fn(u32, u32) -> u32;

/// Every wrong eq. 1, by name.
pub const MATRICES: [(&str, MatrixOfAttitude); 5] = [
    ("eq. 1 with the printed second matrix", matrix_printed),
    ("pitch and roll exchanged", matrix_pitch_roll_swapped),
    ("roll sign wrong", matrix_roll_negated),
    ("heading counter-clockwise", matrix_heading_negated),
    ("follow-up angle clockwise", matrix_follow_up_negated),
];

/// Every wrong eq. 5, by name.
pub const FOLLOW_UPS: [(&str, FollowUp); 3] = [
    ("(a) first-order equivalent angles", follow_up_first_order),
    ("(b) beta = phi", follow_up_is_heading),
    ("(a) and (b)", follow_up_both),
];

/// Every wrong eq. 7, by name.
pub const EQ7: [(&str, Simplified); 3] = [
    ("eq. 7 as printed", eq7_printed),
    ("eq. 7 with m a11", eq7_m_a11),
    ("eq. 7 with the printed sign", eq7_printed_sign),
];

/// Every wrong stamp, by name.
pub const STAMPS: [(&str, Stamp); 3] = [
    ("start of the exposure", mid_exposure_is_start),
    ("end of the exposure", mid_exposure_is_stop),
    ("mean of both ticks", mid_exposure_mean),
];

/// Eq. 3 as printed: without the minus in front of the fraction.
pub fn eq3_printed(a: &Matrix3, (k_h, k_v): Pixel, (m, n): Pixel, (m0, n0): Pixel) -> Pixel {
    let den = m * k_h * a[1][2] + n * k_v * a[1][0] - a[1][1];
    let m_frame = (m * a[2][2] + n * k_v / k_h * a[2][0] - a[2][1] / k_h) / den + m0;
    let n_frame = (m * k_h / k_v * a[0][2] + n * a[0][0] - a[0][1] / k_v) / den + n0;
    (m_frame, n_frame)
}

/// Eq. 7 as printed: without the minus, and with `m a11` for `n a11`.
pub fn eq7_printed(pitch: f64, roll: f64, k: f64, (m, n): Pixel, (m0, n0): Pixel) -> Pixel {
    let (m_frame, n_frame) = eq7_m_a11(pitch, roll, k, (m, n), (0.0, 0.0));
    (-m_frame + m0, -n_frame + n0)
}

/// Eq. 7 with its sign mended, but with `m a11` for `n a11`.
pub fn eq7_m_a11(pitch: f64, roll: f64, k: f64, (m, n): Pixel, (m0, n0): Pixel) -> Pixel {
    let (st, ct) = pitch.sin_cos();
    let (sg, cg) = roll.sin_cos();
    let den = cg * ct - m * k * sg + n * k * cg * st;
    ((m * cg + n * sg * st + sg * ct / k) / den + m0, (m * ct - st / k) / den + n0)
}

/// Eq. 7 with its `m a11` mended, but without the minus in front of the fraction.
pub fn eq7_printed_sign(pitch: f64, roll: f64, k: f64, (m, n): Pixel, (m0, n0): Pixel) -> Pixel {
    let (st, ct) = pitch.sin_cos();
    let (sg, cg) = roll.sin_cos();
    let den = m * k * sg - n * k * cg * st - cg * ct;
    ((m * cg + n * sg * st + sg * ct / k) / den + m0, (n * ct - st / k) / den + n0)
}

/// Eq. 1 as printed: the second matrix holds the pitch, and the roll occurs nowhere.
pub fn matrix_printed(heading: f64, pitch: f64, _roll: f64, follow_up: f64) -> Matrix3 {
    matrix(heading, pitch, pitch, follow_up)
}

/// Pitch taken for roll and roll for pitch.
pub fn matrix_pitch_roll_swapped(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Matrix3 {
    matrix(heading, roll, pitch, follow_up)
}

/// Roll positive with the LEFT wing down.
pub fn matrix_roll_negated(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Matrix3 {
    matrix(heading, pitch, -roll, follow_up)
}

/// Heading counted like the follow-up angle.
pub fn matrix_heading_negated(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Matrix3 {
    matrix(-heading, pitch, roll, follow_up)
}

/// Follow-up angle counted like the heading.
pub fn matrix_follow_up_negated(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Matrix3 {
    matrix(heading, pitch, roll, -follow_up)
}

/// theta1 = theta cos phi + gamma sin phi, gamma1 = gamma cos phi - theta sin phi; the follow-up angle exact.
pub fn follow_up_first_order(heading: f64, pitch: f64, roll: f64) -> [f64; 3] {
    let (sp, cp) = heading.sin_cos();
    let follow_up = (pitch.cos() * sp).atan2(roll.cos() * cp + roll.sin() * pitch.sin() * sp);
    [follow_up, pitch * cp + roll * sp, roll * cp - pitch * sp]
}

/// beta = phi, and eq. 5 with that beta.
pub fn follow_up_is_heading(heading: f64, pitch: f64, roll: f64) -> [f64; 3] {
    let (sp, cp) = heading.sin_cos();
    let equivalent_pitch = (pitch.sin() * cp + pitch.cos() * roll.sin() * sp).asin();
    let across = roll.sin() * cp - roll.cos() * pitch.sin() * sp;
    [heading, equivalent_pitch, across.atan2(pitch.cos() * roll.cos() / equivalent_pitch.cos())]
}

/// beta = phi, and the first-order angles.
pub fn follow_up_both(heading: f64, pitch: f64, roll: f64) -> [f64; 3] {
    let [_, equivalent_pitch, equivalent_roll] = follow_up_first_order(heading, pitch, roll);
    [heading, equivalent_pitch, equivalent_roll]
}

/// The start of the exposure for its middle.
pub fn mid_exposure_is_start(start: u32, _stop: u32) -> u32 {
    start
}

/// The end of the exposure for its middle.
pub fn mid_exposure_is_stop(_start: u32, stop: u32) -> u32 {
    stop
}

/// The mean of both ticks, which is wrong across the counter's wrap.
pub fn mid_exposure_mean(start: u32, stop: u32) -> u32 {
    u32::midpoint(start, stop)
}

/// Attitude linearly in each angle, the heading the long way round across north.
pub fn attitude_long_way(from: [f64; 3], to: [f64; 3], u: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| from[i] + u * (to[i] - from[i]))
}

/// Eq. 1 corrected, multiplied out: the ground that the mutants stand on.
fn matrix(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Matrix3 {
    let (sp, cp) = heading.sin_cos();
    let (st, ct) = pitch.sin_cos();
    let (sg, cg) = roll.sin_cos();
    let (sb, cb) = follow_up.sin_cos();
    let level = [
        [ct * cp, st, ct * sp],
        [-cg * st * cp - sg * sp, cg * ct, -cg * st * sp + sg * cp],
        [sg * st * cp - cg * sp, -sg * ct, sg * st * sp + cg * cp],
    ];
    let turned = |i: usize| [cb * level[0][i] - sb * level[2][i], level[1][i], sb * level[0][i] + cb * level[2][i]];
    let columns = [turned(0), turned(1), turned(2)];
    [0, 1, 2].map(|row| [0, 1, 2].map(|col| columns[col][row]))
}

/// Wrong terms of eq. 21, by name: (x, y), angles, rates, V/HA, f -> displacement a second.
pub type Motion = fn([f64; 2], [f64; 3], [f64; 3], f64, f64) -> [f64; 2];

/// Every wrong eq. 21, by name.
pub const EQ21: [(&str, Motion); 3] = [
    ("eq. 24 with the printed (1,1)", eq24_printed),
    ("eq. 21 with the printed rate vector", eq21_printed_rates),
    ("forward motion backwards", eq25_negated),
];

/// Eq. 24 as printed: -f for -f - x^2/f.
pub fn eq24_printed([x, y]: [f64; 2], angles: [f64; 3], rates: [f64; 3], v: f64, f: f64) -> [f64; 2] {
    let [ex, ey] = eq21([x, y], angles, rates, v, f);
    [ex + x * x / f * rates[0], ey]
}

/// Eq. 21 as printed: the vector behind R_wv holds rates instead of products.
pub fn eq21_printed_rates([x, y]: [f64; 2], angles: [f64; 3], rates: [f64; 3], v: f64, f: f64) -> [f64; 2] {
    let [_, dw, dk] = rates;
    let [ex, ey] = eq21([x, y], [0.0; 3], rates, v, f);
    let [p, w, k] = angles;
    let by_rates = [y * dw + x * y / f * dk - (f + x * x / f) * dk, -x * dw + (f + y * y / f) * dk - x * y / f * dk];
    [ex + by_rates[0] + v * (x * w - f * k), ey + by_rates[1] + v * (x * p + 2.0 * y * w)]
}

/// Eq. 25 with its sign wrong.
pub fn eq25_negated([x, y]: [f64; 2], angles: [f64; 3], rates: [f64; 3], v: f64, f: f64) -> [f64; 2] {
    let [ex, ey] = eq21([x, y], angles, rates, v, f);
    [ex, ey + 2.0 * f * v]
}

/// Right, as a base for the wrong ones.
fn eq21([x, y]: [f64; 2], [p, w, k]: [f64; 3], [dp, dw, dk]: [f64; 3], v: f64, f: f64) -> [f64; 2] {
    let (xx, xy, yy) = (f + x * x / f, x * y / f, f + y * y / f);
    [
        (y * w + xy * k - xx) * dp - (xx * k + xy) * dw + y * dk + v * (x * w - f * k),
        (-x * w + yy * k - xy) * dp - (xy * k + yy) * dw - x * dk + v * (x * p + 2.0 * y * w - f),
    ]
}
