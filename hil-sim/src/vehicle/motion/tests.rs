//! Statistics are taken over 40 flights of 300 frames at 4 Hz. Pitch and roll have no part above 0.25 Hz, so a sample
//! every 2 s is as good as independent: 38 a flight, 1500 in all.

use super::{Area, AttitudeLog, Motion, follow_up_exact, wrapped};
use crate::scenario::footprint::{footprint_margin_at_m, footprint_margin_m};
use crate::scenario::{FollowUpMode, Frame, Mounting, Payload, Replay, Scenario};
use plumbline_survey::camera_file::{CameraFile, Distortion};
use std::f64::consts::PI;

const AREA: Area =
    Area { centre_east_m: 340_000.0, centre_north_m: 5_240_000.0, half_extent_m: 1500.0, base_up_m: 30.0 };
const FLIGHTS: u64 = 40;
const INDEPENDENT: f64 = 1500.0;
const FRAME_US: u64 = 250_000;

fn motion(seed: u64) -> Motion {
    Motion::synthetic(&Scenario::seeded(seed, 300), &AREA).expect("there is room")
}

/// Value and rate by a central difference of 2 ms, at each frame of each flight.
fn sampled(what: impl Fn(&Motion, u64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let mut both = (Vec::new(), Vec::new());
    for motion in (0..FLIGHTS).map(motion) {
        for t_us in (0..300).map(|frame| 3_000_000 + frame * FRAME_US) {
            both.0.push(what(&motion, t_us));
            both.1.push(wrapped(what(&motion, t_us + 1000) - what(&motion, t_us - 1000)) / 0.002);
        }
    }
    both
}

/// Largest distance between the distribution of `values` and the uniform one between the two limits.
fn distance_from_uniform(values: &[f64], low: f64, high: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let distance = |(index, value): (usize, &f64)| {
        let expected = (value - low) / (high - low);
        (expected - index as f64 / count).abs().max((expected - (index + 1) as f64 / count).abs())
    };
    sorted.iter().enumerate().map(distance).fold(0.0, f64::max)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// Kolmogorov and Smirnov's 1e-4 limit, 2.23/√n, and 0.002 for the kurtosis of 24 sinusoids. The rate's root mean
/// square is 2 tilt_max √E[φ(g)²] g' = 20° · √0.0919 · 2π √(mean f²) = 6.12°/s.
#[test]
fn pitch_and_roll_are_uniform_independent_and_slow() {
    let tilt_max = 10_f64.to_radians();
    let (pitch, pitch_rate) = sampled(|motion, t_us| motion.state(t_us).pitch_rad);
    let (roll, roll_rate) = sampled(|motion, t_us| motion.state(t_us).roll_rad);
    for (angle, rate) in [(&pitch, &pitch_rate), (&roll, &roll_rate)] {
        let distance = distance_from_uniform(angle, -tilt_max, tilt_max);
        assert!(distance < 2.23 / INDEPENDENT.sqrt() + 0.002, "{distance}");
        assert!((rms(rate).to_degrees() / 6.12 - 1.0).abs() < 0.1, "{}", rms(rate).to_degrees());
        let fast = rate.iter().filter(|rate| rate.abs() > 20_f64.to_radians()).count();
        assert!(fast * 100 < rate.len(), "{fast}");
        assert!(rate.iter().all(|rate| rate.abs() < 40_f64.to_radians()));
        println!("tilt: distance {distance:.4}, rms rate {:.2} deg/s, above 20 deg/s {fast}", rms(rate).to_degrees());
    }
    let product: f64 = pitch.iter().zip(&roll).map(|(pitch, roll)| pitch * roll).sum();
    let correlation = product / pitch.len() as f64 / (rms(&pitch) * rms(&roll));
    assert!(correlation.abs() < 4.0 / INDEPENDENT.sqrt(), "{correlation}");
}

#[test]
fn heights_are_uniform_at_a_bounded_rate() {
    let (height, rate) = sampled(|motion, t_us| motion.state(t_us).up_m - AREA.base_up_m);
    assert!(height.iter().all(|height| (100.0..=150.0).contains(height)));
    assert!(rate.iter().all(|rate| rate.abs() < 2.501));
    // 40 random phases, each over 1.7 swings: 0.02 by the rounding, and 2.23/√40/4 for the part of a swing left over.
    let distance = distance_from_uniform(&height, 100.0, 150.0);
    assert!(distance < 0.02 + 0.09, "{distance}");
    println!("height: distance {distance:.4}, rms rate {:.2} m/s", rms(&rate));
}

#[test]
fn each_flight_sees_all_headings_without_spinning() {
    for motion in (0..FLIGHTS).map(motion) {
        let heading = |t_us| motion.state(t_us).heading_rad;
        let mut sectors = [false; 8];
        for t_us in (0..300).map(|frame| 3_000_000 + frame * FRAME_US) {
            sectors[((heading(t_us) + PI) / (PI / 4.0)) as usize % 8] = true;
            let rate = wrapped(heading(t_us + 1000) - heading(t_us - 1000)) / 0.002;
            // The course turns at most 0.1 · 2.07 rad/s = 12°/s, four sigma of the wander are 14°/s.
            assert!(rate.abs() < 30_f64.to_radians(), "{}", rate.to_degrees());
        }
        assert_eq!(sectors, [true; 8]);
    }
}

/// Half an hour in 0.1 s: it stays inside, and the mean square of the speed is the promised one.
#[test]
fn the_track_stays_inside_at_its_speed() {
    for (half_extent_m, wished_m_s, flown_m_s) in
        [(1500.0, 35.0, 35.0), (300.0, 35.0, 0.17 * 300.0 / (1.0 + 0.4 / 0.618034) * 1.16_f64.sqrt()), (40.0, 3.0, 3.0)]
    {
        let mut scenario = Scenario::default();
        scenario.vehicle.flight.speed_m_s = wished_m_s;
        let motion = Motion::synthetic(&scenario, &Area { half_extent_m, ..AREA }).expect("there is room");
        assert!((motion.speed_m_s() - flown_m_s).abs() < 1e-4 * flown_m_s, "{}", motion.speed_m_s());
        let states: Vec<_> = (0..18_000).map(|step| motion.state(step * 100_000)).collect();
        let off = |state: &super::TrueState| {
            (state.east_m - AREA.centre_east_m).abs().max((state.north_m - AREA.centre_north_m).abs())
        };
        let farthest_m = states.iter().map(off).fold(0.0, f64::max);
        assert!(farthest_m <= half_extent_m, "{farthest_m}");
        let speeds: Vec<f64> = states.iter().map(|s| s.velocity_enu_m_s[0].hypot(s.velocity_enu_m_s[1])).collect();
        // The cross term of the two circles averages out over some 30 turns; 2 % is what can be left of it.
        assert!((rms(&speeds) / flown_m_s - 1.0).abs() < 0.02, "{}", rms(&speeds));
    }
}

/// Velocity is the derivative of position: a central difference of ±1 ms is off by h² a'/6, some 1e-7 m/s, and by the
/// rounding of 5e6 m, 1e-9 m in 2e-3 s. Angles: a second difference of 1 ms stays below 2.5 rad/s² h² at ±10°, so a
/// rate that jumps by 0.003 rad/s would be seen.
#[test]
fn position_and_angles_are_smooth() {
    let motion = motion(5);
    for t_us in (10_000..60_000_000).step_by(100_003) {
        let [before, now, after] = [t_us - 1000, t_us, t_us + 1000].map(|t_us| motion.state(t_us));
        let moved = [after.east_m - before.east_m, after.north_m - before.north_m, after.up_m - before.up_m];
        for (moved, velocity) in moved.iter().zip(now.velocity_enu_m_s) {
            assert!((moved / 0.002 - velocity).abs() < 3e-6, "{} {velocity}", moved / 0.002);
        }
        let angles =
            |state: &super::TrueState| [state.heading_rad, state.pitch_rad, state.roll_rad, state.follow_up_rad];
        for axis in 0..4 {
            let [a, b, c] = [&before, &now, &after].map(|state| angles(state)[axis]);
            let bend = wrapped(c - b) - wrapped(b - a);
            assert!(bend.abs() < 2.5e-6, "axis {axis} at {t_us}: {bend}");
        }
    }
}

#[test]
fn the_seed_decides() {
    let states = |seed| (0..50).map(|k| motion(seed).state(k * 777_777)).collect::<Vec<_>>();
    assert_eq!(states(1), states(1));
    assert_ne!(states(1), states(2));
}

/// The photogrammetry reference's table of follow-up angles: heading, pitch, roll, angle in degrees.
#[test]
fn the_exact_follow_up_angle_has_its_golden_values() {
    for [heading, pitch, roll, follow_up] in [
        [0.0, 8.0, 10.0, 0.0],
        [90.0, 10.0, 8.0, 88.5942453],
        [180.0, 10.0, -10.0, 180.0],
        [270.0, -12.0, 15.0, -86.8511221],
    ] {
        let [heading, pitch, roll] = [heading, pitch, roll].map(f64::to_radians);
        let ours = follow_up_exact(heading, pitch, roll).to_degrees();
        assert!((ours - follow_up).abs() < 1e-7, "{ours}");
    }
}

#[test]
fn the_servo_follows_lags_or_is_not_there() {
    let angle = |mode, servo_lag_s| {
        let mut scenario = Scenario::default();
        scenario.vehicle.follow_up.mode = mode;
        scenario.world.follow_up.servo_lag_s = servo_lag_s;
        let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
        let state = motion.state(20_000_000);
        let exact = |state: &super::TrueState| follow_up_exact(state.heading_rad, state.pitch_rad, state.roll_rad);
        let rate = wrapped(exact(&motion.state(20_001_000)) - exact(&motion.state(19_999_000))) / 0.002;
        (state.follow_up_rad, exact(&state), rate)
    };
    let (followed, exact, rate) = angle(FollowUpMode::Followed, 0.0);
    assert_eq!(followed, exact);
    assert_eq!(angle(FollowUpMode::Fixed, 0.1).0, 0.0);
    // One time constant behind, but for the change of the rate in that time: below 1 rad/s² · τ² = 0.0025 rad.
    let behind = wrapped(exact - angle(FollowUpMode::Measured, 0.05).0);
    assert!((behind - 0.05 * rate).abs() < 0.0025 && rate.abs() > 0.06, "{behind} {rate}");
}

/// By hand: the corner is atan(√2 tan 30°) = 39.2315° off the axis, the tilt acos(cos² 10°) = 14.1060°:
/// 150 m · tan 53.3375° = 201.52 m. Through the barrel, r (1 − 0.075 r²) = 0.8165 gives r = 0.86505, 40.8613°:
/// 150 m · tan 54.9673° = 213.96 m.
#[test]
fn the_footprint_reaches_to_the_tilted_corner() {
    let scenario = Scenario::default();
    let with = |k1: f64| {
        let distortion = Some(Distortion { k1, ..Distortion::default() });
        Payload { camera: CameraFile { distortion, ..Frame::default().file() }, mount: Mounting::default() }
    };
    let close = |metres: f64, by_hand: f64| assert!((metres - by_hand).abs() < 0.01, "{metres} {by_hand}");
    close(footprint_margin_m(&scenario, &with(0.0)), 201.5160);
    close(footprint_margin_at_m(&scenario, &with(0.0), 0.0), 150.0 * (2.0_f64 / 3.0).sqrt());
    close(footprint_margin_m(&scenario, &with(-0.075)), 213.9625);
    assert_eq!(footprint_margin_at_m(&scenario, &with(-0.075), 1.0), f64::INFINITY);
    // A lens that folds back before its corner shows no limit.
    assert_eq!(footprint_margin_m(&scenario, &with(-0.5)), f64::INFINITY);
}

#[test]
fn no_room_is_refused() {
    for half_extent_m in [0.0, -10.0, f64::NAN] {
        let error = Motion::synthetic(&Scenario::default(), &Area { half_extent_m, ..AREA }).expect_err("no room");
        assert!(error.to_string().contains("too small to fly over"), "{error}");
    }
}

/// 100 s at 50 Hz with a gap of 0.5 s: yaw once around in 20 s from 350°, roll a sine.
fn synthetic_log() -> String {
    let mut text = String::from("t_s,mode,roll_deg,pitch_deg,yaw_deg\n");
    for t_s in (0..5000).map(|row| 10.0 + 0.02 * f64::from(row)).filter(|t_s| !(40.01..40.49).contains(t_s)) {
        let yaw_deg = (350.0 + 18.0 * t_s).rem_euclid(360.0);
        text += &format!("{t_s:.3},5,{:.6},-2.0,{yaw_deg:.6}\n", 8.0 * t_s.sin());
    }
    text
}

fn replayed(start_s: Option<f64>, time_scale: f64, frames: u32) -> Scenario {
    let mut scenario = Scenario::of_frames(frames);
    scenario.run.replay = Some(Replay { att: "".into(), start_s, time_scale });
    scenario
}

/// Cubic Hermite of a sine of 1 rad/s in steps of 0.02 s, slopes by parabolas: off by h²/6 · 8°/s =
/// 5e-4°/s, which the cubic turns into at most h/4 of it, 3e-6°; twenty times that is allowed.
#[test]
fn a_log_is_flown_as_it_is() {
    for (start_s, time_scale) in [(None, 1.0), (Some(15.0), 1.0), (Some(20.0), 0.5)] {
        let log = AttitudeLog::parse(&synthetic_log(), "a.csv").expect("sound");
        let motion = Motion::replay(&replayed(start_s, time_scale, 200), &AREA, log).expect("long enough");
        for t_us in (0..50_000_000).step_by(12_345) {
            let t_s = start_s.unwrap_or(10.0) + time_scale * t_us as f64 * 1e-6;
            let inside = t_s > 40.0 + 1e-9 && t_s < 40.5 - 1e-9;
            assert_eq!(motion.in_gap(t_us), inside, "{t_s}");
            let state = motion.state(t_us);
            let heading = wrapped(state.heading_rad - (350.0 + 18.0 * t_s).to_radians());
            assert!(heading.abs() < 1e-7, "{heading}");
            assert!((state.pitch_rad + 2_f64.to_radians()).abs() < 1e-12);
            // In the gap of 0.5 s the cubic is off by h⁴/384 · 8° = 1.3e-3°, the slopes' part of it by as much.
            // The first row has a chord to one side only: h/2 · 8°/s² · h · 4/27 = 2.4e-4°.
            let allowed = match t_s {
                39.98..40.52 => 3e-3,
                ..10.02 => 2.4e-4,
                _ => 6e-5,
            };
            let roll = state.roll_rad.to_degrees() - 8.0 * t_s.sin();
            assert!(roll.abs() < allowed, "{t_s} {roll}");
        }
    }
}

#[test]
fn a_log_that_cannot_be_flown_is_refused() {
    for (text, sentence) in [
        ("", "a.csv is empty"),
        ("t_s,roll_deg,yaw_deg\n0,1,2\n", "a.csv has no column pitch_deg, only t_s, roll_deg, yaw_deg"),
        ("t_s,roll_deg,pitch_deg,yaw_deg\n0,1,2,3\n", "a.csv: the attitude log has 1 rows, which is no flight"),
        (
            "t_s,roll_deg,pitch_deg,yaw_deg\n0,1,2,3\n1,NaN,2,3\n",
            "a.csv, line 3: roll_deg = \"NaN\" is not a finite number",
        ),
        ("t_s,roll_deg,pitch_deg,yaw_deg\n0,1,2,3\n1,1,2\n", "a.csv, line 3: 3 fields, but the header has 4"),
        ("t_s,roll_deg,pitch_deg,yaw_deg\n1,1,2,3\n0.5,1,2,3\n", "a.csv, line 3: t_s = \"0.5\" is not later than 1"),
        ("t_s,roll_deg,pitch_deg,yaw_deg\n1,1,2,3\n1,1,2,3\n", "a.csv, line 3: t_s = \"1\" is not later than 1"),
    ] {
        assert_eq!(AttitudeLog::parse(text, "a.csv").expect_err(text).to_string(), sentence);
    }
    for (scenario, sentence) in [
        (
            replayed(None, 1.0, 400),
            "a.csv: the attitude log holds 10.000 s to 109.980 s, but 400 frames need 10.000 s to 114.000 s; --frames 383 fits",
        ),
        (
            replayed(Some(0.0), 1.0, 4),
            "a.csv: the attitude log holds 10.000 s to 109.980 s, but 4 frames need 0.000 s to 5.000 s",
        ),
    ] {
        let log = AttitudeLog::parse(&synthetic_log(), "a.csv").expect("sound");
        assert_eq!(log.largest_tilt_rad(&scenario).expect_err("does not cover").to_string(), sentence);
        assert_eq!(Motion::replay(&scenario, &AREA, log).expect_err("does not cover").to_string(), sentence);
    }
}

/// The real log of `vienna.toml`: it covers the flight, has its three gaps in it, and leaves room on 500 m of ground.
#[test]
fn the_real_log_of_vienna_flies() {
    let Some(flights) = plumbline_survey::io::data::for_test("the_real_log_of_vienna_flies", "flights") else { return };
    let data = flights.parent();
    let text = include_str!("../../../scenarios/vienna.toml");
    let scenario = Scenario::parse(text, "vienna.toml", "".as_ref(), data).expect("sound");
    let log = AttitudeLog::load(&scenario.run.replay.as_ref().expect("a replay").att).expect("sound");
    let tilt_rad = log.largest_tilt_rad(&scenario).expect("covers the flight");
    let margin_m = footprint_margin_at_m(
        &scenario,
        &crate::vehicle::mount::payload_of(&scenario).expect("its own camera"),
        tilt_rad,
    );
    println!("vienna: largest tilt {:.2} deg, footprint margin {margin_m:.1} m", tilt_rad.to_degrees());
    assert!((10.0..13.0).contains(&tilt_rad.to_degrees()) && margin_m < 240.0);
    let area = Area { half_extent_m: 250.0 - margin_m, ..AREA };
    // Elsewhere the log has gaps.
    let mut later = scenario.clone();
    later.run.replay.as_mut().expect("a replay").start_s = Some(390.0);
    let motion = Motion::replay(&later, &area, log).expect("flies");
    let silent_ms = (0..scenario.run.duration_us()).step_by(1000).filter(|&t_us| motion.in_gap(t_us)).count();
    // 0.465 + 0.769 + 0.818 s.
    assert!((2045..2056).contains(&silent_ms), "{silent_ms}");
}
