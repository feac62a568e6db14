//! The sums by packed instructions.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

use super::are_aligned;
#[cfg(doc)]
use super::portable;
use core::arch::asm;

/// [`portable::prefix_pairs`], four boxes a turn.
#[inline(always)]
pub(crate) fn prefix_pairs([a, b]: [&[u8]; 2], sums: &mut [[u8; 2]]) -> (usize, i32) {
    let done = sums.len().min(a.len() / 2).min(b.len() / 2) & !3;
    let mut base = 0u32;
    if done > 0 {
        // SAFETY: each turn reads eight bytes of both rows and writes four sums, as long as all of them reach.
        unsafe {
            asm!(
                "2:",
                "ldr {p}, [{a}], #8",
                "ldr {q}, [{b}], #8",
                "ldr {r}, [{a}, #-4]",
                "ldr {s}, [{b}, #-4]",
                "uhadd8 {p}, {p}, {q}",
                "uhadd8 {r}, {r}, {s}",
                // (v0 − (255 − v1)) / 2, rounded down, is the mean rounded up less 128.
                "mvn {q}, {p}, lsr #8",
                "mvn {s}, {r}, lsr #8",
                "uhsub8 {p}, {p}, {q}",
                "uhsub8 {r}, {r}, {s}",
                "sxtb16 {p}, {p}",
                "sxtb16 {r}, {r}",
                "add {p}, {p}, {p}, lsl #16",
                "add {r}, {r}, {r}, lsl #16",
                "sadd16 {p}, {base}, {p}",
                "pkhtb {base}, {p}, {p}, asr #16",
                "sadd16 {r}, {base}, {r}",
                "subs {n}, #4",
                "pkhtb {base}, {r}, {r}, asr #16",
                "str {p}, [{out}], #8",
                "str {r}, [{out}, #-4]",
                "bne 2b",
                a = inout(reg) a.as_ptr() => _,
                b = inout(reg) b.as_ptr() => _,
                out = inout(reg) sums.as_mut_ptr() => _,
                n = inout(reg) done => _,
                base = inout(reg) base,
                p = out(reg) _,
                q = out(reg) _,
                r = out(reg) _,
                s = out(reg) _,
                options(nostack),
            );
        }
    }
    (done, 4 * base as i16 as i32)
}

/// [`portable::prefix_fours`], two boxes a turn.
#[inline(always)]
pub(crate) fn prefix_fours(rows: [&[u8]; 4], sums: &mut [[u8; 2]]) -> (usize, i32) {
    // LDRD traps on other addresses.
    if !are_aligned(rows) {
        return (0, 0);
    }
    let done = rows.iter().fold(sums.len(), |least, row| least.min(row.len() / 4)) & !1;
    let mut total = 0i32;
    if done > 0 {
        // SAFETY: each turn reads eight bytes of all rows, which are aligned as LDRD wants them, and writes two sums, as
        // long as all have them.
        unsafe {
            asm!(
                "2:",
                "ldrd {p}, {q}, [{a}], #8",
                "subs {n}, {n}, #2",
                "usada8 {total}, {p}, {zero}, {total}",
                "usad8 {last}, {q}, {zero}",
                "ldrd {p}, {q}, [{b}], #8",
                "usada8 {total}, {p}, {zero}, {total}",
                "usada8 {last}, {q}, {zero}, {last}",
                "ldrd {p}, {q}, [{c}], #8",
                "usada8 {total}, {p}, {zero}, {total}",
                "usada8 {last}, {q}, {zero}, {last}",
                "ldrd {p}, {q}, [{d}], #8",
                "usada8 {total}, {p}, {zero}, {total}",
                "usada8 {last}, {q}, {zero}, {last}",
                "sub {total}, {total}, #2048",
                "add {last}, {last}, {total}",
                "sub {last}, {last}, #2048",
                "lsl {p}, {last}, #12",
                "pkhtb {p}, {p}, {total}, asr #4",
                "mov {total}, {last}",
                "str {p}, [{out}], #4",
                "bne 2b",
                a = inout(reg) rows[0].as_ptr() => _,
                b = inout(reg) rows[1].as_ptr() => _,
                c = inout(reg) rows[2].as_ptr() => _,
                d = inout(reg) rows[3].as_ptr() => _,
                out = inout(reg) sums.as_mut_ptr() => _,
                n = inout(reg) done => _,
                total = inout(reg) total,
                zero = in(reg) 0u32,
                last = out(reg) _,
                p = out(reg) _,
                q = out(reg) _,
                options(nostack),
            );
        }
    }
    (done, total)
}
