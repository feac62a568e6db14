//! How far the pictures moved while the shutter was open, as the firmware tells it.

use super::statistics::mean;
use crate::run::FrameRecord;
use serde::Serialize;

/// Image motion over the frames whose pose is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Blur {
    /// Mean over the frames of the longest displacement in a frame, pixels of the frame.
    pub mean_px: Option<f64>,
    /// Longest of all.
    pub max_px: Option<f64>,
    /// Frames above half a pixel.
    pub blurred: usize,
    /// Frames above the limit of GB/T 27920.1.
    pub beyond_standard: usize,
    /// Longest exposure that would have kept every frame at half a pixel, microseconds.
    pub exposure_max_us: Option<u32>,
}

/// The figures of a flight.
pub fn blur(frames: &[FrameRecord]) -> Blur {
    let reported: Vec<_> = frames.iter().filter_map(|frame| frame.instant?.motion).collect();
    let lengths: Vec<f64> = reported.iter().map(|motion| f64::from(motion.max_px)).collect();
    Blur {
        mean_px: mean(&lengths),
        max_px: lengths.iter().copied().reduce(f64::max),
        blurred: reported.iter().filter(|motion| motion.warnings[0]).count(),
        beyond_standard: reported.iter().filter(|motion| motion.warnings[1]).count(),
        exposure_max_us: reported.iter().map(|motion| motion.exposure_max_us).min(),
    }
}
