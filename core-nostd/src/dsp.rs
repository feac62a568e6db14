//! Packed arithmetic of Armv7E-M, and a twin with the same bits for every other machine.
//!
//! The compiler does not find such instructions by itself. Whether the machine has them is said by the feature `dsp`:
//! the target's own name does not tell.

/// `sum` plus the four bytes of `word` (USADA8 against zero).
#[inline(always)]
pub fn add_bytes(word: u32, sum: u32) -> u32 {
    #[cfg(feature = "dsp")]
    {
        let total: u32;
        // SAFETY: reads and writes registers only.
        unsafe {
            core::arch::asm!("usada8 {}, {}, {}, {}", lateout(reg) total, in(reg) word, in(reg) 0u32, in(reg) sum,
                options(pure, nomem, nostack, preserves_flags));
        }
        total
    }
    #[cfg(not(feature = "dsp"))]
    {
        word.to_le_bytes().iter().fold(sum, |sum, &byte| sum.wrapping_add(byte as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_bytes_are_added() {
        assert_eq!(add_bytes(u32::from_le_bytes([1, 200, 255, 127]), 10), 10 + 1 + 200 + 255 + 127);
    }
}
