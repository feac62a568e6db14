//! The search for a patch that lies far from where it was predicted: coarse to fine.
//!
//! Boxes of k x k pixels of patch and reference make two small pictures, whose details (a box less the mean around it) are
//! correlated at every shift that they can tell. Half a box off, true ground still correlates half as well as on it, and
//! over a few hundred boxes that stands among the highest of some thousand chance values; which of them it is, the pictures
//! themselves decide: around each of the highest summits the same is done within ±[`FINE_PX`] in boxes of one pixel. The
//! peak's second is the best other place of all of these.

use super::View;
use super::detail::{Limit, limit_to};
use super::search::{HILL_PX, Peak, SearchError, check, put_in};
use crate::dsp::{dot_and_energy, dot4_rows};
use crate::math::sqrt;
use crate::rectify::Run;

/// Radius of the search around a summit, pixels: a box, and two for the climb.
pub const FINE_PX: u16 = 3;
/// Shifts along a side of that search.
const FINE: usize = 2 * FINE_PX as usize + 1;
/// Summits that are looked at in full resolution.
const SUMMITS: usize = 6;
/// Patches longer than this are reduced by boxes of 3 x 3, others by 2 x 2, pixels.
pub const LONG_PX: u16 = 48;
/// Largest boxes: what a summit can be off must stay within the fine search.
const BOX_MAX: usize = 4;
/// Boxes of the patch that rank the shifts, about: of more, every second row or fewer. Between half and one and a half times
/// as many, true ground under noise as strong as its details was among the summits every time in 400.
const LOOK: usize = 120;
/// Every which row of a small picture has a say in its limit.
const LIMIT_ROWS: usize = 3;
/// Boxes to each side that make the surroundings.
const REACH: usize = 2;
/// Bytes behind the details that may be read.
const SLACK: usize = 8;

/// A place that was looked at: the peak around it, and the window's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The peak in terms of the whole search.
    pub(super) peak: Peak,
    /// The same in those of its window.
    pub(super) local: Peak,
    /// The shift at the window's centre.
    pub(super) centre: (i16, i16),
}

/// The patch among all shifts within ±`radius` of `at`, as far as `tile` reaches.
///
/// `patch` and `runs`: as the rectifier leaves them. `at`: (column, row) of the tile at which the patch's upper left pixel
/// is predicted. `bytes`: [`room`], or boxes become larger.
///
/// # Errors
/// [`SearchError`].
pub(super) fn reacquire(
    patch: &View<'_>,
    runs: &[Run],
    tile: &View<'_>,
    at: (i32, i32),
    radius: u16,
    bytes: &mut [u8],
) -> Result<Found, SearchError> {
    check(patch, runs)?;
    let aligned = bytes.as_ptr().align_offset(4);
    let bytes = bytes.get_mut(aligned..).ok_or(SearchError::Capacity)?;
    let span = Span::new(patch, tile, at, radius).ok_or(SearchError::ReferenceTooSmall)?;
    let mut room = [Summit::default(); SUMMITS];
    let summits = coarse(patch, runs, tile, at, &span, bytes, &mut room)?;
    let mut fine = Fine::new(patch, runs, bytes)?;
    let mut found: [Option<Found>; SUMMITS] = [None; SUMMITS];
    for (found, summit) in found.iter_mut().zip(summits) {
        *found = Some(fine.look(tile, at, summit.centre)?);
    }
    // The best and the best other one, each climbing on where its top lies at its window's border.
    let mut best = None;
    for rank in 0..2 {
        for _ in 0..CLIMB {
            let Some((index, place)) = highest(&found, if rank == 0 { None } else { best }) else { break };
            let next = span.nearest((place.peak.d_col, place.peak.d_row));
            if !place.local.on_border || next == place.centre {
                break;
            }
            if let Some(found) = found.get_mut(index) {
                *found = Some(fine.look(tile, at, next)?);
            }
        }
        best = highest(&found, None).map(|(_, place)| place);
    }
    let mut best = best.ok_or(SearchError::Featureless)?;
    for other in found.iter().flatten() {
        let own = ((other.peak.d_col, other.peak.d_row), other.peak.score);
        for (place, score) in [own, (other.peak.second_at, other.peak.second)] {
            if score > best.peak.second && apart(place, (best.peak.d_col, best.peak.d_row)) >= HILL_PX {
                (best.peak.second, best.peak.second_at) = (score, place);
            }
        }
    }
    Ok(best)
}

