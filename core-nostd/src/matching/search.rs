//! Masked normalised cross-correlation of details over whole-pixel shifts.
//!
//! Gain and offset between patch and reference do not matter to it, so other radiometry and season cost little; the
//! details (a pixel less the mean around it) keep changed ground from outweighing the rest. Details have no mean, so none
//! is taken off. Products are summed in integers.
//!
//! The peak of details is one pixel wide, so no shift can be left out, but digits can: a first look (module `look`) with
//! one digit of every detail ranks all the shifts, and the whole patch decides between its highest summits and climbs to
//! the top of the two best.

use super::detail::{Limit, each_piece, limit_to, sweep};
use super::look::Look;
use super::{View, valid};
use crate::dsp::{STRIP, copy, dot_and_energy, dots_and_energies, fill, moments};
use crate::math;
use crate::rectify::Run;

/// Why no search was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SearchError {
    /// The reference is smaller than the patch and the search radius on both sides.
    ReferenceTooSmall,
    /// Scores or details do not fit their buffers, or a run lies outside the patch.
    Capacity,
    /// The patch has no valid pixels, or no detail in them.
    Featureless,
}

/// The highest score of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Peak {
    /// Shift of the patch's centre against the reference's, columns to the right.
    pub d_col: i16,
    /// The same, rows downwards.
    pub d_row: i16,
    /// Normalised cross-correlation of the details there, −1 to 1.
    pub score: f32,
    /// The highest other summit, 0 where there is none.
    pub second: f32,
    /// Where that is, (columns, rows); the peak itself where there is none.
    pub second_at: (i16, i16),
    /// Top of the parabolas through the score and its neighbours along both axes, pixels from the peak, −0.5 to 0.5; 0 on
    /// the border.
    pub vertex: (f32, f32),
    /// Whether the peak lies on the border of the search, so that a higher one may lie beyond.
    pub on_border: bool,
}

/// Summits nearer than this to the peak belong to it: noise puts teeth on a hill, and texture that was averaged to the
/// pixel correlates over two of them.
pub(super) const HILL_PX: i16 = 3;
/// Pixels that the first look takes, where the patch has them.
const LOOK_PX: usize = 300;
/// Every which run it takes at least.
const LOOK_EVERY: usize = 3;
/// Summits of the first look that the whole patch decides between at most.
const SUMMITS: usize = 6;
/// A summit that lies further than this below the highest is none of them, but for the best one away from it: the standard
/// deviation of the difference of two scores.
const BELOW: f32 = 4.0;
/// The second place climbs where it has this share of the top: details a pixel apart correlate by a half, so that one
/// with less has no top that comes near.
const RIVAL: f32 = 0.25;
/// Steps to the top at most: a summit of the look is off by one or two.
const CLIMB: usize = 5;
/// Every which row of the reference, and of the patch, has a say in its limit.
const LIMIT_ROWS: usize = 4;
/// Bytes behind the reference's details that may be read.
const SLACK: usize = 24;

/// Bytes that a search in a reference of `size` needs. Where the patch's details fit in too, with three more a row, they
/// are made only once.
pub const fn room(size: (u16, u16)) -> usize {
    stride(size) * size.1 as usize + SLACK + 3
}

/// From one row of details to the next.
const fn stride(size: (u16, u16)) -> usize {
    (size.0 as usize).next_multiple_of(4)
}

