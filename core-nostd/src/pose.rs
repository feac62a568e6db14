//! From stamped samples to a value, its rate and their sigmas at the instant of mid-exposure (paper 001).
//!
//! One ring per stream. A value exists only between two samples that are close enough: never before the first, never
//! after the last, never across a gap. How it is found:
//!
//! * `fit`: paper 001's penalised least squares over the 21 samples around the instant, in banded form;
//! * [`noise`]: how strongly, by what noise and motion are, for each lag;
//! * [`smooth`]: the two over a [`history`], with what remains when a window is short;
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
    /// The newest samples are still older than the instant: wait for the next.
    NotYet,
    /// The instant is older than what the ring remembers, or nothing was ever received.
    TooOld,
    /// The two samples around the instant are too far apart.
    Gap,
    /// Consecutive samples around the instant are bit-identical though the sensor is noisy: it counts as frozen.
    Frozen,
}

/// How a value was found, for telemetry.
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
        /// Of which were left out as outliers.
        rejected: u8,
        /// The residuals' size over what the sensor was said to have.
        scale: f32,
    },
    /// The newest value propagated with its measured rate.
    Propagated,
}

impl Method {
    /// What a fit of `count` samples with `choice` came to.
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
