//! Masked normalised cross-correlation of details over whole-pixel shifts.
//!
//! Gain and offset between patch and reference do not matter to it, so other radiometry and season cost little; the
//! details (a pixel less the mean around it) keep changed ground from outweighing the rest. Details have no mean, so none
//! is taken off. Sums of products are exact integers within a run of 64 pixels.

use super::View;
use super::detail::{CHUNK, Limit, details, rows};
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
    /// Whether the peak lies on the border of the search, so that a higher one may lie beyond.
    pub on_border: bool,
}

/// Summits nearer than this to the peak belong to it: noise puts teeth on a hill, and texture that was averaged to the
/// pixel correlates over two of them.
const HILL_PX: i16 = 3;

/// Neighbouring shifts whose reference energies are summed together.
const BLOCK: usize = 12;

/// The peak of the scores of every shift within ±`radius`.
///
/// `patch` and `runs`: as the rectifier leaves them. `reference`: patch + 2 `radius` in both directions or larger; its
/// centre is the zero of the shifts when it is exactly that. `bytes`: room for the details of the reference. `scores`:
/// room for (2 `radius` + 1)² scores, row-major from the upper left shift.
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
    let (cols, rows) = patch.size();
    let (reference_cols, reference_rows) = reference.size();
    if (reference_cols as usize) < cols as usize + side - 1 || (reference_rows as usize) < rows as usize + side - 1 {
        return Err(SearchError::ReferenceTooSmall);
    }
    let scores = scores.get_mut(..side * side).ok_or(SearchError::Capacity)?;
    let others = details_into(reference, bytes).ok_or(SearchError::Capacity)?;
    let own = products_into(patch, runs, &others, side, scores)?;
    if own == 0 {
        return Err(SearchError::Featureless);
    }
    normalise(runs, &others, own as f32, side, scores);
    peak(scores, radius).ok_or(SearchError::Capacity)
}

/// The limited details of a whole picture, as bytes of two's complement.
fn details_into<'b>(picture: &View<'_>, bytes: &'b mut [u8]) -> Option<View<'b>> {
    let size = picture.size();
    let bytes = bytes.get_mut(..size.0 as usize * size.1 as usize)?;
    let mut limit = Limit::new();
    for (row, line) in (0..).zip(bytes.chunks_exact_mut(size.0.max(1) as usize)) {
        let (near, own) = rows(size, row);
        let mut chunk = [0; CHUNK];
        for (start, bytes) in (0..).step_by(CHUNK).zip(line.chunks_mut(CHUNK)) {
            let details = details(picture, &near, own, start, &mut chunk);
            limit.add(details);
            for (byte, &detail) in bytes.iter_mut().zip(details) {
                *byte = detail as u8;
            }
        }
    }
    let limit = limit.value();
    for byte in bytes.iter_mut() {
        *byte = (*byte as i8).clamp(-limit, limit) as u8;
    }
    View::new(bytes, size)
}

/// Σ p r of every shift into `scores`, `side` a row; the patch's own Σ p².
fn products_into(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    side: usize,
    scores: &mut [f32],
) -> Result<u64, SearchError> {
    let mut limit = Limit::new();
    for (index, run) in runs.iter().enumerate() {
        let length = (run.end as usize).checked_sub(run.start as usize).ok_or(SearchError::Capacity)?;
        patch.run(run.row as usize, run.start as usize, length).ok_or(SearchError::Capacity)?;
        let mut chunk = [0; CHUNK];
        for start in (run.start..run.end).step_by(CHUNK) {
            limit.add(details(patch, runs, index, start, &mut chunk));
        }
    }
    let limit = limit.value();
    scores.fill(0.0);
    let mut own = 0u64;
    for (index, run) in runs.iter().enumerate() {
        for start in (run.start..run.end).step_by(CHUNK) {
            let mut chunk = [0; CHUNK];
            let length = details(patch, runs, index, start, &mut chunk).len();
            let Some(chunk) = chunk.get_mut(..length) else { break };
            for detail in chunk.iter_mut() {
                *detail = (*detail).clamp(-limit, limit);
                own += (*detail as i32 * *detail as i32) as u64;
            }
            for (row, scores) in (run.row as usize..).zip(scores.chunks_exact_mut(side)) {
                if let Some(others) = reference.run(row, start as usize, length + side - 1) {
                    add_products(chunk, others, scores);
                }
            }
        }
    }
    Ok(own)
}

