//! What the messages of a recording say.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plumbline_firmware::wire::telemetry::FixReport;
use plumbline_sim::run::FrameRecord;
use plumbline_sim::score::fixes::reason;
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::motion::TrueState;
use plumbline_sim::vehicle::mount::antenna;
use plumbline_survey::error::InputError;
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

/// Radius of the ellipse in sigmas that holds 95 % of a normal distribution in the plane: the root of chi-square's quantile, 5.991.
const SIGMAS: f64 = 2.4477;
/// Thickness of an ellipse, metres: as thin as can be seen from the side.
const THIN_M: f64 = 0.1;
/// Of Foxglove's LocationFix: nothing is said, or all of it.
const UNKNOWN: u8 = 0;
const KNOWN: u8 = 3;
/// Of Foxglove's Log.
const WARNING: u8 = 3;

fn time(at_us: u64) -> Value {
    json!({ "sec": at_us / 1_000_000, "nsec": at_us % 1_000_000 * 1000 })
}

/// A picture, PNG.
pub(super) fn image(at_us: u64, frame_id: &str, png: &[u8]) -> Value {
    json!({ "timestamp": time(at_us), "frame_id": frame_id, "data": STANDARD.encode(png), "format": "png" })
}

/// The true pose of the camera: where the vehicle is, and how it is turned.
pub(super) fn transform(at_us: u64, setup: &Setup, truth: &TrueState) -> Value {
    let [east_m, north_m] = [truth.east_m - setup.tile_centre[0], truth.north_m - setup.tile_centre[1]];
    let [x, y, z, w] = rotation(truth);
    json!({
        "timestamp": time(at_us),
        "parent_frame_id": "map",
        "child_frame_id": "vehicle",
        "translation": { "x": east_m, "y": north_m, "z": truth.up_m },
        "rotation": { "x": x, "y": y, "z": z, "w": w },
    })
}

/// Quaternion from forward, left, up to east, north, up: about up by the angle of forward from east, then about left, nose
/// down, then about forward, right wing down.
fn rotation(truth: &TrueState) -> [f64; 4] {
    let half = [truth.roll_rad, -truth.pitch_rad, FRAC_PI_2 - truth.heading_rad].map(|angle| 0.5 * angle);
    let [[sx, cx], [sy, cy], [sz, cz]] = half.map(|angle| [angle.sin(), angle.cos()]);
    [sx * cy * cz - cx * sy * sz, cx * sy * cz + sx * cy * sz, cx * cy * sz - sx * sy * cz, cx * cy * cz + sx * sy * sz]
}

/// Where the antenna truly was, which fixes are of.
///
/// # Errors
/// A place that the grid cannot express.
pub(super) fn true_place(at_us: u64, setup: &Setup, truth: &TrueState) -> Result<Value, InputError> {
    place(at_us, setup, antenna(truth, &setup.payload.mount), None)
}

/// A fix with its covariance, at a height that it says nothing of.
///
/// # Errors
/// A place that the grid cannot express.
pub(super) fn fix(at_us: u64, setup: &Setup, fix: &FixReport, up_m: f64) -> Result<Value, InputError> {
    let [east_m, north_m] = [fix.east_m, fix.north_m].map(f64::from);
    let place_m = [setup.tile_centre[0] + east_m, setup.tile_centre[1] + north_m, up_m];
    place(at_us, setup, place_m, Some(fix))
}

fn place(at_us: u64, setup: &Setup, place_m: [f64; 3], fix: Option<&FixReport>) -> Result<Value, InputError> {
    let [east_m, north_m, up_m] = place_m;
    let (lat_deg, lon_deg) = setup.crs.to_wgs84(east_m, north_m)?;
    let mut covariance = [0.0; 9];
    if let Some(fix) = fix {
        covariance[0] = f64::from(fix.variance_east_m2);
        [covariance[1], covariance[3]] = [f64::from(fix.covariance_m2); 2];
        covariance[4] = f64::from(fix.variance_north_m2);
    }
    Ok(json!({
        "timestamp": time(at_us),
        "frame_id": "map",
        "latitude": lat_deg,
        "longitude": lon_deg,
        "altitude": up_m,
        "position_covariance": covariance,
        "position_covariance_type": if fix.is_some() { KNOWN } else { UNKNOWN },
    }))
}

/// The ellipse of a fix that holds the truth in 95 % of all cases, at the vehicle's height.
pub(super) fn ellipse(at_us: u64, frame: u32, fix: &FixReport, up_m: f64) -> Value {
    let [a, b, c] = [fix.variance_east_m2, fix.covariance_m2, fix.variance_north_m2].map(f64::from);
    let (middle, spread) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
    let [long_m, short_m] =
        [middle + spread, (middle - spread).max(0.0)].map(|variance| 2.0 * SIGMAS * variance.sqrt());
    // Of the long axis from east, counter-clockwise.
    let half_angle = 0.25 * (2.0 * b).atan2(a - c);
    let position = json!({ "x": fix.east_m, "y": fix.north_m, "z": up_m });
    let orientation = json!({ "x": 0.0, "y": 0.0, "z": half_angle.sin(), "w": half_angle.cos() });
    json!({
        "entities": [{
            "timestamp": time(at_us),
            "frame_id": "map",
            "id": format!("fix {frame}"),
            "lifetime": { "sec": 0, "nsec": 0 },
            "frame_locked": false,
            "spheres": [{
                "pose": { "position": position, "orientation": orientation },
                "size": { "x": long_m, "y": short_m, "z": THIN_M },
                "color": { "r": 0.1, "g": 0.6, "b": 0.3, "a": 0.5 },
            }],
        }],
    })
}

/// Why a frame has no fix.
pub(super) fn without_fix(at_us: u64, record: &FrameRecord) -> Value {
    let why = reason(record.report.as_ref()).unwrap_or("none");
    let message = format!("frame {}: no fix ({why})", record.exposure.frame);
    json!({ "timestamp": time(at_us), "level": WARNING, "message": message, "name": "plumbline" })
}
