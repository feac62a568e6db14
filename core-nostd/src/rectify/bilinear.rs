//! One bilinear reading of the frame a cell, written directly into the patch.
//!
//! A row is cut into stretches of a power of two cells. Exact positions at the ends and the middle of each make its
//! parabola, in whole numbers by shifts alone; its readings are made without a test each, since the whole stretch is known
//! to lie in the frame. Without lens distortion the columns where a row enters and leaves the frame follow from the
//! homography, and only the few cells within [`MARGIN_PX`] of the border are tested one by one; with distortion a stretch
//! across the border is halved.

use super::RectifyError;
use super::curvature::CurvatureBound;
use super::kernels::{blend, blend_along, blend_steeply};
use super::scanline::ScanlineMap;
use super::stretch::{Draft, Frame, GUARD, Stretch};
use crate::homography::FrameFromPatch;
use crate::image::Run;
use heapless::VecView;

/// How far a position may be off the exact one, frame pixels: less than a grey level at the steepest edge that an 8-bit
/// picture can have.
const TOLERANCE_PX: f32 = 1.0 / 280.0;
/// The part of it that may be taken by two readings that share a step, as much to one side as to the other. Chosen between
/// none, no shared steps, and all of it, no error left for the parabola: four fifths.
const PAIR_TOLERANCE_PX: f32 = 1.0 / 350.0;
/// Cells nearer to the border than this are tested one by one: more than the tolerance, 0.0036,
/// rounding to Q16 and half a weight, 0.002, and what a stretch's ends keep from the border, 0.0078.
const MARGIN_PX: f32 = 1.0 / 64.0;
/// Cells of the shortest and the longest stretch, as powers of two. Chosen between one cell, where every
/// position is exact anyway, and what [`GUARD`] allows for: 128 truncated steps.
const SHORTEST: u32 = 3;
const LONGEST: u32 = 7;
/// Longest side of a frame; Q16 holds four times as much.
const SIDE_MAX: u16 = 8192;

/// Rectifies into `patch`, which has exactly `map.size()` pixels.
///
/// # Errors
/// [`RectifyError::Size`] for a frame of more than 8192 pixels a side.
pub(super) fn rectify(
    map: &FrameFromPatch<'_>,
    source: &Frame<'_>,
    patch: &mut [u8],
    runs: &mut VecView<Run>,
) -> Result<(), RectifyError> {
    let size = source.size();
    if size.0 > SIDE_MAX || size.1 > SIDE_MAX {
        return Err(RectifyError::Size);
    }
    let plan = Plan::new(map, size);
    let cols = map.size().0;
    for (row, out) in patch.chunks_exact_mut(cols as usize).enumerate() {
        let at = row as f32;
        let mut line = Line { scanline: ScanlineMap::along(map, at), plan, source, out, row: row as u16, runs };
        line.rectify();
    }
    Ok(())
}

/// How every row is cut.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Cells of a stretch, as a power of two; `None` where even the shortest is too far from its parabola, near the horizon.
    power: Option<u32>,
    /// Whether two readings may share a step.
    shares_steps: bool,
}

impl Plan {
    /// Two readings that share a step are off by x''/4.
    fn new(map: &FrameFromPatch<'_>, (cols, rows): (u16, u16)) -> Self {
        let curvature = CurvatureBound::new(map, (cols as f32, rows as f32));
        let pair = 0.25 * curvature.second();
        let shares_steps = pair <= PAIR_TOLERANCE_PX;
        let left = TOLERANCE_PX - if shares_steps { pair } else { 0.0 };
        let fits = |&power: &u32| curvature.parabola_error((1 << power) as f32) <= left;
        Plan { power: (SHORTEST..=LONGEST).rev().find(fits), shares_steps }
    }
}

/// Position, Q16.
type Position = [i32; 2];

/// The exact one at `col`.
#[inline(always)]
fn position(scanline: &ScanlineMap<'_>, col: f32) -> Option<Position> {
    // A cast saturates, and is one instruction.
    scanline.position(col).map(|(x, y)| [(x * 65536.0) as i32, (y * 65536.0) as i32])
}

/// Where a stretch lies.
enum Side {
    /// Every reading has its four pixels.
    Inside(Stretch),
    /// No reading has.
    Outside,
    /// Some may have.
    Across,
}

/// A row of the patch.
struct Line<'a> {
    scanline: ScanlineMap<'a>,
    plan: Plan,
    source: &'a Frame<'a>,
    out: &'a mut [u8],
    row: u16,
    runs: &'a mut VecView<Run>,
}

