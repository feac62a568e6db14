//! The control of the exposure.

use crate::scenario::bounds::Bounded;
use plumbline_core::stamp::EXPOSURE_MAX_US;
use serde::{Deserialize, Serialize};

/// Whether the firmware chooses the exposure of each frame, and within what. `exposure_us` is that of the first frames then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default)]
pub struct AutoExposure {
    /// Whether it does.
    pub is_on: bool,
    /// Shortest exposure.
    pub least_us: u32,
    /// Longest exposure, bounded by the blur besides.
    pub longest_us: u32,
}

impl Default for AutoExposure {
    /// From two rows of the flight computer's sensor up to two stops above the default exposure.
    fn default() -> Self {
        AutoExposure { is_on: false, least_us: 60, longest_us: 8000 }
    }
}

impl AutoExposure {
    pub(super) fn ranges(&self) -> [Bounded; 2] {
        let longest = f64::from(EXPOSURE_MAX_US);
        [
            ("auto_exposure.least_us", self.least_us.into(), 4.0, longest),
            ("auto_exposure.longest_us", self.longest_us.into(), 4.0, longest),
        ]
    }
}
