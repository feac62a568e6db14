//! The products on any machine.

use super::Digits;

/// Adds to `sums[m]` the products of every digit and the signs of `others`, `m` words further on each: a negative byte is
/// 1, others are 0, as are those beyond the end.
#[inline(always)]
pub(crate) fn slide(digits: &Digits, others: &[u8], sums: &mut [i64; 3]) {
    let signs = |at: usize| {
        let byte = |i: usize| others.get(at + i).map_or(0, |&byte| byte >> 7);
        u32::from_le_bytes(core::array::from_fn(byte)) as i64
    };
    let (mut at, mut from) = (0, 0);
    while let Some(&[delta, words]) = digits.stream.get(at..at + 2).filter(|_| at < digits.used) {
        from += delta as i32 as isize;
        let own = digits.stream.get(at + 2..at + 2 + words as usize).unwrap_or(&[]);
        for (start, &own) in (from as usize..).step_by(4).zip(own) {
            for (m, sum) in sums.iter_mut().enumerate() {
                *sum = sum.wrapping_add(own as i32 as i64 * signs(start + 4 * m));
            }
        }
        from += 4 * words as isize + 8;
        at += 2 + words as usize;
    }
}