/// Adds Σ p r of each shift along `others`, which holds one pixel less than both together. Four shifts at a time, so
/// that every detail loaded serves four products; at most 64 x 127², which 32 bits hold.
fn add_products(own: &[i8], others: &[u8], scores: &mut [f32]) {
    let (fours, rest) = scores.as_chunks_mut::<4>();
    let mut at = 0;
    for scores in fours {
        let mut sums = [0i32; 4];
        for (&p, r) in own.iter().zip(others[at..].windows(4)) {
            for (sum, &r) in sums.iter_mut().zip(r) {
                *sum += p as i32 * (r as i8) as i32;
            }
        }
        for (score, sum) in scores.iter_mut().zip(sums) {
            *score += sum as f32;
        }
        at += 4;
    }
    for score in rest {
        let products = own.iter().zip(&others[at..]).map(|(&p, &r)| p as i32 * (r as i8) as i32);
        *score += products.sum::<i32>() as f32;
        at += 1;
    }
}

/// Divides the products of every shift by the root of both energies. The reference's under the mask follows from one
/// shift to the next by one pixel in and one out.
fn normalise(runs: &[Run], reference: &View<'_>, own: f32, side: usize, scores: &mut [f32]) {
    let square = |r: u8| (r as i8 as i32 * r as i8 as i32) as u32;
    for (row, line) in scores.chunks_exact_mut(side).enumerate() {
        for (block, scores) in line.chunks_mut(BLOCK).enumerate() {
            let mut energies = [0u64; BLOCK];
            for run in runs {
                let (start, length) = (run.start as usize + BLOCK * block, (run.end - run.start) as usize);
                let Some(r) = reference.run(run.row as usize + row, start, length + scores.len() - 1) else { continue };
                let mut energy: u32 = r.iter().take(length).map(|&r| square(r)).sum();
                for (shift, sum) in energies.iter_mut().take(scores.len()).enumerate() {
                    *sum += energy as u64;
                    if let (Some(&out), Some(&next)) = (r.get(shift), r.get(shift + length)) {
                        energy = energy + square(next) - square(out);
                    }
                }
            }
            for (score, &energy) in scores.iter_mut().zip(&energies) {
                *score = if energy > 0 { *score / math::sqrt(own * energy as f32) } else { 0.0 };
            }
        }
    }
}

/// The peak among the scores.
fn peak(scores: &[f32], radius: u16) -> Option<Peak> {
    let side = 2 * radius as usize + 1;
    let centred = |at: usize| at as i16 - radius as i16;
    let at = |index: usize| (centred(index % side), centred(index / side));
    let (best, &score) = scores.iter().enumerate().reduce(|best, next| if next.1 > best.1 { next } else { best })?;
    let (d_col, d_row) = at(best);
    let (mut second, mut second_at) = (0.0f32, (d_col, d_row));
    for (index, &value) in scores.iter().enumerate() {
        let (c, r) = at(index);
        let apart = (c - d_col).abs().max((r - d_row).abs()) >= HILL_PX;
        if apart && value > second && is_summit(scores, side, index) {
            (second, second_at) = (value, (c, r));
        }
    }
    let on_border = d_col.abs().max(d_row.abs()) == radius as i16;
    Some(Peak { d_col, d_row, score, second, second_at, on_border })
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
        for (&own, &other) in own.iter().zip(others) {
            let (own, other) = (own as u32, other as u32);
            p += own as u64;
            r += other as u64;
            pp += (own * own) as u64;
            rr += (other * other) as u64;
            pr += (own * other) as u64;
        }
    }
    // All products fit 64 bits unsigned up to 2³² pixels, the difference of the last two 63 and a sign.
    let (own, other) = (n * pp - p * p, n * rr - r * r);
    if own == 0 || other == 0 {
        return 0.0;
    }
    (n * pr).wrapping_sub(p * r) as i64 as f32 / (math::sqrt(own as f32) * math::sqrt(other as f32))
}
