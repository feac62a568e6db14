//! A settings file: the vehicle's part of a scenario.

use super::configuration_of;
use crate::scenario::{Reader, Scenario, Vehicle};
use crate::vehicle::mount::payload_of_file;
use plumbline_firmware::stores::configuration::Configuration;
use plumbline_survey::error::InputError;
use std::path::Path;

/// The configuration of a camera file, of one of its heads where it has several, and, where given, of a settings file: its
/// text and its name. What is not said is as in the default scenario.
///
/// # Errors
/// One sentence for a camera that cannot be used, a key that is none of a vehicle's, a value out of its range.
pub fn configuration(
    camera: &Path,
    head: Option<u8>,
    settings: Option<(&str, &str)>,
) -> Result<Configuration, InputError> {
    let (text, name) = settings.unwrap_or(("", "settings"));
    let mut vehicle = read(text, name)?;
    if head.is_some() && vehicle.head.is_some() {
        return Err(InputError::new(format!("{name}: head is given, and --head too")));
    }
    vehicle.head = vehicle.head.or(head);
    let payload = payload_of_file(&vehicle, None, camera)?;
    Ok(configuration_of(&vehicle, &payload, 0.0))
}

fn read(text: &str, name: &str) -> Result<Vehicle, InputError> {
    let vehicle = keys(text, name)?;
    vehicle.check().map_err(|what| InputError::new(what).at(name))?;
    Ok(vehicle)
}

/// The settings as they stand in a file's text, whose values are not checked against each other.
///
/// # Errors
/// One sentence for a key that is none of a vehicle's, with what the file is instead where that is known.
pub fn keys(text: &str, name: &str) -> Result<Vehicle, InputError> {
    let mut reader = Reader::new(text, name);
    let vehicle: Vehicle = reader.part()?;
    reader.finish(|| {
        if Scenario::reads(text) {
            "is no setting of a configuration: this is a scenario, which fly --scenario takes"
        } else {
            "is no setting of a configuration"
        }
    })?;
    Ok(vehicle)
}
