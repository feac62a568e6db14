//! Box averages of the frame's rows as they arrive.
//!
//! The pose at mid-exposure exists only after the next attitude sample and its latency, often when rows already
//! arrive, and a whole frame does not fit the memory. But a rectified pixel spans many frame pixels, so the frame can
//! be averaged over `factor` x `factor` boxes without knowing where it was taken from: what is kept is an ordinary,
//! smaller frame, and nothing that depends on attitude has run.

use crate::dsp::{add_bytes, add_sixes};

/// Why a row was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReduceError {
    /// The reduced frame does not fit the buffers given.
    Capacity,
    /// A row of another length than the frame's, or one row too many.
    Size,
}

/// How far a frame is reduced, and where a frame pixel lies in the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reduction {
    factor: u16,
    /// Boxes across and along. Where `factor` does not divide the frame the last columns and rows are left out.
    size: (u16, u16),
}

/// Frame pixels a reduced pixel should span at most, as a share of a patch pixel: four boxes a patch pixel keep the
/// area average true to 1/8 of its width.
const BOXES_PER_PATCH_PX: f32 = 4.0;
/// Largest factor: 16-bit sums hold 255 x 16 x 16.
const FACTOR_MAX: u16 = 16;

impl Reduction {
    /// The reduction for a frame whose patch pixels span `ratio` frame pixels, in at most `capacity` reduced pixels:
    /// the largest factor with four boxes a patch pixel; a larger one only if the memory asks for it.
    ///
    /// # Errors
    /// [`ReduceError::Capacity`] when not even 16 x 16 boxes fit.
    pub fn choose(frame: (u16, u16), ratio: f32, capacity: usize) -> Result<Self, ReduceError> {
        let wished = ((ratio / BOXES_PER_PATCH_PX) as u16).clamp(1, FACTOR_MAX);
        (wished..=FACTOR_MAX)
            .map(|factor| Reduction { factor, size: (frame.0 / factor, frame.1 / factor) })
            .find(|r| r.size.0 >= 2 && r.size.1 >= 2 && r.size.0 as usize * r.size.1 as usize <= capacity)
            .ok_or(ReduceError::Capacity)
    }

    /// Frame pixels a side of a box.
    pub fn factor(&self) -> u16 {
        self.factor
    }

    /// Reduced frame, (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Reduced position of a frame position, either axis: boxes and pixels both have their centres at integers.
    pub fn reduced(&self, frame_px: f32) -> f32 {
        (frame_px - 0.5 * (self.factor as f32 - 1.0)) / self.factor as f32
    }
}

/// Sums rows into boxes. The caller keeps the reduced frame and one row of sums.
#[derive(Debug)]
pub struct Reducer {
    reduction: Reduction,
    frame: (u16, u16),
    row: u16,
    /// ceil(2^24 / factor²): the mean of a box without a division, exact for every sum.
    reciprocal: u32,
}

impl Reducer {
    /// Starts a frame of (`cols`, `rows`).
    pub fn new(reduction: Reduction, frame: (u16, u16)) -> Self {
        let area = reduction.factor as u32 * reduction.factor as u32;
        Reducer { reduction, frame, row: 0, reciprocal: (1u32 << 24).div_ceil(area) }
    }

    /// The reduction at work.
    pub fn reduction(&self) -> Reduction {
        self.reduction
    }

    /// Rows taken so far.
    pub fn rows_taken(&self) -> u16 {
        self.row
    }

    /// Whether every row of the frame has arrived.
    pub fn is_complete(&self) -> bool {
        self.row == self.frame.1
    }

    /// Takes the next row. `sums`: at least one entry a box column; `reduced`: row-major, at least
    /// [`Reduction::size`] pixels. Means are rounded to nearest.
    ///
    /// # Errors
    /// [`ReduceError::Size`] for a row of another length or after the last one, [`ReduceError::Capacity`] for buffers
    /// too small.
    pub fn take(&mut self, row: &[u8], sums: &mut [u16], reduced: &mut [u8]) -> Result<(), ReduceError> {
        if row.len() != self.frame.0 as usize || self.is_complete() {
            return Err(ReduceError::Size);
        }
        let (cols, rows) = (self.reduction.size.0 as usize, self.reduction.size.1 as usize);
        let factor = self.reduction.factor;
        let box_row = (self.row / factor) as usize;
        let phase = self.row % factor;
        self.row += 1;
        if box_row >= rows {
            return Ok(());
        }
        let sums = sums.get_mut(..cols).ok_or(ReduceError::Capacity)?;
        let line = reduced.get_mut(box_row * cols..(box_row + 1) * cols).ok_or(ReduceError::Capacity)?;
        if phase == 0 {
            sums.fill(0);
        }
        add_row(row, factor as usize, sums);
        if phase + 1 == factor {
            let half = (factor as u32 * factor as u32) / 2;
            for (mean, &sum) in line.iter_mut().zip(sums.iter()) {
                // 255.5 x 2^24 at most, and 2^16 for the reciprocal's rounding: below 2^32.
                *mean = ((sum as u32 + half).wrapping_mul(self.reciprocal) >> 24) as u8;
            }
        }
        Ok(())
    }
}

/// Adds one row to the sums of its boxes.
fn add_row(row: &[u8], factor: usize, sums: &mut [u16]) {
    match factor {
        2 => add_pairs::<4>(row, sums, 2, |bytes| {
            let word = u32::from_le_bytes(*bytes);
            (word & 0x00ff_00ff) + ((word >> 8) & 0x00ff_00ff)
        }),
        4 => add_pairs::<8>(row, sums, 4, |bytes| {
            let [a, b] = words(bytes);
            add_bytes(a, 0) + (add_bytes(b, 0) << 16)
        }),
        6 => {
            let (pairs, last) = sums.as_chunks_mut::<2>();
            let done = 12 * pairs.len();
            add_sixes(row, pairs);
            add_boxes(row.get(done..).unwrap_or(&[]), factor, last);
        }
        8 => add_pairs::<16>(row, sums, 8, |bytes| {
            let [a, b, c, d] = words(bytes);
            add_bytes(a, add_bytes(b, 0)) + (add_bytes(c, add_bytes(d, 0)) << 16)
        }),
        _ => add_boxes(row, factor, sums),
    }
}

/// Two boxes at a time, whose sums of `BYTES` pixels `both` gives in the halves of a word.
#[inline(always)]
fn add_pairs<const BYTES: usize>(row: &[u8], sums: &mut [u16], factor: usize, both: impl Fn(&[u8; BYTES]) -> u32) {
    let (pairs, last) = sums.as_chunks_mut::<2>();
    let done = pairs.len() * BYTES;
    for (pair, bytes) in pairs.iter_mut().zip(row.as_chunks::<BYTES>().0) {
        let total = (pair[0] as u32 | (pair[1] as u32) << 16) + both(bytes);
        *pair = [total as u16, (total >> 16) as u16];
    }
    add_boxes(row.get(done..).unwrap_or(&[]), factor, last);
}

/// One box at a time, of any width.
fn add_boxes(row: &[u8], factor: usize, sums: &mut [u16]) {
    for (sum, pixels) in sums.iter_mut().zip(row.chunks_exact(factor)) {
        *sum += pixels.iter().map(|&pixel| pixel as u16).sum::<u16>();
    }
}

fn words<const BYTES: usize, const WORDS: usize>(bytes: &[u8; BYTES]) -> [u32; WORDS] {
    const { assert!(BYTES == 4 * WORDS) };
    core::array::from_fn(|i| u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]))
}
