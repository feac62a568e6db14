//! Where a position that had been lost was found, carried on by the reported velocity until the navigation is there itself.
//!
//! A navigation may take a while to believe fixes that are far from its own position, and comes there in a jump. Dead
//! reckoning from the last match needs its velocity alone: jumps of its position do not move what is found.

use super::Situation;
use crate::math::hypot;
use crate::tile::Local;
use crate::units::Micros;

/// Oldest match that is carried on, microseconds. In a turn the velocity of an autopilot without fixes was off by up to 5 m/s
/// within three seconds: in two of them that is as far as a usual search reaches.
const AGE_MAX_US: i32 = 2_000_000;

/// A place of the nadir that was found, and how it goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reckoning {
    /// Instant of the match that it rests on.
    found_at: Micros,
    /// Instant, nadir and velocity (east, north) to which it has come.
    at: Micros,
    local: Local,
    velocity_m_per_s: [f32; 2],
}

impl Reckoning {
    /// Begins with a match.
    pub(super) fn new(situation: &Situation, nadir: Local) -> Self {
        let Situation { mid_exposure_at: at, prediction, .. } = situation;
        Reckoning { found_at: *at, at: *at, local: nadir, velocity_m_per_s: prediction.velocity_m_per_s }
    }

    /// Carried on to another frame; `None` where the match is too old, or the navigation predicts a place within `near_m` of it.
    pub(super) fn to(self, situation: &Situation, near_m: f32) -> Option<Self> {
        let Situation { mid_exposure_at: at, prediction, .. } = *situation;
        if !(0..=AGE_MAX_US).contains(&at.since(self.found_at)) {
            return None;
        }
        let seconds = at.since(self.at) as f32 * 1e-6;
        let velocity_m_per_s = prediction.velocity_m_per_s;
        let flown = |axis: usize| 0.5 * (velocity_m_per_s[axis] + self.velocity_m_per_s[axis]) * seconds;
        let local = Local { east_m: self.local.east_m + flown(0), north_m: self.local.north_m + flown(1) };
        let off_m = hypot(local.east_m - prediction.local.east_m, local.north_m - prediction.local.north_m);
        (off_m > near_m).then_some(Reckoning { at, local, velocity_m_per_s, ..self })
    }

    /// The nadir at the newest frame.
    pub(super) fn local(&self) -> Local {
        self.local
    }
}
