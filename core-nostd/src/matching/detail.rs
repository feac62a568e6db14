//! Detail: what a picture shows beyond the mean of its surroundings.
//!
//! The difference of a pixel to the mean of the valid pixels in the 5 x 5 around it. Fields, shadows of clouds and other
//! slow changes vanish in it, a new field keeps its border only, and neighbouring pixels hardly correlate any more: the
//! correlation of two details has a sharp peak. Over the default scene with 10 % changed ground the correlation of the
//! greys themselves has its peak at a wrong place in 6 % of the frames, that of the details in none.

use super::View;
use super::histogram::Histogram;
use crate::dsp::clamp_bytes;
use crate::rectify::Run;
use core::ops::Range;

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

/// Details that are made at a time, a multiple of four.
pub(super) const CHUNK: usize = 64;
/// Columns whose surroundings they see.
const COLUMNS: usize = CHUNK + SIDE - 1;

/// A sum of pixels in the lower half, their number in the upper one: one addition for both.
type Tally = u32;

const ONE: Tally = 1 << 16;

/// [`STEPS`] over the number of pixels in the surroundings, Q16.
static PER_COUNT: [i32; SIDE * SIDE + 1] = {
    let mut table = [0; SIDE * SIDE + 1];
    let mut count = 1;
    while count < table.len() {
        table[count] = ((STEPS << 16) + count as i32 / 2) / count as i32;
        count += 1;
    }
    table
};

/// The details of `runs[index]` from column `start` on, up to the run's end or the buffer's, as bytes of two's
/// complement, rounded to nearest. Empty where the run leaves the view.
///
/// Of a row with several runs, the surroundings are the one that overlaps the run most.
pub(super) fn details<'o>(
    view: &View<'_>,
    runs: &[Run],
    index: usize,
    start: u16,
    out: &'o mut [u8; CHUNK],
) -> &'o mut [u8] {
    let Some(&run) = runs.get(index) else { return &mut [] };
    let length = (run.end.saturating_sub(start) as usize).min(CHUNK);
    let Some(own) = view.run(run.row as usize, start as usize, length) else { return &mut [] };
    let mut columns = [0 as Tally; COLUMNS];
    tally(view, runs, index, start as i32 - REACH as i32, columns.get_mut(..length + SIDE - 1).unwrap_or(&mut []));
    let mut around = columns.iter().take(SIDE - 1).sum::<Tally>();
    let entering = columns.iter().skip(SIDE - 1);
    for (((detail, &pixel), &entering), &leaving) in out.iter_mut().zip(own).zip(entering).zip(&columns) {
        around += entering;
        let (sum, count) = ((around & (ONE - 1)) as i32, around / ONE);
        let per_count = PER_COUNT.get(count as usize).map_or(0, |&per_count| per_count);
        *detail = detail_of(pixel as i32 * count as i32 - sum, per_count);
        around -= leaving;
    }
    out.get_mut(..length).unwrap_or(&mut [])
}

/// Valid pixels of each column from `first` on, summed over the rows around `runs[index]`.
fn tally(view: &View<'_>, runs: &[Run], index: usize, first: i32, columns: &mut [Tally]) {
    let Some(run) = runs.get(index) else { return };
    let end = first + columns.len() as i32;
    // Pixels of each row, and the column of the first.
    let mut rows: [(&[u8], usize); SIDE] = [(&[], 0); SIDE];
    for ((pixels, start), row) in rows.iter_mut().zip(run.row as i32 - REACH as i32..) {
        let Some(near) = overlapping(runs, index, row) else { continue };
        let (from, to) = (first.max(near.start as i32), end.min(near.end as i32));
        *pixels = view.run(row as usize, from as usize, (to - from).max(0) as usize).unwrap_or(&[]);
        *start = (from - first).max(0) as usize;
    }
    // The columns that every row has are summed at once, the others row by row.
    let common = rows.iter().fold(0..columns.len(), |common, (pixels, start)| {
        common.start.max(*start)..common.end.min(start + pixels.len())
    });
    let common = if common.is_empty() { 0..0 } else { common };
    for (pixels, start) in rows {
        let before = common.start.saturating_sub(start).min(pixels.len());
        let behind = common.end.saturating_sub(start).min(pixels.len());
        add(columns, start, &pixels[..before]);
        add(columns, start + behind, &pixels[behind..]);
    }
    let [a, b, c, d, e] = rows.map(|(pixels, start)| pixels.get(common.start.wrapping_sub(start)..).unwrap_or(&[]));
    for (((((column, &a), &b), &c), &d), &e) in columns[common].iter_mut().zip(a).zip(b).zip(c).zip(d).zip(e) {
        *column = a as Tally + b as Tally + c as Tally + d as Tally + e as Tally + SIDE as Tally * ONE;
    }
}

/// Adds pixels to the columns from `start` on.
fn add(columns: &mut [Tally], start: usize, pixels: &[u8]) {
    for (column, &pixel) in columns.iter_mut().skip(start).zip(pixels) {
        *column += pixel as Tally + ONE;
    }
}

