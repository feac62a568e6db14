//! How far a frame can see.

use super::{Payload, Scenario};
use plumbline_survey::camera_file::CameraFile;
use std::f64::consts::FRAC_PI_2;

/// Metres from the nadir to the farthest ground point that a frame of a synthetic flight can show: H tan(ω + tilt) at
/// the largest height, ω being the angle from the axis to the frame's corner and the tilt that of pitch and roll both
/// at their largest. Over flat ground; infinite when the horizon comes into the frame.
#[must_use]
pub fn footprint_margin_m(scenario: &Scenario, payload: &Payload) -> f64 {
    let tilt_max_rad = scenario.vehicle.flight.tilt_max_deg.to_radians();
    footprint_margin_at_m(scenario, payload, tilt_max_rad.cos().powi(2).acos())
}

/// As [`footprint_margin_m`] for a given angle between the follow-up axis and vertical, radians; a replay's is
/// [`AttitudeLog::largest_tilt_rad`](crate::vehicle::motion::AttitudeLog::largest_tilt_rad). The camera may lean away from
/// that axis by its boresight.
#[must_use]
pub fn footprint_margin_at_m(scenario: &Scenario, payload: &Payload, tilt_rad: f64) -> f64 {
    let [_, pitch_rad, roll_rad] = payload.mount.true_boresight_rad;
    let leans_rad = (pitch_rad.cos() * roll_rad.cos()).acos();
    let off_nadir_rad = corner_tangent(&payload.camera).atan() + tilt_rad + leans_rad;
    if off_nadir_rad < FRAC_PI_2 { scenario.run.flight.height_m[1] * off_nadir_rad.tan() } else { f64::INFINITY }
}

/// Tangents from the camera's axis to the frame's right border and to its upper one, about the farther corner with its
/// distortion.
#[must_use]
pub fn half_tangents(camera: &CameraFile) -> [f64; 2] {
    let borders = borders(camera);
    let stretched = corner_tangent(camera) / borders[0].hypot(borders[1]);
    borders.map(|tangent| tangent * stretched)
}

/// Tangents to the frame's farther borders, across and along, without distortion.
fn borders(camera: &CameraFile) -> [f64; 2] {
    let (k_h, k_v) = camera.tangent_per_px();
    let across = k_h * (0.5 * f64::from(camera.cols) + camera.offset_m_px.abs());
    [across, k_v * (0.5 * f64::from(camera.rows) + camera.offset_n_px.abs())]
}

/// Tangent of the angle from the camera's axis to the farthest corner of the frame. A barrel distortion sees farther
/// than the nominal field of view. Infinite where the distortion never reaches the corner. The tangential part, small
/// in any lens, is left out.
fn corner_tangent(camera: &CameraFile) -> f64 {
    let [across, along] = borders(camera);
    let distorted = across.hypot(along);
    let Some(d) = camera.distortion else { return distorted };
    // Outwards from the axis until the distorted radius passes the corner; a bisection within that step.
    let image = |r: f64| r * (1.0 + r * r * (d.k1 + r * r * (d.k2 + r * r * d.k3)));
    let step = distorted / 64.0;
    let outside = (1..=640).map(|count| f64::from(count) * step).find(|&r| image(r) >= distorted);
    let Some(mut high) = outside else { return f64::INFINITY };
    let mut low = high - step;
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if image(middle) < distorted { low = middle } else { high = middle }
    }
    high
}
