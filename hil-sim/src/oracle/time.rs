//! Stamps and the attitude between two samples (paper 000 needs the instant of mid-exposure; how a board gets there is
//! our own).

use super::rotation::{Matrix3, matrix_a, product, transpose};
use std::f64::consts::{PI, TAU};

/// The middle of an exposure on a free-running 32-bit counter that wraps. An odd difference rounds down.
///
/// Half the wrapping difference is added to the start; the mean of both ticks would overflow.
pub fn mid_exposure_u32(start_tick: u32, stop_tick: u32) -> u32 {
    start_tick.wrapping_add(stop_tick.wrapping_sub(start_tick) / 2)
}

/// The time of a tick in seconds, from the ticks of the last two pulses per second and the second of the later one.
///
/// t = s1 + (c - c1) / (c1 - c0), both differences wrapping, the first signed: a tick may lie before the later pulse.
/// The two pulses must differ, else the answer is not finite.
pub fn pps_time(tick: u32, pulse_before_tick: u32, pulse_tick: u32, pulse_s: f64) -> f64 {
    let since_pulse = tick.wrapping_sub(pulse_tick).cast_signed();
    let ticks_per_s = pulse_tick.wrapping_sub(pulse_before_tick);
    pulse_s + f64::from(since_pulse) / f64::from(ticks_per_s)
}

/// (heading, pitch, roll) in radians a fraction `u` of the way from one sample to the next, each angle linearly, the
/// heading the short way round. The heading comes back within [0, 2 pi].
pub fn attitude_linear(from_rad: [f64; 3], to_rad: [f64; 3], u: f64) -> [f64; 3] {
    let turn = (to_rad[0] - from_rad[0] + PI).rem_euclid(TAU) - PI;
    [
        (from_rad[0] + u * turn).rem_euclid(TAU),
        from_rad[1] + u * (to_rad[1] - from_rad[1]),
        from_rad[2] + u * (to_rad[2] - from_rad[2]),
    ]
}

/// As above by one rotation about a fixed axis (slerp): the control of linear interpolation.
///
/// With D = R1 R0^T the turn from one attitude to the next, of angle w about a unit axis, the attitude at `u` is the
/// turn of angle u w about that axis, times R0. Attitudes half a turn apart have no short way; they are not met here.
pub fn attitude_slerp(from_rad: [f64; 3], to_rad: [f64; 3], u: f64) -> [f64; 3] {
    let [r0, r1] = [from_rad, to_rad].map(|[heading, pitch, roll]| matrix_a(heading, pitch, roll, 0.0));
    let d = product(&r1, &transpose(&r0));
    // Twice sin w times the axis: exact to rounding for the small turns between two samples.
    let s = [d[2][1] - d[1][2], d[0][2] - d[2][0], d[1][0] - d[0][1]];
    let twice_sin = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]).sqrt();
    if twice_sin == 0.0 {
        return [from_rad[0].rem_euclid(TAU), from_rad[1], from_rad[2]];
    }
    let angle = twice_sin.atan2(d[0][0] + d[1][1] + d[2][2] - 1.0);
    let at_u = product(&turn_about(s.map(|x| x / twice_sin), u * angle), &r0);
    [at_u[0][2].atan2(at_u[0][0]).rem_euclid(TAU), at_u[0][1].clamp(-1.0, 1.0).asin(), (-at_u[2][1]).atan2(at_u[1][1])]
}

/// Rodrigues' formula: the right-handed turn about a unit axis.
fn turn_about(axis: [f64; 3], angle_rad: f64) -> Matrix3 {
    let [x, y, z] = axis;
    let (s, c) = angle_rad.sin_cos();
    let v = 1.0 - c;
    [
        [x * x * v + c, x * y * v - z * s, x * z * v + y * s],
        [x * y * v + z * s, y * y * v + c, y * z * v - x * s],
        [x * z * v - y * s, y * z * v + x * s, z * z * v + c],
    ]
}