impl Line<'_> {
    fn rectify(&mut self) {
        let cols = self.out.len();
        let (seen, sure) = match &self.scanline {
            ScanlineMap::Linear(along) => {
                let size = self.source.size();
                let inside = |margin_px| whole(along.inside(size, margin_px, cols as f32 - 1.0));
                let sure = inside(MARGIN_PX);
                (if sure == (0, cols) { sure } else { inside(-MARGIN_PX) }, sure)
            }
            ScanlineMap::Nonlinear(..) => ((0, cols), (0, cols)),
        };
        self.leave(0, seen.0);
        // Words of four cells, counted from the start of the patch so that every machine cuts alike.
        let before = self.row as usize * cols;
        let from = ((before + sure.0).next_multiple_of(4) - before).clamp(seen.0, seen.1);
        let words = sure.1.saturating_sub(from) / 4;
        self.test(seen.0, from);
        self.follow(from, from + 4 * words);
        self.test(from + 4 * words, seen.1);
        self.leave(seen.1, cols);
    }

    /// Cells `col` to `end`, a multiple of four, in stretches.
    #[inline(never)]
    fn follow(&mut self, mut col: usize, end: usize) {
        let Some(longest) = self.plan.power else { return self.test(col, end) };
        let mut power = longest;
        let mut start = position(&self.scanline, col as f32);
        while col < end {
            let count = (end - col).min(1 << power);
            let middle = position(&self.scanline, (col + (1 << power >> 1)) as f32);
            let stop = position(&self.scanline, (col + (1 << power)) as f32);
            match self.side([start, middle, stop], power, count) {
                Side::Inside(stretch) => self.read(&stretch, col, count),
                Side::Outside => self.leave(col, col + count),
                Side::Across if power > SHORTEST => {
                    power -= 1;
                    continue;
                }
                Side::Across => self.test(col, col + count),
            }
            (col, start, power) = (col + count, stop, longest);
        }
    }

    /// The stretch of `count` readings from the first position on, where the third is 2^`power` readings further.
    #[inline(always)]
    fn side(&self, [start, middle, stop]: [Option<Position>; 3], power: u32, count: usize) -> Side {
        let (Some(start), Some(middle), Some(stop)) = (start, middle, stop) else { return Side::Across };
        let (cols, rows) = self.source.size();
        let mut draft = Draft::new();
        let mut is_outside = false;
        for (axis, size) in [cols, rows].into_iter().enumerate() {
            let (half, all) = (middle[axis].wrapping_sub(start[axis]), stop[axis].wrapping_sub(start[axis]));
            let bend = all.wrapping_sub(half.wrapping_mul(2));
            // Q24: slope at the start and second derivative of the parabola. However large, they are checked below.
            let slope = half.wrapping_mul(4).wrapping_sub(all) << (8 - power);
            let second = bend << (10 - 2 * SHORTEST) >> (2 * power - 2 * SHORTEST);
            // Half a step of Q16 makes up for truncation.
            let (at, step, growth, turns) = if self.plan.shares_steps {
                (start[axis].wrapping_sub(second >> 10), slope.wrapping_add(second), second.wrapping_mul(2), count / 2)
            } else {
                (start[axis], slope.wrapping_add(second >> 1), second, count)
            };
            let (at, step) = (at.wrapping_add(if axis == 0 { ROUND } else { 0 }), step.wrapping_add(1 << 7));
            let last = (size as i32 - 1) << 16;
            let far = bend.saturating_abs().saturating_add(GUARD);
            is_outside |= start[axis].max(stop[axis]) < far.wrapping_neg()
                || start[axis].min(stop[axis]).saturating_sub(far) > last;
            draft.set(axis, [at, step, growth], turns, count, size);
        }
        match draft.checked() {
            Some(stretch) => Side::Inside(stretch),
            None if is_outside => Side::Outside,
            None => Side::Across,
        }
    }

    /// Readings of a stretch that lies inside.
    #[inline(always)]
    fn read(&mut self, stretch: &Stretch, col: usize, count: usize) {
        if !self.keep(col, count) {
            return self.leave(col, col + count);
        }
        let Some(out) = self.out.get_mut(col..col + count) else { return };
        if self.plan.shares_steps {
            blend_along(self.source, stretch, out.as_chunks_mut().0);
        } else {
            blend_steeply(self.source, stretch, out);
        }
    }

    /// Cells `col` to `end`, each at its exact position if that is in the frame.
    #[inline(never)]
    fn test(&mut self, col: usize, end: usize) {
        for col in col..end {
            let reading = position(&self.scanline, col as f32).and_then(|at| reading(self.source, at));
            match reading.filter(|_| self.keep(col, 1)) {
                Some(grey) => self.out.iter_mut().skip(col).take(1).for_each(|pixel| *pixel = grey),
                None => self.leave(col, col + 1),
            }
        }
    }

    /// Cells `col` to `end` are not valid.
    #[inline(never)]
    fn leave(&mut self, col: usize, end: usize) {
        if let Some(pixels) = self.out.get_mut(col..end) {
            pixels.fill(0);
        }
    }

    /// Counts cells as valid; `false` where that takes a run more than the list holds.
    fn keep(&mut self, col: usize, count: usize) -> bool {
        let (start, end) = (col as u16, (col + count) as u16);
        match self.runs.last_mut() {
            Some(run) if run.row == self.row && run.end == start => {
                run.end = end;
                true
            }
            _ => self.runs.push(Run { row: self.row, start, end }).is_ok(),
        }
    }
}

/// Weights along rows have eight bits; rounded, they put a reading within half a grey level of exact at the steepest edge.
const ROUND: i32 = 1 << 7;

/// First whole column, and one past the last, of what [`AlongRow::inside`] found.
fn whole((from, to): (f32, f32)) -> (usize, usize) {
    // Casts saturate.
    let first = from as usize;
    let first = first.saturating_add(usize::from((first as f32) < from));
    let end = if to >= 0.0 { (to as usize).saturating_add(1) } else { 0 };
    (first.min(end), end)
}

/// The reading at an exact position; `None` outside the frame, which is from the centre of the first pixel to that of the
/// last.
fn reading(source: &Frame<'_>, [x, y]: Position) -> Option<u8> {
    let (cols, rows) = source.size();
    let last = |count: u16| (count as i32 - 1) << 16;
    if x < 0 || y < 0 || x > last(cols) || y > last(rows) {
        return None;
    }
    // The last pixel is reached with the full weight of its left neighbour's pair.
    let split = |bits: i32, count: u16| {
        let index = (bits >> 16).min(count as i32 - 2);
        (index as usize, (bits as u32 - ((index as u32) << 16)).min(1 << 16))
    };
    let ((col, right), (row, down)) = (split(x + ROUND, cols), split(y, rows));
    Some(blend(u32::from_le_bytes(source.four(col, row)?), right >> 8, down))
}
