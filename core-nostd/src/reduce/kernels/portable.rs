//! The sums on any machine.

use super::are_aligned;

/// Prefix sums of (mean − 128) over the boxes of 2 x 2 of two rows: `sums[i]` up to and including box `i`, at most 256 of
/// them, little-endian, in groups of four boxes as far as both rows and `sums` reach. Returns how many those are, and 4
/// times the last sum. The mean of two pixels is rounded down between the rows and up along the row, so that on average it
/// is neither.
#[inline(always)]
pub(crate) fn prefix_pairs([a, b]: [&[u8]; 2], sums: &mut [[u8; 2]]) -> (usize, i32) {
    let done = sums.len().min(a.len() / 2).min(b.len() / 2) & !3;
    let mut total = 0i16;
    let pairs = a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0);
    for (sum, ([a0, a1], [b0, b1])) in sums.iter_mut().zip(pairs).take(done) {
        let column = |a: u8, b: u8| (a as i16 + b as i16) >> 1;
        total = total.wrapping_add(((column(*a0, *b0) + column(*a1, *b1) + 1) >> 1) - 128);
        *sum = total.to_le_bytes();
    }
    (done, 4 * total as i32)
}

/// Prefix sums of (mean − 128) over the boxes of 4 x 4 of four rows, rounded down: `sums[i]` up to and including box `i`,
/// at most 256 of them, little-endian, in pairs of boxes as far as all rows and `sums` reach. Returns how many those are,
/// and 16 times the last sum before rounding. None where a row does not begin at a multiple of four.
#[inline(always)]
pub(crate) fn prefix_fours(rows: [&[u8]; 4], sums: &mut [[u8; 2]]) -> (usize, i32) {
    if !are_aligned(rows) {
        return (0, 0);
    }
    let done = rows.iter().fold(sums.len(), |least, row| least.min(row.len() / 4)) & !1;
    let [a, b, c, d] = rows.map(|row| row.as_chunks::<4>().0.iter());
    let boxes = a.zip(b).zip(c).zip(d);
    let mut total = 0;
    for (sum, (((a, b), c), d)) in sums.iter_mut().zip(boxes).take(done) {
        total += [a, b, c, d].into_iter().flatten().map(|&pixel| pixel as i32).sum::<i32>() - 16 * 128;
        *sum = ((total >> 4) as i16).to_le_bytes();
    }
    (done, total)
}
