//! Smoothing by the cubic B-spline.
//!
//! Texture finer than two pixels, such as a row of trees or houses, is aliased differently in patch and reference; a
//! least-squares match would follow that. The B-spline's own samples (1 4 1)/6 along each axis remove most of it from
//! the patch, and interpolating the reference with the same spline removes it there at no cost: an interpolation
//! weights 4 x 4 pixels anyway.
use crate::image::{Run, View};
use crate::packed::{across, bytes};
use core::ops::Range;

/// The patch smoothed, into `pixels`, at pixels whose 3 x 3 is valid; the others are left unchanged. `None` if it does
/// not fit.
// Inlined, as [`super::estimate::Estimate::new`].
#[inline(always)]
pub(in crate::matching) fn smooth_into<'b>(patch: &View<'_>, runs: &[Run], pixels: &'b mut [u8]) -> Option<View<'b>> {
    let (cols, rows) = patch.size();
    let stride = cols as usize;
    pixels.get(..stride * rows as usize)?;
    for index in 0..runs.len() {
        let Some((row, inner)) = inner::<3>(runs, index) else { continue };
        let (start, length) = (inner.start as usize, inner.len());
        let line = |row: usize| patch.run(row, start - 1, length + 2);
        let (Some(above), Some(own), Some(below)) = (line(row - 1), line(row), line(row + 1)) else { continue };
        let Some(smoothed) = pixels.get_mut(row * stride + start..row * stride + start + length) else { continue };
        smooth_row(above, own, below, smoothed);
    }
    View::new(pixels, patch.size())
}

/// Smooths a row, from three rows that begin one pixel before `smoothed` and end one after it.
#[inline(never)]
fn smooth_row(above: &[u8], own: &[u8], below: &[u8], smoothed: &mut [u8]) {
    // Columns 0 and 2 of each four, then 1 and 3: at most 6 x 255 in each half of a word.
    let fours = above.as_chunks::<4>().0.iter().zip(own.as_chunks::<4>().0).zip(below.as_chunks::<4>().0);
    let mut columns = fours.map(|((above, own), below)| {
        let [a, o, b] = [above, own, below].map(|four| bytes(u32::from_le_bytes(*four)));
        [a[0] + 4 * o[0] + b[0], a[1] + 4 * o[1] + b[1]]
    });
    let mut done = 0;
    if let Some([mut even, mut odd]) = columns.next() {
        for ([next_even, next_odd], four) in columns.zip(smoothed.as_chunks_mut::<4>().0) {
            let (evens, odds) = (across(even, next_even), across(odd, next_odd));
            let (first, second) = (even + 4 * odd + evens, odd + 4 * evens + odds);
            let parts = [first & 0xffff, second & 0xffff, first >> 16, second >> 16];
            *four = parts.map(thirty_sixth);
            (even, odd) = (next_even, next_odd);
            done += 4;
        }
    }
    let columns = above.iter().zip(own).zip(below).skip(done);
    let mut columns = columns.map(|((&a, &o), &b)| a as u32 + 4 * o as u32 + b as u32);
    let (Some(mut left), Some(mut middle)) = (columns.next(), columns.next()) else { return };
    for (smoothed, right) in smoothed.iter_mut().skip(done).zip(columns) {
        *smoothed = thirty_sixth(left + 4 * middle + right);
        (left, middle) = (middle, right);
    }
}

/// A thirty-sixth, rounded to the nearest: exact for every sum of 36 bytes.
#[inline(always)]
fn thirty_sixth(sum: u32) -> u8 {
    (((sum + 18) * 7282) >> 18) as u8
}

/// Row and columns of `runs[index]` around which `ROWS` rows and columns, an odd number, are valid; `None` if there are
/// none.
pub(super) fn inner<const ROWS: usize>(runs: &[Run], index: usize) -> Option<(usize, Range<u16>)> {
    let reach = ROWS as u16 / 2;
    if let Some(common) = stack::<ROWS>(runs, index) {
        let (start, end) = (common.start + reach, common.end.checked_sub(reach)?);
        return (start < end).then_some((common.row as usize, start..end));
    }
    let run = runs.get(index)?;
    let (mut start, mut end) = (run.start, run.end);
    let row = run.row as i32;
    for other in (row - reach as i32..=row + reach as i32).filter(|&other| other != row) {
        let other = overlapping(runs, index, other)?;
        (start, end) = (start.max(other.start), end.min(other.end));
    }
    let (start, end) = (start + reach, end.checked_sub(reach)?);
    (start < end).then_some((run.row as usize, start..end))
}

/// The columns common to the `ROWS` runs around `runs[index]`, if each is the only one of its row.
fn stack<const ROWS: usize>(runs: &[Run], index: usize) -> Option<Run> {
    let first = index.checked_sub(ROWS / 2)?;
    let stack = runs.get(first..)?.first_chunk::<ROWS>()?;
    let mut common = *stack.first()?;
    let mut row = common.row;
    for run in &stack[1..] {
        row = row.wrapping_add(1);
        if run.row != row {
            return None;
        }
        common.start = common.start.max(run.start);
        common.end = common.end.min(run.end);
    }
    let top = core::mem::replace(&mut common.row, row.wrapping_sub(ROWS as u16 / 2));
    let before = first.checked_sub(1).and_then(|before| runs.get(before));
    let behind = runs.get(first + ROWS);
    (before.is_none_or(|run| run.row < top) && behind.is_none_or(|run| run.row > row)).then_some(common)
}