/// The peak of the scores of every shift within ±`radius`.
///
/// `patch` and `runs`: as the rectifier leaves them. `reference`: patch + 2 `radius` in both directions or larger; its
/// centre is the zero of the shifts when it is exactly that. `bytes`: [`room`] for the reference's details, better
/// more. `scores`: room for (2 `radius` + 1)² scores of the first look, row-major from the upper left shift.
///
/// # Errors
/// [`SearchError`].
#[inline(never)]
pub fn search(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    bytes: &mut [u8],
    scores: &mut [i16],
) -> Result<Peak, SearchError> {
    let side = 2 * radius as usize + 1;
    let fits = |reference: u16, patch: u16| reference as usize >= patch as usize + side - 1;
    let (own, other) = (patch.size(), reference.size());
    if !fits(other.0, own.0) || !fits(other.1, own.1) {
        return Err(SearchError::ReferenceTooSmall);
    }
    check(patch, runs)?;
    let scores = scores.get_mut(..side * side).ok_or(SearchError::Capacity)?;
    let skipped = bytes.as_ptr().align_offset(4);
    let (others, own) = bytes
        .get_mut(skipped..)
        .and_then(|bytes| bytes.split_at_mut_checked(room(other) - 3))
        .ok_or(SearchError::Capacity)?;
    let reference = details_of(reference, others);
    let own = Own::new(patch, runs, own);
    let mut energy = 0;
    own.each((1, 1), |_, details| energy += dot_and_energy(details, details).0 as i64);
    let details = Details { own, energy, reference };
    let looked = valid(runs).clamp(LOOK_PX, LOOK_EVERY * LOOK_PX);
    let large = details.look((LOOK_PX, looked), side, scores);
    let mut room = [Place::default(); SUMMITS];
    let found = rivals(summits(scores, side, &mut room), large).len();
    if details.energy == 0 {
        return Err(SearchError::Featureless);
    }
    // Of an odd number one more is looked at, and not taken.
    let asked = room.get_mut(..found.next_multiple_of(2)).ok_or(SearchError::Featureless)?;
    details.decide(asked);
    let found = asked.get(..found).ok_or(SearchError::Featureless)?;
    details.climb(found, radius, scores).ok_or(SearchError::Featureless)
}

/// Whether all runs lie in the patch.
pub(super) fn check(patch: &View<'_>, runs: &[Run]) -> Result<(), SearchError> {
    for run in runs {
        let length = (run.end as usize).checked_sub(run.start as usize).ok_or(SearchError::Capacity)?;
        patch.run(run.row as usize, run.start as usize, length).ok_or(SearchError::Capacity)?;
    }
    Ok(())
}

/// A shift, from the upper left one on, and what the whole patch says about it.
#[derive(Clone, Copy, Default)]
struct Place {
    col: u16,
    row: u16,
    /// From the reference's first pixel to the one under the patch's.
    offset: usize,
    /// Σ p r, and Σ r² under the mask.
    products: i64,
    energy: i64,
    score: f32,
}

impl Place {
    /// Steps to another place, the larger of both axes.
    fn apart(&self, other: &Place) -> u16 {
        self.col.abs_diff(other.col).max(self.row.abs_diff(other.row))
    }
}

/// The patch's details.
struct Own<'a> {
    patch: &'a View<'a>,
    runs: &'a [Run],
    limit: u8,
    /// The limited details of every piece, with zeros up to a multiple of four, where there is room for them.
    kept: Option<&'a [u8]>,
}

impl<'a> Own<'a> {
    fn new(patch: &'a View<'a>, runs: &'a [Run], room: &'a mut [u8]) -> Self {
        let mut limit = Limit::new();
        let mut count = 0;
        let mut add = |piece: &[u8]| {
            if count % LIMIT_ROWS == 0 {
                limit.add(piece);
            }
            count += 1;
        };
        let mut needed = 0;
        each_piece(patch, runs, |piece| needed += padded(&piece));
        let Some(room) = room.get_mut(..needed) else {
            sweep(patch, runs.iter().copied(), |_, details| add(details));
            return Own { patch, runs, limit: limit.value(), kept: None };
        };
        let mut at = 0;
        sweep(patch, runs.iter().copied(), |piece, details| {
            add(details);
            if let Some(kept) = room.get_mut(at..at + padded(&piece)) {
                put(details, kept);
                at += kept.len();
            }
        });
        let limit = limit.value();
        limit_to(limit, room);
        Own { patch, runs, limit, kept: Some(room) }
    }

