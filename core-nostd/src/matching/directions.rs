//! The matcher for maps of another year: correlation of gradient directions, with a stated probability of a wrong match.
//!
//! Between two years fields change their greys and even their contrast; field borders stay. So the correlated images hold the direction of
//! the grey gradient, neither its size nor its sign ([`mod@gradients`]). The peak's lead, its curvature and the number of pixels give the
//! probability that it is a wrong match ([`mod@risk`]), fitted on some grounds and years and validated on others. The sub-pixel shift is
//! that of least squares over the greys where that is valid (the same ground in the same state), and the vertex of the correlation peak
//! elsewhere, with a jackknife covariance over parts of the patch.
//!
//! A single match of 20 to 30 pixels a side is seldom certain between years. In flight ([`aboard`]) the scores of several key frames are
//! summed before a decision ([`crate::navigation::surface`]).

mod surroundings;
pub mod gradients;
pub mod evidence;
mod images;
mod parts;
mod climb;
pub mod search;
pub mod risk;
pub mod half;
pub mod local_peak;
pub mod aboard;

use super::refine::{RefineError, SubPixel, refine};
use super::{Alone, MatchError, Prior, Rejection, valid};
use crate::image::{Run, View};
use crate::math::squared;
use evidence::Evidence;
use local_peak::LocalPeak;
use nalgebra::{Matrix2, Matrix4};
use risk::{Rule, VALID_OFFSET_PX, holds};
use search::search;

/// The highest score of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Shift of the patch's centre against the reference's, columns to the right.
    pub d_col: i16,
    /// Rows downwards.
    pub d_row: i16,
    /// Normalised cross-correlation of gradient directions there, −1 to 1.
    pub score: f32,
    /// Score of the second peak, off the main lobe; 0 where none is above.
    pub second: f32,
    /// Its shift (columns, rows); the peak's where there is none.
    pub second_at: (i16, i16),
    /// Vertex of the parabolas through the score and its neighbours along both axes, pixels from the peak, −0.5 to 0.5; 0 on the border.
    pub vertex: (f32, f32),
    /// Jackknife covariance of the vertex over the parts of the patch, square pixels.
    pub covariance: Matrix2<f32>,
    /// Whether the peak lies on the border of the search, so that a higher one may lie beyond.
    pub on_border: bool,
    /// Statistics of the peak against its rivals.
    pub evidence: Evidence,
}

impl Peak {
    /// Sub-pixel position of the peak, columns and rows.
    fn top(&self) -> (f32, f32) {
        (self.d_col as f32 + self.vertex.0, self.d_row as f32 + self.vertex.1)
    }
}

/// What [`locate`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The whole-pixel peak.
    pub peak: Peak,
    /// The sub-pixel match around the peak: by least squares over the greys where that is valid, else the peak's vertex.
    pub solution: SubPixel,
    /// Whether the solution is a valid one of least squares.
    pub holds: bool,
    /// Probability that the peak is a wrong match: more than three pixels off.
    pub risk: f32,
    /// Whether the match is accepted, or why not.
    pub accepted: Result<(), Rejection>,
}

/// Co-registration error of two orthophotos of different years, one sigma, each axis, pixels. Measured over eight years of 5 m a pixel,
/// 26,000 peaks that are within 3 pixels: the mean square of their errors is 0.042 plus 0.84 of the jackknife variance.
const CO_REGISTRATION_PX: f32 = 0.2;
/// Largest distance of a least-squares solution from a rival to be valid there, pixels along either axis: the peak's
/// tolerance of half a pixel, and another half since the rival's shift is a whole pixel.
const RIVAL_PX: f32 = 1.0;

/// Searches `patch` in `reference` within ±`radius` around its centre.
///
/// `bytes`: [`search::working_bytes`], `scores`: space for (2 `radius` + 1)²; both are working space.
///
/// # Errors
/// [`MatchError`] where nothing could be searched.
pub fn locate(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    (prior, rule): (Prior, &Rule),
    (bytes, scores): (&mut [u8], &mut [i16]),
) -> Result<Located, MatchError> {
    let peak = search(patch, runs, reference, radius, bytes, scores)?;
    let curvature = peak.evidence.curvature;
    let mut around = |at: &LocalPeak, within_px| {
        let found = least_squares(patch, runs, reference, radius, at, prior, bytes);
        found.ok().filter(|solution| holds(solution, at.top, within_px, curvature))
    };
    let held = around(&LocalPeak { d_col: peak.d_col, d_row: peak.d_row, top: peak.top(), curvature }, VALID_OFFSET_PX);
    let pixels = valid(runs) as u32;
    let side = 2 * radius as u32 + 1;
    let risk = |is_held| risk::risk(&peak.evidence, pixels, side * side, is_held);
    // Over repetitive ground least squares is valid at each copy.
    let (col, row) = peak.second_at;
    let is_alone = held.is_some()
        && risk(false) > rule.risk_max
        && around(&LocalPeak { d_col: col, d_row: row, top: (col as f32, row as f32), curvature }, RIVAL_PX).is_none();
    let risk = risk(is_alone);
    let solution = held.unwrap_or_else(|| vertex_solution(peak.covariance, peak.top(), prior));
    Ok(Located {
        peak,
        solution,
        holds: held.is_some(),
        risk,
        accepted: rule.accepts(&peak, pixels, risk).and_then(|()| risk::precise(&solution)),
    })
}

/// Least squares from a peak.
fn least_squares(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    at: &LocalPeak,
    prior: Prior,
    bytes: &mut [u8],
) -> Result<SubPixel, RefineError> {
    let LocalPeak { d_col, d_row, top, .. } = *at;
    let vertex = (top.0 - d_col as f32, top.1 - d_row as f32);
    let (second, second_at) = (0.0, (d_col, d_row));
    let peak = super::search::Peak { d_col, d_row, score: 0.0, second, second_at, vertex, on_border: false };
    refine(patch, runs, reference, radius, &peak, prior, bytes)
}

/// The vertex of a correlation peak as a solution. Rotation and scale keep their priors.
fn vertex_solution(covariance: Matrix2<f32>, (d_col, d_row): (f32, f32), prior: Prior) -> SubPixel {
    let mut joint = Matrix4::from_diagonal(&[0.0, 0.0, squared(prior.turn_rad), squared(prior.scale)].into());
    let shift = covariance + Matrix2::identity() * squared(CO_REGISTRATION_PX);
    joint.fixed_view_mut::<2, 2>(0, 0).copy_from(&shift);
    SubPixel { turn_and_scale: (0.0, 0.0), joint, d_col, d_row, agreement: 0.0, alone: Alone::default() }
}
