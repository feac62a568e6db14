//! Smoothing by the cubic B-spline.
//!
//! A row of trees or houses finer than two pixels shows in patch and reference as different patterns, since their pixels
//! lie differently on it; a least-squares match would follow those. The B-spline's own samples (1 4 1)/6 along each axis
//! take most of them off the patch, and reading the reference by the same spline takes them off the reference at no cost:
//! an interpolation has to weigh 4 x 4 pixels anyway.

use super::View;
use super::detail::overlapping;
use crate::rectify::Run;
use core::ops::Range;

/// The patch smoothed, into `pixels`, where the 3 x 3 around a pixel is valid; the rest keeps what was there. `None`
/// when it does not fit.
pub(super) fn smooth_into<'b>(patch: &View<'_>, runs: &[Run], pixels: &'b mut [u8]) -> Option<View<'b>> {
    let (cols, rows) = patch.size();
    let stride = cols as usize;
    pixels.get(..stride * rows as usize)?;
    for index in 0..runs.len() {
        let Some((row, inner)) = inner(runs, index, 1) else { continue };
        let (start, length) = (inner.start as usize, inner.len());
        let line = |row: usize| patch.run(row, start - 1, length + 2);
        let (Some(above), Some(own), Some(below)) = (line(row - 1), line(row), line(row + 1)) else { continue };
        let Some(smoothed) = pixels.get_mut(row * stride + start..row * stride + start + length) else { continue };
        let column = |col: usize| above[col] as u32 + 4 * own[col] as u32 + below[col] as u32;
        for (col, smoothed) in smoothed.iter_mut().enumerate() {
            *smoothed = ((column(col) + 4 * column(col + 1) + column(col + 2) + 18) / 36) as u8;
        }
    }
    View::new(pixels, patch.size())
}

/// Row and columns of `runs[index]` whose neighbours up to `reach` pixels away are valid too; `None` where there are
/// none.
pub(super) fn inner(runs: &[Run], index: usize, reach: u16) -> Option<(usize, Range<u16>)> {
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

/// Value of the cubic B-spline over `reference` at (`u`, `v`); `None` where its 4 x 4 pixels leave it.
#[inline(always)]
pub(super) fn spline(reference: &View<'_>, u: f32, v: f32) -> Option<f32> {
    if !(u >= 1.0 && v >= 1.0) {
        return None;
    }
    // Positive, so that truncation is the floor.
    let (col, row) = (u as usize, v as usize);
    let (across, down) = (weights(u - col as f32), weights(v - row as f32));
    let mut sum = 0.0;
    for (down, r) in down.iter().zip(reference.four_by_four(row - 1, col - 1)?) {
        sum += down
            * (across[0] * r[0] as f32 + across[1] * r[1] as f32 + across[2] * r[2] as f32 + across[3] * r[3] as f32);
    }
    Some(sum)
}

/// The four weights of the uniform cubic B-spline at the fraction `t`.
#[inline(always)]
fn weights(t: f32) -> [f32; 4] {
    let (t2, rest) = (t * t, 1.0 - t);
    let (first, last) = (rest * rest * rest * (1.0 / 6.0), t2 * t * (1.0 / 6.0));
    let second = 2.0 / 3.0 + t2 * (0.5 * t - 1.0);
    [first, second, 1.0 - first - second - last, last]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u16, u16) = (12, 9);

    fn plane(col: usize, row: usize) -> u8 {
        (40 + 7 * col + 5 * row) as u8
    }

    /// A plane is smoothed to itself, and read anywhere without error.
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
        for (u, v) in [(1.0, 1.0), (4.3, 2.7), (9.99, 6.5)] {
            let value = spline(&view, u, v).unwrap();
            assert!((value - (40.0 + 7.0 * u + 5.0 * v)).abs() < 1e-4, "({u}, {v}): {value}");
        }
        assert!(spline(&view, 0.9, 3.0).is_none() && spline(&view, 4.0, 7.0).is_none());
    }

    /// At whole pixels the spline reads (1 4 1)/6 along each axis: what the patch is smoothed by.
    #[test]
    fn patch_and_reference_are_smoothed_alike() {
        let pixels: [u8; 108] = core::array::from_fn(|i| (i * 97 % 251) as u8);
        let view = View::new(&pixels, SIZE).unwrap();
        let runs: [Run; 9] = core::array::from_fn(|row| Run { row: row as u16, start: 0, end: 12 });
        let mut smoothed = [0; 108];
        let smoothed = smooth_into(&view, &runs, &mut smoothed).unwrap();
        for (col, row) in [(1, 1), (5, 4), (9, 6)] {
            let value = spline(&view, col as f32, row as f32).unwrap();
            assert!((value - smoothed.run(row, col, 1).unwrap()[0] as f32).abs() <= 0.5);
        }
    }

    #[test]
    fn the_inner_part_has_valid_neighbours() {
        let runs = [(0, 2, 9), (1, 1, 9), (2, 0, 5), (2, 6, 12), (3, 3, 12)];
        let runs = runs.map(|(row, start, end)| Run { row, start, end });
        assert_eq!(inner(&runs, 1, 1), Some((1, 3..4)));
        assert_eq!(inner(&runs, 0, 1), None);
        assert_eq!(inner(&runs, 3, 1), Some((2, 7..8)));
    }
}
