//! Correlation of the greys themselves: the figure that other matchers report, and that no decision hangs on.

use super::kernels::correlation::moments;
use crate::image::{Run, View};
use crate::math;

/// Normalised cross-correlation of the greys themselves at a shift of (`d_col`, `d_row`) from the middle of a search of
/// `radius`, 0 outside the reference and for pictures of one grey.
pub fn grey_correlation(
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