    /// The limited details of `part` pieces in every `whole`, evenly.
    fn each(&self, (part, whole): (usize, usize), mut each: impl FnMut(Run, &[u8])) {
        let mut due = 0;
        let mut is_taken = || {
            let is_taken = due < part;
            due = if due >= whole - part { due + part - whole } else { due + part };
            is_taken
        };
        if let Some(mut kept) = self.kept {
            each_piece(self.patch, self.runs, |piece| {
                let Some((details, rest)) = kept.split_at_checked(padded(&piece)) else { return };
                kept = rest;
                if is_taken() {
                    each(piece, details);
                }
            });
            return;
        }
        sweep(self.patch, self.runs.iter().copied(), |piece, details| {
            if is_taken() {
                let mut room = [0; STRIP];
                let room = &mut room[..padded(&piece).min(STRIP)];
                limit_to(self.limit, details);
                put(details, room);
                each(piece, room);
            }
        });
    }
}

/// Bytes of a piece's details.
fn padded(piece: &Run) -> usize {
    ((piece.end - piece.start) as usize).next_multiple_of(4)
}

/// Copies details into their room, zeros behind them.
fn put(details: &[u8], room: &mut [u8]) {
    let (own, rest) = room.split_at_mut(details.len().min(room.len()));
    copy(details, own);
    fill(0, rest);
}

/// Both pictures' details.
struct Details<'a> {
    own: Own<'a>,
    /// Σ p².
    energy: i64,
    reference: View<'a>,
}

impl Details<'_> {
    /// Scores of every shift, `side` a row, over that share of the pieces; how many details they come from. Kept apart:
    /// it needs a kilobyte of stack.
    #[inline(never)]
    fn look(&self, share: (usize, usize), side: usize, scores: &mut [i16]) -> u32 {
        let mut look = Look::new(&self.reference, self.own.limit, side, scores);
        self.own.each(share, |piece, details| look.add(piece, details));
        look.flush();
        look.counted()
    }

    /// Fills in what the whole patch says about the places, two at a time: an even number of them.
    fn decide(&self, places: &mut [Place]) {
        for place in places.iter_mut() {
            place.offset = place.row as usize * self.reference.stride + place.col as usize;
        }
        self.own.each((1, 1), |piece, own| {
            let length = (piece.end - piece.start) as usize;
            let base = piece.row as usize * self.reference.stride + piece.start as usize;
            for [a, b] in places.as_chunks_mut::<2>().0 {
                let at = [base + a.offset, base + b.offset];
                let sums = dots_and_energies(own, self.reference.pixels, at, length);
                for (place, (products, energy)) in [a, b].into_iter().zip(sums) {
                    place.products += products as i64;
                    place.energy += energy as i64;
                }
            }
        });
        for place in places {
            place.score = normalised(place.products as f32, self.energy, place.energy);
        }
    }

    /// From the two best of the places to their tops. The second one stays away from the first: a row of trees whose
    /// other summit the look put a pixel aside would seem to lead.
    fn climb(&self, places: &[Place], radius: u16, scores: &[i16]) -> Option<Peak> {
        let last = 2 * radius;
        let mut top = places.iter().copied().reduce(better)?;
        let apart = |top: &Place, place: &Place| place.apart(top) >= HILL_PX as u16 && place.score > 0.0;
        let mut second = places.iter().copied().filter(|place| apart(&top, place)).reduce(better);
        // The places beside one, and of those across its corners the one that the look holds highest. Where the search ends,
        // the nearest place stands for one beyond.
        let around = |place: Place| {
            let step = |at: u16, step: u16| (at + step).saturating_sub(1).min(last);
            let beside = |(cols, rows)| (step(place.col, cols), step(place.row, rows));
            let look = |&(col, row): &(u16, u16)| scores.get(row as usize * (last as usize + 1) + col as usize);
            let corner = [(0, 0), (2, 0), (0, 2), (2, 2)].map(beside).into_iter().max_by_key(look).unwrap_or_default();
            let [left, right, above, below] = [(0, 1), (2, 1), (1, 0), (1, 2)].map(beside);
            [left, right, above, below, corner, corner].map(|(col, row)| Place { col, row, ..Place::default() })
        };
        let mut near = [[Place::default(); 6]; 2];
        let rivals = |top: &Place, second: &Place| second.score >= RIVAL * top.score;
        let mut moved = (true, second.is_some_and(|second| rivals(&top, &second)));
        for _ in 0..CLIMB {
            let asked = match moved {
                (true, true) => near.as_mut_slice(),
                (true, false) => &mut near[..1],
                (false, true) => &mut near[1..],
                (false, false) => break,
            };
            if moved.0 {
                asked[0] = around(top);
            }
            if let (true, Some(second), Some(last)) = (moved.1, second, asked.last_mut()) {
                *last = around(second);
            }
            self.decide(asked.as_flattened_mut());
            let higher = near[0].iter().copied().fold(top, better);
            let beside =
                second.map(|second| near[1].iter().copied().filter(|p| apart(&higher, p)).fold(second, better));
            let beside = beside.filter(|place| apart(&higher, place));
            moved = (higher.apart(&top) > 0, beside.zip(second).is_some_and(|(now, before)| now.apart(&before) > 0));
            (top, second) = (higher, beside);
            if let Some(overtaken) = second.as_mut().filter(|second| second.score > top.score) {
                core::mem::swap(&mut top, overtaken);
                near.swap(0, 1);
                moved = (moved.1, moved.0);
            }
        }
        let around = &near[0];
        let centred = |place: Place| (place.col as i16 - radius as i16, place.row as i16 - radius as i16);
        let (d_col, d_row) = centred(top);
        let on_border = [top.col, top.row].iter().any(|&at| at == 0 || at == last);
        // Only around the top itself do neighbours tell where between pixels it is.
        let whole = on_border || moved.0;
        let parabola = |before: f32, after: f32| {
            let bend = 2.0 * top.score - before - after;
            if bend > 0.0 && !whole { (0.5 * (after - before) / bend).clamp(-0.5, 0.5) } else { 0.0 }
        };
        Some(Peak {
            d_col,
            d_row,
            score: top.score,
            second: second.map_or(0.0, |second| second.score),
            second_at: second.map_or((d_col, d_row), centred),
            vertex: (parabola(around[0].score, around[1].score), parabola(around[2].score, around[3].score)),
            on_border,
        })
    }
}

