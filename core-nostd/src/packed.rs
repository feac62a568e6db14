//! Two 16-bit numbers in one word.

/// One in both halves.
pub(crate) const ONES: u32 = 0x0001_0001;
/// The sign bits of both halves.
pub(crate) const SIGNS: u32 = 0x8000_8000;

/// A word of two numbers, each taken modulo 2^16.
#[inline(always)]
pub(crate) fn pack(low: i32, high: i32) -> u32 {
    (low as u32 & 0xffff) | (high as u32) << 16
}

/// The lower number, with its sign.
#[inline(always)]
pub(crate) fn low(word: u32) -> i32 {
    word as i16 as i32
}

/// The upper number, with its sign.
#[inline(always)]
pub(crate) fn high(word: u32) -> i32 {
    word as i32 >> 16
}

/// The upper number of `first`, then the lower one of `second`.
#[inline(always)]
pub(crate) fn across(first: u32, second: u32) -> u32 {
    first >> 16 | second << 16
}

/// Bytes 0 and 2 of a word, then 1 and 3, without sign.
#[inline(always)]
pub(crate) fn bytes(word: u32) -> [u32; 2] {
    const EVEN: u32 = 0x00ff_00ff;
    [word & EVEN, (word >> 8) & EVEN]
}

#[cfg(test)]
mod tests {
    use super::{across, bytes, high, low, pack};
    use crate::arch::{add_bytes, clamp_bytes, difference, dot};

    #[test]
    fn both_numbers_keep_their_signs() {
        let (a, b) = (pack(-3, 32_767), pack(-32_768, 5));
        assert_eq!((low(a), high(a), low(b), high(b)), (-3, 32_767, -32_768, 5));
        assert_eq!(dot(a, b, 7), 7 + 3 * 32_768 + 5 * 32_767);
        assert_eq!(dot(b, b, i32::MAX), i32::MAX.wrapping_add(1 << 30).wrapping_add(25));
        assert_eq!(difference(pack(3, -4), pack(5, -9)), pack(-2, 5), "nothing is borrowed across");
        assert_eq!(across(a, b), pack(32_767, -32_768));
    }

    #[test]
    fn bytes_are_parted() {
        let word = u32::from_le_bytes([1, 255, 128, 127]);
        assert_eq!(bytes(word), [pack(1, 128), pack(255, 127)]);
    }

    #[test]
    fn four_bytes_are_added() {
        assert_eq!(add_bytes(u32::from_le_bytes([1, 200, 255, 127]), 10), 10 + 1 + 200 + 255 + 127);
    }

    #[test]
    fn bytes_are_limited_on_both_sides() {
        for limit in [1, 5, 126, 127] {
            for value in i8::MIN..=i8::MAX {
                let word = clamp_bytes(u32::from_le_bytes([value as u8, 0, value as u8, 1]), limit).to_le_bytes();
                let limit = limit as i8;
                assert_eq!(word.map(|byte| byte as i8), [value, 0, value, 1].map(|v| v.clamp(-limit, limit)));
            }
        }
    }
}
