//! What the three lamps say. A pure function of state and time.

/// The state of the vehicle's camera, the most serious first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Indication {
    /// After faults in a row: no exposures, no fixes. Red, four a second.
    Safe,
    /// No configuration, or one that was refused. Red, one a second.
    Grounded,
    /// The sensor does not answer, or has fallen silent. Red and blue in turn.
    NoSensor,
    /// In the simulator's hands. Blue, steady.
    Simulator,
    /// Frames, but no clock tied to the autopilot's. Blue, one a second.
    NoClock,
    /// All well, no fix in the last second. Green, two a second.
    #[default]
    Searching,
    /// Fixes. Green, a short flash a second.
    Fixing,
}

/// Red, green, blue at `ms` since start.
pub fn lamps(state: Indication, ms: u32) -> [bool; 3] {
    let half_of = |period: u32| ms % period < period / 2;
    match state {
        Indication::Safe => [half_of(250), false, false],
        Indication::Grounded => [half_of(1000), false, false],
        Indication::NoSensor => [half_of(1000), false, !half_of(1000)],
        Indication::Simulator => [false, false, true],
        Indication::NoClock => [false, false, half_of(1000)],
        Indication::Searching => [false, half_of(500), false],
        Indication::Fixing => [false, ms % 1000 < 50, false],
    }
}

#[cfg(test)]
mod tests {
    use super::{Indication, lamps};

    const ALL: [Indication; 7] = [
        Indication::Safe,
        Indication::Grounded,
        Indication::NoSensor,
        Indication::Simulator,
        Indication::NoClock,
        Indication::Searching,
        Indication::Fixing,
    ];

    #[test]
    fn no_two_states_look_the_same_over_a_second() {
        let seen = |state| (0..1000).map(move |ms| lamps(state, ms));
        for (n, a) in ALL.into_iter().enumerate() {
            for b in ALL.into_iter().skip(n + 1) {
                assert!(seen(a).ne(seen(b)), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn red_means_that_there_are_no_fixes() {
        for state in ALL {
            let red = (0..1000).any(|ms| lamps(state, ms)[0]);
            assert_eq!(
                red,
                matches!(state, Indication::Safe | Indication::Grounded | Indication::NoSensor),
                "{state:?}"
            );
        }
    }
}
