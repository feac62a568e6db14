//! The filter on any machine.

use super::{SIDE, WIDTH};

/// Each pixel less the mean of the 5 x 5 around it, in steps of 0.16 (a quarter of 25 times the difference), rounded to
/// nearest.
///
/// `rows`: the five rows around, aligned to four, in any order, `own` the middle one; each begins two columns before the
/// pixels. `first`: the first pixel, divided by four; `out`: four pixels each, as signed bytes, limited to what they hold.
#[inline(always)]
pub(crate) fn high_pass(rows: &[[u8; WIDTH]; SIDE], own: usize, first: usize, out: &mut [[u8; 4]]) {
    let count = out.len().min((WIDTH / 4 - 2).saturating_sub(first));
    let own = own % SIDE;
    for (word, out) in (first..).zip(out.iter_mut().take(count)) {
        *out = core::array::from_fn(|i| {
            let at = 4 * word + i;
            let sum: i32 = rows.iter().flat_map(|row| &row[at..at + SIDE]).map(|&pixel| pixel as i32).sum();
            let difference = (SIDE * SIDE) as i32 * rows[own][at + SIDE / 2] as i32 + 2 - sum;
            (difference.clamp(-512, 511) >> 2) as u8
        });
    }
}