/// Windows that a climb may move on by.
const CLIMB: usize = 3;

/// The highest place, of those that do not belong to the hill of `but` where that is given.
fn highest(found: &[Option<Found>], but: Option<Found>) -> Option<(usize, Found)> {
    let at = |found: &Found| (found.peak.d_col, found.peak.d_row);
    let others = found.iter().enumerate().filter_map(|(index, found)| found.map(|found| (index, found)));
    let others = others.filter(|(_, found)| but.is_none_or(|but| apart(at(found), at(&but)) >= HILL_PX));
    others.reduce(|best, next| if next.1.peak.score > best.1.peak.score { next } else { best })
}

/// Steps between two places, the larger of both axes.
fn apart(a: (i16, i16), b: (i16, i16)) -> i16 {
    (a.0 - b.0).abs().max((a.1 - b.1).abs())
}

/// The tile around the patch at a shift of `centre`, ±[`FINE_PX`].
pub(super) fn window<'a>(patch: &View<'_>, tile: &View<'a>, at: (i32, i32), centre: (i16, i16)) -> Option<View<'a>> {
    let corner = |at: i32, centre: i16| at + centre as i32 - FINE_PX as i32;
    let (cols, rows) = patch.size();
    tile.window(corner(at.0, centre.0), corner(at.1, centre.1), (cols + 2 * FINE_PX, rows + 2 * FINE_PX))
}

/// The shifts at which a fine search fits the tile: the smallest and the largest of columns and of rows.
struct Span {
    cols: (i16, i16),
    rows: (i16, i16),
}

impl Span {
    /// `None` where there is none.
    fn new(patch: &View<'_>, tile: &View<'_>, at: (i32, i32), radius: u16) -> Option<Self> {
        let fine = FINE_PX as i32;
        let radius = radius.min(i16::MAX as u16 / 2) as i32;
        let axis = |at: i32, patch: u16, tile: u16| {
            let last = (tile as i32 - patch as i32 - fine).saturating_sub(at).min(radius);
            let first = fine.saturating_sub(at).max(-radius);
            (first <= last).then_some((first as i16, last as i16))
        };
        let (own, other) = (patch.size(), tile.size());
        Some(Span { cols: axis(at.0, own.0, other.0)?, rows: axis(at.1, own.1, other.1)? })
    }

    /// The shift of the span that is nearest to `shift`.
    fn nearest(&self, shift: (i16, i16)) -> (i16, i16) {
        (shift.0.clamp(self.cols.0, self.cols.1), shift.1.clamp(self.rows.0, self.rows.1))
    }
}

/// A summit of the coarse scores.
#[derive(Clone, Copy, Default)]
struct Summit {
    centre: (i16, i16),
    score: f32,
}

/// Sizes of the small pictures.
#[derive(Clone, Copy)]
struct Sizes {
    /// Pixels along a side of a box.
    factor: usize,
    /// The patch, (columns, rows).
    own: (usize, usize),
    /// Shifts.
    shifts: (usize, usize),
    /// The reference.
    other: (usize, usize),
}

impl Sizes {
    fn new(factor: usize, patch: (u16, u16), span: &Span) -> Self {
        let boxes = |pixels: u16| pixels as usize / factor;
        // Products come in fours; a column that would open one by itself is not worth it.
        let cols = boxes(patch.0);
        let cols = if cols > 4 && cols % 4 == 1 { cols - 1 } else { cols };
        let count = |(first, last): (i16, i16)| (last - first) as usize / factor + 1;
        let (own, shifts) = ((cols, boxes(patch.1)), (count(span.cols), count(span.rows)));
        Sizes { factor, own, shifts, other: (own.0 + shifts.0 - 1, own.1 + shifts.1 - 1) }
    }

    /// Boxes of one pixel, around a summit.
    const fn fine(patch: (u16, u16)) -> Self {
        let own = (patch.0 as usize, patch.1 as usize);
        Sizes { factor: 1, own, shifts: (FINE, FINE), other: (own.0 + FINE - 1, own.1 + FINE - 1) }
    }

