//! A frame and what is asked of its resampling.

use super::Grey;
use super::view::{Ground, Pose};
use plumbline_core::image::Run;
use plumbline_sim::camera::still_match::align;
use plumbline_survey::io::picture::Picture;

/// Search, cells: the largest on board.
pub const RADIUS: u16 = 10;

/// A frame and what it is resampled to, at several attitudes.
#[derive(Clone, Debug)]
pub struct Case {
    /// The picture's name.
    pub picture: &'static str,
    /// What the frame shows.
    pub frame: Grey,
    /// Camera, height, cells.
    pub ground: Ground,
    /// The attitudes.
    pub poses: Vec<Pose>,
    /// Limits on it; none where it is only told.
    pub limits: Option<Limits>,
    /// What it is there for.
    pub purpose: Purpose,
    /// Where the patch must be found, for matching.
    pub reference: Option<Reference>,
}

/// What a case is there for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Error and time.
    Timed,
    /// A picture without detail, to see that all mean the same place.
    Smooth,
    /// Matching error.
    Matched,
}

/// What a case must reach, and what is wished for: `(must, goal)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Root mean square of what flies against the exact average, grey levels.
    pub rms: (f64, f64),
    /// Its time over that of OpenCV's full-size warp with INTER_AREA behind it.
    pub time: (f64, f64),
}

/// A reference, and where the patch's centre lies in it.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The tile.
    pub tile: Picture,
    /// Cells east and south of the centre.
    pub truth: (f64, f64),
}

impl Reference {
    /// How far from the truth a patch is found, cells; NaN where it cannot be searched for.
    pub fn error_px(&self, patch: &[u8], runs: &[Run], cells: (u16, u16)) -> f64 {
        let patch = Picture { cols: cells.0.into(), rows: cells.1.into(), pixels: patch.to_vec() };
        align(&patch, runs, &self.tile, RADIUS).map_or(f64::NAN, |place| {
            (f64::from(place.d_col) - self.truth.0).hypot(f64::from(place.d_row) - self.truth.1)
        })
    }
}
