//! The directions in flight: confirm a least-squares match; otherwise score a frame for the log-likelihood surface, and find the frame's
//! own peak near the surface's decision.

use super::half::{self, Scores, scores};
use super::local_peak::{self, LocalPeak};
use super::risk::{VALID_OFFSET_PX, holds, is_within};
use super::search::{images, working_bytes};
use super::{least_squares, vertex_solution};
use crate::budget::{PATCH_MAX_PX, SEARCH_MAX_PX};
use crate::image::{Run, View};
use crate::matching::refine::SubPixel;
use crate::matching::{MatchError, Prior, valid};

/// Working space of [`frame_peak`] on board, bytes.
pub const WORKING_BYTES: usize = {
    const PATCH: (u16, u16) = (PATCH_MAX_PX as u16, PATCH_MAX_PX as u16);
    const SIDE: u16 = PATCH.0 + 2 * SEARCH_MAX_PX as u16;
    working_bytes(PATCH, (SIDE, SIDE)) + half::working_bytes(PATCH, (SIDE, SIDE))
};

/// Largest distance of the directions' peak from that of the high-pass images for a confirmation, pixels along either axis: a valid
/// least-squares solution is within half a pixel of the one, and within one and a half of the other.
const CONFIRMED_WITHIN_PX: u16 = 1;
/// Largest distance of a frame's own peak from the decided position, pixels along either axis: a cell of the surface and the rounding of
/// both.
const DECIDED_WITHIN_PX: u16 = 3;
/// Ratio of a peak's error variance to its jackknife variance. Measured over 2,400 frames of flights between years: 1.5 to 2.
const VARIANCE_RATIO: f32 = 2.0;
/// Largest sigma of a frame's own peak along either axis, pixels. Chosen: half of what is a wrong match.
const SIGMA_MAX_PX: f32 = 1.5;

/// The frame's own correlation peak near a given shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePeak {
    /// Whole-pixel shift of the patch's centre, columns to the right and rows downwards.
    pub peak: (i16, i16),
    /// The sub-pixel match there.
    pub solution: SubPixel,
    /// Whether that is a valid solution of least squares over the greys.
    pub holds: bool,
}

/// Whether the directions confirm a least-squares solution: their own peak near it is within the tolerance. The solution and the `peak`
/// that it started from are relative to `at`, the tile's (column, row) under the patch's upper left pixel at the centre of the search.
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
    const AROUND_PX: u16 = CONFIRMED_WITHIN_PX + 1;
    let (cols, rows) = patch.size();
    let from = |at: i32, peak: i16| at + i32::from(peak) - i32::from(AROUND_PX);
    let size = (cols + 2 * AROUND_PX, rows + 2 * AROUND_PX);
    let Some(window) = tile.window(from(at.0, peak.0), from(at.1, peak.1), size) else { return Ok(false) };
    let images = images(patch, runs, &window, bytes)?;
    let Some(found) = local_peak::near(&images, (0, 0), CONFIRMED_WITHIN_PX, AROUND_PX) else { return Ok(false) };
    let top = (found.top.0 + f32::from(peak.0), found.top.1 + f32::from(peak.1));
    Ok(holds(solution, top, VALID_OFFSET_PX, found.curvature))
}

/// Scores the shifts of `patch` in `reference`, passes scores and number of valid pixels to `decide`, and finds the frame's own peak near
/// the shift that it returns; `None` without a shift or a peak.
///
/// `radius`, `middle`: radius of the search, and centre of the scored shifts less centre of the search, pixels (columns, rows). `may_hold`:
/// whether least squares is worth trying. `bytes`: [`WORKING_BYTES`].
///
/// # Errors
/// [`MatchError`] where nothing could be searched.
#[inline(never)]
pub fn frame_peak(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    (radius, middle): (u16, (i16, i16)),
    (prior, may_hold): (Prior, bool),
    bytes: &mut [u8],
    decide: impl FnOnce(&Scores, u32) -> Option<(i16, i16)>,
) -> Result<Option<FramePeak>, MatchError> {
    let Some((found, alone)) = vertex_near(patch, runs, reference, (radius, middle), prior, bytes, decide)? else {
        return Ok(None);
    };
    let mut held = || {
        let solution = least_squares(patch, runs, reference, radius, &found, prior, bytes).ok()?;
        holds(&solution, found.top, VALID_OFFSET_PX, found.curvature).then_some(solution)
    };
    let held = if may_hold { held() } else { None };
    let own = FramePeak { peak: (found.d_col, found.d_row), solution: held.unwrap_or(alone), holds: held.is_some() };
    Ok(is_within(&own.solution, SIGMA_MAX_PX).then_some(own))
}

/// The peak near the shift that `decide` returns, and its vertex as a solution.
#[inline(never)]
fn vertex_near(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    (radius, middle): (u16, (i16, i16)),
    prior: Prior,
    bytes: &mut [u8],
    decide: impl FnOnce(&Scores, u32) -> Option<(i16, i16)>,
) -> Result<Option<(LocalPeak, SubPixel)>, MatchError> {
    let needed = half::working_bytes(patch.size(), reference.size());
    let (halves, bytes) = bytes.split_at_mut_checked(needed).ok_or(MatchError::Capacity)?;
    let images = images(patch, runs, reference, bytes)?;
    let scores = scores(&images, radius, middle, halves).ok_or(MatchError::Capacity)?;
    let Some(at) = decide(&scores, valid(runs) as u32) else { return Ok(None) };
    let Some(found) = local_peak::near(&images, at, DECIDED_WITHIN_PX, radius) else { return Ok(None) };
    let covariance = local_peak::covariance(&images, &found, radius) * VARIANCE_RATIO;
    Ok(Some((found, vertex_solution(covariance, found.top, prior))))
}