/// The details of a row of a picture that is valid from border to border, into `out`.
pub(super) fn row_details(picture: &View<'_>, row: usize, out: &mut [u8]) {
    let (cols, rows) = (picture.size().0 as usize, picture.size().1 as usize);
    let reach = REACH as usize;
    let first = row.saturating_sub(reach);
    let count = (row + reach + 1).min(rows) - first;
    let Some(own) = picture.run(row, 0, cols) else { return };
    for (start, out) in (0usize..).step_by(CHUNK).zip(out.chunks_mut(CHUNK)) {
        // Sums of the columns from REACH before the chunk to REACH behind it; outside the picture 0.
        let mut columns = [0u16; COLUMNS];
        let from = start.saturating_sub(reach);
        let to = (start + out.len() + reach).min(cols);
        // A row outside the picture stands for nothing.
        let part = |nth: usize| match picture.run(first + nth, from, to - from) {
            Some(pixels) if nth < count => pixels,
            _ => &ZEROS[..to - from],
        };
        sum_columns([part(0), part(1), part(2), part(3), part(4)], &mut columns[from + reach - start..]);
        let mut around: i32 = columns[..SIDE - 1].iter().map(|&column| column as i32).sum();
        let length = out.len();
        let mut step = |cols: Range<usize>, wide: usize| {
            let (pixels, per_count) = ((wide * count) as i32, PER_COUNT.get(wide * count).map_or(0, |&per| per));
            let five = columns[cols.start..cols.end + SIDE - 1].windows(SIDE);
            for ((detail, &pixel), five) in out[cols.clone()].iter_mut().zip(&own[start..][cols]).zip(five) {
                around += five[SIDE - 1] as i32;
                *detail = detail_of(pixel as i32 * pixels - around, per_count);
                around -= five[0] as i32;
            }
        };
        // Near the borders of the picture fewer columns are around.
        let wide = |col: usize| (col + reach + 1).min(cols) - col.saturating_sub(reach);
        let inner = reach.saturating_sub(start).min(length);
        let end = cols.saturating_sub(reach + start).clamp(inner, length);
        (0..inner).for_each(|col| step(col..col + 1, wide(start + col)));
        step(inner..end, SIDE);
        (end..length).for_each(|col| step(col..col + 1, wide(start + col)));
    }
}

/// Sums of five rows column by column; four columns at a time, two in a word.
fn sum_columns(rows: [&[u8]; SIDE], columns: &mut [u16]) {
    const EVEN: u32 = 0x00ff_00ff;
    let [a, b, c, d, e] = rows.map(|row| row.as_chunks::<4>());
    let (fours, _) = columns.as_chunks_mut::<4>();
    let words = a.0.iter().zip(b.0).zip(c.0).zip(d.0).zip(e.0);
    for (four, ((((a, b), c), d), e)) in fours.iter_mut().zip(words) {
        let words = [a, b, c, d, e].map(|bytes| u32::from_le_bytes(*bytes));
        let even = words.iter().fold(0, |sum, word| sum + (word & EVEN));
        let odd = words.iter().fold(0, |sum, word| sum + ((word >> 8) & EVEN));
        *four = [even as u16, odd as u16, (even >> 16) as u16, (odd >> 16) as u16];
    }
    let done = 4 * a.0.len();
    let rest = a.1.iter().zip(b.1).zip(c.1).zip(d.1).zip(e.1);
    for (column, ((((&a, &b), &c), &d), &e)) in columns.iter_mut().skip(done).zip(rest) {
        *column = a as u16 + b as u16 + c as u16 + d as u16 + e as u16;
    }
}

/// Stands for rows outside a picture.
static ZEROS: [u8; COLUMNS] = [0; COLUMNS];

/// `difference` x `per_count` of [`PER_COUNT`], rounded to nearest.
#[inline(always)]
fn detail_of(difference: i32, per_count: i32) -> u8 {
    ((difference * per_count + (1 << 15)) >> 16).clamp(-MAX, MAX) as u8
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

/// The size beyond which details are limited.
pub(super) struct Limit {
    sizes: Histogram,
}

impl Limit {
    /// Of no details yet.
    pub(super) fn new() -> Self {
        Limit { sizes: Histogram::new() }
    }

    /// Takes details into account.
    pub(super) fn add(&mut self, details: &[u8]) {
        for &detail in details {
            self.sizes.add((detail as i8).unsigned_abs());
        }
    }

    /// The limit for the details taken into account.
    pub(super) fn value(&self) -> u8 {
        (LIMIT * self.sizes.median()).clamp(1.0, MAX as f32) as u8
    }
}

/// Limits details to ±`limit`.
pub(super) fn limit_to(limit: u8, details: &mut [u8]) {
    let (fours, rest) = details.as_chunks_mut::<4>();
    for four in fours {
        *four = clamp_bytes(u32::from_le_bytes(*four), limit).to_le_bytes();
    }
    for detail in rest {
        *detail = (*detail as i8).clamp(-(limit as i8), limit as i8) as u8;
    }
}
