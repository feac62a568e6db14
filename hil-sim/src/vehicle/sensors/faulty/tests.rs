//! Each fault is flown through the sensors beside the same flight without it: what is not faulty keeps its bytes, at every
//! instant, and what is faulty is off by what was asked for, within the interval alone.

use crate::scenario::{Fault, FollowUpMode, Mounting, Scenario};
use crate::vehicle::motion::{Area, Motion};
use crate::vehicle::sensors::{Reading, Sample, Streams};
use crate::vehicle::servo::wrapped;

const AREA: Area = Area { centre_east_m: 3000.0, centre_north_m: 7000.0, half_extent_m: 1500.0, base_up_m: 0.0 };
/// Of the faults.
const FROM_US: u64 = 4_000_000;
const TO_US: u64 = 8_000_000;
const CONVERGENCE_RAD: f64 = 0.02;

fn scenario(fault: Option<&str>) -> Scenario {
    let mut scenario = Scenario::default();
    scenario.vehicle.follow_up.mode = FollowUpMode::Measured;
    scenario.vehicle.position.white_m = 0.5;
    scenario.vehicle.attitude.drift_deg = 0.2;
    scenario.faults.timed =
        fault.map(|word| format!("{word}@4..8").parse::<Fault>().expect(word)).into_iter().collect();
    scenario
}

fn flown(fault: Option<&str>) -> Vec<Sample> {
    let scenario = scenario(fault);
    let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
    let mut streams = Streams::new(&scenario, Mounting::default(), CONVERGENCE_RAD);
    std::iter::from_fn(|| streams.next_before(12_000_000, &motion, &|state| Some(state.up_m))).collect()
}

/// The numbers of a sample, and whose they are.
fn numbers(sample: &Sample) -> (&'static str, Vec<f64>) {
    match sample.reading {
        Reading::Pps { second } => ("pps", vec![second as f64]),
        Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s: [north, east, down] } => {
            ("attitude", vec![heading_true_rad, pitch_rad, roll_rad, north, east, down])
        }
        Reading::FollowUp { follow_up_rad } => ("encoder", vec![follow_up_rad]),
        Reading::Range { slant_m } => ("range", slant_m.into_iter().collect()),
        Reading::Position { east_m, north_m, up_m, velocity_ned_m_s: [north, east, down] } => {
            ("position", vec![east_m, north_m, up_m, north, east, down])
        }
    }
}

/// The samples of `sensor` within the interval, (good, faulty). All others are checked to be what they are without a fault.
fn pairs(fault: &str, sensors: &[&str]) -> Vec<(u64, &'static str, Vec<f64>, Vec<f64>)> {
    let (good, bad) = (flown(None), flown(Some(fault)));
    assert_eq!(good.len(), bad.len(), "{fault}");
    let mut pairs = Vec::new();
    for (good, bad) in good.iter().zip(&bad) {
        let at_us = good.sampled_at_us;
        assert_eq!((at_us, good.arrived_at_us), (bad.sampled_at_us, bad.arrived_at_us), "{fault}");
        let ((sensor, good_numbers), (_, bad_numbers)) = (numbers(good), numbers(bad));
        if sensors.contains(&sensor) && (FROM_US..TO_US).contains(&at_us) {
            pairs.push((at_us, sensor, good_numbers, bad_numbers));
        } else {
            assert_eq!(good, bad, "{fault} at {at_us}");
        }
    }
    assert!(pairs.len() > 10, "{fault}");
    pairs
}

/// Whether the faulty numbers are those that `expected` makes of the good ones, all of them.
fn becomes(fault: &str, sensor: &str, expected: impl Fn(u64, &[f64]) -> Vec<f64>) {
    for (at_us, _, good, bad) in pairs(fault, &[sensor]) {
        let wanted = expected(at_us, &good);
        let off = wanted.iter().zip(&bad).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(wanted.len() == bad.len() && off < 1e-9, "{fault} at {at_us}: {wanted:?} and {bad:?}");
        assert!(good != bad || fault.contains("steps"), "{fault} did nothing at {at_us}");
    }
}

#[test]
fn silent_sensors_are_silent_for_their_time() {
    for (fault, sensor) in
        [("position.off", "position"), ("range.off", "range"), ("attitude.off", "attitude"), ("encoder.off", "encoder")]
    {
        let kept = |sample: &Sample| numbers(sample).0 != sensor || !(FROM_US..TO_US).contains(&sample.sampled_at_us);
        let expected: Vec<Sample> = flown(None).into_iter().filter(kept).collect();
        assert_eq!(flown(Some(fault)), expected, "{fault}");
    }
}

#[test]
fn what_is_stuck_says_what_it_said_last() {
    let held: [(&str, &str, &[usize]); 7] = [
        ("position.stuck", "position", &[0, 1, 2, 3, 4, 5]),
        ("position.stuck_position", "position", &[0, 1, 2]),
        ("range.stuck", "range", &[0]),
        ("attitude.stuck", "attitude", &[0, 1, 2, 3, 4, 5]),
        ("attitude.stuck_pitch", "attitude", &[1]),
        ("attitude.stuck_roll", "attitude", &[2]),
        ("heading.stuck", "attitude", &[0]),
    ];
    for (fault, sensor, stuck) in held.into_iter().chain([("encoder.stuck", "encoder", [0].as_slice())]) {
        let good = flown(None);
        let last = good.iter().rfind(|sample| numbers(sample).0 == sensor && sample.sampled_at_us < FROM_US);
        let last = numbers(last.expect("there was one")).1;
        becomes(fault, sensor, |_, good| {
            (0..good.len()).map(|index| if stuck.contains(&index) { last[index] } else { good[index] }).collect()
        });
    }
}

