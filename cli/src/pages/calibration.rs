//! `report.html` of a calibrated camera: what the block said before and after, on one page that needs nothing but itself.
//!
//! Everything on it is computed from the block, its observations and the adjustment; given are two figures of paper 002
//! alone, in `points`. Style and plots are those of a flight's [page](super::flight). Heads, stations and points are
//! counted from 0, as in the files. The same block gives the same bytes.

mod before;
mod control;
mod correlations;
mod head;
mod histograms;
mod interior;
mod mounts;
mod observed;
mod points;
mod propagate;
mod seam_map;
mod seams;
#[cfg(test)]
mod tests;
mod vectors;
mod warnings;

use before::Before;
use maud::html;
use observed::Observed;
use plumbline_survey::calibrate::{Block, Calibration, Observations, Symmetrised};
use seams::Seams;

/// Arc seconds of a radian.
const ARC_SECONDS: f64 = 648_000.0 / std::f64::consts::PI;

/// What the page's sections share.
struct Page<'a> {
    block: &'a Block,
    observations: &'a Observations,
    calibration: &'a Calibration,
    before: Before,
    symmetrised: Symmetrised,
    seams: Seams,
    observed: Observed,
}

/// The page: residuals before and after, seams, the paper's tables, how far the observations control each other.
#[must_use]
pub fn page(block: &Block, observations: &Observations, calibration: &Calibration) -> String {
    let symmetrised = Symmetrised::new(&calibration.heads);
    let seams = Seams::new(block, observations, calibration, &symmetrised);
    let page = Page {
        before: Before::new(block, observations),
        observed: Observed::new(block, observations, calibration, &symmetrised, seams.view.f_px),
        block,
        observations,
        calibration,
        symmetrised,
        seams,
    };
    let body = html! {
        (page.head())
        (page.warnings())
        (page.before_and_after())
        (page.seams())
        (page.mounts())
        (page.interiors())
        (page.correlations())
        (page.control())
    };
    plumbline_charts::page::page("Plumbline calibration", &body)
}

/// Root mean square of a coordinate.
fn rms<'v>(vectors: impl Iterator<Item = &'v [f64; 2]>) -> Option<f64> {
    let (count, squares) = vectors.fold((0, 0.0), |(n, sum), v| (n + 2, sum + v[0] * v[0] + v[1] * v[1]));
    (count > 0).then(|| (squares / f64::from(count)).sqrt())
}
