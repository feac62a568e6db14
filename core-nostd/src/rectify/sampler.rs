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

/// Bits of the interpolation weights. Two weights and a grey level fill 8 + 2 x 11 = 30 bits, and the reading is
/// within 0.13 grey levels of exact.
const WEIGHT_BITS: u32 = 11;

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
    pub(super) fn holds(&self, (col, row): (I16F16, I16F16)) -> bool {
        let (cols, rows) = self.reduction.size();
        let last = |count: u16| I16F16::from_bits((count as i32 - 1) << 16);
        col >= 0 && row >= 0 && col <= last(cols) && row <= last(rows)
    }

    /// The reading at (`col`, `row`), rounded to nearest. The caller has checked the position against
    /// [`Source::holds`]; outside it the nearest pixels are read, never memory beyond them.
    #[inline(always)]
    pub(super) fn bilinear(&self, col: I16F16, row: I16F16) -> u32 {
        let (cols, rows) = self.reduction.size();
        let (x, wx) = split(col, cols);
        let (y, wy) = split(row, rows);
        let at = y * cols as usize + x;
        let Some(upper) = self.pixels.get(at..at + 2) else { return 0 };
        let Some(lower) = self.pixels.get(at + cols as usize..at + cols as usize + 2) else { return 0 };
        let one = 1u32 << WEIGHT_BITS;
        let top = upper[0] as u32 * (one - wx) + upper[1] as u32 * wx;
        let bottom = lower[0] as u32 * (one - wx) + lower[1] as u32 * wx;
        (top * (one - wy) + bottom * wy + (1 << (2 * WEIGHT_BITS - 1))) >> (2 * WEIGHT_BITS)
    }
}

/// Pixel and weight of a position; the last pixel is reached with the full weight of its left neighbour's pair.
#[inline(always)]
fn split(position: I16F16, count: u16) -> (usize, u32) {
    // Rounded steps may end a hair below zero.
    let bits = position.to_bits().max(0) as u32;
    let index = (bits >> 16).min(count as u32 - 2);
    (index as usize, (bits - (index << 16)) >> (16 - WEIGHT_BITS))
}
