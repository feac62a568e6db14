//! Flights in trouble: every frame ends with a fix that is right within its sigma, or with a reason that is counted.

use super::{Flown, flown, scenario};
use plumbline_core::pipeline::Refusal::{self, AttitudeGap, AttitudeStuck, NoAttitude, NoClock};
use plumbline_core::stamp::StampSource;
use plumbline_sim::scenario::{AttitudeFaults, Scenario};

const FRAMES: u32 = 10;
/// Seconds of the flight: the first frame opens at 3 s, four a second, so that the frames 4, 5 and 6 lie within.
const INTERVAL_S: [f64; 2] = [3.95, 4.6];
/// The frames that it concerns.
const HIT: std::ops::Range<usize> = 4..7;

fn with(faults: AttitudeFaults) -> Flown {
    sound(scenario(1, FRAMES), |scenario| scenario.faults.attitude_faults = faults)
}

/// Flies, and holds every frame to the rule.
fn sound(mut scenario: Scenario, change: impl FnOnce(&mut Scenario)) -> Flown {
    change(&mut scenario);
    scenario.check().expect("a scenario");
    let flown = flown(scenario);
    for (record, scored) in flown.frames.iter().zip(&flown.scored) {
        let report = record.report.expect("every frame is reported");
        let Some([east_m, north_m]) = scored.error_m else {
            assert!(report.reason().is_some(), "frame {} has neither fix nor reason", scored.frame);
            continue;
        };
        let error_px = east_m.hypot(north_m) / flown.resolution_m;
        let sigmas = scored.nees.expect("a covariance").sqrt();
        println!("frame {}: {error_px:.3} px, {sigmas:.2} sigma", scored.frame);
        assert!(error_px <= 1.5 && sigmas <= 5.0, "frame {}: {error_px} px, {sigmas} sigma", scored.frame);
    }
    println!("{:?}", flown.reasons());
    flown
}

impl Flown {
    fn reasons(&self) -> Vec<Option<Refusal>> {
        self.frames.iter().map(|frame| frame.report.and_then(|report| report.reason())).collect()
    }

    /// Only the frames of the spell are refused, all of them, each for one of `reasons`.
    fn refuses_only_the_spell(&self, reasons: &[Refusal]) {
        for (frame, reason) in self.reasons().into_iter().enumerate() {
            let as_expected =
                if HIT.contains(&frame) { reason.is_some_and(|r| reasons.contains(&r)) } else { reason.is_none() };
            assert!(as_expected, "frame {frame}: {reason:?}");
        }
    }

    fn sigma_us(&self) -> f64 {
        super::mean(self.frames.iter().filter_map(|frame| frame.instant?.stamp).map(|stamp| stamp.sigma_us.into()))
    }
}

#[test]
fn a_silent_attitude_sensor() {
    with(AttitudeFaults { gap_s: Some(INTERVAL_S), ..AttitudeFaults::default() })
        .refuses_only_the_spell(&[AttitudeGap, NoAttitude]);
}

#[test]
fn attitudes_that_are_no_numbers() {
    let flown = with(AttitudeFaults { nan_s: Some(INTERVAL_S), ..AttitudeFaults::default() });
    flown.refuses_only_the_spell(&[AttitudeGap, NoAttitude]);
    // 130 in 0.65 s at 200 Hz.
    assert_eq!(flown.health.invalid, 130);
}

#[test]
fn attitudes_stamped_backwards() {
    let flown = with(AttitudeFaults { backwards_s: Some(INTERVAL_S), ..AttitudeFaults::default() });
    flown.refuses_only_the_spell(&[AttitudeGap, NoAttitude]);
    // All but those with which the history begins anew, one in twenty.
    assert!((115..130).contains(&flown.health.backwards), "{:?}", flown.health);
}

#[test]
fn an_attitude_sensor_that_hangs() {
    with(AttitudeFaults { stuck_s: Some(INTERVAL_S), ..AttitudeFaults::default() })
        .refuses_only_the_spell(&[AttitudeStuck]);
}

/// It hangs ever longer before a frame's exposure, from just after it to most of a window of the fit, at tilts of 20
/// deg/s.
#[test]
fn an_attitude_sensor_that_has_just_hung() {
    for before_ms in [-8, 2, 40, 80] {
        println!("{before_ms} ms before frame 4");
        let mut scenario = scenario(1, 6);
        (scenario.vehicle.flight.tilt_hz, scenario.run.frame_jitter_us) = ([0.4, 0.65], 0);
        sound(scenario, |scenario| {
            let from_s = 4.001 - 1e-3 * f64::from(before_ms);
            scenario.faults.attitude_faults.stuck_s = Some([from_s, 4.15]);
        });
    }
}

/// Pulses without names, and nothing at all.
#[test]
fn a_clock_that_is_never_tied() {
    for pps in [true, false] {
        let flown =
            sound(scenario(1, 4), |scenario| (scenario.world.timer.pps, scenario.world.timer.timesync) = (pps, false));
        assert_eq!(flown.reasons(), [Some(NoClock); 4]);
    }
}

/// The clock is TIMESYNC's then, whose round trip the stamps' sigma shows.
#[test]
fn a_flight_without_pulses() {
    let flown = sound(scenario(1, FRAMES), |scenario| scenario.faults.timer.pps_lost_s = Some([0.0, 1e9]));
    assert!(flown.accepted() >= 9 && flown.sigma_us() > 500.0, "{} us", flown.sigma_us());
}

/// Frames are stamped by their arrival, less precisely.
#[test]
fn a_flight_without_edges() {
    let line = |lost_edge_percent: f64| {
        sound(scenario(1, FRAMES), |scenario| {
            (scenario.faults.shutter.lost_edge_percent, scenario.vehicle.shutter.arrival_jitter_us) =
                (lost_edge_percent, 100.0);
            scenario.vehicle.shutter.arrival_latency_us = 800;
            // By TIMESYNC alone the clock would hide the difference.
            scenario.world.timer.pps = true;
        })
    };
    let (lost, wired) = (line(100.0), line(0.0));
    let sources =
        |flown: &Flown| -> Vec<_> { flown.frames.iter().filter_map(|frame| frame.instant?.stamp?.source()).collect() };
    assert_eq!(sources(&lost), [StampSource::Arrival; FRAMES as usize]);
    assert!(lost.accepted() >= 9 && lost.sigma_us() > 50.0 * wired.sigma_us(), "{} us", lost.sigma_us());
}
