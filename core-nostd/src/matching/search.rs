//! Masked normalised cross-correlation over whole-pixel shifts.
//!
//! Gain and offset between patch and reference do not matter to it, so other radiometry and season cost little. All
//! sums are integers; only the final quotient is a float.
//!
//! What has changed on the ground does matter: a new field twenty greys off outweighs everything else in a bland
//! picture, and its best place is not the true one. So the peak is sought with the greys of both pictures limited to
//! where most of them lie ([`Limits`], [`View::limited_into`]); what is reported is the plain correlation there,
//! [`plain`].

use super::{Limits, View};
use crate::math;
use crate::rectify::Run;

/// Why no search was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SearchError {
    /// The reference is smaller than the patch and the search radius on both sides.
    ReferenceTooSmall,
    /// The scores do not fit the buffer, or a run lies outside the patch.
    Capacity,
    /// The patch has no valid pixels, or all of one grey.
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
    /// Normalised cross-correlation there, −1 to 1.
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

/// Scores of every shift within ±`radius`, row-major from the upper left one, into `scores`.
///
/// `patch` and `runs`: as the rectifier leaves them; the patch's greys are taken within `limits`. `reference`: exactly patch + 2 `radius` in both directions or
/// larger; its centre is the zero of the shifts when it is exactly that.
///
/// # Errors
/// [`SearchError`].
pub fn search_into(
    patch: &View<'_>,
    runs: &[Run],
    limits: Limits,
    reference: &View<'_>,
    radius: u16,
    scores: &mut [f32],
) -> Result<(), SearchError> {
    let side = 2 * radius as usize + 1;
    let (cols, rows) = patch.size();
    let (reference_cols, reference_rows) = reference.size();
    if (reference_cols as usize) < cols as usize + side - 1 || (reference_rows as usize) < rows as usize + side - 1 {
        return Err(SearchError::ReferenceTooSmall);
    }
    let scores = scores.get_mut(..side * side).ok_or(SearchError::Capacity)?;
    let own = patch_sums(patch, runs, limits)?;
    for (row, line) in scores.chunks_exact_mut(side).enumerate() {
        for (block, scores) in line.chunks_mut(BLOCK).enumerate() {
            correlate_block(patch, runs, reference, (block * BLOCK, row), &own, scores);
        }
    }
    Ok(())
}

/// Neighbouring shifts that are correlated together. A multiple of 4; 12 covers the 21 shifts of the usual search in two.
const BLOCK: usize = 12;

/// Count, sum and the square root of n Σp² − (Σp)² of the valid pixels: the same for every shift.
struct PatchSums {
    count: u64,
    sum: u64,
    spread: f32,
    limits: Limits,
}

fn patch_sums(patch: &View<'_>, runs: &[Run], limits: Limits) -> Result<PatchSums, SearchError> {
    let (mut count, mut sum, mut squares) = (0u64, 0u64, 0u64);
    for run in runs {
        let length = (run.end as usize).checked_sub(run.start as usize).ok_or(SearchError::Capacity)?;
        let pixels = patch.run(run.row as usize, run.start as usize, length).ok_or(SearchError::Capacity)?;
        count += length as u64;
        for grey in pixels.iter().map(|&p| limits.apply(p) as u64) {
            sum += grey;
            squares += grey * grey;
        }
    }
    let variance = count * squares - sum * sum;
    if variance == 0 {
        return Err(SearchError::Featureless);
    }
    Ok(PatchSums { count, sum, spread: math::sqrt(variance as f32), limits })
}

/// Sums of the reference under the patch at one shift: Σr, Σr², Σpr.
#[derive(Clone, Copy, Default)]
struct Sums {
    grey: u64,
    squares: u64,
    products: u64,
}

