//! How long the frames were exposed.

use super::statistics::mean;
use crate::run::FrameRecord;
use serde::Serialize;

/// Lengths of all frames' exposures, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exposures {
    /// Shortest.
    pub min: Option<u64>,
    /// Mean.
    pub mean: Option<f64>,
    /// Longest.
    pub max: Option<u64>,
    /// Frames whose camera was set to another exposure than that of the frame before.
    pub changes: usize,
}

/// The figures of a flight.
pub fn exposures(frames: &[FrameRecord]) -> Exposures {
    let lengths = || frames.iter().map(|frame| frame.exposure.close_us - frame.exposure.open_us);
    Exposures {
        min: lengths().min(),
        mean: mean(&lengths().map(|us| us as f64).collect::<Vec<_>>()),
        max: lengths().max(),
        changes: frames.windows(2).filter(|pair| pair[0].exposure.set_us != pair[1].exposure.set_us).count(),
    }
}
