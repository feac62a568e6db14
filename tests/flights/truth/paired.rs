//! One flight twice, with one thing different: what that thing costs a fix, without what all fixes have in common.

use super::{Flown, flown, flown_told, mean, scenario};
use plumbline_core::stamp::StampSource;
use plumbline_firmware::wire::telemetry::FixReport;
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::stamps::error;

/// Half of the exposure.
const HALF_US: i32 = 2500;

/// Pitch and roll at 20 deg/s each, root mean square (2 · 10° √0.0919 · 2π √(mean f²)), 40 m/s, 5 ms of exposure as a
/// smear, attitude at 200 Hz that arrives 5 ms late.
fn fast(frames: u32) -> Scenario {
    let mut scenario = scenario(7, frames);
    (scenario.vehicle.flight.tilt_max_deg, scenario.vehicle.flight.tilt_hz) = (10.0, [0.4, 0.65]);
    scenario.vehicle.flight.speed_m_s = 40.0;
    (scenario.vehicle.exposure_us, scenario.world.exposure_samples) = (2 * HALF_US as u32, 5);
    (scenario.vehicle.attitude.rate_hz, scenario.world.attitude.latency_us) = (200, 5000);
    scenario
}

/// A shutter's line as it is in the field, and a timer of 20 ppm.
fn field(frames: u32) -> Scenario {
    let mut scenario = fast(frames);
    scenario.world.timer.drift_ppm = 20.0;
    let (shutter, faults) = (&mut scenario.vehicle.shutter, &mut scenario.faults.shutter);
    shutter.edge_jitter_us = 2.0;
    (shutter.open_delay_us, shutter.close_delay_us) = (35, 20);
    (shutter.arrival_latency_us, shutter.arrival_jitter_us) = (800, 40.0);
    shutter.exposure_jitter_us = 20.0;
    scenario.world.timer.pps = true;
    (faults.lost_edge_percent, faults.extra_edge_percent) = (2.0, 2.0);
    scenario
}

/// These exposures by a line without noise and faults and a timer without drift: stamps as exact as a timer of 1 MHz
/// can give them.
fn perfect(frames: u32) -> Flown {
    let mut scenario = field(frames);
    scenario.vehicle.shutter.edge_jitter_us = 0.0;
    (scenario.faults.shutter.lost_edge_percent, scenario.faults.shutter.extra_edge_percent) = (0.0, 0.0);
    scenario.world.timer.drift_ppm = 0.0;
    (scenario.vehicle.timer.rate_walk_ppm, scenario.vehicle.timer.pps_jitter_us) = (0.0, 0.0);
    let perfect = flown(scenario);
    for frame in &perfect.frames {
        let (error_us, _, source) = error(frame).expect("a stamp");
        assert!(error_us.abs() <= 1.5 && source == StampSource::BothEdges, "{error_us} us");
    }
    perfect
}

/// Root mean square distance of the fixes of two flights, pixels of the reference, over frames fixed in both; how many
/// those are.
fn apart(name: &str, a: &Flown, b: &Flown) -> (f64, usize) {
    let fix = |flown: &Flown, index: usize| flown.frames[index].report.and_then(|report| report.fix);
    let pairs = (0..a.frames.len()).filter_map(|index| fix(a, index).zip(fix(b, index)));
    let apart = |(a, b): (FixReport, FixReport)| f64::from(a.east_m - b.east_m).hypot(f64::from(a.north_m - b.north_m));
    let apart_px: Vec<f64> = pairs.map(|pair| apart(pair) / a.resolution_m).collect();
    let rms_px = mean(apart_px.iter().map(|px| px * px)).sqrt();
    let max_px = apart_px.iter().copied().fold(0.0, f64::max);
    println!("{name}: {rms_px:.5} px RMS, {max_px:.5} px at most, over {} frames", apart_px.len());
    (rms_px, apart_px.len())
}

/// 10 us at 20 deg/s are 0.0002°, half a millimetre of a pixel's five metres.
#[test]
fn stamps_from_the_field_cost_nothing_against_perfect_ones() {
    let (perfect, field_flown) = (perfect(40), flown(field(40)));
    let (rms_px, both) = apart("stamps from the field", &field_flown, &perfect);
    assert!(rms_px <= 0.005 && both >= 36, "{rms_px} px over {both}");
    // Told that its edges come half of the exposure late, the firmware stamps where the shutter opens.
    let start = flown_told(field(20), |configuration| {
        let stamps = &mut configuration.stamps;
        (stamps.delays_us.0, stamps.delays_us.1) = (stamps.delays_us.0 + HALF_US, stamps.delays_us.1 + HALF_US);
        stamps.readout_us.0 += HALF_US as u32;
    });
    let early_us = mean(start.frames.iter().filter_map(error).map(|(error_us, ..)| error_us));
    assert!((early_us + f64::from(HALF_US)).abs() < 10.0, "{early_us} us");
    let (rms_px, both) = apart("stamps at the start", &start, &perfect);
    assert!(rms_px > 0.005 && both >= 18, "a stamp at the start of the exposure passes: {rms_px} px over {both}");
}

/// With the middle row's pose for all rows the first and the last are 0.2° off, a tenth of a pixel, and half of that is left
/// in the fix. A rate known to 1 deg/s leaves 0.01°, 0.005 px; three of that. Against a global shutter.
#[test]
fn bands_take_a_rolling_shutter_off() {
    let flight = |rolling_shutter_ms| {
        let mut scenario = fast(40);
        (scenario.vehicle.rolling_shutter_ms, scenario.world.exposure_samples) = (rolling_shutter_ms, 1);
        flown(scenario)
    };
    let (rms_px, both) = apart("rolling shutter", &flight(20.0), &flight(0.0));
    assert!(both >= 36 && rms_px <= 0.015, "{rms_px} px over {both}");
}
