//! Dead reckoning: a matched position, propagated by the reported velocity.

use crate::tile::Local;
use crate::units::Micros;

/// Duration of a jump of the attitude, microseconds: the attitude is fitted over its samples around a frame's instant, so that the first
/// frame sees a part of the jump. Chosen: the fit's 21 samples at 50 Hz, and a frame's interval.
pub const JUMP_ONSET_US: i32 = 600_000;

/// Reported motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// The instant.
    pub at: Micros,
    /// Velocity towards grid east and north, m/s.
    pub velocity_m_per_s: [f32; 2],
}

/// Displacement between two instants by the mean of both velocities, metres east and north.
pub fn displacement_m(from: Moment, to: Moment) -> [f32; 2] {
    let seconds = to.at.since(from.at) as f32 * 1e-6;
    core::array::from_fn(|axis| 0.5 * (from.velocity_m_per_s[axis] + to.velocity_m_per_s[axis]) * seconds)
}

/// A propagated nadir.
#[derive(Clone, Copy, Debug)]
pub struct DeadReckoning {
    /// Instant of the match that it starts from.
    begun_at: Micros,
    newest: Moment,
    local: Local,
}

impl DeadReckoning {
    /// Starts from a match. `nadir`: in the tile's frame, metres.
    pub fn new(moment: Moment, nadir: Local) -> Self {
        DeadReckoning { begun_at: moment.at, newest: moment, local: nadir }
    }

    /// Propagated to another frame by the mean of both velocities; `None` where the match is older than `age_us`, or later.
    pub fn to(self, moment: Moment, age_us: i32) -> Option<Self> {
        if !(0..=age_us).contains(&moment.at.since(self.begun_at)) {
            return None;
        }
        let local = self.local.moved(displacement_m(self.newest, moment));
        Some(DeadReckoning { newest: moment, local, ..self })
    }

    /// The propagated nadir.
    pub fn local(&self) -> Local {
        self.local
    }

    /// Time since the match, microseconds.
    pub fn age_us(&self) -> i32 {
        self.newest.at.since(self.begun_at)
    }

    /// Distance from a position, metres.
    pub fn off_m(&self, place: Local) -> f32 {
        self.local.off_m(place)
    }
}
