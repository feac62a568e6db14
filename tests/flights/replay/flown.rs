//! Flights with everything that can go wrong.

use plumbline_sim::link::Link;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::replay::read::{Log, read};
use plumbline_sim::replay::{End, Replayed, fixes_csv, replay};
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::scenario::{Camera, EdgeSource, FollowUpMode, Light, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{self, score};
use plumbline_sim::setup::Setup;

/// A small camera: rendered in no time, and fixes are as good.
pub fn scenario(seed: u64, frames: u32) -> Scenario {
    let mut scenario = Scenario::seeded(seed, frames);
    scenario.camera = Camera::of_size(128, 128);
    scenario
}

/// `fixes.csv` of a flight.
pub fn csv(setup: &Setup, flight: &Flight) -> String {
    let scored = score(setup, flight, &Unrectified::default());
    score::fixes_csv(setup, flight, &scored)
}

/// A flight's fixes and its log.
pub fn flown(scenario: Scenario) -> (String, Vec<u8>) {
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let mut link = InProcess::logged(&setup.flash).expect("it boots");
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    (csv(&setup, &flight), link.close_log())
}

pub fn replayed(bytes: &[u8]) -> (Log, Replayed) {
    let log = read(bytes, None).expect("a log");
    let replayed = replay(&log, None).expect("it can be replayed");
    (log, replayed)
}

/// Its replay is the flight; how many frames had a fix.
fn assert_same(scenario: Scenario) -> usize {
    let frames = scenario.run.frames as usize;
    let (fixes, bytes) = flown(scenario);
    let (log, replayed) = replayed(&bytes);
    assert_eq!(replayed.first_difference, None);
    assert_eq!((replayed.different, replayed.gaps, replayed.end), (0, 0, End::Closed));
    assert_eq!((replayed.same, replayed.replayed), (replayed.frames, replayed.records));
    assert_eq!(fixes_csv(&log, None, &replayed).expect("placed"), fixes);
    assert_eq!(fixes.lines().count(), frames + 1);
    replayed.accepted
}

#[test]
fn a_quiet_flight() {
    assert!(assert_same(scenario(1, 30)) > 25);
}

#[test]
fn a_bad_link_and_a_laser_that_misses() {
    let mut scenario = scenario(2, 40);
    scenario.faults.range.dropout_percent = 20.0;
    let faults = &mut scenario.faults.link_faults;
    (faults.bit_error_percent, faults.cut_percent, faults.unknown_percent) = (0.02, 2.0, 2.0);
    assert!(assert_same(scenario) > 5);
}

#[test]
fn a_rolling_shutter_on_a_measured_axis() {
    let mut scenario = scenario(3, 20);
    (scenario.vehicle.rolling_shutter_ms, scenario.vehicle.follow_up.mode) = (20.0, FollowUpMode::Measured);
    scenario.world.follow_up.servo_lag_s = 0.3;
    assert!(assert_same(scenario) > 10);
}

#[test]
fn lost_edges_bounces_lost_frames_and_no_pulses() {
    let mut scenario = scenario(4, 40);
    let faults = &mut scenario.faults.shutter;
    (faults.lost_edge_percent, faults.extra_edge_percent, faults.lost_frame_percent) = (15.0, 15.0, 15.0);
    scenario.faults.timer.pps_lost_s = Some([4.0, 7.0]);
    assert!(assert_same(scenario) > 5);
}

#[test]
fn one_edge_and_none() {
    for edges in [EdgeSource::One, EdgeSource::None] {
        let mut scenario = scenario(5, 10);
        scenario.vehicle.shutter.edges = edges;
        assert!(assert_same(scenario) > 5);
    }
}

/// A replay has no pixels that could be bright or dark: the commands are in the log, and stamps of one edge go by them.
#[test]
fn an_exposure_that_is_controlled() {
    let mut scenario = scenario(6, 40);
    (scenario.vehicle.auto_exposure.is_on, scenario.vehicle.shutter.edges) = (true, EdgeSource::One);
    scenario.world.light = Light { from_stops: -2.0, to_stops: 2.0, ..Light::default() };
    assert!(assert_same(scenario) > 30);
}
