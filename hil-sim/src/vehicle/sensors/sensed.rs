//! What there is to sense.

use crate::vehicle::motion::{Motion, TrueState};

/// A vehicle as its sensors find it.
pub trait Sensed {
    /// The camera's truth at an instant.
    fn state(&self, t_us: u64) -> TrueState;

    /// Whether the attitude sensor has nothing to say.
    fn in_gap(&self, _t_us: u64) -> bool {
        false
    }

    /// What the autopilot believes of itself, its antenna's place, where it navigates: its messages say this and nothing else.
    fn believed(&self, _t_us: u64) -> Option<TrueState> {
        None
    }
}

impl Sensed for Motion {
    fn state(&self, t_us: u64) -> TrueState {
        Motion::state(self, t_us)
    }

    fn in_gap(&self, t_us: u64) -> bool {
        Motion::in_gap(self, t_us)
    }
}
