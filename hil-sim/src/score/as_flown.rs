//! What `report.json` says otherwise than the parts it is made of have it.

use crate::setup::{Setup, radiometry_of};
use plumbline_firmware::wire::telemetry::StampHealth;
use serde::ser::Error;
use serde::{Serialize, Serializer};

/// All keys of the scenario; how the reference differs from the ground is as it was made, which depends on the ground.
pub(super) fn scenario_as_flown(setup: &Setup) -> serde_json::Value {
    let mut whole = setup.scenario.resolved();
    let made = radiometry_of(&setup.scenario);
    let keys = [
        ("gamma", made.gamma),
        ("gain", made.gain),
        ("offset_dn", made.offset),
        ("noise_dn", made.noise_dn),
        ("changed_fraction", made.changed_fraction),
    ];
    keys.into_iter().for_each(|(key, value)| whole["reference"][key] = value.into());
    whole
}

/// The board's counters; `free_wheeling_s` is null where no pulse came, which the board tells by its largest number.
pub(super) fn null_without_pulses<S: Serializer>(health: &StampHealth, serializer: S) -> Result<S::Ok, S::Error> {
    let mut whole = serde_json::to_value(health).map_err(S::Error::custom)?;
    if health.free_wheeling_s == u32::MAX {
        whole["free_wheeling_s"] = serde_json::Value::Null;
    }
    whole.serialize(serializer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use std::path::Path;

    #[test]
    fn defaults_are_told_as_flown_and_no_pulse_is_null() {
        let scenario =
            Scenario::parse("name = \"x\"\n[reference]\ngain = 1.5\n", "x", Path::new(""), None).expect("sound");
        let told = scenario_as_flown(&Setup::prepare(scenario).expect("flown"));
        let reference = &told["reference"];
        assert_eq!(
            (&reference["gamma"], &reference["gain"], &reference["noise_dn"]),
            (&0.8.into(), &1.5.into(), &3.0.into())
        );
        let health = |free_wheeling_s| StampHealth { free_wheeling_s, ..StampHealth::default() };
        let told = |health: StampHealth| null_without_pulses(&health, serde_json::value::Serializer).expect("written");
        assert!(told(health(u32::MAX))["free_wheeling_s"].is_null());
        assert_eq!(told(health(7))["free_wheeling_s"], 7);
    }
}