    /// From one row of details to the next, patch and reference.
    const fn strides(&self) -> (usize, usize) {
        (self.own.0.next_multiple_of(4), (self.other.0 + 3).next_multiple_of(4))
    }

    /// Bytes of the patch's details, of the reference's, and of what serves first for grey boxes and then for energies by
    /// columns and scores.
    const fn bytes(&self) -> [usize; 3] {
        let (own, other) = self.strides();
        let (grey, scores) =
            (self.other.0 * (self.other.1 + 2) + 4 * REACH + 1, 4 * (self.other.0 + self.shifts.0 * self.shifts.1));
        [own * self.own.1, other * self.other.1 + SLACK, if grey > scores { grey } else { scores }]
    }

    /// All of them, and the patch with its gaps filled, at its boxes' greys and counts.
    const fn room(&self, patch: (u16, u16)) -> usize {
        let [own, other, rest] = self.bytes();
        let filled = patch.0 as usize * patch.1 as usize + 2 * self.own.0 * (self.own.1 + 1) + 4 * REACH;
        own + if other + rest > filled { other + rest } else { filled }
    }
}

/// Bytes that a search of ±`radius` needs for a patch of `size`, with the smallest boxes.
pub const fn room(size: (u16, u16), radius: u16) -> usize {
    let factor = smallest_factor(size);
    let count = 2 * radius as usize / factor + 1;
    let own = (size.0 as usize / factor, size.1 as usize / factor);
    let other = (own.0 + count - 1, own.1 + count - 1);
    let coarse = Sizes { factor, own, shifts: (count, count), other }.room(size);
    let fine = Sizes::fine(size).room(size);
    3 + if coarse > fine { coarse } else { fine }
}

const fn smallest_factor((cols, rows): (u16, u16)) -> usize {
    if cols > LONG_PX || rows > LONG_PX { 3 } else { 2 }
}

/// The highest summits of the small pictures' correlation. Not inlined: what it needs of the stack is free again for the
/// fine search.
#[inline(never)]
fn coarse<'s>(
    patch: &View<'_>,
    runs: &[Run],
    tile: &View<'_>,
    at: (i32, i32),
    span: &Span,
    bytes: &mut [u8],
    room: &'s mut [Summit; SUMMITS],
) -> Result<&'s [Summit], SearchError> {
    let sizes = (smallest_factor(patch.size())..=BOX_MAX).map(|factor| Sizes::new(factor, patch.size(), span));
    let sizes = { sizes }.find(|sizes| sizes.room(patch.size()) <= bytes.len()).ok_or(SearchError::Capacity)?;
    let (own, rest) = bytes.split_at_mut_checked(sizes.bytes()[0]).ok_or(SearchError::Capacity)?;
    let valid = own_details(patch, runs, &sizes, own, rest).ok_or(SearchError::Featureless)?;
    let corner = (at.0 + span.cols.0 as i32, at.1 + span.rows.0 as i32);
    let every = ((valid + LOOK / 2) / LOOK).max(1);
    let (_, scores) = ranked(own, tile, corner, &sizes, every, rest)?;
    let count = summits(scores, sizes.shifts, room);
    let shift = |first: i16, boxes: i16| first + sizes.factor as i16 * boxes;
    let found = room.get_mut(..count).unwrap_or(&mut []);
    for summit in &mut *found {
        summit.centre = (shift(span.cols.0, summit.centre.0), shift(span.rows.0, summit.centre.1));
    }
    Ok(found)
}