/// Scores of up to [`BLOCK`] shifts from (`col`, `row`) rightwards.
///
/// Two things make it cheap. Σr and Σr² of a run follow from one shift to the next by one pixel in and one out. And
/// four shifts are multiplied at a time, so that every pixel loaded serves four products.
fn correlate_block(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    (col, row): (usize, usize),
    own: &PatchSums,
    scores: &mut [f32],
) {
    let mut sums = [Sums::default(); BLOCK];
    let count = scores.len().min(BLOCK);
    for run in runs {
        let (start, length) = (run.start as usize, (run.end - run.start) as usize);
        let Some(p) = patch.run(run.row as usize, start, length) else { continue };
        // What all shifts of the block see of the row.
        let Some(r) = reference.run(run.row as usize + row, start + col, length + count - 1) else { continue };
        let (mut grey, mut squares) = (0u32, 0u32);
        for &pixel in r.iter().take(length) {
            grey += pixel as u32;
            squares += pixel as u32 * pixel as u32;
        }
        for (shift, sums) in sums.iter_mut().take(count).enumerate() {
            sums.grey += grey as u64;
            sums.squares += squares as u64;
            if let (Some(&out), Some(&next)) = (r.get(shift), r.get(shift + length)) {
                let (out, next) = (out as u32, next as u32);
                grey = grey + next - out;
                squares = squares + next * next - out * out;
            }
        }
        for (four, sums) in sums.chunks_exact_mut(4).enumerate() {
            let shift = 4 * four;
            match r.get(shift..shift + length + 3) {
                Some(r) => {
                    for (sums, products) in sums.iter_mut().zip(products_of_four(p, own.limits, r)) {
                        sums.products += products as u64;
                    }
                }
                // The last shifts of a block that four do not divide.
                None => {
                    for (more, sums) in sums.iter_mut().enumerate().take(count.saturating_sub(shift)) {
                        let products = p
                            .iter()
                            .zip(r.iter().skip(shift + more))
                            .map(|(&p, &r)| own.limits.apply(p) as u32 * r as u32);
                        sums.products += products.sum::<u32>() as u64;
                    }
                }
            }
        }
    }
    for (score, sums) in scores.iter_mut().zip(&sums) {
        *score = correlation(own, sums);
    }
}

/// Σ p r for four neighbouring shifts; `r` holds three pixels more than `p`. A run has at most 8192 pixels, and 8192 x
/// 255² fits 32 bits.
#[inline]
fn products_of_four(p: &[u8], limits: Limits, r: &[u8]) -> [u32; 4] {
    let mut sums = [0u32; 4];
    let (fours, rest) = p.as_chunks::<4>();
    let mut at = 0;
    for four in fours {
        let Some(r) = r.get(at..at + 7) else { return sums };
        for (k, &p) in four.iter().enumerate() {
            let p = limits.apply(p);
            for (shift, sum) in sums.iter_mut().enumerate() {
                *sum += p as u32 * r[k + shift] as u32;
            }
        }
        at += 4;
    }
    for (k, &p) in rest.iter().enumerate() {
        let p = limits.apply(p);
        for (shift, sum) in sums.iter_mut().enumerate() {
            *sum += p as u32 * r.get(at + k + shift).copied().unwrap_or(0) as u32;
        }
    }
    sums
}

/// Normalised cross-correlation; 0 for a reference of one grey.
fn correlation(own: &PatchSums, sums: &Sums) -> f32 {
    let variance = own.count * sums.squares - sums.grey * sums.grey;
    if variance == 0 {
        return 0.0;
    }
    // Both products fit 64 bits unsigned, their difference fits 63 and a sign.
    let covariance = (own.count * sums.products).wrapping_sub(own.sum * sums.grey) as i64;
    covariance as f32 / (own.spread * math::sqrt(variance as f32))
}

/// The plain correlation at a shift of (`d_col`, `d_row`) from the middle of a search of `radius`; 0 outside it.
pub fn plain(patch: &View<'_>, runs: &[Run], reference: &View<'_>, radius: u16, (d_col, d_row): (i16, i16)) -> f32 {
    let shift = |d: i16| usize::try_from(d as i32 + radius as i32);
    let (Ok(col), Ok(row)) = (shift(d_col), shift(d_row)) else { return 0.0 };
    let Ok(own) = patch_sums(patch, runs, Limits::NONE) else { return 0.0 };
    let mut score = [0.0];
    correlate_block(patch, runs, reference, (col, row), &own, &mut score);
    score[0]
}

/// The peak of `scores` as [`search_into`] left them for the same `radius`; `None` when the scores do not belong to
/// the radius.
pub fn peak(scores: &[f32], radius: u16) -> Option<Peak> {
    let side = 2 * radius as usize + 1;
    let scores = scores.get(..side * side)?;
    let centred = |at: usize| at as i16 - radius as i16;
    let at = |index: usize| (centred(index % side), centred(index / side));
    let (mut best, mut score) = (0, f32::NEG_INFINITY);
    for (index, &value) in scores.iter().enumerate() {
        if value > score {
            (best, score) = (index, value);
        }
    }
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
