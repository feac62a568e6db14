//! What is reported of a plan that is flown.

use plumbline_core::exposure::{Counts, Exposures};
use serde::{Deserialize, Serialize};

/// A planned photo: reported before its exposure, and again when its frame has been stamped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PhotoReport {
    /// Number in the plan, in the order of flight, from 0.
    pub photo: u32,
    /// Mid-exposure on the autopilot's clock: as it is to be, or as it was.
    pub mid_exposure_us: u64,
    /// The frame that shows it; `None` before the exposure.
    pub frame: Option<u32>,
}

/// How far a plan has been flown, once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlanReport {
    /// Photos of the plan.
    pub photos: u32,
    /// The one that comes next.
    pub next: u32,
    /// Exposures committed to.
    pub exposed: u32,
    /// Photos missed: passed by before they could be exposed.
    pub passed: u32,
    /// Photos missed: too far off the line.
    pub off_line: u32,
    /// Photos missed: too soon after the one before.
    pub too_soon: u32,
}

impl PlanReport {
    /// Of a plan of so many photos.
    pub fn new(photos: u32, exposures: &Exposures) -> Self {
        let Counts { exposed, passed, off_line, too_soon } = exposures.counts();
        PlanReport { photos, next: exposures.next(), exposed, passed, off_line, too_soon }
    }
}