/// Scores of all shifts of the patch's boxes from `corner` of the tile on, and the reference's details they were made of.
fn ranked<'b>(
    own: &[u8],
    tile: &View<'_>,
    corner: (i32, i32),
    sizes: &Sizes,
    every: usize,
    room: &'b mut [u8],
) -> Result<(&'b [u8], &'b [[u8; 4]]), SearchError> {
    let [_, other, rest] = sizes.bytes();
    let (other, room) = room.split_at_mut_checked(other).ok_or(SearchError::Capacity)?;
    let room = room.get_mut(..rest).ok_or(SearchError::Capacity)?;
    let (cols, rows) = sizes.other;
    let (Ok(col), Ok(row)) = (usize::try_from(corner.0), usize::try_from(corner.1)) else {
        return Err(SearchError::ReferenceTooSmall);
    };
    let (grey, columns) = room.split_at_mut_checked(cols * rows).ok_or(SearchError::Capacity)?;
    let columns = columns.as_chunks_mut::<2>().0.get_mut(..cols + 2 * REACH).ok_or(SearchError::Capacity)?;
    reduce(tile, (col, row), sizes.factor, (cols, rows), grey).ok_or(SearchError::ReferenceTooSmall)?;
    let stride = sizes.strides().1;
    let (details, slack) = other.split_at_mut_checked(stride * rows).ok_or(SearchError::Capacity)?;
    slack.fill(0);
    details_into(grey, (cols, rows), stride, (&mut *details, columns));
    let mut limit = Limit::new();
    for line in details.chunks_exact(stride.max(1)).step_by(LIMIT_ROWS) {
        limit.add(line.get(..cols).unwrap_or(&[]));
    }
    limit_to(limit.value(), details);
    let words = room.as_chunks_mut::<4>().0;
    let (energies, scores) = words.split_at_mut_checked(cols).ok_or(SearchError::Capacity)?;
    let scores = scores.get_mut(..sizes.shifts.0 * sizes.shifts.1).ok_or(SearchError::Capacity)?;
    correlate(own, other, sizes, every, scores);
    normalise(other, sizes, energies, scores);
    Ok((other, scores))
}

/// The search around summits.
struct Fine<'a> {
    sizes: Sizes,
    /// The patch's details, rows padded with zeros, and their energy.
    own: &'a [u8],
    energy: i32,
    runs: &'a [Run],
    room: &'a mut [u8],
}

impl<'a> Fine<'a> {
    fn new(patch: &View<'_>, runs: &'a [Run], bytes: &'a mut [u8]) -> Result<Self, SearchError> {
        let sizes = Sizes::fine(patch.size());
        let (own, room) = bytes.split_at_mut_checked(sizes.bytes()[0]).ok_or(SearchError::Capacity)?;
        own_details(patch, runs, &sizes, own, room).ok_or(SearchError::Featureless)?;
        let own = &*own;
        let energy = dot_and_energy(own, own).1;
        Ok(Fine { sizes, own, energy, runs, room })
    }

    /// The peak around a shift of `centre`.
    #[inline(never)]
    fn look(&mut self, tile: &View<'_>, at: (i32, i32), centre: (i16, i16)) -> Result<Found, SearchError> {
        let fine = FINE_PX as i32;
        let corner = (at.0 + centre.0 as i32 - fine, at.1 + centre.1 as i32 - fine);
        let (other, scores) = ranked(self.own, tile, corner, &self.sizes, 1, &mut *self.room)?;
        let rank =
            |(col, row): (usize, usize)| scores.get(row * FINE + col).map_or(0.0, |&score| f32::from_le_bytes(score));
        let all = || (0..FINE * FINE).map(|index| (index % FINE, index / FINE));
        let highest = |best: (usize, usize), next: (usize, usize)| if rank(next) > rank(best) { next } else { best };
        let top = all().reduce(highest).unwrap_or((FINE_PX as usize, FINE_PX as usize));
        let strides = self.sizes.strides();
        let score = |place| score((self.own, self.energy), other, self.runs, strides, place);
        let far = |place: &(usize, usize)| place.0.abs_diff(top.0).max(place.1.abs_diff(top.1)) >= HILL_PX as usize;
        let second = all().filter(far).reduce(highest).filter(|&place| rank(place) > 0.0);
        let on_border = [top.0, top.1].iter().any(|&at| at == 0 || at == FINE - 1);
        // Ranks are squares of what is as high as the scores but for the mask.
        let parabola = |before: (usize, usize), after: (usize, usize)| {
            let height = |place| sqrt(rank(place).max(0.0));
            let bend = 2.0 * height(top) - height(before) - height(after);
            if bend > 0.0 { (0.5 * (height(after) - height(before)) / bend).clamp(-0.5, 0.5) } else { 0.0 }
        };
        let vertex = if on_border {
            (0.0, 0.0)
        } else {
            let (col, row) = top;
            (parabola((col - 1, row), (col + 1, row)), parabola((col, row - 1), (col, row + 1)))
        };
        let shift = |(col, row): (usize, usize)| (col as i16 - FINE_PX as i16, row as i16 - FINE_PX as i16);
        let (d_col, d_row) = shift(top);
        let local = Peak {
            d_col,
            d_row,
            score: score(top),
            second: second.map_or(0.0, score),
            second_at: shift(second.unwrap_or(top)),
            vertex,
            on_border,
        };
        let moved = |(col, row): (i16, i16)| (col + centre.0, row + centre.1);
        let ((d_col, d_row), second_at) = (moved((d_col, d_row)), moved(local.second_at));
        Ok(Found { peak: Peak { d_col, d_row, second_at, ..local }, local, centre })
    }
}