fn better(a: Place, b: Place) -> Place {
    if b.score > a.score { b } else { a }
}

/// Products over the root of both energies.
fn normalised(products: f32, own: i64, other: i64) -> f32 {
    if own > 0 && other > 0 { products / (math::sqrt(own as f32) * math::sqrt(other as f32)) } else { 0.0 }
}

/// The limited details of a picture that is valid from border to border, rows aligned to four.
fn details_of<'b>(picture: &View<'_>, bytes: &'b mut [u8]) -> View<'b> {
    let size = picture.size();
    let stride = stride(size);
    let mut limit = Limit::new();
    let rows = (0..size.1).map(|row| Run { row, start: 0, end: size.0 });
    sweep(picture, rows, |piece, details| {
        if (piece.row as usize).is_multiple_of(LIMIT_ROWS) {
            limit.add(details);
        }
        if let Some(room) = bytes.get_mut(piece.row as usize * stride + piece.start as usize..) {
            let length = details.len().min(room.len());
            put(details, room.split_at_mut(length).0);
        }
    });
    limit_to(limit.value(), bytes);
    View { pixels: bytes, size, stride }
}

/// The highest summits among the scores, as places, highest first.
fn summits<'r>(scores: &[i16], side: usize, room: &'r mut [Place; SUMMITS]) -> &'r mut [Place] {
    let (mut count, mut lowest) = (0, i16::MIN);
    for (row, line) in scores.chunks_exact(side).enumerate() {
        for (col, &score) in line.iter().enumerate() {
            if score > lowest && is_summit(scores, side, (col, row), score) {
                insert(
                    room,
                    &mut count,
                    Place { col: col as u16, row: row as u16, score: score as f32, ..Place::default() },
                );
                lowest = if count == SUMMITS { room[SUMMITS - 1].score as i16 } else { i16::MIN };
            }
        }
    }
    room.get_mut(..count).unwrap_or(&mut [])
}

