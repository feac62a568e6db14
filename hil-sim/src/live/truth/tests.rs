use super::*;
use crate::noise::{GaussMarkov, stream, uniform};

/// [w, x, y, z] of heading, pitch and roll.
fn quaternion(heading: f64, pitch: f64, roll: f64) -> [f64; 4] {
    let ([sy, cy], [sp, cp], [sr, cr]) = (half(heading), half(pitch), half(roll));
    [cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy]
}

fn half(angle: f64) -> [f64; 2] {
    let (sin, cos) = (0.5 * angle).sin_cos();
    [sin, cos]
}

/// The true motion at an instant: 25 m/s east, banking and turning as `amplitude` says.
fn state(at_s: f64, amplitude: f64) -> (TrueState, [f64; 4]) {
    let (roll, pitch) = (amplitude * 0.4 * (1.3 * at_s).sin(), amplitude * 0.08 * (0.7 * at_s).sin());
    let heading = amplitude * 0.5 * (0.2 * at_s).sin();
    let velocity_enu_m_s = [25.0, 0.0, 0.0];
    let base = TrueState { east_m: 25.0 * at_s, up_m: 100.0, velocity_enu_m_s, ..TrueState::default() };
    let state = TrueState { heading_rad: heading, pitch_rad: pitch, roll_rad: roll, ..base };
    (state, quaternion(heading, pitch, roll))
}

/// A minute of truth at 50 Hz: a true state `shift_us` after each attitude, whose filter is off by some wandering tenths of a
/// degree and late by `delay_us`, and whose stamps are whole milliseconds; and where `is_pinned` a stamp behind each.
fn flown(shift_us: f64, amplitude: f64, delay_us: f64, is_pinned: bool) -> Truth {
    let mut truth = Truth::default();
    let mut rng = stream(3, "phase");
    let mut off = [0, 1, 2].map(|axis| GaussMarkov::new(0.3_f64.to_radians(), 20.0, axis, "filter"));
    for index in 0..3000 {
        let at_us = f64::from(index) * 20_000.0 + 1000.0 * uniform(&mut rng) + 5e6;
        let (estimated, _) = state((at_us - delay_us) * 1e-6, amplitude);
        let [heading, pitch, roll] = off.each_mut().map(|off| off.at(at_us as u64));
        let attitude =
            quaternion(estimated.heading_rad + heading, estimated.pitch_rad + pitch, estimated.roll_rad + roll);
        truth.attitude((at_us / 1000.0) as u32, attitude, at_us * 1e-6);
        let (state, attitude) = state((at_us + shift_us) * 1e-6, amplitude);
        truth.state(attitude, state, (at_us + shift_us) * 1e-6);
        if is_pinned {
            truth.stamp((at_us + shift_us).floor());
        }
    }
    truth
}

#[test]
fn the_order_of_arrival_says_the_instant_with_its_bound() {
    let mut truth = flown(3000.0, 1.0, 16_000.0, false);
    let shift = truth.settle();
    // The filter's delay is in the fit, which therefore says nothing of the instant.
    assert!(shift.fitted.is_some() && shift.attitude_delay_us().is_none(), "{shift:?}");
    assert!((shift.us - 3500.0).abs() < 300.0, "{shift:?}");
    assert!((shift.error_us - 17_500.0).abs() < 1200.0 && (shift.interval_us - 20_000.0).abs() < 1100.0, "{shift:?}");
}

#[test]
fn a_stamp_behind_it_tells_the_instant_and_what_is_left_is_the_filters_delay() {
    let mut truth = flown(0.0, 1.0, 16_000.0, true);
    let shift = truth.settle();
    assert!(shift.pinned > 0.99 && shift.error_us <= 500.0, "{shift:?}");
    for at_s in [20.0, 33.333, 60.0] {
        let off_m = truth.at(at_s * 1e6).unwrap().east_m - 25.0 * at_s;
        assert!(off_m.abs() < 1e-3, "{off_m}");
    }
    let [delay_us, sigma_us] = shift.attitude_delay_us().unwrap();
    assert!((delay_us - 16_000.0).abs() < 1000.0 && sigma_us < 1000.0, "{delay_us} {sigma_us}");
    // A stamp of another clock changes nothing.
    truth.stamp(5.0);
    assert_eq!(truth.settle(), shift);
}

#[test]
fn what_is_not_between_two_attitudes_of_its_own_is_left_out() {
    let mut truth = Truth::default();
    let (one, attitude) = state(1.0, 1.0);
    truth.state(attitude, one, 1.0);
    assert!(truth.newest_us().is_none());
    truth.attitude(1000, attitude, 1.0);
    truth.state(attitude, one, 1.0);
    truth.state(attitude, one, 1.001);
    // A stamp that runs backwards, too.
    truth.attitude(900, attitude, 1.01);
    assert_eq!((truth.unordered, truth.all().len()), (1, 1));
    assert!(truth.at(1.1e6).is_none());
}

#[test]
fn a_place_is_on_the_grid_and_above_home() {
    let crs = Crs::from_epsg(32755).unwrap();
    let place = Place { crs: crs.clone(), home_alt_m: 584.0 };
    let sim = SimState {
        attitude: quaternion(1.0, 0.1, -0.2),
        place_e7: Some([-353_632_610, 1_491_652_300]),
        alt_m: 704.0,
        velocity_ned_m_s: [20.0, 10.0, -1.0],
    };
    let state = place.state(&sim).unwrap();
    let (lat, lon) = crs.to_wgs84(state.east_m, state.north_m).unwrap();
    assert!((lat + 35.363_261).abs() < 1e-8 && (lon - 149.165_23).abs() < 1e-8);
    let convergence = crs.convergence_rad(state.east_m, state.north_m).unwrap();
    assert!((state.heading_rad + convergence - 1.0).abs() < 1e-9 && (state.up_m - 120.0).abs() < 1e-9);
    assert!((state.pitch_rad - 0.1).abs() < 1e-9 && (state.roll_rad + 0.2).abs() < 1e-9);
    // The course over the grid is the true one less the convergence too.
    let [east, north, up] = state.velocity_enu_m_s;
    assert!((east.atan2(north) + convergence - 10f64.atan2(20.0)).abs() < 1e-9 && up == 1.0);
}
