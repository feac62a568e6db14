//! What the stamps are worth: mid-exposure as the firmware tells it against the true one.

use super::statistics::mean;
use crate::run::FrameRecord;
use plumbline_core::stamp::StampSource;
use serde::Serialize;
use std::collections::BTreeMap;

/// Errors of the stamps, over all frames that have one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stamps {
    /// Root mean square of the error, microseconds.
    pub rms_us: Option<f64>,
    /// Mean error: the stamp less the truth.
    pub mean_us: Option<f64>,
    /// Largest error without its sign.
    pub max_us: Option<f64>,
    /// Mean of (error/sigma)², 1 where the sigmas are right.
    pub nees_mean: Option<f64>,
    /// Frames by what their stamp was made of; `none` where there was none.
    pub sources: BTreeMap<&'static str, usize>,
}

/// The stamp's error in microseconds, its sigma and its source; `None` for a frame without a stamp.
pub fn error(record: &FrameRecord) -> Option<(f64, f64, StampSource)> {
    let reported = record.instant?.stamp?;
    // The difference is taken in integers: instants of a long flight have more digits than it.
    let off_us = reported.mid_us as i64 - record.exposure.open_us as i64;
    let error_us = off_us as f64 - (record.exposure.mid_exact_us() - record.exposure.open_us as f64);
    Some((error_us, f64::from(reported.sigma_us), reported.source()?))
}

/// The figures of a flight.
pub fn stamps(frames: &[FrameRecord]) -> Stamps {
    let errors: Vec<_> = frames.iter().filter_map(error).collect();
    let over = |figure: fn(&(f64, f64, StampSource)) -> f64| mean(&errors.iter().map(figure).collect::<Vec<_>>());
    let mut sources: BTreeMap<&'static str, usize> =
        [StampSource::BothEdges, StampSource::OneEdge, StampSource::Arrival].map(|source| (source.name(), 0)).into();
    for (_, _, source) in &errors {
        *sources.entry(source.name()).or_default() += 1;
    }
    sources.insert("none", frames.len() - errors.len());
    Stamps {
        rms_us: over(|(error, _, _)| error * error).map(f64::sqrt),
        mean_us: over(|(error, _, _)| *error),
        max_us: errors.iter().map(|(error, _, _)| error.abs()).reduce(f64::max),
        nees_mean: over(|(error, sigma, _)| (error / sigma).powi(2)),
        sources,
    }
}
