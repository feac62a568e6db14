//! Reacquisition: the search for a patch far from its prediction, coarse to fine.
//!
//! Boxes of k x k pixels of patch and reference make two reduced pictures, whose high-pass images are correlated at
//! every shift of whole boxes. At an offset of half a box the true position still has half of its correlation, which
//! over a few hundred boxes is among the highest of some thousand chance values. Full resolution then decides: around
//! each of the highest local maxima the pictures are correlated within ±`FINE_PX`. The second peak is the best other
//! shift of all of these.

mod sizes;
mod boxes;
mod ranking;
mod fine;

use super::MatchError;
use super::local_maximum::MAIN_LOBE_PX;
use super::search::{Peak, check};
use crate::image::{Run, View};
use fine::{Fine, FineMatch};
use ranking::{CANDIDATES, Candidate, coarse};
use sizes::Span;
pub use sizes::working_bytes;
pub(super) use sizes::{FINE_PX, LONG_PX};

/// Most windows by which a climb moves on: a candidate is off by a box at most, which is one window.
const CLIMB: usize = 3;

/// Searches all shifts of the patch within ±`radius` of `at`, as far as `tile` reaches.
///
/// `patch` and `runs`: as the rectifier leaves them. `at`: (column, row) of the tile at which the patch's upper left
/// pixel is predicted. `bytes`: [`working_bytes`]; with less, boxes become larger.
///
/// # Errors
/// [`MatchError`].
pub(super) fn reacquire(
    patch: &View<'_>,
    runs: &[Run],
    tile: &View<'_>,
    at: (i32, i32),
    radius: u16,
    bytes: &mut [u8],
) -> Result<FineMatch, MatchError> {
    check(patch, runs)?;
    let aligned = bytes.as_ptr().align_offset(4);
    let bytes = bytes.get_mut(aligned..).ok_or(MatchError::Capacity)?;
    let span = Span::new(patch, tile, at, radius).ok_or(MatchError::OutsideReference)?;
    let mut buffer = [Candidate::default(); CANDIDATES];
    let candidates = coarse(patch, runs, tile, at, &span, bytes, &mut buffer)?;
    let mut fine = Fine::new(patch, runs, bytes)?;
    let mut found: [Option<FineMatch>; CANDIDATES] = [None; CANDIDATES];
    for (found, candidate) in found.iter_mut().zip(candidates) {
        *found = Some(fine.search(tile, at, *candidate)?);
    }
    // The best and the best other one; each climbs on while its peak lies on its window's border.
    let mut best = None;
    for rank in 0..2 {
        for _ in 0..CLIMB {
            let Some((index, found_at)) = highest(&found, if rank == 0 { None } else { best }) else { break };
            let next = span.nearest((found_at.peak.d_col, found_at.peak.d_row));
            if !found_at.local.on_border || next == found_at.centre {
                break;
            }
            if let Some(found) = found.get_mut(index) {
                *found = Some(fine.search(tile, at, next)?);
            }
        }
        best = highest(&found, None).map(|(_, found_at)| found_at);
    }
    let mut best = best.ok_or(MatchError::Featureless)?;
    second_into(&mut best.peak, &found);
    Ok(best)
}

/// Sets the second peak to the best other shift of all `found`.
fn second_into(peak: &mut Peak, found: &[Option<FineMatch>]) {
    for other in found.iter().flatten() {
        let own = ((other.peak.d_col, other.peak.d_row), other.peak.score);
        for (found_at, score) in [own, (other.peak.second_at, other.peak.second)] {
            if score > peak.second && apart(found_at, (peak.d_col, peak.d_row)) >= MAIN_LOBE_PX {
                (peak.second, peak.second_at) = (score, found_at);
            }
        }
    }
}

/// The highest shift, optionally of those off the main lobe of `but`.
fn highest(found: &[Option<FineMatch>], but: Option<FineMatch>) -> Option<(usize, FineMatch)> {
    let at = |found: &FineMatch| (found.peak.d_col, found.peak.d_row);
    let others = found.iter().enumerate().filter_map(|(index, found)| found.map(|found| (index, found)));
    let others = others.filter(|(_, found)| but.is_none_or(|but| apart(at(found), at(&but)) >= MAIN_LOBE_PX));
    others.reduce(|best, next| if next.1.peak.score > best.1.peak.score { next } else { best })
}

/// Distance of two shifts, the larger of both axes.
fn apart(a: (i16, i16), b: (i16, i16)) -> i16 {
    (a.0 - b.0).abs().max((a.1 - b.1).abs())
}

/// The tile around the patch at a shift of `centre`, ±[`FINE_PX`].
pub(super) fn window<'a>(patch: &View<'_>, tile: &View<'a>, at: (i32, i32), centre: (i16, i16)) -> Option<View<'a>> {
    let corner = |at: i32, centre: i16| at + centre as i32 - FINE_PX as i32;
    let (cols, rows) = patch.size();
    tile.window(corner(at.0, centre.0), corner(at.1, centre.1), (cols + 2 * FINE_PX, rows + 2 * FINE_PX))
}
