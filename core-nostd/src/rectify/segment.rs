//! One line of readings across a patch, in segments between exactly computed positions.

use super::sampler::Source;
use crate::homography::FrameFromPatch;
use fixed::types::I16F16;

/// Added to a cell's sum by a reading outside the frame; no sum of 256 valid readings reaches it.
pub(super) const INVALID: u32 = 1 << 20;
/// Longest segment, in readings, as a power of two.
const LONGEST_LOG2: u32 = 5;
/// Positions beyond this are not stepped between: two of them must lie within Q16 of each other. The frame ends long
/// before.
const FAR_PX: f32 = 16_000.0;

/// How the lines of a patch are cut: the same for all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    samples: u16,
    /// Readings a segment, as a power of two: steps are shifts, not divisions.
    length_log2: u32,
}

impl Line {
    /// The longest segment of 1, 2, 4 ... 32 readings whose linear interpolation stays within `tolerance_px` of the
    /// frame.
    ///
    /// Between the ends of a segment of length L the error is at most L²/8 max|x''|. The second difference over a
    /// stretch is L² x'' itself; it is taken along the borders and the middle of the patch, where a homography's
    /// curvature has its extremes, and doubled where a lens distortion may peak in between.
    pub(super) fn plan(map: &FrameFromPatch<'_>, source: &Source<'_>, samples: u16, tolerance_px: f32) -> Self {
        const PROBES: u16 = 8;
        let (cols, rows) = (map.size().0 as f32, map.size().1 as f32);
        let stretch = cols / PROBES as f32;
        let (frame_cols, frame_rows) = {
            let (c, r) = source.reduction().size();
            let f = source.reduction().factor() as f32;
            (c as f32 * f, r as f32 * f)
        };
        let mut curvature = 0.0f32;
        for row in 0..=4 {
            let row = row as f32 * 0.25 * rows - 0.5;
            for probe in 0..PROBES {
                let at = |half: f32| map.frame_position((probe as f32 + half) * stretch - 0.5, row);
                let (Some(a), Some(b), Some(c)) = (at(0.0), at(0.5), at(1.0)) else { continue };
                // A stretch wholly off the frame is never read.
                let outside = |a: f32, c: f32, limit: f32| (a < 0.0 && c < 0.0) || (a > limit && c > limit);
                if outside(a.0, c.0, frame_cols) || outside(a.1, c.1, frame_rows) {
                    continue;
                }
                let half = 0.5 * stretch;
                let second = |a: f32, b: f32, c: f32| (a - 2.0 * b + c).abs() / (half * half);
                curvature = curvature.max(second(a.0, b.0, c.0)).max(second(a.1, b.1, c.1));
            }
        }
        let safety = if map.is_distorted() { 2.0 } else { 1.0 };
        let mut length_log2 = LONGEST_LOG2;
        while length_log2 > 0 {
            let cells = (1u32 << length_log2) as f32 / samples as f32;
            if safety * curvature * cells * cells <= 8.0 * tolerance_px {
                break;
            }
            length_log2 -= 1;
        }
        Line { samples, length_log2 }
    }

    /// Adds the readings of the line at patch row `row` to the cells' `sums`; a reading outside the frame adds
    /// [`INVALID`].
    pub(super) fn accumulate(&self, map: &FrameFromPatch<'_>, source: &Source<'_>, row: f32, sums: &mut [u32]) {
        let samples = self.samples as usize;
        let readings = sums.len() * samples;
        let step = 1.0 / self.samples as f32;
        let position = |reading: usize| {
            let (col, row) = map.frame_position((reading as f32 + 0.5) * step - 0.5, row)?;
            let (col, row) = (source.reduction().reduced(col), source.reduction().reduced(row));
            // A cast is one instruction, the crate's own conversion a hundred.
            let q16 = |px: f32| I16F16::from_bits((px * 65536.0) as i32);
            (col.abs() < FAR_PX && row.abs() < FAR_PX).then(|| (q16(col), q16(row)))
        };
        let length = 1 << self.length_log2;
        let mut first = 0;
        let mut start = position(0);
        while first < readings {
            // The last segment may end beyond the patch: the geometry goes on there.
            let end = position(first + length);
            let taken = length.min(readings - first);
            match (start, end) {
                (Some(a), Some(b)) => {
                    let step = ((b.0 - a.0) >> self.length_log2, (b.1 - a.1) >> self.length_log2);
                    let segment = Segment { at: a, step, ends_inside: source.holds(a) && source.holds(b) };
                    segment.accumulate(source, first, taken, samples, sums);
                }
                _ => mark(sums, first, taken, samples),
            }
            start = end;
            first += length;
        }
    }
}

/// A stretch of readings at even steps.
struct Segment {
    at: (I16F16, I16F16),
    step: (I16F16, I16F16),
    /// Both ends can be read, so everything between can: the steps are rounded down, which leaves every position
    /// between the ends but for less than a reading's 2^-11 of a pixel.
    ends_inside: bool,
}

impl Segment {
    /// Adds readings `first..first + count` to their cells.
    fn accumulate(&self, source: &Source<'_>, first: usize, count: usize, samples: usize, sums: &mut [u32]) {
        let (mut col, mut row) = self.at;
        let mut left = samples - first % samples;
        let mut cells = sums.iter_mut().skip(first / samples);
        let Some(mut cell) = cells.next() else { return };
        for _ in 0..count {
            if left == 0 {
                left = samples;
                let Some(next) = cells.next() else { return };
                cell = next;
            }
            let readable = self.ends_inside || source.holds((col, row));
            *cell += if readable { source.bilinear(col, row) } else { INVALID };
            left -= 1;
            col += self.step.0;
            row += self.step.1;
        }
    }
}

/// Marks the cells of readings `first..first + length` as invalid.
fn mark(sums: &mut [u32], first: usize, length: usize, samples: usize) {
    for reading in first..first + length {
        if let Some(sum) = sums.get_mut(reading / samples) {
            *sum += INVALID;
        }
    }
}
