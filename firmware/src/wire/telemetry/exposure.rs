//! What is reported of an exposure that is controlled.

use plumbline_core::auto_exposure::Command;
use serde::{Deserialize, Serialize};

/// A command to the camera. A simulated camera obeys this very report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExposureReport {
    /// Number of the first frame that it holds for.
    pub from: u32,
    /// Its exposure, microseconds.
    pub us: u32,
}

impl From<Command> for ExposureReport {
    fn from(Command { from, us }: Command) -> Self {
        ExposureReport { from, us }
    }
}