/// Correlation of the details at a place of the window, the reference's energy under the mask.
fn score(
    (own, own_energy): (&[u8], i32),
    other: &[u8],
    runs: &[Run],
    strides: (usize, usize),
    (col, row): (usize, usize),
) -> f32 {
    let (mut products, mut energy) = (0, 0);
    for run in runs {
        let (line, start, length) = (run.row as usize, run.start as usize, (run.end - run.start) as usize);
        let own = own.get(line * strides.0 + start..).and_then(|own| own.get(..length)).unwrap_or(&[]);
        let others = other.get((line + row) * strides.1 + start + col..).unwrap_or(&[]);
        let (product, square) = dot_and_energy(own, others);
        products += product;
        energy += square;
    }
    if energy > 0 { products as f32 / (sqrt(own_energy as f32) * sqrt(energy as f32)) } else { 0.0 }
}

/// The limited details of the patch's boxes, rows padded with zeros, and zeros where a box is not wholly valid; how many
/// are. `None` where there is no detail, or not the room.
///
/// In the surroundings the outermost pixels of a row go on where it is not valid, and the nearest row where there is none.
fn own_details(patch: &View<'_>, runs: &[Run], sizes: &Sizes, out: &mut [u8], room: &mut [u8]) -> Option<usize> {
    let (width, height) = (patch.size().0 as usize, patch.size().1 as usize);
    let Sizes { factor, own: (cols, rows), .. } = *sizes;
    let (filled, room) = room.split_at_mut_checked(width * height)?;
    let (columns, room) = room.split_at_mut_checked(2 * (cols + 2 * REACH))?;
    let (grey, counts) = room.get_mut(..2 * cols * rows)?.split_at_mut_checked(cols * rows)?;
    counts.fill(0);
    let first = runs.first()?.row as usize;
    let mut done = 0;
    for run in runs {
        let (row, start, end) = (run.row as usize, run.start as usize, run.end as usize);
        let pixels = patch.run(row, start, end - start)?;
        let (Some(&left), Some(&right)) = (pixels.first(), pixels.last()) else { continue };
        // Rows without a run are those of the row before.
        while done < row && done > first {
            copy_line(filled, width, done - 1, done);
            done += 1;
        }
        let line = filled.get_mut(row * width..(row + 1) * width)?;
        let (before, line) = line.split_at_mut_checked(start)?;
        if done <= row {
            before.fill(left);
        }
        done = row + 1;
        let (line, behind) = line.split_at_mut_checked(pixels.len())?;
        line.iter_mut().zip(pixels).for_each(|(to, &from)| *to = from);
        behind.fill(right);
        if let Some(counts) = counts.chunks_exact_mut(cols.max(1)).nth(row / factor.max(1)) {
            for (col, count) in counts.iter_mut().enumerate() {
                let (from, to) = ((col * factor).max(start), (col * factor + factor).min(end));
                *count = count.saturating_add(to.saturating_sub(from) as u8);
            }
        }
    }
    for row in (0..first.min(height)).rev() {
        copy_line(filled, width, row + 1, row);
    }
    for row in done.max(1)..height {
        copy_line(filled, width, row - 1, row);
    }
    reduce(&View::new(filled, patch.size())?, (0, 0), factor, (cols, rows), grey)?;
    let stride = sizes.strides().0;
    details_into(grey, (cols, rows), stride, (&mut *out, columns.as_chunks_mut::<2>().0));
    let mut limit = Limit::new();
    let mut valid = 0;
    let whole = (factor * factor) as u8;
    let mut counts = counts.chunks_exact(cols.max(1));
    for line in out.chunks_exact_mut(stride.max(1)) {
        let Some(counts) = counts.next() else { break };
        for (detail, &count) in line.iter_mut().zip(counts) {
            if count == whole {
                limit.add(core::slice::from_ref(detail));
                valid += 1;
            } else {
                *detail = 0;
            }
        }
    }
    limit_to(limit.value(), out);
    out.iter().any(|&detail| detail != 0).then_some(valid)
}

