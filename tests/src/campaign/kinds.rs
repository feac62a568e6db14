//! One fault of each kind, as large as real ones are, for campaigns over all of them.

use plumbline_sim::scenario::Fault;

/// Kinds and values; those of a measured follow-up angle and of pulses need a scenario that has them.
pub const FAULTS: &[&str] = &[
    "position.off",
    "position.stuck",
    "position.stuck_position",
    "position.jump=200",
    "position.drag=3",
    "position.wrong_velocity=3",
    "gnss.off",
    "gnss.jump=200",
    "gnss.drag=3",
    "range.off",
    "range.stuck",
    "range.bias=-10",
    "range.scale=1.1",
    "range.steps=5",
    "attitude.off",
    "attitude.stuck",
    "attitude.bias=1",
    "attitude.bias=3",
    "attitude.bias=9",
    "attitude.scale=1.1",
    "attitude.scale=1.3",
    "attitude.delayed=100",
    "attitude.delayed=300",
    "attitude.stale=500",
    "attitude.stuck_pitch",
    "attitude.stuck_roll",
    "heading.bias=10",
    "heading.bias=20",
    "heading.stuck",
    "baro.bias=15",
    "baro.scale=1.04",
    "encoder.off",
    "encoder.stuck",
    "encoder.bias=3",
    "clock.offset=200",
    "clock.offset=-200",
    "clock.asymmetry=50",
    "clock.jitter=20",
    "clock.phase=100",
    "clock.reboot",
    "link.off",
    "link.duplicates=20",
    "link.reordering=20",
    "link.replay=5",
    "link.second_sender",
    "camera.repeated",
    "camera.dark=0.1",
    "camera.dirty=10",
    "camera.dead_rows=20",
    "camera.gain_steps=2",
    "power.off",
];

/// Those that begin with one of the words, or all without a word, in the interval `FROM..TO`.
///
/// # Errors
/// The interval is none, or a word begins none.
pub fn faults(words: &[String], interval: &str) -> Result<Vec<Fault>, String> {
    if let Some(word) = words.iter().find(|word| !FAULTS.iter().any(|fault| fault.starts_with(word.as_str()))) {
        return Err(format!("no fault begins with {word:?}; those of all kinds are {}", FAULTS.join(" ")));
    }
    let is_meant = |fault: &&&str| words.is_empty() || words.iter().any(|word| fault.starts_with(word.as_str()));
    FAULTS.iter().filter(is_meant).map(|fault| format!("{fault}@{interval}").parse()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline_sim::scenario::KINDS;

    #[test]
    fn every_kind_that_there_is_has_a_value() {
        let all = faults(&[], "20..55").expect("sound");
        for kind in KINDS {
            assert!(all.iter().any(|fault| fault.what == kind.what), "{}.{}", kind.unit, kind.name);
        }
        let range = faults(&["range.s".into()], "20..55").expect("sound");
        assert_eq!(range.len(), 3);
        assert!(faults(&["rage".into()], "20..55").unwrap_err().contains("rage"));
    }
}
