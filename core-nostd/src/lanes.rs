//! Two 16-bit numbers in a word, and the instructions of Armv7E-M that work on both at once.
//!
//! The twins give the same bits on every other machine; the feature `dsp` chooses, as in [`crate::dsp`].

pub mod pairs;

/// One in both halves.
pub const ONES: u32 = 0x0001_0001;
/// The sign of both halves.
pub const SIGNS: u32 = 0x8000_8000;

/// A word of two numbers, each taken modulo 2^16.
#[inline(always)]
pub fn pack(low: i32, high: i32) -> u32 {
    (low as u32 & 0xffff) | (high as u32) << 16
}

/// The lower number, with its sign.
#[inline(always)]
pub fn low(word: u32) -> i32 {
    word as i16 as i32
}

/// The upper number, with its sign.
#[inline(always)]
pub fn high(word: u32) -> i32 {
    word as i32 >> 16
}

/// The upper number of `first`, then the lower one of `second`.
#[inline(always)]
pub fn across(first: u32, second: u32) -> u32 {
    first >> 16 | second << 16
}

/// Bytes 0 and 2 of a word, then 1 and 3, without sign.
#[inline(always)]
pub fn bytes(word: u32) -> [u32; 2] {
    const EVEN: u32 = 0x00ff_00ff;
    [word & EVEN, (word >> 8) & EVEN]
}

/// The same with sign (SXTB16).
#[inline(always)]
pub fn signed_bytes(word: u32) -> [u32; 2] {
    #[cfg(feature = "dsp")]
    {
        let (even, odd): (u32, u32);
        // SAFETY: reads and writes registers only.
        unsafe {
            core::arch::asm!("sxtb16 {}, {}", lateout(reg) even, in(reg) word, options(pure, nomem, nostack, preserves_flags));
            core::arch::asm!("sxtb16 {}, {}, ror #8", lateout(reg) odd, in(reg) word,
                options(pure, nomem, nostack, preserves_flags));
        }
        [even, odd]
    }
    #[cfg(not(feature = "dsp"))]
    {
        let [a, b, c, d] = word.to_le_bytes().map(|byte| byte as i8 as i32);
        [pack(a, c), pack(b, d)]
    }
}

/// The differences of both numbers, modulo 2^16 (SSUB16).
#[inline(always)]
pub fn difference(a: u32, b: u32) -> u32 {
    #[cfg(feature = "dsp")]
    {
        let result: u32;
        // SAFETY: reads and writes registers only.
        unsafe {
            core::arch::asm!("ssub16 {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b,
                options(pure, nomem, nostack, preserves_flags));
        }
        result
    }
    #[cfg(not(feature = "dsp"))]
    {
        pack(low(a) - low(b), high(a) - high(b))
    }
}

/// `sum` plus the products of both numbers, modulo 2^32 (SMLAD).
#[inline(always)]
pub fn dot(a: u32, b: u32, sum: i32) -> i32 {
    #[cfg(feature = "dsp")]
    {
        let result: i32;
        // SAFETY: reads and writes registers only, and the flag Q, which nothing reads.
        unsafe {
            core::arch::asm!("smlad {}, {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b, in(reg) sum,
                options(pure, nomem, nostack, preserves_flags));
        }
        result
    }
    #[cfg(not(feature = "dsp"))]
    {
        sum.wrapping_add(low(a) * low(b)).wrapping_add(high(a) * high(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(signed_bytes(word), [pack(1, -128), pack(-1, 127)]);
    }
}
