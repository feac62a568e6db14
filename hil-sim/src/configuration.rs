//! The configuration store of a vehicle: camera, sensors and shutter. All calibrated values are the true ones.

pub mod key;
mod link;
pub mod settings;
mod stamps;

use crate::scenario::{FollowUpMode, Payload, Vehicle};
use crate::vehicle::mount::configured_arm;
use plumbline_firmware::stores::configuration::Configuration;
use std::f64::consts::TAU;

/// How fast a course is expected to turn at most, radians a second: 20 degrees a second, which the synthetic track reaches
/// (`vehicle/motion/track.rs`).
const WEAVE_RAD_S: f64 = 0.35;

/// The configuration of a vehicle with its payload. `shake_deg`: what its attitude does beside the tilts, one sigma.
pub fn configuration_of(vehicle: &Vehicle, payload: &Payload, shake_deg: f64) -> Configuration {
    let camera = &payload.camera;
    Configuration {
        frame: (camera.cols as u16, camera.rows as u16),
        fov_rad: (camera.fov_h_deg.to_radians() as f32, camera.fov_v_deg.to_radians() as f32),
        offset_px: (camera.offset_m_px as f32, camera.offset_n_px as f32),
        distortion: camera.distortion.map(|d| [d.k1, d.k2, d.k3, d.p1, d.p2].map(|k| k as f32)),
        follow_up: match vehicle.follow_up.mode {
            FollowUpMode::Followed => 0,
            FollowUpMode::Measured => 1,
            FollowUpMode::Fixed => 2,
        },
        lever_arm_m: configured_arm(&payload.mount, vehicle.follow_up.mode).map(|m| m as f32),
        boresight_rad: payload.mount.boresight_rad.map(|rad| rad as f32),
        sigmas: sigmas_of(vehicle),
        motions: motions_of(vehicle, shake_deg),
        latencies_us: latencies_of(vehicle),
        readout_us: vehicle.rolling_shutter_us() as u32,
        lag: vehicle.attitude.lag,
        limits_us: limits_of(vehicle),
        search_px: vehicle.search_px,
        send_patches: vehicle.send_patches,
        stamps: stamps::of(vehicle),
        link: link::of(vehicle),
    }
}

/// One sigma of each source, as its data sheet would say: tilt white and drift, heading white and drift, follow-up, range,
/// position white and drift, velocity, that of turns, altitude's bias and scale.
fn sigmas_of(vehicle: &Vehicle) -> [f32; 12] {
    let attitude = &vehicle.attitude;
    let follow_up = if vehicle.follow_up.mode == FollowUpMode::Measured { vehicle.follow_up.noise_deg } else { 0.0 };
    let radians = |deg: f64| deg.to_radians() as f32;
    // A centimetre is what the message resolves, of range and of velocity.
    let resolved = |sigma: f64| sigma.hypot(0.003) as f32;
    [
        radians(attitude.white_deg),
        radians(attitude.drift_deg),
        radians(attitude.heading_white_deg.unwrap_or(attitude.white_deg)),
        radians(attitude.heading_drift_deg.unwrap_or(attitude.drift_deg)),
        radians(follow_up),
        resolved(vehicle.range.sigma_m),
        vehicle.position.white_m as f32,
        vehicle.position_sigma_m() as f32,
        resolved(vehicle.position.velocity_sigma_m_s),
        attitude.turn_velocity_sigma_m_s as f32,
        vehicle.altitude.sigma_m as f32,
        vehicle.altitude.scale_sigma as f32,
    ]
}

/// What the vehicle may do, as who prepares a flight would know it: tilts as large and as fast as it is configured for, and a
/// shake beside them.
fn motions_of(vehicle: &Vehicle, shake_deg: f64) -> [(u32, [f32; 4]); 2] {
    let interval_us = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let radians = |deg: f64| deg.to_radians() as f32;
    let period_s = (1.0 / vehicle.flight.tilt_hz[1]) as f32;
    let tilt = radians(vehicle.flight.tilt_max_deg.max(1.0));
    let weave_m = (vehicle.flight.speed_m_s / WEAVE_RAD_S) as f32;
    let weave = [weave_m, (TAU / WEAVE_RAD_S) as f32, 0.0, 1.0];
    let position = (interval_us(vehicle.position.rate_hz), weave);
    [(interval_us(vehicle.attitude.rate_hz), [tilt, period_s, radians(shake_deg), 0.7]), position]
}

/// How much older than their stamps the sensors' values are, microseconds: calibrated.
fn latencies_of(vehicle: &Vehicle) -> [u32; 4] {
    [vehicle.attitude.delay_us, vehicle.follow_up.delay_us, vehicle.range.delay_us, vehicle.position.delay_us]
}

/// Attitude gap, range gap, position age, patience, microseconds: a few sample intervals of each stream.
fn limits_of(vehicle: &Vehicle) -> [u32; 4] {
    let interval = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let attitude = (4 * interval(vehicle.attitude.rate_hz)).max(100_000);
    let range = (4 * interval(vehicle.range.rate_hz)).max(100_000);
    [attitude, range, 1_000_000, 200_000]
}
