//! The search in full resolution around a shift.

use super::boxes;
use super::ranking::ranked;
use super::sizes::{FINE, FINE_PX, Sizes};
use crate::image::{Run, View};
use crate::matching::MatchError;
use crate::matching::kernels::correlation::dot_and_energy;
use crate::matching::local_maximum::{MAIN_LOBE_PX, vertex};
use crate::matching::search::Peak;
use crate::math::sqrt;

/// Result of a search: the peak, and the window's centre.
#[derive(Clone, Copy, Debug)]
pub(in crate::matching) struct FineMatch {
    /// The peak relative to the whole search's centre.
    pub(in crate::matching) peak: Peak,
    /// The peak relative to its window's centre.
    pub(in crate::matching) local: Peak,
    /// The shift at the window's centre.
    pub(in crate::matching) centre: (i16, i16),
}

/// The search around candidates.
pub(super) struct Fine<'a> {
    sizes: Sizes,
    /// The patch's high-pass image, rows padded with zeros, and its energy.
    own: &'a [u8],
    energy: i32,
    runs: &'a [Run],
    buffer: &'a mut [u8],
}

impl<'a> Fine<'a> {
    pub(super) fn new(patch: &View<'_>, runs: &'a [Run], bytes: &'a mut [u8]) -> Result<Self, MatchError> {
        let sizes = Sizes::fine(patch.size());
        let (own, buffer) = bytes.split_at_mut_checked(sizes.bytes()[0]).ok_or(MatchError::Capacity)?;
        boxes::patch_into(patch, runs, &sizes, own, buffer).ok_or(MatchError::Featureless)?;
        let own = &*own;
        let energy = dot_and_energy(own, own).1;
        Ok(Fine { sizes, own, energy, runs, buffer })
    }

    /// The peak around a shift of `centre`.
    #[inline(never)]
    pub(super) fn search(
        &mut self,
        tile: &View<'_>,
        at: (i32, i32),
        centre: (i16, i16),
    ) -> Result<FineMatch, MatchError> {
        let fine = FINE_PX as i32;
        let corner = (at.0 + centre.0 as i32 - fine, at.1 + centre.1 as i32 - fine);
        let (other, scores) = ranked(self.own, tile, corner, &self.sizes, 1, &mut *self.buffer)?;
        let rank =
            |(col, row): (usize, usize)| scores.get(row * FINE + col).map_or(0.0, |&score| f32::from_le_bytes(score));
        let all = || (0..FINE * FINE).map(|index| (index % FINE, index / FINE));
        let highest = |best: (usize, usize), next: (usize, usize)| if rank(next) > rank(best) { next } else { best };
        let top = all().reduce(highest).unwrap_or((FINE_PX as usize, FINE_PX as usize));
        let strides = self.sizes.strides();
        let score = |shift| score((self.own, self.energy), other, self.runs, strides, shift);
        let is_apart =
            |shift: &(usize, usize)| shift.0.abs_diff(top.0).max(shift.1.abs_diff(top.1)) >= MAIN_LOBE_PX as usize;
        let second = all().filter(is_apart).reduce(highest).filter(|&shift| rank(shift) > 0.0);
        let on_border = [top.0, top.1].iter().any(|&at| at == 0 || at == FINE - 1);
        // Ranks are squared scores but for the mask.
        let height = |shift| sqrt(rank(shift).max(0.0));
        let vertex = |before, behind| vertex(height(before), height(top), height(behind));
        let (col, row) = top;
        let vertex = if on_border {
            (0.0, 0.0)
        } else {
            (vertex((col - 1, row), (col + 1, row)), vertex((col, row - 1), (col, row + 1)))
        };
        let shift = |(col, row): (usize, usize)| (col as i16 - FINE_PX as i16, row as i16 - FINE_PX as i16);
        let (d_col, d_row) = shift(top);
        let second_at = shift(second.unwrap_or(top));
        let second = second.map_or(0.0, score);
        let local = Peak { d_col, d_row, score: score(top), second, second_at, vertex, on_border };
        let moved = |(col, row): (i16, i16)| (col + centre.0, row + centre.1);
        let ((d_col, d_row), second_at) = (moved((d_col, d_row)), moved(second_at));
        Ok(FineMatch { peak: Peak { d_col, d_row, second_at, ..local }, local, centre })
    }
}

/// Correlation of the high-pass images at a shift of the window, the reference's energy under the mask.
fn score(
    (own, own_energy): (&[u8], i32),
    other: &[u8],
    runs: &[Run],
    strides: (usize, usize),
    (col, row): (usize, usize),
) -> f32 {
    let (mut products, mut energy) = (0, 0);
    for run in runs {
        let (line, start, length) = (run.row as usize, run.start as usize, (run.end - run.start) as usize);
        let own = own.get(line * strides.0 + start..).and_then(|own| own.get(..length)).unwrap_or(&[]);
        let others = other.get((line + row) * strides.1 + start + col..).unwrap_or(&[]);
        let (product, square) = dot_and_energy(own, others);
        products += product;
        energy += square;
    }
    if energy > 0 { products as f32 / (sqrt(own_energy as f32) * sqrt(energy as f32)) } else { 0.0 }
}
