//! The instructions themselves.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

use core::arch::asm;

/// `left` itself, though the compiler does not know that: a loop that counts it down is not unrolled. For loops that
/// run rarely, whose copies would take up tightly coupled memory.
#[inline(always)]
pub(crate) fn opaque(left: usize) -> usize {
    let same: usize;
    // SAFETY: no instruction at all.
    unsafe { asm!("/* {} */", inlateout(reg) left => same, options(nomem, nostack, preserves_flags)) }
    same
}

/// Square root (VSQRT).
#[inline(always)]
pub(crate) fn sqrt(value: f32) -> f32 {
    let root: u32;
    // SAFETY: changes registers only, and restores s0, which this target does not accept as an operand.
    unsafe {
        asm!(
            "vmov {kept}, s0",
            "vmov s0, {value}",
            "vsqrt.f32 s0, s0",
            "vmov {value}, s0",
            "vmov s0, {kept}",
            kept = out(reg) _,
            value = inlateout(reg) value.to_bits() => root,
            options(pure, nomem, nostack),
        );
    }
    f32::from_bits(root)
}

/// `sum` plus the four bytes of `word` (USADA8 against zero).
#[inline(always)]
pub(crate) fn add_bytes(word: u32, sum: u32) -> u32 {
    let total: u32;
    // SAFETY: reads and writes registers only.
    unsafe {
        asm!("usada8 {}, {}, {}, {}", lateout(reg) total, in(reg) word, in(reg) 0u32, in(reg) sum,
            options(pure, nomem, nostack, preserves_flags));
    }
    total
}

/// Limits each of four signed bytes to ±`limit`, 1 to 127, by saturating additions and subtractions.
#[inline(always)]
pub(crate) fn clamp_bytes(word: u32, limit: u8) -> u32 {
    let margin = (127 - limit as u32) * 0x0101_0101;
    let result: u32;
    // SAFETY: reads and writes registers only. The lower limit counts from −128,
    // so its margin is one more.
    unsafe {
        asm!(
            "qadd8 {w}, {w}, {margin}",
            "qsub8 {w}, {w}, {margin}",
            "qsub8 {w}, {w}, {more}",
            "qadd8 {w}, {w}, {more}",
            w = inout(reg) word => result,
            margin = in(reg) margin,
            more = in(reg) margin + 0x0101_0101,
            options(pure, nomem, nostack, preserves_flags),
        );
    }
    result
}

/// The differences of both halves, modulo 2^16 (SSUB16).
#[inline(always)]
pub(crate) fn difference(a: u32, b: u32) -> u32 {
    let result: u32;
    // SAFETY: reads and writes registers only.
    unsafe {
        asm!("ssub16 {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b,
            options(pure, nomem, nostack, preserves_flags));
    }
    result
}

/// `sum` plus the products of both halves, modulo 2^32 (SMLAD).
#[inline(always)]
pub(crate) fn dot(a: u32, b: u32, sum: i32) -> i32 {
    let result: i32;
    // SAFETY: reads and writes registers only, and the flag Q, which nothing reads.
    unsafe {
        asm!("smlad {}, {}, {}, {}", lateout(reg) result, in(reg) a, in(reg) b, in(reg) sum,
            options(pure, nomem, nostack, preserves_flags));
    }
    result
}