#[test]
fn positions_jump_and_are_dragged_with_their_velocity() {
    let east = |v: f64| [-v * CONVERGENCE_RAD.sin(), v * CONVERGENCE_RAD.cos()];
    let moved = |good: &[f64], east_m: f64, [north, east]: [f64; 2]| {
        vec![good[0] + east_m, good[1], good[2], good[3] + north, good[4] + east, good[5]]
    };
    becomes("position.jump=40", "position", |_, good| moved(good, 40.0, [0.0; 2]));
    // Both messages tell of the velocity; of the attitude's the position is no part.
    for (fault, drag) in [("position.drag=2", 2.0), ("position.wrong_velocity=2", 0.0)] {
        for (at_us, sensor, good, bad) in pairs(fault, &["position", "attitude"]) {
            let wanted = match sensor {
                "position" => moved(&good, drag * 1e-6 * (at_us - FROM_US) as f64, east(2.0)),
                _ => moved(&good, 0.0, east(2.0)),
            };
            let off = wanted.iter().zip(&bad).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{fault} at {at_us}: {wanted:?} and {bad:?}");
        }
    }
}

#[test]
fn ranges_are_off() {
    becomes("range.bias=-3", "range", |_, good| vec![good[0] - 3.0]);
    becomes("range.scale=1.1", "range", |_, good| vec![good[0] * 1.1]);
    becomes("range.steps=5", "range", |_, good| vec![(good[0] / 5.0).round() * 5.0]);
}

#[test]
fn angles_and_altitudes_are_off() {
    let bias = 2_f64.to_radians();
    let tilted =
        |good: &[f64], tilt: &dyn Fn(f64) -> f64| [&[good[0], tilt(good[1]), tilt(good[2])], &good[3..]].concat();
    becomes("attitude.bias=2", "attitude", |_, good| tilted(good, &|angle| angle + bias));
    becomes("attitude.scale=0.5", "attitude", |_, good| tilted(good, &|angle| angle * 0.5));
    becomes("heading.bias=2", "attitude", |_, good| [&[wrapped(good[0] + bias)], &good[1..]].concat());
    becomes("encoder.bias=2", "encoder", |_, good| vec![wrapped(good[0] + bias)]);
    let up = |good: &[f64], up_m: f64| [&good[..2], &[up_m], &good[3..]].concat();
    becomes("baro.bias=30", "position", |_, good| up(good, good[2] + 30.0));
    becomes("baro.scale=1.05", "position", |_, good| up(good, good[2] * 1.05));
}

/// Older by the delay: the truth of then, the noise of now.
#[test]
fn attitudes_are_delayed_and_nobody_is_told() {
    let motion = Motion::synthetic(&scenario(None), &AREA).expect("there is room");
    let late_us = 40_000;
    becomes("attitude.delayed=40", "attitude", |at_us, good| {
        let (then, now) = (motion.state(at_us - late_us), motion.state(at_us));
        let (sin, cos) = CONVERGENCE_RAD.sin_cos();
        let [east, north, up] = then.velocity_enu_m_s;
        vec![
            wrapped(good[0] + then.heading_rad - now.heading_rad),
            good[1] + then.pitch_rad - now.pitch_rad,
            good[2] + then.roll_rad - now.roll_rad,
            north * cos - east * sin,
            north * sin + east * cos,
            -up,
        ]
    });
}

/// At 200 Hz and one new value in 100 ms: twenty samples say the same angles, and the first of them is a good one.
#[test]
fn stale_attitudes_bear_fresh_stamps() {
    let pairs = pairs("attitude.stale=100", &["attitude"]);
    for chunk in pairs.chunks(20) {
        assert_eq!(chunk[0].2, chunk[0].3);
        assert!(chunk.iter().all(|(_, _, _, bad)| bad[..3] == chunk[0].3[..3]));
        assert!(chunk.iter().skip(1).all(|(_, _, good, bad)| good[..3] != bad[..3] && good[3..] == bad[3..]));
    }
}

/// Pulses of another phase are late by it; those of an autopilot that booted in the midst of a second are whole seconds of its
/// new clock.
#[test]
fn pulses_come_in_another_phase() {
    let pulses = |word: &str| -> Vec<u64> {
        let mut scenario = Scenario::default();
        scenario.world.timer.pps = true;
        scenario.faults.timed = [word.parse::<Fault>().expect(word)].into_iter().collect();
        let motion = Motion::synthetic(&scenario, &AREA).expect("there is room");
        let mut streams = Streams::new(&scenario, Mounting::default(), CONVERGENCE_RAD);
        let samples: Vec<_> = std::iter::from_fn(|| streams.next_before(8_500_000, &motion, &|_| None)).collect();
        assert!(samples.is_sorted_by_key(|sample| sample.arrived_at_us));
        let pulses = samples.iter().filter(|sample| numbers(sample).0 == "pps");
        pulses.map(|sample| sample.sampled_at_us / 1000).collect()
    };
    assert_eq!(pulses("clock.phase=300@4..7"), [1000, 2000, 3000, 4300, 5300, 6300, 7000, 8000]);
    assert_eq!(pulses("clock.reboot@4..5.25"), [1000, 2000, 3000, 6250, 7250, 8250]);
}
