//! The matcher for maps of another year: correlation of gradient directions, and how probable it is that it is wrong.
//!
//! Between two years fields change their greys and even their contrast; what stays is where they meet. So the images that are
//! correlated say which way the picture changes, not by how much nor with which sign ([`mod@gradients`]). From the highest
//! shift's lead, its sharpness and the number of pixels comes the probability that it is a wrong place ([`mod@risk`]), learnt on
//! some grounds and years and judged on others. The sub-pixel shift is that of least squares over the greys where both pictures
//! show the same ground in the same state, and the peak's own top elsewhere, with a covariance from how far the patch's parts
//! are at odds about it.
//!
//! On 20 to 30 pixels a side a single match between years is seldom certain, so what flies of it is [`aboard`]: the scores of a frame, which are
//! added to those of frames before ([`crate::navigation::surface`]).

mod surroundings;
pub mod gradients;
pub mod evidence;
mod images;
mod parts;
mod climb;
pub mod search;
pub mod risk;
pub mod half;
pub mod summit;
pub mod aboard;

use super::refine::{RefineError, SubPixel, refine};
use super::{Alone, MatchError, Prior, Rejection, valid};
use crate::image::{Run, View};
use crate::math::squared;
use evidence::Evidence;
use nalgebra::{Matrix2, Matrix4};
use risk::{HELD_PX, Rule, holds};
use search::search;
use summit::Summit;

/// The highest score of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Shift of the patch's centre against the reference's, columns to the right.
    pub d_col: i16,
    /// Its rows downwards.
    pub d_row: i16,
    /// Normalised cross-correlation of gradient directions there, −1 to 1.
    pub score: f32,
    /// The highest score away from it, 0 where there is none above.
    pub second: f32,
    /// Where that is, (columns, rows); the peak itself where there is none.
    pub second_at: (i16, i16),
    /// Top of the parabolas through the score and its neighbours along both axes, pixels from the peak, −0.5 to 0.5; 0 on
    /// the border.
    pub vertex: (f32, f32),
    /// Covariance of the vertex as parts of the patch are at odds about it, square pixels.
    pub covariance: Matrix2<f32>,
    /// Whether the peak lies on the border of the search, so that a higher one may lie beyond.
    pub on_border: bool,
    /// What speaks for it.
    pub evidence: Evidence,
}

impl Peak {
    /// Where its top is, columns and rows.
    fn top(&self) -> (f32, f32) {
        (self.d_col as f32 + self.vertex.0, self.d_row as f32 + self.vertex.1)
    }
}

/// What [`locate`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The whole-pixel peak.
    pub peak: Peak,
    /// The sub-pixel match around the peak by least squares over the greys where it holds, else the peak's own top.
    pub solution: SubPixel,
    /// Whether the solution is that of least squares.
    pub holds: bool,
    /// Probability that the peak is a wrong place: more than three pixels off.
    pub risk: f32,
    /// Whether it is to be believed, or why not.
    pub accepted: Result<(), Rejection>,
}

/// One sigma, each axis, of where two orthophotos of other years have the same ground, pixels. Measured over eight years of 5 m a
/// pixel, 26,000 peaks that are within 3 pixels: the mean square of their errors is 0.042 and 0.84 of what their parts are at odds.
const BETWEEN_ORTHOS_PX: f32 = 0.2;
/// How far least squares may be from a rival to hold there, pixels along either axis: its whole pixel is the peak's, and half a pixel
/// beside.
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
    let mut around = |at: &Summit, within_px| {
        let found = least_squares(patch, runs, reference, radius, at, prior, bytes);
        found.ok().filter(|solution| holds(solution, at.top, within_px, curvature))
    };
    let held = around(&Summit { d_col: peak.d_col, d_row: peak.d_row, top: peak.top(), curvature }, HELD_PX);
    let pixels = valid(runs) as u32;
    let side = 2 * radius as u32 + 1;
    let risk = |is_held| risk::risk(&peak.evidence, pixels, side * side, is_held);
    // Where ground repeats least squares hold at each of its copies.
    let (col, row) = peak.second_at;
    let is_alone = held.is_some()
        && risk(false) > rule.risk_max
        && around(&Summit { d_col: col, d_row: row, top: (col as f32, row as f32), curvature }, RIVAL_PX).is_none();
    let risk = risk(is_alone);
    let solution = held.unwrap_or_else(|| of_top(peak.covariance, peak.top(), prior));
    Ok(Located {
        peak,
        solution,
        holds: held.is_some(),
        risk,
        accepted: rule.accepts(&peak, pixels, risk).and_then(|()| risk::precise(&solution)),
    })
}

/// Least squares around a top.
fn least_squares(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    at: &Summit,
    prior: Prior,
    bytes: &mut [u8],
) -> Result<SubPixel, RefineError> {
    let Summit { d_col, d_row, top, .. } = *at;
    let vertex = (top.0 - d_col as f32, top.1 - d_row as f32);
    let (second, second_at) = (0.0, (d_col, d_row));
    let peak = super::search::Peak { d_col, d_row, score: 0.0, second, second_at, vertex, on_border: false };
    refine(patch, runs, reference, radius, &peak, prior, bytes)
}

/// What the top of a correlation says by itself. Turn and scale stay as they were taken to be.
fn of_top(covariance: Matrix2<f32>, (d_col, d_row): (f32, f32), prior: Prior) -> SubPixel {
    let mut joint = Matrix4::from_diagonal(&[0.0, 0.0, squared(prior.turn_rad), squared(prior.scale)].into());
    let shift = covariance + Matrix2::identity() * squared(BETWEEN_ORTHOS_PX);
    joint.fixed_view_mut::<2, 2>(0, 0).copy_from(&shift);
    SubPixel { turn_and_scale: (0.0, 0.0), joint, d_col, d_row, agreement: 0.0, alone: Alone::default() }
}
