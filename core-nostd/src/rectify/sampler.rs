//! Bilinear readings of a frame at Q16 positions.

use super::RectifyError;
use crate::reduce::Reduction;
use fixed::types::I16F16;

/// A frame as the rectifier reads it: the pixels left by a [`Reduction`] (of factor 1 for the frame itself).
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    pixels: &'a [u8],
    reduction: Reduction,
}

/// A column and a row of the source, whole numbers at the centres of pixels.
pub(super) type Position = (I16F16, I16F16);

/// Steps of a reading per grey level.
pub(super) const STEPS: u32 = 256;
/// Weights along rows have eight bits, as many as let two rows share a word; rounded, they put a reading within half a
/// grey level of exact at the steepest edge. Those along columns have twelve.
const ROUND: i32 = 1 << 7;

impl<'a> Source<'a> {
    /// Row-major `pixels`, exactly as many as `reduction` leaves.
    ///
    /// # Errors
    /// [`RectifyError::Size`] for another number of pixels or a frame of less than 2 x 2.
    pub fn new(pixels: &'a [u8], reduction: Reduction) -> Result<Self, RectifyError> {
        let (cols, rows) = reduction.size();
        if cols < 2 || rows < 2 || pixels.len() != cols as usize * rows as usize {
            return Err(RectifyError::Size);
        }
        Ok(Source { pixels, reduction })
    }

    /// What the frame was reduced by.
    pub fn reduction(&self) -> &Reduction {
        &self.reduction
    }

    /// Whether the position can be read: from the centre of the first pixel to that of the last.
    #[inline(always)]
    pub(super) fn holds(&self, (col, row): Position) -> bool {
        let (cols, rows) = self.reduction.size();
        let last = |count: u16| I16F16::from_bits((count as i32 - 1) << 16);
        col >= 0 && row >= 0 && col <= last(cols) && row <= last(rows)
    }

    /// Whether the position lies so far inside that its four pixels exist without a look at the border.
    #[inline(always)]
    fn is_inner(&self, (col, row): Position) -> bool {
        let (cols, rows) = self.reduction.size();
        let last = |count: u16| I16F16::from_bits((count as i32 - 1) << 16);
        col >= 0 && row >= 0 && col < last(cols) && row < last(rows)
    }

    /// The reading at (`col`, `row`), in [`STEPS`]. The caller has checked the position against [`Source::holds`]; outside
    /// it the nearest pixels are read, never memory beyond them.
    pub(super) fn reading(&self, (col, row): Position) -> u32 {
        let (cols, rows) = self.reduction.size();
        // The last pixel is reached with the full weight of its left neighbour's pair.
        let split = |bits: i32, count: u16| {
            let bits = bits.max(0) as u32;
            let index = (bits >> 16).min(count as u32 - 2);
            (index as usize, (bits - (index << 16)).min(1 << 16))
        };
        let ((x, fx), (y, fy)) = (split(col.to_bits() + ROUND, cols), split(row.to_bits(), rows));
        let (fx, fy) = (fx >> 8, fy >> 4);
        let pair = |row: usize| {
            let at = row * cols as usize + x;
            self.pixels.get(at..at + 2).map_or(0, |pair| pair[0] as u32 * (256 - fx) + pair[1] as u32 * fx)
        };
        (pair(y) * (4096 - fy) + pair(y + 1) * fy) >> 12
    }

    /// Adds `N` readings to each cell's sum, from `at` on in even steps, in [`STEPS`]; false, and nothing done, unless
    /// the first and the last of them lie well inside.
    ///
    /// The same bits as [`Source::reading`], about 20 instructions each.
    #[inline(always)]
    pub(super) fn add_readings<const N: usize>(&self, at: Position, step: Position, sums: &mut [u32]) -> bool {
        let (stride, count) = (self.reduction.size().0 as usize, (sums.len() * N) as i32);
        let (mut x, mut y) = (at.0.to_bits().wrapping_add(ROUND), at.1.to_bits());
        let (dx, dy) = (step.0.to_bits(), step.1.to_bits());
        let end = |from: i32, step: i32| I16F16::from_bits(from.wrapping_add(step.wrapping_mul(count - 1)));
        let first = (I16F16::from_bits(x), I16F16::from_bits(y));
        if count == 0 || !self.is_inner(first) || !self.is_inner((end(x, dx), end(y, dy))) {
            return false;
        }
        for sum in sums {
            let mut total = 0;
            for _ in 0..N {
                // SAFETY: positions are linear in the index, so all lie between the first and the last, which both have
                // their four pixels inside the frame; a frame of `size` pixels is what `new` has checked.
                let (top, bottom) = unsafe {
                    let first = self.pixels.as_ptr().add((y >> 16) as usize * stride + (x >> 16) as usize);
                    (first.cast::<u16>().read_unaligned(), first.add(stride).cast::<u16>().read_unaligned())
                };
                // Both rows at once, in the halves of a word: left and right pixels, weighed.
                let four = u16::from_le(top) as u32 | (u16::from_le(bottom) as u32) << 16;
                let (fx, fy) = ((x as u32 >> 8) & 0xff, (y as u32 >> 4) & 0xfff);
                let rows = (four & 0x00ff_00ff) * (256 - fx) + ((four >> 8) & 0x00ff_00ff) * fx;
                total += ((rows & 0xffff) * (4096 - fy) + (rows >> 16) * fy) >> 12;
                (x, y) = (x.wrapping_add(dx), y.wrapping_add(dy));
            }
            *sum += total;
        }
        true
    }
}
