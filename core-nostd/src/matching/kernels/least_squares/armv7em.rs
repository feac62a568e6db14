//! The loops whole: the compiler would not keep their numbers in the registers that there are.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

#[cfg(doc)]
use super::portable;
use super::{Pair, Weighing};
use crate::packed::{high, low};
use core::arch::asm;

/// [`portable::weighed_products`].
#[inline(always)]
pub(crate) fn weighed_products(pairs: &[Pair]) -> [i32; 6] {
    let [mut xx, mut xy, mut xp, mut yy, mut yp, mut pp] = [0i32; 6];
    if !pairs.is_empty() {
        // SAFETY: each turn reads a pair, as long as there is one. What is
        // pushed is the compiler's own again at the end.
        unsafe {
            asm!(
                "push {{r6, r7}}",
                "mov r7, #0",
                "2:",
                "ldm r0, {{r2, r3, r4, r5}}",
                "add r0, #24",
                "smulbb r6, r2, r5",
                "smultt lr, r2, r5",
                "pkhbt r6, r6, lr, lsl #16",
                "smlad r8, r6, r2, r8",
                "smulbb lr, r3, r5",
                "smlad r9, r6, r3, r9",
                "smultt r2, r3, r5",
                "smlad r10, r6, r4, r10",
                "pkhbt lr, lr, r2, lsl #16",
                "smulbb r6, r4, r5",
                "smultt r2, r4, r5",
                "smlad r11, lr, r3, r11",
                "pkhbt r6, r6, r2, lsl #16",
                "smlad r12, lr, r4, r12",
                "cmp r0, r1",
                "smlad r7, r6, r4, r7",
                "bne 2b",
                "mov r0, r7",
                "pop {{r6, r7}}",
                inout("r0") pairs.as_ptr() => pp,
                in("r1") pairs.as_ptr_range().end,
                out("r2") _,
                out("r3") _,
                out("r4") _,
                out("r5") _,
                out("lr") _,
                inout("r8") xx,
                inout("r9") xy,
                inout("r10") xp,
                inout("r11") yy,
                inout("r12") yp,
            );
        }
    }
    [xx, xy, xp, yy, yp, pp]
}

/// [`portable::weighed_sums`].
#[inline(always)]
pub(crate) fn weighed_sums(pairs: &[Pair]) -> [i32; 9] {
    let [mut x, mut y, mut p, mut xe, mut ye, mut pe, mut e, mut ee] = [0i32; 8];
    let mut w = 0u32;
    if !pairs.is_empty() {
        // SAFETY: each turn reads a pair, as long as there is one. What is
        // pushed is the compiler's own again at the end.
        unsafe {
            asm!(
                "push {{r1, r6, r7}}",
                "mov r7, #0",
                "2:",
                "ldm r0!, {{r1, r2, r3, r6}}",
                "smlad r4, r1, r6, r4",
                "smlad r5, r2, r6, r5",
                "smlad r8, r3, r6, r8",
                "add r9, r9, r6",
                "ldr r6, [r0], #8",
                "smlad r10, r1, r6, r10",
                "ldr r1, [r0, #-4]",
                "smlad r11, r2, r6, r11",
                "ldr r2, [sp]",
                "smlad r12, r3, r6, r12",
                "sxtah lr, lr, r6",
                "smlad r7, r6, r1, r7",
                "cmp r0, r2",
                "add lr, lr, r6, asr #16",
                "bne 2b",
                "mov r0, r7",
                "pop {{r1, r6, r7}}",
                inout("r0") pairs.as_ptr() => ee,
                inout("r1") pairs.as_ptr_range().end => _,
                out("r2") _,
                out("r3") _,
                inout("r4") x,
                inout("r5") y,
                inout("r8") p,
                inout("r9") w,
                inout("r10") xe,
                inout("r11") ye,
                inout("r12") pe,
                inout("lr") e,
            );
        }
    }
    [x, y, p, low(w) + high(w), xe, ye, pe, e, ee]
}

