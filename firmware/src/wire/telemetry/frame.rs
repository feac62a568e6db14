//! What one frame came to.

use plumbline_core::fix::Fix;
use plumbline_core::math::ln;
use plumbline_core::pipeline::{Outcome, Refusal, Situation};
use plumbline_core::tile::Local;
use serde::{Deserialize, Serialize};

/// What one frame came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Number of the frame.
    pub sequence: u32,
    /// Mid-exposure on the autopilot's clock, 0 where it is not known.
    pub mid_exposure_us: u64,
    /// [`Refusal::code`], 0 for an accepted frame.
    pub refusal: u8,
    /// Where the patch was found, accepted or not.
    pub matched: Option<MatchReport>,
    /// The fix.
    pub fix: Option<FixReport>,
    /// Where the navigation believed the camera to be.
    pub predicted: Option<PositionReport>,
    /// Height and angles that the frame was rectified with.
    pub situation: Option<SituationReport>,
    /// Instructions of each of [`STAGES`]; zeros where the board counts none.
    pub instructions: [u32; STAGES.len()],
    /// Radius of the search, pixels; 0 where nothing was matched. This and what follows stands last, where a reader that does not know it
    /// does not miss it.
    pub search_px: u8,
    /// [`Risk`] of the fix; 0 without one.
    pub risk: Risk,
}

/// The stages of a frame: reading and reducing its rows, mid-exposure on the autopilot's clock, the pose there with all
/// that holds at that instant, rectification, matching, fix.
pub const STAGES: [&str; 6] = ["reduce", "stamp", "pose", "rectify", "match", "fix"];

impl FrameReport {
    /// An empty report for a frame.
    pub fn new(sequence: u32) -> Self {
        FrameReport {
            sequence,
            mid_exposure_us: 0,
            refusal: 0,
            matched: None,
            fix: None,
            predicted: None,
            situation: None,
            instructions: [0; STAGES.len()],
            search_px: 0,
            risk: Risk(0),
        }
    }

    /// Why the frame has no fix.
    pub fn reason(&self) -> Option<Refusal> {
        Refusal::from_code(self.refusal)
    }
}

/// Probability that a fix is a wrong place, more than three pixels off, in tenths of a power of ten below 1 (decibels): 40 is 1e-4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Risk(pub u8);

impl Risk {
    /// Of a probability, the next larger one that can be said.
    pub fn new(probability: f32) -> Self {
        const PER_NAT: f32 = 10.0 / core::f32::consts::LN_10;
        // What is rounded to a whole one up to an f32's last places is meant to be that.
        Risk((-PER_NAT * ln(probability) + 1e-3) as u8)
    }
}

/// Where the patch's centre was found relative to the predicted position, pixels of the tile: columns to grid east, rows to
/// grid south.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MatchReport {
    /// Columns, sub-pixel where there is a least-squares solution.
    pub d_col: f32,
    /// Rows, likewise.
    pub d_row: f32,
    /// Normalised cross-correlation of the greys at the whole-pixel peak, −1 to 1.
    pub correlation: f32,
    /// That of the second-best position, 0 where there is none.
    pub second_correlation: f32,
    /// Columns of the whole-pixel peak.
    pub peak_col: f32,
    /// Rows of the whole-pixel peak.
    pub peak_row: f32,
}

impl MatchReport {
    /// Of an outcome.
    pub fn new(outcome: &Outcome) -> Self {
        let ([correlation, second_correlation], [peak_col, peak_row]) = (outcome.grey_correlation, outcome.peak);
        MatchReport { d_col: outcome.d_col, d_row: outcome.d_row, correlation, second_correlation, peak_col, peak_row }
    }
}

/// A fix on the tile's grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixReport {
    /// Grid metres east of the tile's centre.
    pub east_m: f32,
    /// Grid metres north of the tile's centre.
    pub north_m: f32,
    /// Variance of the east coordinate, square metres.
    pub variance_east_m2: f32,
    /// Covariance of the two, square metres.
    pub covariance_m2: f32,
    /// Variance of the north coordinate, square metres.
    pub variance_north_m2: f32,
}

impl FixReport {
    /// Of a fix.
    pub fn new(fix: &Fix) -> Self {
        let c = &fix.covariance;
        FixReport {
            east_m: fix.local.east_m,
            north_m: fix.local.north_m,
            variance_east_m2: c[(0, 0)],
            covariance_m2: c[(0, 1)],
            variance_north_m2: c[(1, 1)],
        }
    }
}

/// A position on the tile's grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PositionReport {
    /// Grid metres east of the tile's centre.
    pub east_m: f32,
    /// Grid metres north of the tile's centre.
    pub north_m: f32,
}

impl PositionReport {
    /// Of a position.
    pub fn new(local: Local) -> Self {
        PositionReport { east_m: local.east_m, north_m: local.north_m }
    }
}

/// Height and angles at mid-exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SituationReport {
    /// Of the camera above the ground, metres.
    pub height_m: f32,
    /// Of the body's forward axis, clockwise from the tile's grid north, radians.
    pub heading_rad: f32,
    /// Of the body, nose up, radians.
    pub pitch_rad: f32,
    /// Of the body, right wing down, radians.
    pub roll_rad: f32,
    /// Of the camera about the body's up axis, counter-clockwise seen from above, radians.
    pub follow_up_rad: f32,
}

impl SituationReport {
    /// Of a situation.
    pub fn new(situation: &Situation) -> Self {
        SituationReport {
            height_m: situation.height_m,
            heading_rad: situation.attitude.heading.0,
            pitch_rad: situation.attitude.pitch.0,
            roll_rad: situation.attitude.roll.0,
            follow_up_rad: situation.follow_up.0,
        }
    }
}
