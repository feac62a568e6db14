//! Sums of the boxes of 2 x 2 and 4 x 4 frame pixels, the two sizes of most flights.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(super) use armv7em::{prefix_fours, prefix_pairs};
#[cfg(not(feature = "dsp"))]
pub(super) use portable::{prefix_fours, prefix_pairs};

/// Whether all rows begin at multiples of four.
fn are_aligned<const N: usize>(rows: [&[u8]; N]) -> bool {
    rows.iter().all(|row| row.as_ptr().addr().is_multiple_of(4))
}

#[cfg(test)]
mod tests {
    use super::{prefix_fours, prefix_pairs};

    #[repr(align(4))]
    struct Row([u8; 45]);

    /// Rows of unrelated pixels.
    fn rows<const N: usize>() -> [Row; N] {
        let pixel = |row: usize, col: usize| ((row * 57 + col * 91 + row * col * 13) ^ 0x55) as u8;
        core::array::from_fn(|row| Row(core::array::from_fn(|col| pixel(row, col))))
    }

    #[test]
    fn pairs_are_rounded_down_and_up() {
        let [Row(a), Row(b)] = rows::<2>();
        let mut sums = [[7, 0]; 24];
        assert_eq!(prefix_pairs([&a, &b], &mut sums).0, 20);
        let mut total = 0;
        for (i, &sum) in sums.iter().enumerate().take(20) {
            let column = |c: usize| (a[c] as i32 + b[c] as i32).div_euclid(2);
            total += (column(2 * i) + column(2 * i + 1) + 1).div_euclid(2) - 128;
            assert_eq!(i16::from_le_bytes(sum) as i32, total, "box {i}");
        }
        assert_eq!(sums[20..], [[7, 0]; 4], "no half four");
    }

    #[test]
    fn fours_are_rounded_down_at_the_end() {
        let rows = rows::<4>();
        let mut sums = [[7, 0]; 12];
        let mut total = 0;
        let (done, last) = prefix_fours(rows.each_ref().map(|row| &row.0[..]), &mut sums);
        for (i, &sum) in sums.iter().enumerate().take(10) {
            total += rows.iter().flat_map(|row| &row.0[4 * i..4 * i + 4]).map(|&p| p as i32 - 128).sum::<i32>();
            assert_eq!(i16::from_le_bytes(sum) as i32, total.div_euclid(16), "box {i}");
        }
        assert_eq!((done, last, &sums[10..]), (10, total, &[[7, 0]; 2][..]));
        assert_eq!(prefix_fours(rows.each_ref().map(|row| &row.0[1..]), &mut sums), (0, 0), "not aligned");
    }
}
