//! Dead reckoning: a place that was found, carried on by the reported velocity.

use crate::tile::Local;
use crate::units::Micros;

/// A jump of the attitude takes so long to be there as a whole: it is fitted over its samples around a frame's instant, so that the first
/// frame sees a part of it, microseconds. Chosen: the fit's 21 samples at 50 Hz, and a frame's interval.
pub const JUMPING_US: i32 = 600_000;

/// What the navigation reports of the motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// The instant.
    pub at: Micros,
    /// Velocity towards grid east and north, m/s.
    pub velocity_m_per_s: [f32; 2],
}

/// The way from one instant to another by the mean of both velocities, metres east and north.
pub fn way_m(from: Moment, to: Moment) -> [f32; 2] {
    let seconds = to.at.since(from.at) as f32 * 1e-6;
    core::array::from_fn(|axis| 0.5 * (from.velocity_m_per_s[axis] + to.velocity_m_per_s[axis]) * seconds)
}

/// A place of the nadir, and how far it has come.
#[derive(Clone, Copy, Debug)]
pub struct Reckoning {
    /// Instant of the match that it rests on.
    begun_at: Micros,
    newest: Moment,
    local: Local,
}

impl Reckoning {
    /// From a match on.
    pub fn new(moment: Moment, nadir: Local) -> Self {
        Reckoning { begun_at: moment.at, newest: moment, local: nadir }
    }

    /// Carried on to another frame, by the mean of both velocities; `None` where the match is older than `age_us` or comes later.
    pub fn to(self, moment: Moment, age_us: i32) -> Option<Self> {
        if !(0..=age_us).contains(&moment.at.since(self.begun_at)) {
            return None;
        }
        let local = self.local.moved(way_m(self.newest, moment));
        Some(Reckoning { newest: moment, local, ..self })
    }

    /// Where it has come to.
    pub fn local(&self) -> Local {
        self.local
    }

    /// For how long it has been carried on, microseconds.
    pub fn age_us(&self) -> i32 {
        self.newest.at.since(self.begun_at)
    }

    /// How far it is from a place, metres.
    pub fn off_m(&self, place: Local) -> f32 {
        self.local.off_m(place)
    }
}
