//! Stamps of whole flights in-process: edges and pulses over the link, stamps back by telemetry.

use plumbline_core::stamp::StampSource;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{FrameRecord, Keep, fly};
use plumbline_sim::scenario::{Camera, EdgeSource, Scenario};
use plumbline_sim::score::stamps::{Stamps, error, stamps};
use plumbline_sim::setup::Setup;

/// Of the stamps' errors. Σ(error/sigma)² of n independent errors has a standard deviation of √(2/n): 0.032 over 2,000 frames.
const NEES: std::ops::Range<f64> = 0.9..1.1;

/// A small camera, as the pictures do not matter, with pulses, every fault of the shutter's line and a timer that wraps in
/// the flight.
fn scenario(seed: u64, frames: u32) -> Scenario {
    let mut scenario = Scenario::seeded(seed, frames);
    scenario.vehicle.exposure_us = 5000;
    scenario.world.timer.pps = true;
    scenario.camera = Camera::of_size(32, 32);
    (scenario.vehicle.resolution_m, scenario.vehicle.search_px) = (10.0, 3);
    // Slow streams are as good here.
    (scenario.vehicle.attitude.rate_hz, scenario.vehicle.range.rate_hz) = (20, 10);
    let (shutter, faults) = (&mut scenario.vehicle.shutter, &mut scenario.faults.shutter);
    (shutter.open_delay_us, shutter.close_delay_us) = (35, 20);
    (shutter.arrival_latency_us, shutter.arrival_jitter_us) = (800, 40.0);
    shutter.exposure_jitter_us = 20.0;
    (faults.lost_edge_percent, faults.extra_edge_percent, faults.lost_frame_percent) = (2.0, 2.0, 2.0);
    scenario
}

fn flown(scenario: Scenario) -> Vec<FrameRecord> {
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    println!("{:?}", flight.health.stamps);
    flight.frames
}

fn told(name: &str, stamps: &Stamps) -> (f64, f64) {
    println!("{name}: {stamps:?}");
    (stamps.rms_us.expect("stamps"), stamps.nees_mean.expect("stamps"))
}

/// Two flights of a thousand frames.
fn holds(edges: EdgeSource, limit_us: f64) {
    let flights = (1..=2).flat_map(|seed| {
        let mut scenario = scenario(seed, 1000);
        scenario.vehicle.shutter.edges = edges;
        flown(scenario)
    });
    let stamps = stamps(&flights.collect::<Vec<_>>());
    let (rms_us, nees) = told(&format!("{edges:?}"), &stamps);
    assert!(rms_us <= limit_us && NEES.contains(&nees));
    // What is lost on its way has no stamp: 2 in 100 frames.
    assert!(stamps.sources["none"] < 70, "{:?}", stamps.sources);
}

#[test]
fn flown_stamps_of_both_edges() {
    holds(EdgeSource::Both, 10.0);
}

#[test]
fn flown_stamps_of_one_edge() {
    holds(EdgeSource::One, 100.0);
}

#[test]
fn flown_stamps_by_arrival() {
    holds(EdgeSource::None, 100.0);
}

/// The pulses are gone from the 20th to the 100th second: the frames from the 80th on.
#[test]
fn flown_stamps_outlive_the_pulses() {
    let mut scenario = scenario(3, 400);
    scenario.faults.timer.pps_lost_s = Some([20.0, 100.0]);
    let frames = flown(scenario);
    let late: Vec<FrameRecord> =
        frames.into_iter().filter(|f| (80e6..100e6).contains(&(f.exposure.open_us as f64))).collect();
    let (rms_us, _) = told("60 s without pulses", &stamps(&late));
    assert!(rms_us <= 100.0 && late.len() > 70);
    for (error_us, sigma_us, _) in late.iter().filter_map(error) {
        assert!(error_us.abs() < 5.5 * sigma_us, "{error_us} us, sigma {sigma_us}");
    }
    for stamp in late.iter().filter_map(|f| f.instant?.stamp) {
        assert!(stamp.by_pulses && (60..=80).contains(&stamp.free_wheeling_s), "{stamp:?}");
    }
}

/// No pulses at all: TIMESYNC alone, whose quickest round trips take 1.6 ms and more, and not evenly.
#[test]
fn flown_stamps_without_pulses_say_how_little_they_know() {
    let mut scenario = scenario(4, 100);
    scenario.world.timer.pps = false;
    let frames = flown(scenario);
    for (error_us, sigma_us, source) in frames.iter().filter_map(error) {
        // Evenly within plus and minus half the round trip: 0.46 ms of 1.6, 0.87 of 3.
        assert!(error_us.abs() < 3.0 * sigma_us, "{error_us} us, sigma {sigma_us}");
        assert!((460.0..1000.0).contains(&sigma_us), "{error_us} us, sigma {sigma_us}");
        assert!(source != StampSource::Arrival);
    }
    let told: Vec<_> = frames.iter().filter_map(|f| f.instant?.stamp).collect();
    assert!(told.len() > 90 && told.iter().all(|stamp| !stamp.by_pulses && stamp.free_wheeling_s == u32::MAX));
}
