//! Masked normalised cross-correlation of gradient directions over whole-pixel shifts.
//!
//! Both channels have the same weight, and no mean is subtracted: over the eight years that changes nothing. Products are summed in
//! integers. A coarse ranking by one digit of every value orders all shifts; the whole patch decides between its highest local maxima and
//! climbs to the peak.

use super::Peak;
use super::climb::climb;
use super::gradients::{CHANNELS, filter, typical_energy};
use super::images::{Images, Patch};
use crate::image::{Run, View};
use crate::matching::MatchError;
use crate::matching::local_maximum::{LocalMaximum, highest};
use crate::matching::search::images::{ScoredShift, put};
use crate::matching::search::{READ_AHEAD, check, stride};

/// Local maxima of the coarse ranking that the whole patch scores: at most as many as with high-pass images.
const CANDIDATES: usize = 6;
/// Working space of a search for a `patch` in a `reference`, bytes, whatever the patch's mask.
pub const fn working_bytes(patch: (u16, u16), reference: (u16, u16)) -> usize {
    // Pieces are rounded up to four pixels; the shortest, of one pixel, has an invalid one next to it.
    let own = 2 * (patch.0 as usize + 1) * patch.1 as usize;
    reference_bytes(reference) + CHANNELS * own + 3
}

/// Bytes of the reference's image.
const fn reference_bytes(size: (u16, u16)) -> usize {
    CHANNELS * stride(size) * size.1 as usize + READ_AHEAD
}

/// The peak over all shifts within ±`radius`.
///
/// `patch` and `runs`: as the rectifier leaves them. `reference`: patch + 2 `radius` in both directions or larger; its centre is the zero
/// of the shifts when it is exactly that. `bytes`: [`working_bytes`]. `scores`: (2 `radius` + 1)² scores of the coarse ranking. Both are
/// working space.
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
    let images = images(patch, runs, reference, bytes)?;
    let scores = scores.get_mut(..side * side).ok_or(MatchError::Capacity)?;
    images.rank(side, scores);
    let mut buffer = [LocalMaximum::default(); CANDIDATES];
    let mut shifts = [ScoredShift::default(); CANDIDATES];
    let maxima = highest(scores, (side, side), |&score| score, &mut buffer);
    let found = shifts.get_mut(..maxima.len()).ok_or(MatchError::Featureless)?;
    for (shift, maximum) in found.iter_mut().zip(maxima) {
        *shift = ScoredShift::new(maximum.col, maximum.row);
    }
    images.score(found);
    climb(&images, found, radius, scores).ok_or(MatchError::Featureless)
}

/// Both images. `bytes`: [`working_bytes`].
///
/// # Errors
/// [`MatchError`] where the patch is featureless or invalid, or the space is too small.
pub(super) fn images<'b>(
    patch: &'b View<'_>,
    runs: &'b [Run],
    reference: &View<'_>,
    bytes: &'b mut [u8],
) -> Result<Images<'b>, MatchError> {
    check(patch, runs)?;
    // Both channels of the reference are stored as one picture.
    if reference.size().1 > u16::MAX / CHANNELS as u16 {
        return Err(MatchError::Capacity);
    }
    let skipped = bytes.as_ptr().align_offset(4);
    let bytes = bytes.get_mut(skipped..).ok_or(MatchError::Capacity)?;
    let (others, own) = bytes.split_at_mut_checked(reference_bytes(reference.size())).ok_or(MatchError::Capacity)?;
    let reference = filtered(reference, others);
    let images = Images::new(Patch::new(patch, runs, own).ok_or(MatchError::Capacity)?, reference);
    if images.is_featureless() { Err(MatchError::Featureless) } else { Ok(images) }
}

/// The image of a picture that is valid everywhere, rows aligned to four bytes, the second channel below the first.
fn filtered<'b>(picture: &View<'_>, bytes: &'b mut [u8]) -> View<'b> {
    let size = picture.size();
    let (stride, height) = (stride(size), size.1 as usize);
    let rows = (0..size.1).map(|row| Run { row, start: 0, end: size.0 });
    let energy = typical_energy(picture, rows.clone());
    filter(picture, rows, energy, |piece, channels| {
        for (channel, values) in channels.into_iter().enumerate() {
            let at = (channel * height + piece.row as usize) * stride + piece.start as usize;
            if let Some(target) = bytes.get_mut(at..) {
                let length = values.len().min(target.len());
                put(values, target.split_at_mut(length).0);
            }
        }
    });
    View::with_stride(bytes, (size.0, size.1 * CHANNELS as u16), stride)
}
