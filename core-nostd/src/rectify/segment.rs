//! One line of readings across a patch, in segments between exactly computed positions.

use super::sampler::{Frame, INVALID, Path};
use crate::homography::FrameFromPatch;
use fixed::types::I16F16;

/// Shortest segment, in cells.
const SHORTEST: u16 = 2;

/// How the lines of a patch are cut: the same for all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    samples: u16,
    /// Cells a segment; `None` where even the shortest strays too far, near the horizon.
    cells: Option<u16>,
}

impl Line {
    /// The fewest segments of equal length whose parabolas stay within `tolerance_px` of the frame.
    ///
    /// Through both ends and the middle of a segment of length L a parabola is off by at most L³/(72√3) max|x'''|. The
    /// third difference over a stretch is L³ x''' itself; it is taken along the borders and the middle of the patch,
    /// where a homography has its extremes, and doubled where a lens distortion may peak in between.
    pub(super) fn plan(map: &FrameFromPatch<'_>, source: &Frame<'_>, samples: u16, tolerance_px: f32) -> Self {
        const PROBES: usize = 8;
        const PER_THIRD: f32 = 1.0 / 124.7;
        let (cols, rows) = map.size();
        let stretch = cols as f32 / PROBES as f32;
        let factor = source.reduction().factor() as f32;
        let (frame_cols, frame_rows) = source.reduction().size();
        let (frame_cols, frame_rows) = (frame_cols as f32 * factor, frame_rows as f32 * factor);
        let mut third = 0.0f32;
        for row in 0..=4 {
            let row = row as f32 * 0.25 * rows as f32 - 0.5;
            let at: [_; PROBES + 1] = core::array::from_fn(|i| map.frame_position(i as f32 * stretch - 0.5, row));
            for four in at.windows(4) {
                let &[Some(a), Some(b), Some(c), Some(d)] = four else { continue };
                // A stretch wholly off the frame is never read.
                let outside = |a: f32, d: f32, limit: f32| (a < 0.0 && d < 0.0) || (a > limit && d > limit);
                if outside(a.0, d.0, frame_cols) || outside(a.1, d.1, frame_rows) {
                    continue;
                }
                let difference = |a: f32, b: f32, c: f32, d: f32| (d - a - 3.0 * (c - b)).abs();
                third = third.max(difference(a.0, b.0, c.0, d.0)).max(difference(a.1, b.1, c.1, d.1));
            }
        }
        let third = third * if map.is_distorted() { 2.0 } else { 1.0 };
        let strays = |cells: u16| {
            let stretches = cells as f32 / stretch;
            PER_THIRD * third * stretches * stretches * stretches > tolerance_px
        };
        let lengths = (1..=cols).map(|segments| cols.div_ceil(segments)).take_while(|&cells| cells >= SHORTEST);
        Line { samples, cells: lengths.into_iter().find(|&cells| !strays(cells)) }
    }

    /// Adds the readings of the line at patch row `row` to the cells' `sums`; a reading outside the frame adds
    /// [`INVALID`].
    pub(super) fn accumulate(&self, map: &FrameFromPatch<'_>, source: &Frame<'_>, row: f32, sums: &mut [u32]) {
        let apart = 1.0 / self.samples as f32;
        let per_factor = 1.0 / source.reduction().factor() as f32;
        let offset = -0.5 * (source.reduction().factor() as f32 - 1.0) * per_factor;
        let position = |reading: f32| {
            let (col, row) = map.frame_position((reading + 0.5) * apart - 0.5, row)?;
            Some((col * per_factor + offset, row * per_factor + offset))
        };
        let Some(cells) = self.cells else {
            for (cell, sum) in sums.iter_mut().enumerate() {
                for reading in 0..self.samples as usize {
                    let at = position((cell * self.samples as usize + reading) as f32);
                    let q16 = |px: f32| I16F16::from_bits((px * 65536.0) as i32);
                    let at = at.map(|(col, row)| (q16(col), q16(row))).filter(|&at| source.holds(at));
                    *sum = sum.saturating_add(at.map_or(INVALID, |at| source.reading(at)));
                }
            }
            return;
        };
        let readings = (cells * self.samples) as f32;
        let mut first = 0.0;
        let mut start = position(first);
        for sums in sums.chunks_mut(cells as usize) {
            // The last segment may end beyond the patch: the geometry goes on there.
            let middle = position(first + 0.5 * readings);
            first += readings;
            let end = position(first);
            match start.zip(middle).zip(end).and_then(|((a, m), b)| Path::new(a, m, b, readings)) {
                Some(path) => source.add_readings(path, self.samples, sums),
                None => sums.iter_mut().for_each(|sum| *sum = sum.saturating_add(INVALID)),
            }
            start = end;
        }
    }
}
