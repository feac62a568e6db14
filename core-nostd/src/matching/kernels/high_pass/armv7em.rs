//! The filter by packed instructions.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

#[cfg(doc)]
use super::portable;
use super::{SIDE, WIDTH};
use core::arch::asm;

/// [`portable::high_pass`], four pixels a turn.
#[inline(always)]
pub(crate) fn high_pass(rows: &[[u8; WIDTH]; SIDE], own: usize, first: usize, out: &mut [[u8; 4]]) {
    let count = out.len().min((WIDTH / 4 - 2).saturating_sub(first));
    let own = own % SIDE;
    if count > 0 {
        // SAFETY: each turn reads a word of every row, one beyond the pixels at most, and writes one of `out`: `count`
        // keeps both within, and `first` lies in a row since `count` is not 0.
        unsafe {
            asm!(
                // Sums of the columns 0 and 2, then with 1 and 3 added: pairs of neighbours.
                "ldr {t}, [{rows}], #4",
                "uxtb16 {even}, {t}",
                "uxtb16 {pairs}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w1}]",
                "uxtab16 {even}, {even}, {t}",
                "uxtab16 {pairs}, {pairs}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w2}]",
                "uxtab16 {even}, {even}, {t}",
                "uxtab16 {pairs}, {pairs}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w3}]",
                "uxtab16 {even}, {even}, {t}",
                "uxtab16 {pairs}, {pairs}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w4}]",
                "uxtab16 {even}, {even}, {t}",
                "uxtab16 {pairs}, {pairs}, {t}, ror #8",
                "add {pairs}, {pairs}, {even}",
                "2:",
                "ldr {t}, [{rows}], #4",
                "uxtb16 {e}, {t}",
                "uxtb16 {o}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w1}]",
                "uxtab16 {e}, {e}, {t}",
                "uxtab16 {o}, {o}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w2}]",
                "uxtab16 {e}, {e}, {t}",
                "uxtab16 {o}, {o}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w3}]",
                "uxtab16 {e}, {e}, {t}",
                "uxtab16 {o}, {o}, {t}, ror #8",
                "ldr {t}, [{rows}, #{w4}]",
                "uxtab16 {e}, {e}, {t}",
                "uxtab16 {o}, {o}, {t}, ror #8",
                // Around the first and third pixel: columns 0 to 4 and 2 to 6, pair by pair.
                "lsr {t}, {pairs}, #16",
                "add {pairs}, {pairs}, {e}",
                "add {t}, {t}, {e}, lsl #16",
                "add {t}, {t}, {o}, lsl #16",
                "add {pairs}, {pairs}, {t}",
                // Around the second and fourth: one column less, one more.
                "sub {even}, {o}, {even}",
                "add {t}, {pairs}, {even}",
                "mov {even}, {e}",
                "add {o}, {e}, {o}",
                "ldr {e}, [{own}], #4",
                // 25 times the pixels, two to make the quarter round, less the sums.
                "uxtb16 {p}, {e}",
                "uxtb16 {e}, {e}, ror #8",
                "mla {p}, {p}, {area}, {round}",
                "mla {e}, {e}, {area}, {round}",
                "ssub16 {p}, {p}, {pairs}",
                "ssub16 {e}, {e}, {t}",
                "ssat16 {p}, #10, {p}",
                "ssat16 {e}, #10, {e}",
                "mov {pairs}, {o}",
                "lsr {p}, {p}, #2",
                "lsl {e}, {e}, #6",
                "and {p}, {p}, #0x00ff00ff",
                "and {e}, {e}, #0xff00ff00",
                "orr {p}, {p}, {e}",
                "str {p}, [{out}], #4",
                "subs {n}, #1",
                "bne 2b",
                w1 = const WIDTH - 4,
                w2 = const 2 * WIDTH - 4,
                w3 = const 3 * WIDTH - 4,
                w4 = const 4 * WIDTH - 4,
                rows = inout(reg) rows.as_flattened().as_ptr().add(4 * first) => _,
                own = inout(reg) rows.as_flattened().as_ptr().add(own * WIDTH + 4 * first + 2) => _,
                out = inout(reg) out.as_mut_ptr() => _,
                n = inout(reg) count => _,
                area = in(reg) (SIDE * SIDE) as u32,
                round = in(reg) 0x0002_0002u32,
                even = out(reg) _,
                pairs = out(reg) _,
                e = out(reg) _,
                o = out(reg) _,
                p = out(reg) _,
                t = out(reg) _,
                options(nostack),
            );
        }
    }
}
