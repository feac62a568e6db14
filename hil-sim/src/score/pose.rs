//! What the poses are worth: attitude at mid-exposure as the firmware tells it against the true one, and how it was found.

use super::statistics::mean;
use crate::run::FrameRecord;
use crate::vehicle::servo::wrapped;
use serde::Serialize;
use std::collections::BTreeMap;

/// Errors of pitch and roll, over all frames that have a pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Poses {
    /// Root mean square error of an axis, degrees.
    pub tilt_rms_deg: Option<f64>,
    /// Mean of (error/sigma)² of an axis, 1 where the sigmas are right.
    pub nees_mean: Option<f64>,
    /// Frames by how the attitude was found: `second` and `third` order of the fit, `straight` between two samples, `none`.
    pub methods: BTreeMap<&'static str, usize>,
    /// Samples that the fits left out as mistakes.
    pub rejected_samples: usize,
}

/// The figures of a flight.
pub fn poses(frames: &[FrameRecord]) -> Poses {
    let (mut squares, mut normalised) = (Vec::new(), Vec::new());
    let mut methods: BTreeMap<&'static str, usize> =
        ["second", "third", "straight", "none"].map(|name| (name, 0)).into();
    let mut rejected_samples = 0;
    for frame in frames {
        let reported = frame.instant.and_then(|instant| instant.pose);
        let (Some(reported), Some(used)) = (reported, frame.report.and_then(|report| report.situation)) else {
            *methods.entry("none").or_default() += 1;
            continue;
        };
        let name = match reported.order {
            2 => "second",
            3 => "third",
            _ => "straight",
        };
        *methods.entry(name).or_default() += 1;
        rejected_samples += usize::from(reported.samples[2]);
        let sigma = f64::from(reported.sigma[0]);
        for (used, truth) in [(used.pitch_rad, frame.truth.pitch_rad), (used.roll_rad, frame.truth.roll_rad)] {
            let error = wrapped(f64::from(used) - truth);
            squares.push(error.to_degrees().powi(2));
            if sigma > 0.0 {
                normalised.push((error / sigma).powi(2));
            }
        }
    }
    Poses { tilt_rms_deg: mean(&squares).map(f64::sqrt), nees_mean: mean(&normalised), methods, rejected_samples }
}
