//! A settings file: what a scenario file says, as far as it is about the vehicle and not about the world.

use super::mission_of;
use crate::scenario::Scenario;
use crate::stage::camera_of;
use plumbline_firmware::stores::mission::Mission;
use plumbline_survey::error::InputError;
use std::path::Path;
use toml::{Table, Value};

/// The keys, each with those of its table; a table without any is a plain key.
const KEYS: [(&str, &[&str]); 14] = [
    ("head", &[]),
    ("send_patches", &[]),
    ("search_px", &[]),
    ("resolution_m", &[]),
    ("exposure_us", &[]),
    ("rolling_shutter_ms", &[]),
    ("mount", &["lever_arm_m", "boresight_deg"]),
    ("flight", &["tilt_max_deg", "tilt_hz", "speed_m_s"]),
    ("attitude", &["rate_hz", "delay_us", "lag", "white_deg", "drift_deg", "heading_white_deg", "heading_drift_deg"]),
    ("follow_up", &["mode", "noise_deg", "delay_us"]),
    ("range", &["sigma_m", "rate_hz", "delay_us"]),
    ("position", &["sigma_m", "white_m", "velocity_sigma_m_s", "rate_hz", "delay_us"]),
    (
        "shutter",
        &[
            "edges",
            "edge_jitter_us",
            "open_delay_us",
            "close_delay_us",
            "exposure_jitter_us",
            "arrival_latency_us",
            "arrival_jitter_us",
        ],
    ),
    ("timer", &["pps_jitter_us", "rate_walk_ppm"]),
];

/// The mission of a camera file, of one of its heads where it has several, and, where given, of a settings file: its text and
/// its name. What is not said is as in the default scenario.
///
/// # Errors
/// One sentence for a camera that cannot be used, a key that is none of a mission's, a value out of its range.
pub fn mission(camera: &Path, head: Option<u8>, settings: Option<(&str, &str)>) -> Result<Mission, InputError> {
    let refuse = |why: String| InputError::new(why);
    let (text, name) = settings.unwrap_or(("", "settings"));
    let mut table: Table = toml::from_str(text).map_err(|error| {
        refuse(format!("{name}: {}", error.message().split_whitespace().collect::<Vec<_>>().join(" ")))
    })?;
    for (key, value) in &table {
        let known = KEYS.iter().find(|(known, _)| known == key).map(|(_, keys)| *keys);
        let none = |key: &str| refuse(format!("{name}: {key} is no setting of a mission"));
        let inner = known.ok_or_else(|| none(key))?;
        let unknown = value.as_table().and_then(|table| table.keys().find(|key| !inner.contains(&key.as_str())));
        if let Some(unknown) = unknown {
            return Err(none(&format!("{key}.{unknown}")));
        }
    }
    let send_patches = match table.remove("send_patches") {
        None => true,
        Some(Value::Boolean(send)) => send,
        Some(_) => return Err(refuse(format!("{name}: send_patches is neither true nor false"))),
    };
    let text = toml::to_string(&table).map_err(|error| refuse(format!("{name}: {error}")))?;
    // The camera takes its place before anything is checked against it.
    let mut scenario: Scenario =
        toml::from_str(&text).map_err(|error| refuse(format!("{name}: {}", error.message().replace('\n', " "))))?;
    scenario.camera_file = Some(camera.to_owned());
    if head.is_some() && scenario.head.is_some() {
        return Err(refuse(format!("{name}: head is given, and --head too")));
    }
    scenario.head = scenario.head.or(head);
    let file = camera_of(&mut scenario)?;
    Ok(Mission { send_patches, ..mission_of(&scenario, &file) })
}