/// Sorts a place in, behind those as high. Kept apart: it is rare.
#[inline(never)]
fn insert(room: &mut [Place; SUMMITS], count: &mut usize, place: Place) {
    let at = room.iter().take(*count).position(|other| place.score > other.score).unwrap_or(*count);
    *count = (*count + 1).min(SUMMITS);
    put_in(room.iter_mut().take(*count).skip(at), place);
}

/// Puts an item in front of others: each moves down a place, and the last one goes.
#[inline(always)]
pub(super) fn put_in<'a, T: 'a>(others: impl Iterator<Item = &'a mut T>, item: T) {
    let mut moved = item;
    for other in others {
        core::mem::swap(other, &mut moved);
    }
}

/// Those of the `places`, highest first, that may be the peak or the second one, by their scores of `large` details.
///
/// A detail adds 0 or ±1 to a score by chance, a variance of 1/4, to the difference of two scores 1/2.
fn rivals(places: &mut [Place], large: u32) -> &mut [Place] {
    let Some(&highest) = places.first() else { return places };
    let least = highest.score - BELOW * math::sqrt(0.5 * large as f32);
    let other = places.iter().position(|place| place.apart(&highest) >= HILL_PX as u16).unwrap_or(0);
    let close = places.iter().take_while(|place| place.score >= least).count();
    places.get_mut(..close.max(other + 1)).unwrap_or(&mut [])
}

/// Whether no neighbour is higher. The flank of a broad hill is no second place, however high it is where the hill's
/// own ring ends.
#[inline(never)]
fn is_summit(scores: &[i16], side: usize, (col, row): (usize, usize), own: i16) -> bool {
    let (left, right) = (col.saturating_sub(1), (col + 1).min(side - 1));
    let is_top = |row: usize| {
        let line = scores.get(row * side + left..=row * side + right);
        line.is_some_and(|line| line.iter().all(|&score| score <= own))
    };
    is_top(row) && is_top(row.saturating_sub(1)) && is_top((row + 1).min(side - 1))
}

/// Normalised cross-correlation of the greys themselves at a shift of (`d_col`, `d_row`) from the middle of a search of
/// `radius`, the figure every other matcher reports; 0 outside the reference and for pictures of one grey.
pub fn correlation(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    (d_col, d_row): (i16, i16),
) -> f32 {
    let shifted = |at: u16, d: i16| usize::try_from(at as i32 + radius as i32 + d as i32).ok();
    let (mut n, mut p, mut r, mut pp, mut rr, mut pr) = (0u64, 0u64, 0u64, 0u64, 0u64, 0u64);
    for run in runs {
        let length = run.end.saturating_sub(run.start) as usize;
        let (Some(row), Some(start)) = (shifted(run.row, d_row), shifted(run.start, d_col)) else { return 0.0 };
        let Some(own) = patch.run(run.row as usize, run.start as usize, length) else { return 0.0 };
        let Some(others) = reference.run(row, start, length) else { return 0.0 };
        n += length as u64;
        // At most 2^16 pixels: their sums fit 32 bits.
        let sums = moments(own, others);
        for (total, sum) in [&mut p, &mut r, &mut pp, &mut rr, &mut pr].into_iter().zip(sums) {
            *total += sum as u64;
        }
    }
    // All products fit 64 bits unsigned up to 2³² pixels, the difference of the last two 63 and a sign.
    let (own, other) = (n * pp - p * p, n * rr - r * r);
    if own == 0 || other == 0 {
        return 0.0;
    }
    (n * pr).wrapping_sub(p * r) as i64 as f32 / (math::sqrt(own as f32) * math::sqrt(other as f32))
}
