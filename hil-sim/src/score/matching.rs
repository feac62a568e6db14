//! How often and how well the matching found the truth.

use super::Scored;
use super::statistics::{mean, percentile};
use serde::Serialize;

/// Distance at which a match counts as right, pixels.
const RIGHT_PX: f64 = 1.5;

/// Length of an error.
pub fn length(error: [f64; 2]) -> f64 {
    error[0].hypot(error[1])
}

/// Rectified and unrectified.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MatchRate {
    /// Share of all frames within 1.5 px of the truth, raw.
    pub unrectified: f64,
    /// Share of all frames within 1.5 px of the truth, rectified.
    pub rectified: f64,
}

/// Errors of matching, pixels of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MatchingError {
    /// Raw frame averaged to R, whole-pixel peak, all frames.
    pub unrectified_mean: Option<f64>,
    /// Rectified, whole-pixel peak, accepted frames.
    pub rectified_integer_mean: Option<f64>,
    /// Rectified, sub-pixel, accepted frames.
    pub rectified_mean: Option<f64>,
    /// 95th percentile of the same.
    pub rectified_p95: Option<f64>,
    /// Largest of the same.
    pub accepted_max: Option<f64>,
    /// Mean of what the attitude's error alone explains, accepted frames.
    pub attitude_mean: Option<f64>,
    /// Mean of what is left without it: the matching itself.
    pub matching_mean: Option<f64>,
}

/// Share of the frames that are right.
pub(super) fn match_rate(scored: &[Scored]) -> MatchRate {
    let rate = |pick: fn(&Scored) -> Option<[f64; 2]>| {
        let right = scored.iter().filter_map(pick).filter(|&error| length(error) <= RIGHT_PX).count();
        right as f64 / scored.len().max(1) as f64
    };
    MatchRate { unrectified: rate(|s| s.raw_px), rectified: rate(|s| s.error_px) }
}

/// Errors of all frames unrectified, of the `accepted` ones rectified.
pub(super) fn matching_error(scored: &[Scored], accepted: &[&Scored]) -> MatchingError {
    let raw: Vec<f64> = scored.iter().filter_map(|s| s.raw_px).map(length).collect();
    let rectified = lengths(accepted, |s| s.error_px);
    let without_attitude = |s: &Scored| {
        s.error_px.zip(s.attitude_px).map(|(error, attitude)| [error[0] - attitude[0], error[1] - attitude[1]])
    };
    MatchingError {
        unrectified_mean: mean(&raw),
        rectified_integer_mean: mean(&lengths(accepted, |s| s.integer_px)),
        rectified_mean: mean(&rectified),
        rectified_p95: percentile(&rectified, 0.95),
        accepted_max: rectified.iter().copied().reduce(f64::max),
        attitude_mean: mean(&lengths(accepted, |s| s.attitude_px)),
        matching_mean: mean(&lengths(accepted, without_attitude)),
    }
}

/// Lengths of the errors that are known.
pub(super) fn lengths(scored: &[&Scored], pick: impl Fn(&Scored) -> Option<[f64; 2]>) -> Vec<f64> {
    scored.iter().filter_map(|s| pick(s)).map(length).collect()
}
