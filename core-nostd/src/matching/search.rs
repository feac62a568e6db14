//! Masked normalised cross-correlation of details over whole-pixel shifts.
//!
//! Gain and offset between patch and reference do not matter to it, so other radiometry and season cost little; the
//! details (a pixel less the mean around it) keep changed ground from outweighing the rest. Details have no mean, so none
//! is taken off. Products are summed in integers.
//!
//! The peak of details is one pixel wide, so no shift can be left out, but rows can: a first look over some hundred
//! pixels ranks all the shifts, and the whole patch decides between its highest summits and climbs to the top of the
//! two best. A score that would just be accepted stands 4.5 deviations above chance; in a look over a fifth of the rows,
//! the least there is, it still stands two above, where a few of a hundred summits stand by chance.

use super::detail::{CHUNK, Limit, details, limit_to, row_details};
use super::{View, valid};
use crate::dsp::{dot_and_energy, dot4};
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
/// Pixels that the first look takes at least, where the patch has them.
const LOOK_PX: usize = 220;
/// Every which run it takes at least.
const LOOK_EVERY: usize = 5;
/// Summits of the first look that the whole patch decides between.
const SUMMITS: usize = 12;
/// Steps to the top at most: a summit of the look is off by one or two.
const CLIMB: usize = 4;
/// Neighbouring shifts whose reference energies are summed together.
const BLOCK: usize = 24;

/// The peak of the scores of every shift within ±`radius`.
///
/// `patch` and `runs`: as the rectifier leaves them. `reference`: patch + 2 `radius` in both directions or larger; its
/// centre is the zero of the shifts when it is exactly that. `bytes`: room for the details of the reference. `scores`:
/// room for (2 `radius` + 1)² scores of the first look, row-major from the upper left shift.
///
/// # Errors
/// [`SearchError`].
pub fn search(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    bytes: &mut [u8],
    scores: &mut [f32],
) -> Result<Peak, SearchError> {
    let side = 2 * radius as usize + 1;
    let fits = |reference: u16, patch: u16| reference as usize >= patch as usize + side - 1;
    let (own, other) = (patch.size(), reference.size());
    if !fits(other.0, own.0) || !fits(other.1, own.1) {
        return Err(SearchError::ReferenceTooSmall);
    }
    for run in runs {
        let length = (run.end as usize).checked_sub(run.start as usize).ok_or(SearchError::Capacity)?;
        patch.run(run.row as usize, run.start as usize, length).ok_or(SearchError::Capacity)?;
    }
    let scores = scores.get_mut(..side * side).ok_or(SearchError::Capacity)?;
    let every = (valid(runs) / LOOK_PX).clamp(1, LOOK_EVERY);
    let details = Details {
        patch,
        runs,
        limit: limit(patch, runs, every),
        reference: details_into(reference, bytes).ok_or(SearchError::Capacity)?,
    };
    details.look(every, side, scores);
    let mut room = [Place::default(); SUMMITS];
    let found = summits(scores, side, &mut room);
    if details.decide(found) == 0 {
        return Err(SearchError::Featureless);
    }
    details.climb(found, radius).ok_or(SearchError::Featureless)
}

/// A shift, from the upper left one on, and what the whole patch says about it.
#[derive(Clone, Copy, Default)]
struct Place {
    col: u16,
    row: u16,
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

/// Both pictures' details.
struct Details<'a> {
    patch: &'a View<'a>,
    runs: &'a [Run],
    limit: u8,
    reference: View<'a>,
}

