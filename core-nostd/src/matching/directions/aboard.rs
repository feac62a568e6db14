//! Directions on board: whether least squares hold where they have found a patch, and else the scores of a frame, which are added to those
//! of frames before, and the frame's own top where all of them put it.

use super::half::{self, Scores, scores};
use super::risk::{HELD_PX, holds, is_within};
use super::search::{images, working_bytes};
use super::summit::{self, Summit};
use super::{least_squares, of_top};
use crate::budget::{PATCH_MAX_PX, SEARCH_MAX_PX};
use crate::image::{Run, View};
use crate::matching::refine::SubPixel;
use crate::matching::{MatchError, Prior, valid};

/// Bytes that [`look`] needs on board.
pub const WORKING_BYTES: usize = {
    const PATCH: (u16, u16) = (PATCH_MAX_PX as u16, PATCH_MAX_PX as u16);
    const SIDE: u16 = PATCH.0 + 2 * SEARCH_MAX_PX as u16;
    working_bytes(PATCH, (SIDE, SIDE)) + half::working_bytes(PATCH, (SIDE, SIDE))
};

/// Pixels that the directions' top may lie off that of the high-pass images where least squares hold, along either axis: they are within half
/// a pixel of the one, and within one and a half of the other.
const BESIDE_PX: u16 = 1;
/// Pixels that a frame's own top may lie off the place that it is looked for at, along either axis: a step of the surface
/// and the rounding of both.
const NEAR_PX: u16 = 3;
/// By how much the variance of a top is larger than its parts say. Measured over 2,400 frames of flights between years: 1.5 to 2.
const OVER_PARTS: f32 = 2.0;
/// Largest sigma of an own top along either axis, pixels. Chosen: half of what is a wrong match.
const SIGMA_MAX_PX: f32 = 1.5;

/// A frame's own top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Own {
    /// The whole-pixel shift of the patch's centre, columns and rows.
    pub peak: (i16, i16),
    /// The match there.
    pub solution: SubPixel,
    /// By least squares over the greys.
    pub holds: bool,
}

/// Whether a solution of least squares holds by the directions, too. It and the `peak` that it was found around are off `at`,
/// the tile's (column, row) under the upper left pixel of the patch where it was looked for.
///
/// # Errors
/// [`MatchError`] where nothing could be compared.
#[inline(never)]
pub fn confirms(
    patch: &View<'_>,
    runs: &[Run],
    (tile, at): (&View<'_>, (i32, i32)),
    (peak, solution): ((i16, i16), &SubPixel),
    bytes: &mut [u8],
) -> Result<bool, MatchError> {
    const AROUND_PX: u16 = BESIDE_PX + 1;
    let (cols, rows) = patch.size();
    let from = |at: i32, peak: i16| at + i32::from(peak) - i32::from(AROUND_PX);
    let size = (cols + 2 * AROUND_PX, rows + 2 * AROUND_PX);
    let Some(window) = tile.window(from(at.0, peak.0), from(at.1, peak.1), size) else { return Ok(false) };
    let images = images(patch, runs, &window, bytes)?;
    let Some(found) = summit::near(&images, (0, 0), BESIDE_PX, AROUND_PX) else { return Ok(false) };
    let top = (found.top.0 + f32::from(peak.0), found.top.1 + f32::from(peak.1));
    Ok(holds(solution, top, HELD_PX, found.curvature))
}

/// Scores the shifts of `patch` in `reference`, asks `decide` with them and the number of valid pixels where to look, and
/// finds the patch's own top there: nothing where `decide` says nothing, or there is none.
///
/// `middle`: of the scores' shifts, pixels off the middle of the search. `may_hold`: whether least squares are worth a try.
///
/// # Errors
/// [`MatchError`] where nothing could be searched.
#[inline(never)]
pub fn look(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    (radius, middle): (u16, (i16, i16)),
    (prior, may_hold): (Prior, bool),
    bytes: &mut [u8],
    decide: impl FnOnce(&Scores, u32) -> Option<(i16, i16)>,
) -> Result<Option<Own>, MatchError> {
    let Some((found, alone)) = own_top(patch, runs, reference, (radius, middle), prior, bytes, decide)? else {
        return Ok(None);
    };
    let mut held = || {
        let solution = least_squares(patch, runs, reference, radius, &found, prior, bytes).ok()?;
        holds(&solution, found.top, HELD_PX, found.curvature).then_some(solution)
    };
    let held = if may_hold { held() } else { None };
    let own = Own { peak: (found.d_col, found.d_row), solution: held.unwrap_or(alone), holds: held.is_some() };
    Ok(is_within(&own.solution, SIGMA_MAX_PX).then_some(own))
}

/// The patch's own top where `decide` says, and what it says by itself.
#[inline(never)]
fn own_top(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    (radius, middle): (u16, (i16, i16)),
    prior: Prior,
    bytes: &mut [u8],
    decide: impl FnOnce(&Scores, u32) -> Option<(i16, i16)>,
) -> Result<Option<(Summit, SubPixel)>, MatchError> {
    let needed = half::working_bytes(patch.size(), reference.size());
    let (halves, bytes) = bytes.split_at_mut_checked(needed).ok_or(MatchError::Capacity)?;
    let images = images(patch, runs, reference, bytes)?;
    let scores = scores(&images, radius, middle, halves).ok_or(MatchError::Capacity)?;
    let Some(at) = decide(&scores, valid(runs) as u32) else { return Ok(None) };
    let Some(found) = summit::near(&images, at, NEAR_PX, radius) else { return Ok(None) };
    let covariance = summit::covariance(&images, &found, radius) * OVER_PARTS;
    Ok(Some((found, of_top(covariance, found.top, prior))))
}