/// Copies a line of a picture onto a neighbour of it.
fn copy_line(picture: &mut [u8], width: usize, from: usize, to: usize) {
    let upper = from.min(to) * width;
    let both = picture.get_mut(upper..upper + 2 * width).and_then(|both| both.split_at_mut_checked(width));
    let Some((upper, lower)) = both else { return };
    let (from, to) = if from < to { (upper, lower) } else { (lower, upper) };
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Means of `cols` x `rows` boxes of a picture from `corner` on, rounded to nearest. `None` where they leave it.
fn reduce(
    picture: &View<'_>,
    corner: (usize, usize),
    factor: usize,
    (cols, rows): (usize, usize),
    out: &mut [u8],
) -> Option<()> {
    for (row, line) in (0..rows).zip(out.chunks_exact_mut(cols.max(1))) {
        let at = |n: usize| picture.run(corner.1 + row * factor + n, corner.0, cols * factor);
        match factor {
            1 => line.iter_mut().zip(at(0)?).for_each(|(to, &from)| *to = from),
            2 => {
                let (above, below) = (at(0)?.as_chunks::<2>().0, at(1)?.as_chunks::<2>().0);
                for ((grey, a), b) in line.iter_mut().zip(above).zip(below) {
                    let sum = a[0] as u32 + a[1] as u32 + b[0] as u32 + b[1] as u32;
                    *grey = ((sum + 2) >> 2) as u8;
                }
            }
            3 => {
                let [a, b, c] = [at(0)?.as_chunks::<3>().0, at(1)?.as_chunks::<3>().0, at(2)?.as_chunks::<3>().0];
                for (((grey, a), b), c) in line.iter_mut().zip(a).zip(b).zip(c) {
                    let sum: u32 = a.iter().chain(b).chain(c).map(|&grey| grey as u32).sum();
                    // A ninth, exact for every sum of nine bytes.
                    *grey = (((sum + 4) * 7282) >> 16) as u8;
                }
            }
            _ => {
                for (col, grey) in line.iter_mut().enumerate() {
                    let mut sum = 0;
                    for n in 0..factor {
                        sum += at(n)?.iter().skip(col * factor).take(factor).map(|&grey| grey as u32).sum::<u32>();
                    }
                    let area = (factor * factor).max(1) as u32;
                    *grey = ((sum + area / 2) / area) as u8;
                }
            }
        }
    }
    Some(())
}

/// The details of a picture, not limited yet, rows `stride` apart with zeros behind them; beyond its border the outermost
/// pixels go on. `columns`: room for a sum of each column, from two before the first to two behind the last, over the rows
/// from two before a row to two behind it.
fn details_into(grey: &[u8], (cols, rows): (usize, usize), stride: usize, (out, columns): (&mut [u8], &mut [[u8; 2]])) {
    let line = |row: usize| {
        let row = row.saturating_sub(REACH).min(rows.saturating_sub(1));
        grey.get(row * cols..row * cols + cols).unwrap_or(&[])
    };
    let add = |columns: &mut [[u8; 2]], row: usize| {
        for (column, &entering) in columns.iter_mut().skip(REACH).zip(line(row)) {
            *column = (u16::from_le_bytes(*column) + entering as u16).to_le_bytes();
        }
    };
    columns.fill([0; 2]);
    (0..2 * REACH).for_each(|row| add(columns, row));
    for (row, details) in (0..rows).zip(out.chunks_exact_mut(stride.max(1))) {
        let (details, behind) = details.split_at_mut(cols.min(stride));
        behind.fill(0);
        add(columns, row + 2 * REACH);
        if let Some([left @ .., first]) = columns.get_mut(..=REACH) {
            left.fill(*first);
        }
        if let Some([last, right @ ..]) = columns.get_mut(cols + REACH - 1..) {
            right.fill(*last);
        }
        let sum = |column: [u8; 2]| u16::from_le_bytes(column) as i32;
        let mut around: i32 = columns.iter().take(2 * REACH).map(|&column| sum(column)).sum();
        let five = columns.windows(2 * REACH + 1);
        for ((detail, &own), five) in details.iter_mut().zip(line(row + REACH)).zip(five) {
            around += sum(five[2 * REACH]);
            // 4/25 in Q16, rounded to nearest.
            *detail = (((own as i32 * 25 - around) * 10486 + (1 << 15)) >> 16).clamp(-127, 127) as u8;
            around -= sum(five[0]);
        }
        for (column, &leaving) in columns.iter_mut().skip(REACH).zip(line(row)) {
            *column = (u16::from_le_bytes(*column) - leaving as u16).to_le_bytes();
        }
    }
}

/// Products of both pictures' details at every shift, over every `every`th row of the patch.
fn correlate(own: &[u8], other: &[u8], sizes: &Sizes, every: usize, scores: &mut [[u8; 4]]) {
    let strides = sizes.strides();
    for (line, scores) in scores.chunks_exact_mut(sizes.shifts.0.max(1)).enumerate() {
        for (at, scores) in (0..).step_by(4).zip(scores.chunks_mut(4)) {
            let others = other.get(line * strides.1 + at..).unwrap_or(&[]);
            let sums = dot4_rows(own, others, strides, every);
            for (score, sum) in scores.iter_mut().zip(sums) {
                *score = sum.to_le_bytes();
            }
        }
    }
}

/// Makes scores of products: their squares, with their signs, over the reference's energy under the patch's rectangle.
fn normalise(other: &[u8], sizes: &Sizes, energies: &mut [[u8; 4]], scores: &mut [[u8; 4]]) {
    let stride = sizes.strides().1;
    let (cols, rows) = sizes.own;
    let line = |row: usize| other.get(row * stride..row * stride + sizes.other.0).unwrap_or(&[]);
    energies.fill([0; 4]);
    for row in 0..rows {
        add_squares(energies, line(row), 1);
    }
    for (row, scores) in scores.chunks_exact_mut(sizes.shifts.0.max(1)).enumerate() {
        let mut energy: i32 = energies.iter().take(cols).map(|&energy| i32::from_le_bytes(energy)).sum();
        let entering = energies.iter().skip(cols).map(|&energy| i32::from_le_bytes(energy)).chain([0]);
        for ((score, leaving), entering) in scores.iter_mut().zip(energies.iter()).zip(entering) {
            let product = i32::from_le_bytes(*score) as f32;
            let ranked = if energy > 0 { product * product.abs() / energy as f32 } else { 0.0 };
            *score = ranked.to_le_bytes();
            energy += entering - i32::from_le_bytes(*leaving);
        }
        if row + 1 < sizes.shifts.1 {
            add_squares(energies, line(row), -1);
            add_squares(energies, line(row + rows), 1);
        }
    }
}

fn add_squares(energies: &mut [[u8; 4]], details: &[u8], sign: i32) {
    for (energy, &detail) in energies.iter_mut().zip(details) {
        let detail = detail as i8 as i32;
        *energy = (i32::from_le_bytes(*energy) + sign * detail * detail).to_le_bytes();
    }
}

/// The highest summits, highest first; their centres are still shifts of boxes.
fn summits(scores: &[[u8; 4]], (cols, rows): (usize, usize), room: &mut [Summit; SUMMITS]) -> usize {
    let score = |col: usize, row: usize| scores.get(row * cols + col).map_or(0.0, |&score| f32::from_le_bytes(score));
    let mut count = 0;
    for row in 0..rows {
        for col in 0..cols {
            let own = score(col, row);
            if count == SUMMITS && own <= room[SUMMITS - 1].score {
                continue;
            }
            let around = (row.saturating_sub(1)..=(row + 1).min(rows - 1))
                .flat_map(|row| (col.saturating_sub(1)..=(col + 1).min(cols - 1)).map(move |col| (col, row)));
            if around.into_iter().any(|(col, row)| score(col, row) > own) {
                continue;
            }
            let at = room.iter().take(count).position(|summit| own > summit.score).unwrap_or(count);
            count = (count + 1).min(SUMMITS);
            let summit = Summit { centre: (col as i16, row as i16), score: own };
            put_in(room.iter_mut().take(count).skip(at), summit);
        }
    }
    count
}