impl Details<'_> {
    /// Details of the patch's runs, of the first and every `every`th: row, column of the first, their number, and the
    /// details themselves with zeros up to a multiple of four.
    fn patch(&self, every: usize, mut each: impl FnMut(usize, usize, usize, &[u8])) {
        let mut chunk = [0; CHUNK];
        for index in (0..self.runs.len()).step_by(every) {
            let run = self.runs[index];
            for start in (run.start..run.end).step_by(CHUNK) {
                let own = details(self.patch, self.runs, index, start, &mut chunk);
                limit_to(self.limit, own);
                let length = own.len();
                let padded = length.next_multiple_of(4);
                chunk[length..padded].fill(0);
                each(run.row as usize, start as usize, length, &chunk[..padded]);
            }
        }
    }

    /// Scores of every shift, `side` a row, over every `every`th run.
    fn look(&self, every: usize, side: usize, scores: &mut [f32]) {
        scores.fill(0.0);
        let mut own_energy = 0;
        self.patch(every, |row, start, _, own| {
            own_energy += dot_and_energy(own, own).0 as i64;
            for (row, scores) in (row..).zip(scores.chunks_exact_mut(side)) {
                let others = self.reference.from(row, start);
                for (at, scores) in (0..).step_by(4).zip(scores.chunks_mut(4)) {
                    let sums = dot4(own, others.get(at..).unwrap_or(&[]));
                    for (score, sum) in scores.iter_mut().zip(sums) {
                        *score += sum as f32;
                    }
                }
            }
        });
        self.normalise(every, own_energy, side, scores);
    }

    /// Divides the products of every shift by the root of both energies. The reference's under the mask follows from one
    /// shift to the next by one pixel in and one out.
    fn normalise(&self, every: usize, own: i64, side: usize, scores: &mut [f32]) {
        let square = |r: u8| r as i8 as i32 * r as i8 as i32;
        for (row, line) in scores.chunks_exact_mut(side).enumerate() {
            for (block, scores) in line.chunks_mut(BLOCK).enumerate() {
                let mut energies = [0i64; BLOCK];
                for run in self.runs.iter().step_by(every) {
                    let (start, length) = (run.start as usize + BLOCK * block, (run.end - run.start) as usize);
                    let Some(r) = self.reference.run(run.row as usize + row, start, length + scores.len() - 1) else {
                        continue;
                    };
                    let (under, entering) = r.split_at(length);
                    let mut energy = dot_and_energy(under, under).0;
                    let mut steps = r.iter().zip(entering);
                    for sum in energies.iter_mut().take(scores.len()) {
                        *sum += energy as i64;
                        if let Some((&out, &next)) = steps.next() {
                            energy = energy + square(next) - square(out);
                        }
                    }
                }
                for (score, &energy) in scores.iter_mut().zip(&energies) {
                    *score = normalised(*score, own, energy);
                }
            }
        }
    }

    /// Fills in what the whole patch says about the places; its own Σ p².
    fn decide(&self, places: &mut [Place]) -> i64 {
        let mut own_energy = 0;
        self.patch(1, |row, start, length, own| {
            let own = &own[..length];
            own_energy += dot_and_energy(own, own).0 as i64;
            for place in places.iter_mut() {
                let others = self.reference.from(row + place.row as usize, start + place.col as usize);
                let (products, energy) = dot_and_energy(own, others);
                place.products += products as i64;
                place.energy += energy as i64;
            }
        });
        for place in places {
            place.score = normalised(place.products as f32, own_energy, place.energy);
        }
        own_energy
    }

    /// From the two best of the places to their tops. The second one stays away from the first: a row of trees whose
    /// other summit the look put a pixel aside would seem to lead.
    fn climb(&self, places: &[Place], radius: u16) -> Option<Peak> {
        let last = 2 * radius;
        let mut top = places.iter().copied().reduce(better)?;
        let apart = |top: &Place, place: &Place| place.apart(top) >= HILL_PX as u16 && place.score > 0.0;
        let mut second = places.iter().copied().filter(|place| apart(&top, place)).reduce(better);
        // Where the search ends, the nearest place stands for one beyond.
        let around = |place: Place| {
            let step = |at: u16, step: usize| (at + step as u16).saturating_sub(1).min(last);
            core::array::from_fn::<_, NEAR, _>(|i| Place {
                col: step(place.col, i % 3),
                row: step(place.row, i / 3),
                ..Place::default()
            })
        };
        let mut near = [[Place::default(); NEAR]; 2];
        let mut moved = (true, second.is_some());
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
        }
        let around = &near[0];
        let centred = |place: Place| (place.col as i16 - radius as i16, place.row as i16 - radius as i16);
        let (d_col, d_row) = centred(top);
        let on_border = [top.col, top.row].iter().any(|&at| at == 0 || at == last);
        // Only around the top itself do neighbours tell where between pixels it is.
        let whole = on_border || around[NEAR / 2].apart(&top) > 0;
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
            vertex: (parabola(around[3].score, around[5].score), parabola(around[1].score, around[7].score)),
            on_border,
        })
    }
}

