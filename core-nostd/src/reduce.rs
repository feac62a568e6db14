//! What is kept of a frame's rows as they arrive.
//!
//! The pose at mid-exposure exists only after the next attitude sample and its latency, often when rows already arrive.
//! But a rectified pixel spans many frame pixels, so the frame can be averaged over `factor` x `factor` boxes without
//! knowing where it was taken from: nothing that depends on attitude has run.
//!
//! What is kept is, for every row of boxes, the sum of all boxes left of each border between two. The rectifier integrates
//! along the borders of its cells (module `rectify`), and such a sum is one reading where the boxes would be many. Only
//! where a patch pixel spans less than two frame pixels are the pixels themselves kept, for bilinear readings.

pub(crate) mod kernels;

use crate::arch::add_bytes;
use kernels::{prefix_fours, prefix_pairs};

/// Why rows were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReduceError {
    /// What is kept does not fit the memory given.
    Capacity,
    /// Rows of another length or number than expected, or too many.
    Size,
}

/// What is kept of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reduction {
    /// Frame pixels a side of a box; 0 where the pixels themselves are kept.
    factor: u16,
    /// Boxes, or pixels, across and along. Where `factor` does not divide the frame the last columns and rows are left
    /// out.
    size: (u16, u16),
}

/// Patch pixels that span fewer frame pixels than this are read from the frame itself. Chosen between 1, where there is nothing
/// to average, and 3. Over ground of 40 grey levels, waves of two patch pixels and more, a reading is off the average by 1.0
/// grey levels (root mean square) at 1, 3.1 at 1.5, 3.8 at 2 and 5.0 at 3; but sums take twice the memory of pixels.
const AVERAGED_FROM: f32 = 2.0;
/// Boxes a patch pixel spans at least. Over ground of 40 grey levels, waves of a third of a patch pixel and more, what a box
/// hides at the border of a cell is 0.6 grey levels (root mean square) at six, 2.1 at three and 6.4 at one and a half.
const BOXES_PER_PATCH_PX: f32 = 3.0;
/// Powers of two: the mean of a box is a shift.
const FACTORS: [u16; 7] = [1, 2, 4, 8, 16, 32, 64];
/// What is taken off every box, so that sums over a row of 256 of them stay within 16 bits.
const MID_GREY: i32 = 128;

impl Reduction {
    /// The frame as it is, for bilinear readings.
    pub fn none(frame: (u16, u16)) -> Self {
        Reduction { factor: 0, size: frame }
    }

    /// What is kept of a frame whose patch pixels span `ratio` frame pixels, in at most `capacity` bytes. Below 2 the
    /// frame itself where it fits; else the largest boxes of which a patch pixel spans three, larger ones only if the
    /// memory asks for it.
    ///
    /// # Errors
    /// [`ReduceError::Capacity`] when not even boxes of 64 x 64 fit, or no two of them the frame.
    pub fn choose(frame: (u16, u16), ratio: f32, capacity: usize) -> Result<Self, ReduceError> {
        let whole = Reduction::none(frame);
        let fits = |r: &Reduction| r.size.0 >= 2 && r.size.1 >= 2 && r.bytes() <= capacity;
        if ratio < AVERAGED_FROM && fits(&whole) {
            return Ok(whole);
        }
        let wished = FACTORS.into_iter().rev().find(|&factor| factor as f32 * BOXES_PER_PATCH_PX <= ratio);
        FACTORS
            .into_iter()
            .filter(|&factor| factor >= wished.unwrap_or(1))
            .map(|factor| Reduction { factor, size: (frame.0 / factor, frame.1 / factor) })
            .find(fits)
            .ok_or(ReduceError::Capacity)
    }

    /// Frame pixels a side of a box, or of what else is kept.
    pub fn factor(&self) -> u16 {
        self.factor.max(1)
    }

    /// Whether sums of boxes are kept, not pixels.
    pub fn is_boxes(&self) -> bool {
        self.factor > 0
    }

    /// Boxes or pixels, (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Bytes of a row of what is kept. Of sums, two bytes each: one that is not used, so that those made two at a time are
    /// words of the memory, the 0 of the first border, and one for each box.
    pub fn stride(&self) -> usize {
        let cols = self.size.0 as usize;
        if self.is_boxes() { 2 * (cols + 2) } else { cols }
    }

    /// Bytes of all that is kept.
    pub fn bytes(&self) -> usize {
        self.stride() * self.size.1 as usize
    }

    /// Bits that a sum is shifted right so that those of the longest row fit 16 bits: none up to 256 boxes.
    pub fn shift(&self) -> u32 {
        self.size.0.div_ceil(256).next_power_of_two().trailing_zeros()
    }
}

