//! What is remembered of a flight's navigation.

use crate::vehicle::inertial::estimator::FixCounts;

/// A tenth of a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Seconds of the simulated time.
    pub at_s: f64,
    /// Where the vehicle was: grid east, north, up.
    pub truth_m: [f64; 3],
    /// Where its autopilot believed to be.
    pub believed_m: [f64; 3],
    /// Where it would have believed to be without a fix since satellite navigation was lost.
    pub free_m: Option<[f64; 3]>,
    /// What its horizontal velocity was off by.
    pub velocity_error_m_s: f64,
    /// What its heading was off by, clockwise.
    pub heading_error_rad: f64,
    /// Normalised error squared of the filter's position; 2 expected.
    pub nees: Option<f64>,
    /// How far to the right of its leg it truly was.
    pub across_m: f64,
    /// It was about to get on its leg still.
    pub is_turning: bool,
}

impl Moment {
    /// Horizontal error of where the autopilot believed to be, metres.
    #[must_use]
    pub fn error_m(&self) -> f64 {
        beside(&self.believed_m, &self.truth_m)
    }

    /// What it would be without fixes.
    #[must_use]
    pub fn free_error_m(&self) -> Option<f64> {
        self.free_m.map(|free_m| beside(&free_m, &self.truth_m))
    }
}

fn beside(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// What the board has told the pilot of satellite navigation, seconds of the simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ToldOfGnss {
    /// When first that it disagrees with the map.
    pub disagreed_at_s: Option<f64>,
    /// By how many metres then.
    pub offset_m: Option<f64>,
    /// When last that it agrees again.
    pub agreed_at_s: Option<f64>,
}

/// A flight's navigation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// When satellite navigation was lost.
    pub gnss_lost_s: Option<f64>,
    /// What was to be flown: grid east and north.
    pub waypoints: Vec<[f64; 2]>,
    /// What the board has told of satellite navigation.
    pub gnss: ToldOfGnss,
    /// What the estimator did with the fixes.
    pub fixes: FixCounts,
    /// Ten a second.
    pub moments: Vec<Moment>,
}
