//! From stamped samples to a value, its rate and their sigmas at the instant of mid-exposure (paper 001).
//!
//! One ring buffer per stream. A value exists only between two samples that are close enough: not before the first,
//! after the last, or across a gap.
//!
//! * `fit`: paper 001's penalised least squares over the 21 samples around the instant, in banded form;
//! * [`noise`]: the strength of smoothing for each lag, by noise and motion;
//! * [`smooth`]: the two over a [`history`], and linear interpolation if a window is short;
//! * [`position`]: positions, which come too rarely to be waited for.

mod band;
mod penalty;
mod fit;
pub mod history;
pub mod noise;
pub mod smooth;
pub mod position;
#[cfg(test)]
mod tests;

use fit::Fitted;
pub use history::{Backwards, Channels, History, Interpolated};
use noise::Choice;
pub use penalty::{ALPHA_MAX, Order};
pub use smooth::{Estimate, Smoother, Wait};

/// Why a stream has no value at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PoseError {
    /// The newest samples are older than the instant: wait for the next.
    NotYet,
    /// The instant is older than the oldest sample, or nothing was ever received.
    TooOld,
    /// The two samples around the instant are too far apart.
    Gap,
    /// Consecutive samples around the instant are bit-identical though the sensor is noisy: it counts as frozen.
    Frozen,
}

/// Method of a value, for telemetry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// By linear interpolation between two samples.
    Linear,
    /// By the fit.
    Fitted {
        /// Order of the differences.
        order: Order,
        /// α.
        alpha: f32,
        /// Whole samples between the instant's own interval and the nearer end of the window.
        lag: u8,
        /// Samples in the window.
        count: u8,
        /// Samples of these that were rejected as outliers.
        rejected: u8,
        /// Size of the residuals over the sensor's configured noise.
        scale: f32,
    },
    /// The newest value propagated with its measured rate.
    Propagated,
}

impl Method {
    /// Of a fit of `count` samples with `choice`.
    fn fitted<const C: usize>(choice: &Choice, lag: usize, count: usize, fitted: &Fitted<C>) -> Self {
        Method::Fitted {
            order: choice.order,
            alpha: choice.alpha,
            lag: lag.min(u8::MAX as usize) as u8,
            count: count.min(u8::MAX as usize) as u8,
            rejected: fitted.rejected,
            scale: fitted.scale,
        }
    }
}
