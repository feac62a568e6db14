//! The configuration store of a scenario: camera, sensors and shutter. All calibrated values are the true ones.

pub mod settings;
mod stamps;

use crate::scenario::{FollowUpMode, Scenario};
use crate::vehicle::mount::configured_arm;
use plumbline_firmware::stores::configuration::Configuration;
use plumbline_survey::camera_file::CameraFile;
use std::f64::consts::TAU;

/// How fast the synthetic track turns at most, radians a second: see [`crate::vehicle::motion`].
const WEAVE_RAD_S: f64 = 0.35;

/// The configuration of `scenario`, with the camera of `camera`.
pub fn configuration_of(scenario: &Scenario, camera: &CameraFile) -> Configuration {
    Configuration {
        frame: (camera.cols as u16, camera.rows as u16),
        fov_rad: (camera.fov_h_deg.to_radians() as f32, camera.fov_v_deg.to_radians() as f32),
        offset_px: (camera.offset_m_px as f32, camera.offset_n_px as f32),
        distortion: camera.distortion.map(|d| [d.k1, d.k2, d.k3, d.p1, d.p2].map(|k| k as f32)),
        follow_up: match scenario.follow_up.mode {
            FollowUpMode::Followed => 0,
            FollowUpMode::Measured => 1,
            FollowUpMode::Fixed => 2,
        },
        lever_arm_m: configured_arm(scenario).map(|m| m as f32),
        boresight_rad: scenario.mount.boresight_deg.map(|deg| deg.to_radians() as f32),
        sigmas: sigmas_of(scenario),
        motions: motions_of(scenario),
        latencies_us: latencies_of(scenario),
        readout_us: scenario.rolling_shutter_us() as u32,
        lag: scenario.attitude.lag,
        limits_us: limits_of(scenario),
        search_px: scenario.search_px,
        send_patches: true,
        stamps: stamps::of(scenario),
    }
}

/// One sigma of each source, as its data sheet would say: tilt white and drift, heading white and drift, follow-up, range,
/// position white and drift, velocity.
fn sigmas_of(scenario: &Scenario) -> [f32; 9] {
    let attitude = &scenario.attitude;
    let follow_up = if scenario.follow_up.mode == FollowUpMode::Measured { scenario.follow_up.noise_deg } else { 0.0 };
    let radians = |deg: f64| deg.to_radians() as f32;
    // A centimetre is what the message resolves, of range and of velocity.
    let resolved = |sigma: f64| sigma.hypot(0.003) as f32;
    [
        radians(attitude.white_deg),
        radians(attitude.drift_deg),
        radians(attitude.heading_white_deg.unwrap_or(attitude.white_deg)),
        radians(attitude.heading_drift_deg.unwrap_or(attitude.drift_deg)),
        radians(follow_up),
        resolved(scenario.range.sigma_m),
        scenario.position.white_m as f32,
        scenario.position_sigma_m() as f32,
        resolved(scenario.position.velocity_sigma_m_s),
    ]
}

/// What the vehicle may do, as who prepares a flight would know it: tilts as large and as fast as the scenario's, in a
/// replayed log a shake beside them.
fn motions_of(scenario: &Scenario) -> [(u32, [f32; 4]); 2] {
    let interval_us = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let radians = |deg: f64| deg.to_radians() as f32;
    let period_s = (1.0 / scenario.flight.tilt_hz[1]) as f32;
    let tilt = radians(scenario.flight.tilt_max_deg.max(1.0));
    let shake = if scenario.replay.is_some() { radians(1.0) } else { 0.0 };
    let weave_m = (scenario.flight.speed_m_s / WEAVE_RAD_S) as f32;
    let weave = [weave_m, (TAU / WEAVE_RAD_S) as f32, 0.0, 1.0];
    let position = (interval_us(scenario.position.rate_hz), weave);
    [(interval_us(scenario.attitude.rate_hz), [tilt, period_s, shake, 0.7]), position]
}

/// How much older than their stamps the sensors' values are, microseconds: calibrated.
fn latencies_of(scenario: &Scenario) -> [u32; 4] {
    [scenario.attitude.delay_us, scenario.follow_up.delay_us, scenario.range.delay_us, scenario.position.delay_us]
}

/// Attitude gap, range gap, position age, patience, microseconds: a few sample intervals of each stream.
fn limits_of(scenario: &Scenario) -> [u32; 4] {
    let interval = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let attitude = (4 * interval(scenario.attitude.rate_hz)).max(100_000);
    let range = (4 * interval(scenario.range.rate_hz)).max(100_000);
    [attitude, range, 1_000_000, 200_000]
}