/// Resolution of the spline's positions, parts of a pixel.
pub(super) const FRACTIONS: i32 = 256;

/// Weights of the uniform cubic B-spline at `fraction` 0 to 255 of [`FRACTIONS`], for the pixels from one before to two
/// after; their sum is [`FRACTIONS`]. The outer two are rounded; the inner two make the first moment exact, so that
/// rounding widens the spline a little but never shifts it.
#[inline(always)]
pub(super) fn weights(fraction: i32) -> [i32; 4] {
    let sixth = |t: i32| ((t * t * t + 3 * FRACTIONS * FRACTIONS) as u32 / (6 * FRACTIONS * FRACTIONS) as u32) as i32;
    let (first, last) = (sixth(FRACTIONS - fraction), sixth(fraction));
    let third = fraction + first - 2 * last;
    [first, FRACTIONS - first - third - last, third, last]
}

/// The run of `row` that overlaps `runs[index]` most; `runs` are sorted by row.
fn overlapping(runs: &[Run], index: usize, row: i32) -> Option<Run> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u16, u16) = (12, 9);

    fn plane(col: usize, row: usize) -> u8 {
        (40 + 7 * col + 5 * row) as u8
    }

    /// A plane is smoothed to itself.
    #[test]
    fn a_plane_stays_a_plane() {
        let pixels: [u8; 108] = core::array::from_fn(|i| plane(i % 12, i / 12));
        let view = View::new(&pixels, SIZE).unwrap();
        let runs: [Run; 9] = core::array::from_fn(|row| Run { row: row as u16, start: 1, end: 11 });
        let mut smoothed = [0; 108];
        smooth_into(&view, &runs, &mut smoothed).unwrap();
        for (i, &grey) in smoothed.iter().enumerate() {
            let (col, row) = (i % 12, i / 12);
            let inside = (2..10).contains(&col) && (1..8).contains(&row);
            assert_eq!(grey, if inside { plane(col, row) } else { 0 }, "({col}, {row})");
        }
    }

    #[test]
    fn a_thirty_sixth_is_rounded_to_nearest() {
        for sum in 0..=255 * 36u32 {
            assert_eq!(thirty_sixth(sum) as u32, (sum + 18) / 36, "{sum}");
        }
    }

    /// Whole words and what is left of a row.
    #[test]
    fn every_pixel_of_a_row_is_smoothed() {
        let rows: [[u8; 16]; 3] = core::array::from_fn(|r| core::array::from_fn(|c| (r * 83 + c * c * 29) as u8));
        for length in 0..=14 {
            let mut smoothed = [7; 14];
            let [above, own, below] = rows.each_ref().map(|row| &row[..length + 2]);
            smooth_row(above, own, below, &mut smoothed[..length]);
            for (col, &grey) in smoothed.iter().enumerate() {
                let column = |c: usize| rows[0][c] as u32 + 4 * rows[1][c] as u32 + rows[2][c] as u32;
                let sum = column(col) + 4 * column(col + 1) + column(col + 2);
                assert_eq!(grey as u32, if col < length { (sum + 18) / 36 } else { 7 }, "{col} of {length}");
            }
        }
    }

    /// The spline's four weights, to two steps of 256; sum and first moment exact.
    #[test]
    fn weights_are_the_splines() {
        for fraction in 0..FRACTIONS {
            let t = fraction as f64 / FRACTIONS as f64;
            let spline = [
                (1.0 - t).powi(3) / 6.0,
                2.0 / 3.0 - t * t + 0.5 * t.powi(3),
                2.0 / 3.0 - (1.0 - t).powi(2) + 0.5 * (1.0 - t).powi(3),
                t.powi(3) / 6.0,
            ];
            let weights = weights(fraction);
            for (weight, exact) in weights.iter().zip(spline) {
                assert!((*weight as f64 - FRACTIONS as f64 * exact).abs() < 2.0, "{fraction}: {weights:?}");
            }
            assert_eq!(weights.iter().sum::<i32>(), FRACTIONS);
            assert_eq!(weights[2] + 2 * weights[3] - weights[0], fraction, "{fraction}: {weights:?}");
        }
    }

    #[test]
    fn the_inner_part_has_valid_neighbours() {
        let runs = [(0, 2, 9), (1, 1, 9), (2, 0, 5), (2, 6, 12), (3, 3, 12)];
        let runs = runs.map(|(row, start, end)| Run { row, start, end });
        assert_eq!(inner::<3>(&runs, 1), Some((1, 3..4)));
        assert_eq!(inner::<3>(&runs, 0), None);
        assert_eq!(inner::<3>(&runs, 3), Some((2, 7..8)));
    }
}
