//! Dead reckoning: a place that was found, carried on by the reported velocity.

use super::Situation;
use crate::math::hypot;
use crate::tile::Local;
use crate::units::Micros;

/// A place of the nadir, and how far it has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reckoning {
    /// Instant of the match that it rests on.
    begun_at: Micros,
    /// Instant, nadir and velocity (east, north) to which it has come.
    at: Micros,
    local: Local,
    velocity_m_per_s: [f32; 2],
}

impl Reckoning {
    /// From a match on.
    pub(super) fn new(situation: &Situation, nadir: Local) -> Self {
        let Situation { mid_exposure_at: at, prediction, .. } = *situation;
        Reckoning { begun_at: at, at, local: nadir, velocity_m_per_s: prediction.velocity_m_per_s }
    }

    /// Carried on to another frame, by the mean of both velocities; `None` where the match is older than `age_us` or comes later.
    pub(super) fn to(self, situation: &Situation, age_us: i32) -> Option<Self> {
        let Situation { mid_exposure_at: at, prediction, .. } = *situation;
        if !(0..=age_us).contains(&at.since(self.begun_at)) {
            return None;
        }
        let seconds = at.since(self.at) as f32 * 1e-6;
        let [east, north] = prediction.velocity_m_per_s;
        let [east_before, north_before] = self.velocity_m_per_s;
        let local = Local {
            east_m: self.local.east_m + 0.5 * (east + east_before) * seconds,
            north_m: self.local.north_m + 0.5 * (north + north_before) * seconds,
        };
        Some(Reckoning { at, local, velocity_m_per_s: prediction.velocity_m_per_s, ..self })
    }

    /// Where it has come to.
    pub(super) fn local(&self) -> Local {
        self.local
    }

    /// For how long it has been carried on, microseconds.
    pub(super) fn age_us(&self) -> i32 {
        self.at.since(self.begun_at)
    }

    /// How far it is from a place.
    pub(super) fn off_m(&self, place: Local) -> f32 {
        hypot(self.local.east_m - place.east_m, self.local.north_m - place.north_m)
    }
}