/// [`portable::weigh_rows`].
#[inline(always)]
pub(crate) fn weigh_rows(pixels: &[u8], stride: usize, weights: [u32; 4], out: &mut [[u32; 2]]) -> Option<()> {
    let needed = stride.checked_mul(3)?.checked_add(4 * out.len())?;
    if pixels.len() < needed {
        return None;
    }
    if !out.is_empty() {
        // SAFETY: each turn reads four bytes of all rows, which were checked to have as many as `out` words, and writes two
        // words, as long as there are any.
        unsafe {
            asm!(
                "2:",
                "ldr {t}, [{p}]",
                "uxtb16 {e}, {t}",
                "uxtb16 {o}, {t}, ror #8",
                "ldr {t}, [{p}, {s}]",
                "mul {e}, {e}, {w0}",
                "mul {o}, {o}, {w0}",
                "uxtb16 {u}, {t}",
                "uxtb16 {t}, {t}, ror #8",
                "mla {e}, {u}, {w1}, {e}",
                "mla {o}, {t}, {w1}, {o}",
                "ldr {t}, [{p}, {s}, lsl #1]",
                "uxtb16 {u}, {t}",
                "uxtb16 {t}, {t}, ror #8",
                "mla {e}, {u}, {w2}, {e}",
                "mla {o}, {t}, {w2}, {o}",
                "add {t}, {p}, {s}",
                "ldr {t}, [{t}, {s}, lsl #1]",
                "add {p}, #4",
                "uxtb16 {u}, {t}",
                "uxtb16 {t}, {t}, ror #8",
                "mla {e}, {u}, {w3}, {e}",
                "mla {o}, {t}, {w3}, {o}",
                "subs {n}, #1",
                "eor {e}, #0x80008000",
                "eor {o}, #0x80008000",
                "pkhbt {t}, {e}, {o}, lsl #16",
                "pkhtb {u}, {o}, {e}, asr #16",
                "strd {t}, {u}, [{out}], #8",
                "bne 2b",
                p = inout(reg) pixels.as_ptr() => _,
                s = in(reg) stride,
                w0 = in(reg) weights[0],
                w1 = in(reg) weights[1],
                w2 = in(reg) weights[2],
                w3 = in(reg) weights[3],
                out = inout(reg) out.as_mut_ptr() => _,
                n = inout(reg) out.len() => _,
                e = out(reg) _,
                o = out(reg) _,
                t = out(reg) _,
                u = out(reg) _,
                options(nostack),
            );
        }
    }
    Some(())
}

/// The instructions that give the residuals r11 and r12 of a pair their weights and store all at r0 + `$at`.
macro_rules! weigh {
    ($we:literal, $e:literal) => {
        concat!(
            "ssat r11, #13, r11, asr #12\n",
            "ssat r12, #13, r12, asr #12\n",
            "ldrd r10, lr, [sp, #16]\n",
            "mul r8, r11, r10\n",
            "mul r9, r12, r10\n",
            "ssat r8, #8, r8, asr #16\n",
            "ssat r9, #8, r9, asr #16\n",
            "ldrb r8, [lr, r8]\n",
            "ldrb r9, [lr, r9]\n",
            "pkhbt r10, r11, r12, lsl #16\n",
            "smulbb r11, r11, r8\n",
            "smulbb r12, r12, r9\n",
            "pkhbt r8, r8, r9, lsl #16\n",
            "pkhbt r11, r11, r12, lsl #16\n",
            "strd r8, r11, [r0, #",
            $we,
            "]\n",
            "str r10, [r0, #",
            $e,
            "]\n",
            "ldrd r8, r9, [sp, #8]",
        )
    };
}

/// [`portable::weigh_residuals`].
#[inline(always)]
pub(crate) fn weigh_residuals(fours: &mut [[Pair; 2]], columns: &[[u32; 2]], weighing: &Weighing<'_>) {
    if columns.len() <= fours.len() {
        return;
    }
    let &Weighing { across, gain, rest, bins, weights } = weighing;
    if !fours.is_empty() {
        // SAFETY: each turn reads one entry of `columns`, of which there is one more than turns, and works on one of
        // `fours`, as long as there is one; a bin of eight bits with sign lies within the table around its middle. What is
        // pushed is the compiler's again at the end.
        unsafe {
            asm!(
                "push {{r6, r7, r8, r9, r10, r11, r12}}",
                "ldrd r4, r5, [r1], #8",
                "2:",
                "ldr r10, [r0, #8]",
                "ldrd r6, r7, [r1], #8",
                "sxth r11, r10",
                "asr r12, r10, #16",
                "mls r11, r11, r8, r9",
                "mls r12, r12, r8, r9",
                "smlad r11, r4, r2, r11",
                "smlad r12, r5, r2, r12",
                "smlad r11, r5, r3, r11",
                "smlad r12, r6, r3, r12",
                "lsr r4, r4, #16",
                "orr r4, r4, r5, lsl #16",
                "lsr r5, r5, #16",
                "orr r5, r5, r6, lsl #16",
                weigh!("12", "20"),
                "ldr r10, [r0, #32]",
                "lsr lr, r6, #16",
                "orr lr, lr, r7, lsl #16",
                "sxth r11, r10",
                "asr r12, r10, #16",
                "mls r11, r11, r8, r9",
                "mls r12, r12, r8, r9",
                "smlad r11, r4, r2, r11",
                "smlad r12, r5, r2, r12",
                "smlad r11, r5, r3, r11",
                "smlad r12, lr, r3, r12",
                "mov r4, r6",
                "mov r5, r7",
                weigh!("36", "44"),
                "ldr r10, [sp, #24]",
                "add r0, #48",
                "cmp r0, r10",
                "bne 2b",
                "pop {{r6, r7, r8, r9, r10, r11, r12}}",
                inout("r0") fours.as_mut_ptr() => _,
                inout("r1") columns.as_ptr() => _,
                in("r2") across[0],
                in("r3") across[1],
                out("r4") _,
                out("r5") _,
                in("r8") gain,
                in("r9") rest,
                in("r10") bins,
                in("r11") weights.as_ptr().wrapping_add(128),
                in("r12") fours.as_mut_ptr_range().end,
                out("lr") _,
            );
        }
    }
}
