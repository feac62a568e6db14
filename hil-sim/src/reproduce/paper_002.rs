//! Paper 002: calibration of a camera of four heads, on a made-up flight over made-up ground.
//!
//! [`parallax`] is sections 2.2 and 3.1.1, [`world`] the camera and its block of 25 stations, [`methods`] the paper's three
//! ways to the mounting angles, [`table_5`] the triangulation of virtual images. Tables 1 to 4 are lost with their
//! numbers; what they say in words has a row.

pub mod methods;
pub mod parallax;
pub mod table_5;
pub mod world;

use super::Row;
use methods::{Outcome, rms};
use plumbline_survey::adjust::SolveError;
use rayon::prelude::*;
use serde::Serialize;
use world::InteriorError;

/// Seeds of the blocks that the rows on methods are the mean of.
pub const SEEDS: std::ops::RangeInclusive<u64> = 1..=24;
/// Unknown points of a block: about 55 observations a picture.
pub const POINTS: usize = 564;
/// The paper's "residuals below 2 um" of the heads' own calibration.
pub const RESIDUAL: InteriorError = InteriorError { linear_px: 0.3, radial_px: 0.15 };
/// Blocks over which errors are compared with their standard deviations.
pub const POOLED: u64 = 200;

/// Everything that was reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seeds of the blocks.
    pub seeds: Vec<u64>,
    /// The rows, table by table.
    pub rows: Vec<Row>,
}

/// What several blocks come to.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Root mean square of all angle errors, arc seconds.
    pub angles_arcsec: f64,
    /// Seams: root mean square of the blocks' and the largest of all, pixels.
    pub seam_px: (f64, f64),
    /// Errors over their standard deviations, root mean square; NaN where there are none.
    pub ratio: f64,
}

impl Summary {
    /// Of some blocks.
    #[must_use]
    pub fn new(outcomes: &[Outcome]) -> Self {
        let ratios = outcomes.iter().flat_map(|of| of.errors_arcsec.iter().zip(&of.sigmas_arcsec).map(|(e, s)| e / s));
        Summary {
            angles_arcsec: rms(outcomes.iter().flat_map(|of| of.errors_arcsec.iter().copied())),
            seam_px: (
                rms(outcomes.iter().map(|of| of.seam_px.0)),
                outcomes.iter().fold(0.0, |most: f64, of| most.max(of.seam_px.1)),
            ),
            ratio: rms(ratios),
        }
    }
}

/// The outcomes of several blocks, in the order of their seeds.
///
/// # Errors
/// None for these blocks; the adjustment's own are passed on.
pub fn outcomes(
    seeds: impl Iterator<Item = u64>,
    of: impl Fn(u64) -> Result<Outcome, SolveError> + Sync,
) -> Result<Vec<Outcome>, SolveError> {
    let seeds: Vec<u64> = seeds.collect();
    seeds.par_iter().map(|seed| of(*seed)).collect()
}
