//! The products by long multiplications.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

use super::{Digits, portable};
use core::arch::asm;

/// [`portable::slide`].
///
/// One multiplication makes sixteen products and adds up those of equal shift, each in a digit of its own, seven shifts
/// in all: 0.15 instructions a product.
#[inline(always)]
pub(crate) fn slide(digits: &Digits, others: &[u8], sums: &mut [i64; 3]) {
    // LDRD traps on addresses that are no multiples of four.
    let is_aligned = others.as_ptr().addr().is_multiple_of(4);
    if digits.used == 0 || others.len() < digits.reach || !is_aligned {
        return portable::slide(digits, others, sums);
    }
    let mut halves = sums.map(|sum| (sum as u32, (sum >> 32) as u32));
    // SAFETY: reads the stream up to its end, which `add` set, and `others` up to `reach`, which was checked. `others`
    // begins at a word and `add` takes starts of words only, as LDRD wants them.
    unsafe {
        asm!(
            "ldrd {w}, {n}, [{p}], #8",
            "3:",
            "add {r}, {r}, {w}",
            "ldrd {a}, {b}, [{r}], #8",
            "lsr {a}, #7",
            "lsr {b}, #7",
            "and {a}, #0x01010101",
            "and {b}, #0x01010101",
            "2:",
            "ldrd {w}, {v}, [{p}], #8",
            "smlal {l0}, {h0}, {w}, {a}",
            "smlal {l1}, {h1}, {w}, {b}",
            "smlal {l0}, {h0}, {v}, {b}",
            "ldrd {a}, {b}, [{r}], #8",
            "subs {n}, #2",
            "lsr {a}, #7",
            "lsr {b}, #7",
            "and {a}, #0x01010101",
            "and {b}, #0x01010101",
            "smlal {l2}, {h2}, {w}, {a}",
            "smlal {l1}, {h1}, {v}, {a}",
            "smlal {l2}, {h2}, {v}, {b}",
            "bne 2b",
            "ldrd {w}, {n}, [{p}], #8",
            "cmp {n}, #0",
            "bne 3b",
            p = inout(reg) digits.stream.as_ptr() => _,
            r = inout(reg) others.as_ptr() => _,
            n = out(reg) _,
            w = out(reg) _,
            v = out(reg) _,
            a = out(reg) _,
            b = out(reg) _,
            l0 = inout(reg) halves[0].0,
            h0 = inout(reg) halves[0].1,
            l1 = inout(reg) halves[1].0,
            h1 = inout(reg) halves[1].1,
            l2 = inout(reg) halves[2].0,
            h2 = inout(reg) halves[2].1,
            options(readonly, nostack),
        );
    }
    *sums = halves.map(|(low, high)| ((high as u64) << 32 | low as u64) as i64);
}
