//! Detail: what a picture shows beyond the mean of its surroundings.
//!
//! The difference of a pixel to the mean of the valid pixels in the 5 x 5 around it. Fields, shadows of clouds and other
//! slow changes vanish in it, a new field keeps its border only, and neighbouring pixels hardly correlate any more: the
//! correlation of two details has a sharp peak. Over the default scene with 10 % changed ground the correlation of the
//! greys themselves has its peak at a wrong place in 6 % of the frames, that of the details in none.

use super::View;
use super::histogram::Histogram;
use crate::rectify::Run;

/// Pixels to each side that make the surroundings.
const REACH: u16 = 2;
/// Columns and rows of the surroundings.
const SIDE: usize = 2 * REACH as usize + 1;
/// Steps of a detail per grey level: bland ground differs by less than a grey.
const STEPS: i32 = 4;
/// Largest detail: 32 greys.
const MAX: i32 = i8::MAX as i32;
/// Details beyond this many medians of their size are limited to it: it says "different", not "how different".
const LIMIT: f32 = 2.0;

/// The details of the pixels of `runs[index]`, from its first to its last.
///
/// Of a row with several runs, the surroundings are the one that overlaps the run most. Empty where the run lies
/// outside the view.
pub(super) fn details<'v>(view: &View<'v>, runs: &[Run], index: usize) -> Details<'v> {
    let mut near = [Near { pixels: &[], start: 0 }; SIDE];
    let Some(&run) = runs.get(index) else { return Details { near, window: Window::default(), at: 0, end: 0 } };
    for (distance, near) in (-(REACH as i32)..).zip(&mut near) {
        let row = run.row as i32 + distance;
        let Some(other) = overlapping(runs, index, row) else { continue };
        let length = other.end.saturating_sub(other.start) as usize;
        if let Some(pixels) = view.run(row as usize, other.start as usize, length) {
            *near = Near { pixels, start: other.start };
        }
    }
    let mut details = Details { near, window: Window::default(), at: run.start, end: run.end };
    for col in run.start as i32 - REACH as i32..run.start as i32 + REACH as i32 {
        details.window.push(details.column(col));
    }
    details
}

/// The details of a whole picture of `size`: every row is one run from border to border.
pub(super) fn rows((cols, rows): (u16, u16), row: u16) -> ([Run; SIDE], usize) {
    // The rows around `row` that exist, and which of them `row` is.
    let first = row.saturating_sub(REACH).min(rows.saturating_sub(SIDE as u16));
    let mut near = [Run { row: 0, start: 0, end: cols }; SIDE];
    for (row, near) in (first..).zip(&mut near) {
        near.row = row;
    }
    (near, (row - first) as usize)
}

/// The run of `row` that overlaps `runs[index]` most; `runs` are sorted by row.
pub(super) fn overlapping(runs: &[Run], index: usize, row: i32) -> Option<Run> {
    let run = *runs.get(index)?;
    let overlap = |other: &Run| other.end.min(run.end).saturating_sub(other.start.max(run.start));
    let best = |best: Option<Run>, other: &Run| match best {
        Some(best) if overlap(&best) >= overlap(other) => Some(best),
        _ => (overlap(other) > 0).then_some(*other),
    };
    let distance = |other: &&Run| (other.row as i32).abs_diff(run.row as i32);
    let wanted = row.abs_diff(run.row as i32);
    let take = |other: &&Run| distance(other) <= wanted;
    let of_row = |other: &&Run| other.row as i32 == row;
    if row < run.row as i32 {
        runs[..index].iter().rev().take_while(take).filter(of_row).fold(None, best)
    } else {
        runs[index..].iter().take_while(take).filter(of_row).fold(None, best)
    }
}

/// Valid pixels of one row of the surroundings.
#[derive(Clone, Copy)]
struct Near<'v> {
    pixels: &'v [u8],
    start: u16,
}

/// A sum of pixels in the lower half, their number in the upper one: one addition for both.
type Tally = u32;

const ONE: Tally = 1 << 16;

/// The columns of the surroundings, oldest first, with their total.
#[derive(Default)]
struct Window {
    columns: [Tally; SIDE],
    total: Tally,
}

impl Window {
    /// The newest column comes, the oldest goes.
    #[inline(always)]
    fn push(&mut self, column: Tally) {
        let [oldest, a, b, c, d] = self.columns;
        self.total = self.total + column - oldest;
        self.columns = [a, b, c, d, column];
    }
}

/// Iterator over the details of a run.
pub(super) struct Details<'v> {
    near: [Near<'v>; SIDE],
    window: Window,
    at: u16,
    end: u16,
}

impl Details<'_> {
    #[inline(always)]
    fn column(&self, col: i32) -> Tally {
        let mut column = 0;
        for near in &self.near {
            if let Some(&pixel) = near.pixels.get(col.wrapping_sub(near.start as i32) as usize) {
                column += pixel as Tally + ONE;
            }
        }
        column
    }
}

impl Iterator for Details<'_> {
    type Item = i8;

    #[inline(always)]
    fn next(&mut self) -> Option<i8> {
        if self.at >= self.end {
            return None;
        }
        self.window.push(self.column(self.at as i32 + REACH as i32));
        let own = &self.near[REACH as usize];
        let pixel = *own.pixels.get((self.at - own.start) as usize)? as i32;
        self.at += 1;
        let (sum, count) = ((self.window.total & (ONE - 1)) as i32, (self.window.total / ONE) as i32);
        let detail = STEPS * (pixel * count - sum) / count.max(1);
        Some(detail.clamp(-MAX, MAX) as i8)
    }
}

/// The size beyond which details are limited.
pub(super) struct Limit {
    sizes: Histogram,
}

impl Limit {
    /// Of no details yet.
    pub(super) fn new() -> Self {
        Limit { sizes: Histogram::new() }
    }

    /// Takes a detail into account.
    #[inline(always)]
    pub(super) fn add(&mut self, detail: i8) {
        self.sizes.add(detail.unsigned_abs());
    }

    /// The limit for the details taken into account.
    pub(super) fn value(&self) -> i8 {
        (LIMIT * self.sizes.median()).clamp(1.0, MAX as f32) as i8
    }
}
