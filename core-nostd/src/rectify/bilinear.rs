//! One bilinear reading of the frame a cell, straight into the patch.
//!
//! A row is cut into stretches of a power of two cells. Exact positions at the ends and the middle of each make its
//! parabola, in whole numbers by shifts alone; its readings are made without a test each, since the whole stretch is known
//! to lie in the frame. Without lens distortion the columns where a row enters and leaves the frame follow from the
//! homography, and only the few cells within [`MARGIN_PX`] of the border are tested one by one; with distortion a stretch
//! across the border is halved.

use super::bends::Bends;
use super::way::Way;
use super::{RectifyError, Run};
use crate::dsp::{Stretch, blend, blend_along, blend_at, opaque};
use crate::homography::FrameFromPatch;
use crate::reduce::Reduction;
use heapless::VecView;

/// How far a position may be off the exact one, frame pixels: less than a grey level at the steepest edge that an 8-bit
/// picture can have.
const TOLERANCE_PX: f32 = 1.0 / 280.0;
/// The part of it that is taken by two readings that share a step: as much to one side as to the other.
const PAIR_TOLERANCE_PX: f32 = 1.0 / 350.0;
/// Cells nearer to the border than this are tested one by one: more than the tolerance, rounding and [`GUARD`].
const MARGIN_PX: f32 = 1.0 / 64.0;
/// How far a stretch's ends must lie inside, Q16: more than what its steps lose by truncation, one a reading.
const GUARD: i32 = 512;
/// Cells of the shortest and the longest stretch, as powers of two.
const SHORTEST: u32 = 3;
const LONGEST: u32 = 7;
/// Longest side of a frame; Q16 holds four times as much.
const SIDE_MAX: u16 = 8192;

/// A frame as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    /// Row-major, exactly as many as `size` says.
    pixels: &'a [u8],
    size: (u16, u16),
}

impl<'a> Frame<'a> {
    /// # Errors
    /// [`RectifyError::Size`] for another number of pixels than `reduction` leaves or a frame of less than 2 x 2.
    pub(super) fn new(pixels: &'a [u8], reduction: Reduction) -> Result<Self, RectifyError> {
        let size = reduction.size();
        let fits = !reduction.is_boxes() && size.0 >= 2 && size.1 >= 2 && pixels.len() == reduction.bytes();
        fits.then_some(Frame { pixels, size }).ok_or(RectifyError::Size)
    }
}

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
    let size = source.size;
    if size.0 > SIDE_MAX || size.1 > SIDE_MAX {
        return Err(RectifyError::Size);
    }
    let plan = Plan::new(map, size);
    let cols = map.size().0;
    for (row, out) in patch.chunks_exact_mut(cols as usize).enumerate() {
        let at = row as f32;
        let mut line = Line { way: Way::along(map, at), plan, source, out, row: row as u16, runs };
        line.rectify();
    }
    Ok(())
}

/// How rows are cut: the same for all of them.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Cells of a stretch, as a power of two; `None` where even the shortest strays too far, near the horizon.
    power: Option<u32>,
    /// Whether two readings may share a step.
    shares_steps: bool,
}

impl Plan {
    /// Two readings that share a step are off by x''/4.
    fn new(map: &FrameFromPatch<'_>, (cols, rows): (u16, u16)) -> Self {
        let bends = Bends::new(map, (cols as f32, rows as f32));
        let pair = 0.25 * bends.second();
        let shares_steps = pair <= PAIR_TOLERANCE_PX;
        let left = TOLERANCE_PX - if shares_steps { pair } else { 0.0 };
        let fits = |&power: &u32| bends.strays((1 << power) as f32) <= left;
        Plan { power: (SHORTEST..=LONGEST).rev().find(fits), shares_steps }
    }
}

/// Position, Q16.
type Position = [i32; 2];

