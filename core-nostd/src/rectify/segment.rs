//! One line of readings across a patch, in segments between exactly computed positions.

use super::sampler::Source;
use crate::homography::FrameFromPatch;
use fixed::types::I16F16;

/// Added to a cell's sum by a reading outside the frame; no sum of 256 valid readings reaches it.
pub(super) const INVALID: u32 = 1 << 24;
/// Longest segment, in readings.
const LONGEST: u16 = 32;
/// Positions beyond this do not fit Q16; the frame ends long before.
const FAR_PX: f32 = 30_000.0;

/// How the lines of a patch are cut: the same for all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    samples: u16,
    /// Readings a segment.
    length: u16,
}

impl Line {
    /// The longest segment of 1, 2, 4 ... 32 readings whose linear interpolation stays within `tolerance_px` of the
    /// frame.
    ///
    /// Between the ends of a segment of length L the error is at most L²/8 max|x''|. The second difference over a
    /// stretch is L² x'' itself; it is taken along the borders and the middle of the patch, where a homography's
    /// curvature has its extremes, and doubled for the lens distortion's, which may peak in between.
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
        let mut length = LONGEST;
        while length > 1 {
            let cells = length as f32 / samples as f32;
            if 2.0 * curvature * cells * cells <= 8.0 * tolerance_px {
                break;
            }
            length /= 2;
        }
        Line { samples, length }
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
            (col.abs() < FAR_PX && row.abs() < FAR_PX).then(|| (I16F16::from_num(col), I16F16::from_num(row)))
        };
        let mut first = 0;
        let mut start = position(0);
        while first < readings {
            let length = (self.length as usize).min(readings - first);
            let end = position(first + length);
            match (start, end) {
                (Some(a), Some(b)) => accumulate_segment(source, a, b, first, length, samples, sums),
                _ => mark(sums, first, length, samples),
            }
            start = end;
            first += length;
        }
    }
}

/// Readings `first..first + length` between positions `a` (of the first) and `b` (one past the last).
fn accumulate_segment(
    source: &Source<'_>,
    a: (I16F16, I16F16),
    b: (I16F16, I16F16),
    first: usize,
    length: usize,
    samples: usize,
    sums: &mut [u32],
) {
    let limits = source.limits();
    let (mut col, mut row) = a;
    let count = I16F16::from_num(length as u32);
    let (dcol, drow) = ((b.0 - a.0) / count, (b.1 - a.1) / count);
    // Steps are rounded towards zero, so every position lies between the two ends: both inside means all inside.
    let within = |(c, r): (I16F16, I16F16)| c >= 0 && r >= 0 && c <= limits.0 && r <= limits.1;
    let all_inside = within(a) && within(b);
    let mut cell = first / samples;
    let mut left = samples - first % samples;
    for _ in 0..length {
        let reading = if all_inside || within((col, row)) { source.bilinear(col, row) } else { INVALID };
        if let Some(sum) = sums.get_mut(cell) {
            *sum += reading;
        }
        left -= 1;
        if left == 0 {
            left = samples;
            cell += 1;
        }
        col += dcol;
        row += drow;
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