/// Keeps what is to be kept of a frame's rows. The memory is the caller's.
#[derive(Debug)]
pub struct Reducer {
    reduction: Reduction,
    frame: (u16, u16),
    row: u16,
}

impl Reducer {
    /// Starts a frame of (`cols`, `rows`).
    pub fn new(reduction: Reduction, frame: (u16, u16)) -> Self {
        Reducer { reduction, frame, row: 0 }
    }

    /// The reduction at work.
    pub fn reduction(&self) -> Reduction {
        self.reduction
    }

    /// Rows taken so far.
    pub fn rows_taken(&self) -> u16 {
        self.row
    }

    /// Rows that [`Reducer::take`] expects next at least: those of a row of boxes, or what is left of the frame; 0 after
    /// it.
    pub fn rows_wanted(&self) -> u16 {
        self.reduction.factor().min(self.frame.1.saturating_sub(self.row))
    }

    /// Whether every row of the frame has arrived.
    pub fn is_complete(&self) -> bool {
        self.row == self.frame.1
    }

    /// Takes the next [`Reducer::rows_wanted`] rows, one behind the other, or several times that, up to the whole frame.
    /// `kept`: at least [`Reduction::bytes`].
    ///
    /// Of boxes, entry `i` + 1 of a row is the sum of (mean − 128) over the boxes left of border `i`, shifted right by
    /// [`Reduction::shift`] and rounded down, little-endian.
    ///
    /// # Errors
    /// [`ReduceError::Size`] for another number of pixels or after the last row, [`ReduceError::Capacity`] for too
    /// little memory; what was taken before stays taken.
    pub fn take(&mut self, rows: &[u8], kept: &mut [u8]) -> Result<(), ReduceError> {
        let mut rows = rows;
        loop {
            let wanted = self.rows_wanted();
            let (next, rest) =
                rows.split_at_checked(self.frame.0 as usize * wanted as usize).ok_or(ReduceError::Size)?;
            if next.is_empty() {
                return Err(ReduceError::Size);
            }
            if wanted == self.reduction.factor() {
                self.keep(next, kept)?;
            }
            self.row += wanted;
            rows = rest;
            if rows.is_empty() {
                return Ok(());
            }
        }
    }

    /// Keeps a row of boxes, or of pixels.
    fn keep(&self, rows: &[u8], kept: &mut [u8]) -> Result<(), ReduceError> {
        let stride = self.reduction.stride();
        let first = (self.row / self.reduction.factor()) as usize * stride;
        let line = kept.get_mut(first..first + stride).ok_or(ReduceError::Capacity)?;
        if self.reduction.is_boxes() {
            let (ahead, sums) = line.as_chunks_mut::<2>().0.split_at_mut(2);
            ahead.fill([0; 2]);
            prefix(rows, self.frame.0 as usize, self.reduction, sums);
        } else if line.len() == rows.len() {
            line.copy_from_slice(rows);
        } else {
            return Err(ReduceError::Size);
        }
        Ok(())
    }
}

/// Sums of the boxes of one row, up to and with each.
fn prefix(rows: &[u8], cols: usize, reduction: Reduction, sums: &mut [[u8; 2]]) {
    let factor = reduction.factor() as usize;
    let line = |nth: usize| rows.get(nth * cols..(nth + 1) * cols).unwrap_or(&[]);
    let begun = match (factor, reduction.shift()) {
        (2, 0) => prefix_pairs([line(0), line(1)], sums),
        (4, 0) => prefix_fours([line(0), line(1), line(2), line(3)], sums),
        _ => (0, 0),
    };
    prefix_from(begun, rows, cols, reduction, sums);
}

/// [`prefix`] of boxes of any size from box `done` on, where the sum of pixels so far is `total`; rounded down at the end.
#[inline(never)]
fn prefix_from((done, mut total): (usize, i32), rows: &[u8], cols: usize, reduction: Reduction, sums: &mut [[u8; 2]]) {
    let factor = reduction.factor() as usize;
    let shift = reduction.shift() + 2 * factor.trailing_zeros();
    let first = done * factor;
    for (from, sum) in (first..).step_by(factor).zip(sums.iter_mut().skip(done)) {
        let mut bytes = 0;
        for line in rows.chunks_exact(cols.max(1)) {
            let (words, rest) = line.get(from..from + factor).unwrap_or(&[]).as_chunks::<4>();
            for word in words {
                bytes = add_bytes(u32::from_le_bytes(*word), bytes);
            }
            bytes += rest.iter().map(|&pixel| pixel as u32).sum::<u32>();
        }
        // A row of 65,536 pixels, 64 high, stays below 2^30.
        total += bytes as i32 - MID_GREY * (factor * factor) as i32;
        *sum = ((total >> shift) as i16).to_le_bytes();
    }
}