/// A place and its eight neighbours.
const NEAR: usize = 9;

fn better(a: Place, b: Place) -> Place {
    if b.score > a.score { b } else { a }
}

/// Products over the root of both energies.
fn normalised(products: f32, own: i64, other: i64) -> f32 {
    if own > 0 && other > 0 { products / (math::sqrt(own as f32) * math::sqrt(other as f32)) } else { 0.0 }
}

/// The limit for the details of a patch, by every `every`th of its runs.
fn limit(patch: &View<'_>, runs: &[Run], every: usize) -> u8 {
    let mut limit = Limit::new();
    let mut chunk = [0; CHUNK];
    for index in (0..runs.len()).step_by(every) {
        for start in (runs[index].start..runs[index].end).step_by(CHUNK) {
            limit.add(details(patch, runs, index, start, &mut chunk));
        }
    }
    limit.value()
}

/// The limited details of a whole picture, as bytes of two's complement.
fn details_into<'b>(picture: &View<'_>, bytes: &'b mut [u8]) -> Option<View<'b>> {
    let size = picture.size();
    let stride = size.0 as usize;
    let bytes = bytes.get_mut(..stride * size.1 as usize)?;
    let mut limit = Limit::new();
    for (row, line) in (0..).zip(bytes.chunks_exact_mut(stride.max(1))) {
        row_details(picture, row, line);
        if row % LIMIT_ROWS == 0 {
            limit.add(line);
        }
    }
    limit_to(limit.value(), bytes);
    View::new(bytes, size)
}

/// Every which row of the reference has a say in its limit.
const LIMIT_ROWS: usize = 3;

/// The highest summits among the scores, as places, highest first.
fn summits<'r>(scores: &[f32], side: usize, room: &'r mut [Place; SUMMITS]) -> &'r mut [Place] {
    let mut count = 0;
    for (index, &score) in scores.iter().enumerate() {
        let full = count == SUMMITS;
        if full && score <= room[SUMMITS - 1].score || !is_summit(scores, side, index) {
            continue;
        }
        let at = room[..count].iter().position(|place| score > place.score).unwrap_or(count);
        count += usize::from(!full);
        room[at..count].rotate_right(1);
        room[at] = Place { col: (index % side) as u16, row: (index / side) as u16, score, ..Place::default() };
    }
    &mut room[..count]
}

/// Whether no neighbour is higher. The flank of a broad hill is no second place, however high it is where the hill's
/// own ring ends.
fn is_summit(scores: &[f32], side: usize, index: usize) -> bool {
    let (col, row) = (index % side, index / side);
    let (left, right) = (col.saturating_sub(1), (col + 1).min(side - 1));
    let rows = row.saturating_sub(1)..=(row + 1).min(side - 1);
    let Some(&own) = scores.get(index) else { return false };
    rows.into_iter().all(|row| {
        scores.get(row * side + left..=row * side + right).is_some_and(|line| line.iter().all(|&score| score <= own))
    })
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
        let mut sums = [0u32; 5];
        for (&own, &other) in own.iter().zip(others) {
            let (own, other) = (own as u32, other as u32);
            for (sum, add) in sums.iter_mut().zip([own, other, own * own, other * other, own * other]) {
                *sum += add;
            }
        }
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