/// The exact one at `col`.
#[inline(always)]
fn position(way: &Way<'_>, col: f32) -> Option<Position> {
    // A cast saturates, and is one instruction.
    way.position(col).map(|(x, y)| [(x * 65536.0) as i32, (y * 65536.0) as i32])
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
    way: Way<'a>,
    plan: Plan,
    source: &'a Frame<'a>,
    out: &'a mut [u8],
    row: u16,
    runs: &'a mut VecView<Run>,
}

impl Line<'_> {
    fn rectify(&mut self) {
        let cols = self.out.len();
        let (seen, sure) = match &self.way {
            Way::Straight(along) => {
                let size = self.source.size;
                let inside = |margin_px| whole(along.inside(size, margin_px, cols as f32 - 1.0));
                let sure = inside(MARGIN_PX);
                (if sure == (0, cols) { sure } else { inside(-MARGIN_PX) }, sure)
            }
            Way::Bent(..) => ((0, cols), (0, cols)),
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
        let mut start = position(&self.way, col as f32);
        while col < end {
            let count = (end - col).min(1 << power);
            let middle = position(&self.way, (col + (1 << power >> 1)) as f32);
            let stop = position(&self.way, (col + (1 << power)) as f32);
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
        let (cols, rows) = self.source.size;
        let mut stretch = Stretch { at: start, step: [0; 2], growth: [0; 2] };
        let (mut is_inside, mut is_outside) = (true, false);
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
            is_inside &= stays(at, step, (growth, turns), count, last);
            (stretch.at[axis], stretch.step[axis], stretch.growth[axis]) = (at, step, growth);
        }
        match (is_inside, is_outside) {
            (true, _) => Side::Inside(stretch),
            (_, true) => Side::Outside,
            _ => Side::Across,
        }
    }

    /// Readings of a stretch that lies inside.
    #[inline(always)]
    fn read(&mut self, stretch: &Stretch, col: usize, count: usize) {
        if !self.keep(col, count) {
            return self.leave(col, col + count);
        }
        let (first, stride) = (self.source.pixels.as_ptr(), self.source.size.0);
        let Some(out) = self.out.get_mut(col..col + count) else { return };
        // SAFETY: `stays` has checked every position; `Source` has as many pixels as its size says.
        unsafe {
            if self.plan.shares_steps {
                blend_along(first, stride, stretch, out.as_chunks_mut().0);
            } else {
                blend_steeply(first, stride, stretch, out);
            }
        }
    }

    /// Cells `col` to `end`, each at its exact position if that is in the frame.
    #[inline(never)]
    fn test(&mut self, col: usize, end: usize) {
        for col in col..end {
            let reading = position(&self.way, col as f32).and_then(|at| reading(self.source, at));
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

    /// Counts cells as valid; `false` where that takes a run for which there is no place.
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

/// As [`blend_along`] for a map that bends too much for that: the steps grow after every reading.
///
/// # Safety
/// The same.
#[inline(never)]
unsafe fn blend_steeply(pixels: *const u8, stride: u16, stretch: &Stretch, out: &mut [u8]) {
    let ([mut x, mut y], [mut dx, mut dy]) = (stretch.at, stretch.step);
    let mut out = out.iter_mut();
    let mut left = out.len();
    while left > 0 {
        // SAFETY: as the caller says.
        let blended = unsafe { blend_at(pixels, stride, x, y) };
        if let Some(pixel) = out.next() {
            *pixel = blended;
        }
        (x, y) = (x.wrapping_add(dx >> 8), y.wrapping_add(dy >> 8));
        (dx, dy) = (dx.wrapping_add(stretch.growth[0]), dy.wrapping_add(stretch.growth[1]));
        left = opaque(left - 1);
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

/// The reading at an exact position; `None` outside the frame, which is from the centre of the first pixel to that of the
/// last.
fn reading(source: &Frame<'_>, [x, y]: Position) -> Option<u8> {
    let (cols, rows) = source.size;
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
    let pair = |row: usize| source.pixels.get(row * cols as usize + col..)?.first_chunk::<2>();
    let (&[a, b], &[c, d]) = (pair(row)?, pair(row + 1)?);
    Some(blend(u32::from_le_bytes([a, b, c, d]), right >> 8, down))
}
