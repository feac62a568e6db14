//! One line of readings across a patch, in segments between exactly computed positions.

use super::sampler::{Position, STEPS, Source};
use crate::homography::FrameFromPatch;
use fixed::types::I16F16;

/// Added to a cell's sum by a reading outside the frame; no sum of 256 valid readings reaches it.
pub(super) const INVALID: u32 = 1 << 24;
const _: () = assert!(256 * 255 * STEPS < INVALID);
/// Longest segment, in cells.
const LONGEST: usize = 32;
/// Positions beyond this are not stepped between: two of them must lie within Q16 of each other. The frame ends long
/// before.
const FAR_PX: f32 = 16_000.0;

/// How the lines of a patch are cut: the same for all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    samples: u16,
    /// Cells a segment; `None` where even one bends too much, near the horizon.
    cells: Option<usize>,
}

impl Line {
    /// The longest segment of 1, 2, 4 ... 32 cells whose linear interpolation stays within `tolerance_px` of the
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
        let bends = |cells: usize| safety * curvature * (cells * cells) as f32 > 8.0 * tolerance_px;
        let cells = core::iter::successors(Some(LONGEST), |cells| Some(cells / 2));
        let cells = cells.take_while(|&cells| cells > 0).find(|&cells| !bends(cells));
        Line { samples, cells }
    }

    /// Adds the readings of the line at patch row `row` to the cells' `sums`; a reading outside the frame adds
    /// [`INVALID`].
    pub(super) fn accumulate(&self, map: &FrameFromPatch<'_>, source: &Source<'_>, row: f32, sums: &mut [u32]) {
        let apart = 1.0 / self.samples as f32;
        let position = |reading: usize| {
            let (col, row) = map.frame_position((reading as f32 + 0.5) * apart - 0.5, row)?;
            let (col, row) = (source.reduction().reduced(col), source.reduction().reduced(row));
            // A cast is one instruction, the crate's own conversion a hundred.
            let q16 = |px: f32| I16F16::from_bits((px * 65536.0) as i32);
            (col.abs() < FAR_PX && row.abs() < FAR_PX).then(|| (q16(col), q16(row)))
        };
        let Some(cells) = self.cells else {
            for (reading, cell) in (0..sums.len() * self.samples as usize).map(|r| (r, r / self.samples as usize)) {
                add(source, position(reading), &mut sums[cell]);
            }
            return;
        };
        let mut start = position(0);
        let mut first = 0;
        for sums in sums.chunks_mut(cells) {
            // The last segment may end beyond the patch: the geometry goes on there.
            first += cells * self.samples as usize;
            let end = position(first);
            match (start, end) {
                (Some(a), Some(b)) => self.between(source, a, b, cells, sums),
                _ => sums.iter_mut().for_each(|sum| *sum = sum.saturating_add(INVALID)),
            }
            start = end;
        }
    }

    /// Adds the readings of a segment of `cells`, the first of them at `a`; the next segment's first is at `b`.
    fn between(&self, source: &Source<'_>, a: Position, b: Position, cells: usize, sums: &mut [u32]) {
        let readings = cells as i32 * self.samples as i32;
        let step = |a: I16F16, b: I16F16| I16F16::from_bits((b - a).to_bits() / readings);
        let step = (step(a.0, b.0), step(a.1, b.1));
        let inside = match self.samples {
            1 => source.add_readings::<1>(a, step, sums),
            2 => source.add_readings::<2>(a, step, sums),
            3 => source.add_readings::<3>(a, step, sums),
            4 => source.add_readings::<4>(a, step, sums),
            _ => false,
        };
        if inside {
            return;
        }
        let mut at = a;
        for sum in sums {
            for _ in 0..self.samples {
                add(source, Some(at), sum);
                at = (at.0 + step.0, at.1 + step.1);
            }
        }
    }
}

/// Adds the reading at a position to a cell's sum, [`INVALID`] where there is none.
fn add(source: &Source<'_>, at: Option<Position>, sum: &mut u32) {
    let reading = at.filter(|&at| source.holds(at)).map_or(INVALID, |at| source.reading(at));
    *sum = sum.saturating_add(reading);
}
