//! A settings file: what a scenario file says, as far as it is about the vehicle and not about the world.

use super::configuration_of;
use crate::scenario::{Scenario, line_of, sentence};
use crate::vehicle::mount::camera_of;
use plumbline_firmware::stores::configuration::Configuration;
use plumbline_survey::error::InputError;
use std::path::Path;
use toml::de::{DeTable, DeValue};

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

/// The configuration of a camera file, of one of its heads where it has several, and, where given, of a settings file: its text and
/// its name. What is not said is as in the default scenario.
///
/// # Errors
/// One sentence for a camera that cannot be used, a key that is none of a configuration's, a value out of its range.
pub fn configuration(
    camera: &Path,
    head: Option<u8>,
    settings: Option<(&str, &str)>,
) -> Result<Configuration, InputError> {
    let (text, name) = settings.unwrap_or(("", "settings"));
    let (own, send_patches) = of_a_scenario(text, name)?;
    // The camera takes its place before anything is checked against it.
    let read: Result<Scenario, _> = toml::from_str(&own);
    let mut scenario = read.map_err(|error| InputError::new(sentence(name, text, &error).to_string()))?;
    scenario.camera_file = Some(camera.to_owned());
    if head.is_some() && scenario.head.is_some() {
        return Err(InputError::new(format!("{name}: head is given, and --head too")));
    }
    scenario.head = scenario.head.or(head);
    let file = camera_of(&mut scenario)?;
    Ok(Configuration { send_patches, ..configuration_of(&scenario, &file) })
}

/// The settings without `send_patches`, which no scenario has, everything else in its place, and whether patches are sent.
fn of_a_scenario(text: &str, name: &str) -> Result<(String, bool), InputError> {
    let refuse = |at: usize, why: &str| InputError::new(format!("{name}{}: {why}", line_of(text, at)));
    let none = |at: usize, key: &str| refuse(at, &format!("{key} is no setting of a configuration"));
    let table = DeTable::parse(text).map_err(|error| InputError::new(sentence(name, text, &error).to_string()))?;
    let (mut own, mut send_patches) = (text.to_owned(), true);
    for (key, value) in table.get_ref() {
        let (at, key) = (key.span().start, key.get_ref().as_ref());
        let (_, inner) = KEYS.iter().find(|(known, _)| *known == key).ok_or_else(|| none(at, key))?;
        if let DeValue::Table(table) = value.get_ref()
            && let Some((unknown, _)) = table.iter().find(|(own, _)| !inner.contains(&own.get_ref().as_ref()))
        {
            return Err(none(unknown.span().start, &format!("{key}.{}", unknown.get_ref())));
        }
        if key == "send_patches" {
            let DeValue::Boolean(send) = value.get_ref() else {
                return Err(refuse(at, "send_patches is neither true nor false"));
            };
            send_patches = *send;
            let end = value.span().end;
            own.replace_range(at..end, &" ".repeat(end - at));
        }
    }
    Ok((own, send_patches))
}
