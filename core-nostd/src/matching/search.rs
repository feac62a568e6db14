//! Masked normalised cross-correlation of high-pass images over whole-pixel shifts.
//!
//! It is invariant to gain and offset between patch and reference, so other radiometry and season cost little; the
//! high-pass filter keeps changed ground from outweighing the rest. High-pass values have no mean to subtract. Products
//! are summed in integers.
//!
//! The peak is one pixel wide, so no shift can be skipped, but precision can be reduced: a coarse ranking with one
//! digit of every value orders all the shifts, and the whole patch decides between its highest local maxima and climbs
//! to the vertices of the two best.

pub(super) mod images;
mod climb;

use super::MatchError;
use super::high_pass::{ClippingThreshold, clip, filter};
use super::local_maximum::{LocalMaximum, MAIN_LOBE_PX, highest};
use crate::image::{Run, View};
use crate::math;
use images::{Images, Patch, ScoredShift, put};

/// The highest score of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Shift of the patch's centre against the reference's, columns to the right.
    pub d_col: i16,
    /// Its rows downwards.
    pub d_row: i16,
    /// Normalised cross-correlation of the high-pass images there, −1 to 1.
    pub score: f32,
    /// The second peak: the highest other local maximum, 0 without one.
    pub second: f32,
    /// Its shift, (columns, rows); the peak's without one.
    pub second_at: (i16, i16),
    /// Vertex of the parabolas through the score and its neighbours along both axes, pixels from the peak, −0.5 to 0.5;
    /// 0 on the border.
    pub vertex: (f32, f32),
    /// Whether the peak lies on the border of the search, so that a higher one may lie beyond.
    pub on_border: bool,
}

impl Peak {
    /// Its shift, (columns to the right, rows downwards).
    pub(crate) fn at(&self) -> (i16, i16) {
        (self.d_col, self.d_row)
    }
}

/// Most local maxima of the coarse ranking that the whole patch decides between: with six of them and a ranking over
/// [`images::RANKING_PX`] no frame of the default scene is lost that a search of every shift over the whole patch
/// finds. Over the weak one of the four series the peak is wrong 291 times of 1,500 with one, 84 with three, 38 with
/// six, 25 with twelve.
const CANDIDATES: usize = 6;
/// Largest distance of a candidate below the highest maximum, except for the best one off its main lobe, in standard
/// deviations of the difference of two scores. Chosen: of normal numbers 3 in 100,000 are beyond.
const CANDIDATE_SIGMAS: f32 = 4.0;
/// Stride of the rows that set the clipping threshold, in the reference and in the patch: the median of the
/// sizes of n normal values has a relative deviation of 1.17/√n, 7 % for a quarter of a thousand.
const CLIPPING_STRIDE: usize = 4;
/// Bytes after the reference's high-pass image that may be read. The ranking reads up to 18 beyond the pixel under a
/// piece's last one: 7 by which a piece is rounded up to pairs of words, 8 for two more sums beside the first, 3 by
/// which the shifts are rounded up to words. Rounded up to pairs of words.
pub(super) const READ_AHEAD: usize = 24;

/// Working space of a search in a reference of `size`, bytes. If the patch's high-pass image fits in too, with three
/// more a row, it is computed only once.
pub const fn working_bytes(size: (u16, u16)) -> usize {
    stride(size) * size.1 as usize + READ_AHEAD + 3
}

/// Bytes from one row of the reference's high-pass image to the next.
pub(super) const fn stride(size: (u16, u16)) -> usize {
    (size.0 as usize).next_multiple_of(4)
}

