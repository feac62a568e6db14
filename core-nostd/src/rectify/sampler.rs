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

/// Added to a cell's sum by a reading outside the frame; no sum of 256 valid readings reaches it.
pub(super) const INVALID: u32 = 1 << 24;
const _: () = assert!(256 * 255 * STEPS < INVALID);
/// Positions beyond this and steps above that, in source pixels, are not held: half of what the numbers do, so that none
/// overflows along a path.
const FAR_PX: f32 = 8_000.0;
const STEP_MAX_PX: f32 = 60.0;

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

    /// Row-major.
    pub(super) fn pixels(&self) -> &'a [u8] {
        self.pixels
    }

    /// Whether the position can be read: from the centre of the first pixel to that of the last.
    #[inline(always)]
    pub(super) fn holds(&self, (col, row): Position) -> bool {
        let (cols, rows) = self.reduction.size();
        let last = |count: u16| I16F16::from_bits((count as i32 - 1) << 16);
        col >= 0 && row >= 0 && col <= last(cols) && row <= last(rows)
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

    /// Adds `samples` readings to each cell's sum along `path`, in [`STEPS`]; [`INVALID`] for one outside the frame.
    ///
    /// The same bits as [`Source::reading`]. Where the path lies inside the frame, about 22 instructions a reading; where
    /// it crosses the border it is halved until that is a matter of a few cells.
    pub(super) fn add_readings(&self, path: Path, samples: u16, sums: &mut [u32]) {
        let count = sums.len() * samples as usize;
        match (self.side(&path, count as i64), samples) {
            (Side::Inside, 1) => self.add_along::<1, true>(path, samples, sums),
            (Side::Inside, 2) => self.add_along::<2, true>(path, samples, sums),
            (Side::Inside, _) => self.add_along::<0, true>(path, samples, sums),
            (Side::Outside, _) => sums.iter_mut().for_each(|sum| *sum = sum.saturating_add(INVALID)),
            (Side::Across, _) if sums.len() <= FEW => self.add_along::<0, false>(path, samples, sums),
            (Side::Across, _) => {
                let (near, far) = sums.split_at_mut(sums.len() / 2);
                let further = path.from(near.len() as i64 * samples as i64);
                self.add_readings(path, samples, near);
                self.add_readings(further, samples, far);
            }
        }
    }

    /// Where `count` readings lie.
    fn side(&self, path: &Path, count: i64) -> Side {
        let (cols, rows) = self.reduction.size();
        let axis = |at: i32, step: i32, bend: i32, size: u16| {
            // A parabola strays from its chord by an eighth of its bend; truncation takes less than one a step off.
            let (at, end) = (at as i64, at as i64 + advance(step, bend, count));
            let stray = (((bend as i64).abs() * count * count) >> 11) + count;
            let (least, most, last) = (at.min(end) - stray, at.max(end) + stray, (size as i64 - 1) << 16);
            if least >= 0 && most < last {
                Side::Inside
            } else if most < 0 || least > last {
                Side::Outside
            } else {
                Side::Across
            }
        };
        match (axis(path.at.0 + ROUND, path.step.0, path.bend.0, cols), axis(path.at.1, path.step.1, path.bend.1, rows))
        {
            (Side::Inside, Side::Inside) => Side::Inside,
            (Side::Outside, _) | (_, Side::Outside) => Side::Outside,
            _ => Side::Across,
        }
    }

    /// Adds `N` readings a cell, or `samples` where `N` is 0; `INSIDE` where [`Source::side`] has said so.
    #[inline(always)]
    fn add_along<const N: usize, const INSIDE: bool>(&self, path: Path, samples: u16, sums: &mut [u32]) {
        let (cols, rows) = self.reduction.size();
        let stride = cols as usize;
        let last = ((cols as u32 - 1) << 16, (rows as u32 - 1) << 16);
        let ((mut x, mut y), (mut dx, mut dy)) = ((path.at.0 + ROUND, path.at.1), path.step);
        for sum in sums {
            let mut total = 0u32;
            for _ in 0..if N == 0 { samples as usize } else { N } {
                // As unsigned numbers, negative ones are large.
                if INSIDE || ((x as u32) < last.0 && (y as u32) < last.1) {
                    // SAFETY: column and row are at least 0 and less than the last ones, by the test before or, for all
                    // of the path, by `side`; `new` has checked that there are as many pixels.
                    let (top, bottom) = unsafe {
                        let first = self.pixels.as_ptr().add((y >> 16) as usize * stride + (x >> 16) as usize);
                        (first.cast::<u16>().read_unaligned(), first.add(stride).cast::<u16>().read_unaligned())
                    };
                    // Both rows at once, in the halves of a word: left and right pixels, weighed.
                    let four = u16::from_le(top) as u32 | (u16::from_le(bottom) as u32) << 16;
                    let (fx, fy) = ((x as u32 >> 8) & 0xff, (y as u32 >> 4) & 0xfff);
                    let rows = (four & 0x00ff_00ff) * (256 - fx) + ((four >> 8) & 0x00ff_00ff) * fx;
                    total += ((rows & 0xffff) * (4096 - fy) + (rows >> 16) * fy) >> 12;
                } else {
                    let at = (I16F16::from_bits(x - ROUND), I16F16::from_bits(y));
                    total = total.saturating_add(if self.holds(at) { self.reading(at) } else { INVALID });
                }
                (x, y) = (x + (dx >> 8), y + (dy >> 8));
                (dx, dy) = (dx + path.bend.0, dy + path.bend.1);
            }
            *sum = if INSIDE { *sum + total } else { sum.saturating_add(total) };
        }
    }
}

