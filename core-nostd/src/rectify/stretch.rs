//! The frame as it is, and stretches of positions that are known to lie in it.

use super::RectifyError;
use crate::reduce::Reduction;

/// How far a stretch's ends must lie inside, Q16: more than the steps lose by truncation, one a reading and at most 128.
pub(super) const GUARD: i32 = 512;

/// A frame as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a> {
    /// Row-major, exactly as many as `size` says.
    pixels: &'a [u8],
    size: (u16, u16),
}

impl<'a> Frame<'a> {
    /// # Errors
    /// [`RectifyError::Size`] for another number of pixels than `reduction` leaves or a frame of less than 2 x 2.
    pub(crate) fn new(pixels: &'a [u8], reduction: Reduction) -> Result<Self, RectifyError> {
        let size = reduction.size();
        let fits = !reduction.is_boxes() && size.0 >= 2 && size.1 >= 2 && pixels.len() == reduction.bytes();
        fits.then_some(Frame { pixels, size }).ok_or(RectifyError::Size)
    }

    /// (cols, rows).
    pub(crate) fn size(&self) -> (u16, u16) {
        self.size
    }

    /// The first pixel, and pixels from one row to the next.
    #[cfg(feature = "dsp")]
    #[inline(always)]
    pub(super) fn start(&self) -> (*const u8, u16) {
        (self.pixels.as_ptr(), self.size.0)
    }

    /// Two pixels from (`col`, `row`) on, and the two below; `None` outside.
    #[inline(always)]
    pub(super) fn four(&self, col: usize, row: usize) -> Option<[u8; 4]> {
        let cols = self.size.0 as usize;
        let pair = |row: usize| self.pixels.get(row * cols + col..)?.first_chunk::<2>();
        let (&[a, b], &[c, d]) = (pair(row)?, pair(row + 1)?);
        Some([a, b, c, d])
    }
}

/// Positions in a frame, Q16 of a pixel, column and row, at steps of Q24 / 2^24 pixels. The step grows with every reading,
/// or with every second where two share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stretch {
    /// Where the first reading is.
    at: [i32; 2],
    /// From one reading to the next.
    step: [i32; 2],
    /// What is added to the step.
    growth: [i32; 2],
}

impl Stretch {
    /// Position, step and growth.
    #[inline(always)]
    pub(super) fn parts(&self) -> ([i32; 2], [i32; 2], [i32; 2]) {
        (self.at, self.step, self.growth)
    }
}

/// A [`Stretch`] that is not yet known to lie in the frame.
#[derive(Debug)]
pub(crate) struct Draft {
    stretch: Stretch,
    is_inside: [bool; 2],
}

impl Draft {
    /// Without columns and rows.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Draft { stretch: Stretch { at: [0; 2], step: [0; 2], growth: [0; 2] }, is_inside: [false; 2] }
    }

    /// Columns (0) or rows (1) of `count` readings from `at` on, with a `step` that grows by `growth` at each of `turns`, in
    /// a frame of `size` columns or rows.
    #[inline(always)]
    pub(crate) fn set(&mut self, axis: usize, [at, step, growth]: [i32; 3], turns: usize, count: usize, size: u16) {
        self.is_inside[axis] = stays(at, step, (growth, turns), count, (size as i32 - 1) << 16);
        (self.stretch.at[axis], self.stretch.step[axis], self.stretch.growth[axis]) = (at, step, growth);
    }

    /// The stretch, if all four pixels of every reading are the frame's.
    #[inline(always)]
    pub(crate) fn checked(self) -> Option<Stretch> {
        (self.is_inside[0] & self.is_inside[1]).then_some(self.stretch)
    }
}

/// Whether `count` readings from `at` on, with a `step` that grows by `growth` at each of `turns`, all lie at least
/// [`GUARD`] less what truncation takes from 0 and `last`.
#[inline(always)]
fn stays(at: i32, step: i32, (growth, turns): (i32, usize), count: usize, last: i32) -> bool {
    let Ok(last_step) = i32::try_from(step as i64 + growth as i64 * (turns as i64 - 1)) else { return false };
    // Steps of one sign lead from one end to the other; steps of a few 65536ths lead nowhere.
    if (step ^ last_step) < 0 && step.unsigned_abs().max(last_step.unsigned_abs()) > 512 {
        return false;
    }
    let mean = (step >> 1) + (last_step >> 1);
    // The last reading, a step before the end of the last step.
    let end = at as i64 + ((mean as i64 * count as i64 - last_step as i64) >> 8);
    let holds = |at: i64| at >= GUARD as i64 && at <= (last - GUARD) as i64;
    holds(at as i64) && holds(end)
}