/// The peak of the scores of every shift within ±`radius`.
///
/// `patch` and `runs`: as the rectifier leaves them. `reference`: patch + 2 `radius` in both directions or larger; its
/// centre is shift zero when it is exactly that. `bytes`: [`working_bytes`] for the reference's high-pass image, or
/// more. `scores`: space for (2 `radius` + 1)² scores of the coarse ranking, row-major from the upper left shift.
///
/// # Errors
/// [`MatchError`].
#[inline(never)]
pub fn search(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    bytes: &mut [u8],
    scores: &mut [i16],
) -> Result<Peak, MatchError> {
    let side = 2 * radius as usize + 1;
    let fits = |reference: u16, patch: u16| reference as usize >= patch as usize + side - 1;
    let (own, other) = (patch.size(), reference.size());
    if !fits(other.0, own.0) || !fits(other.1, own.1) {
        return Err(MatchError::OutsideReference);
    }
    check(patch, runs)?;
    let scores = scores.get_mut(..side * side).ok_or(MatchError::Capacity)?;
    let skipped = bytes.as_ptr().align_offset(4);
    let (others, own) = bytes
        .get_mut(skipped..)
        .and_then(|bytes| bytes.split_at_mut_checked(working_bytes(other) - 3))
        .ok_or(MatchError::Capacity)?;
    let reference = filtered(reference, others);
    let images = Images::new(Patch::new(patch, runs, own), reference);
    let large = images.rank(side, scores);
    let mut buffer = [LocalMaximum::default(); CANDIDATES];
    let mut shifts = [ScoredShift::default(); CANDIDATES];
    let maxima = highest(scores, (side, side), |&score| score, &mut buffer);
    for (shift, maximum) in shifts.iter_mut().zip(maxima) {
        *shift = ScoredShift::new(maximum.col, maximum.row);
        shift.score = maximum.score as f32;
    }
    let found = candidates(shifts.get(..maxima.len()).unwrap_or(&[]), large);
    if images.is_featureless() {
        return Err(MatchError::Featureless);
    }
    // Shifts are scored in pairs: of an odd number one more is scored and ignored.
    let asked = shifts.get_mut(..found.next_multiple_of(2)).ok_or(MatchError::Featureless)?;
    images.score(asked);
    let found = asked.get(..found).ok_or(MatchError::Featureless)?;
    climb::climb(&images, found, radius, scores).ok_or(MatchError::Featureless)
}

/// Whether all runs lie in the patch.
pub(super) fn check(patch: &View<'_>, runs: &[Run]) -> Result<(), MatchError> {
    for run in runs {
        let length = (run.end as usize).checked_sub(run.start as usize).ok_or(MatchError::Capacity)?;
        patch.run(run.row as usize, run.start as usize, length).ok_or(MatchError::Capacity)?;
    }
    Ok(())
}

/// The clipped high-pass image of a picture without invalid pixels, rows aligned to four.
fn filtered<'b>(picture: &View<'_>, bytes: &'b mut [u8]) -> View<'b> {
    let size = picture.size();
    let stride = stride(size);
    let mut threshold = ClippingThreshold::new();
    let rows = (0..size.1).map(|row| Run { row, start: 0, end: size.0 });
    filter(picture, rows, |piece, values| {
        if (piece.row as usize).is_multiple_of(CLIPPING_STRIDE) {
            threshold.add(values);
        }
        if let Some(target) = bytes.get_mut(piece.row as usize * stride + piece.start as usize..) {
            let length = values.len().min(target.len());
            put(values, target.split_at_mut(length).0);
        }
    });
    clip(threshold.value(), bytes);
    View::with_stride(bytes, size, stride)
}

/// Number of the `shifts`, highest first, that may be the peak or the second one, given scores of `large` values.
///
/// By chance a value adds 0 or ±1 to a score: a variance of 1/4, and to the difference of two scores 1/2.
fn candidates(shifts: &[ScoredShift], large: u32) -> usize {
    let Some(&highest) = shifts.first() else { return 0 };
    let least = highest.score - CANDIDATE_SIGMAS * math::sqrt(0.5 * large as f32);
    let other = shifts.iter().position(|shift| shift.apart(&highest) >= MAIN_LOBE_PX as u16).unwrap_or(0);
    let close = shifts.iter().take_while(|shift| shift.score >= least).count();
    close.max(other + 1).min(shifts.len())
}