/// How far `count` steps lead, Q16.
fn advance(step: i32, bend: i32, count: i64) -> i64 {
    (count * step as i64 + count * (count - 1) / 2 * bend as i64) >> 8
}

/// Where a path lies.
enum Side {
    /// Every reading has its four pixels.
    Inside,
    /// No reading has.
    Outside,
    /// Some may have.
    Across,
}

/// Cells whose readings are tested one by one where a path crosses the border.
const FEW: usize = 4;

/// Positions of readings along a parabola: Q16 of a source pixel, steps and their growth in Q24.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    at: (i32, i32),
    step: (i32, i32),
    bend: (i32, i32),
}

impl Path {
    /// The same path from its `reading` on.
    fn from(self, reading: i64) -> Path {
        let on = |at: i32, step: i32, bend: i32| at + advance(step, bend, reading) as i32;
        let steeper = |step: i32, bend: i32| step + bend * reading as i32;
        Path {
            at: (on(self.at.0, self.step.0, self.bend.0), on(self.at.1, self.step.1, self.bend.1)),
            step: (steeper(self.step.0, self.bend.0), steeper(self.step.1, self.bend.1)),
            bend: self.bend,
        }
    }

    /// `readings` from `start` on through `middle`, the next one at `end`, in source pixels. `None` where any of them is
    /// so far away that numbers do not hold it; the frame ends long before.
    pub(super) fn new(start: (f32, f32), middle: (f32, f32), end: (f32, f32), readings: f32) -> Option<Path> {
        let per = 1.0 / readings;
        let axis = |start: f32, middle: f32, end: f32| {
            let bend = 4.0 * (start - 2.0 * middle + end) * (per * per);
            let step = (4.0 * middle - 3.0 * start - end) * per + 0.5 * bend;
            let near = start.abs().max(middle.abs()).max(end.abs()) < FAR_PX;
            let slow = step.abs().max((step + readings * bend).abs()) < STEP_MAX_PX;
            // A cast is one instruction, the crate's own conversion a hundred.
            let q24 = |px: f32| (px * 16_777_216.0) as i32;
            (near && slow).then(|| ((start * 65536.0) as i32, q24(step), q24(bend)))
        };
        let ((x, dx, ddx), (y, dy, ddy)) = (axis(start.0, middle.0, end.0)?, axis(start.1, middle.1, end.1)?);
        Some(Path { at: (x, y), step: (dx, dy), bend: (ddx, ddy) })
    }
}
