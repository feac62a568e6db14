//! The sums by packed instructions.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

use super::portable;
use core::arch::asm;

/// Loads a word of others' bytes, adds their products with the own ones in `{a}` and `{p}`, and their squares.
macro_rules! one_more_place {
    ($others:literal, $dot:literal, $energy:literal) => {
        concat!(
            "ldr {r}, [{",
            $others,
            "}], #4\n",
            "sxtb16 {b}, {r}\n",
            "sxtb16 {r}, {r}, ror #8\n",
            "smlad {",
            $dot,
            "}, {a}, {b}, {",
            $dot,
            "}\n",
            "smlad {",
            $energy,
            "}, {b}, {b}, {",
            $energy,
            "}\n",
            "smlad {",
            $dot,
            "}, {p}, {r}, {",
            $dot,
            "}\n",
            "smlad {",
            $energy,
            "}, {r}, {r}, {",
            $energy,
            "}\n",
        )
    };
}

/// Takes the squares of what lies behind others' bytes off again: of the last word, shifted right by `{n}`'s lowest byte.
macro_rules! less_what_is_behind {
    ($others:literal, $energy:literal) => {
        concat!(
            "ldr {r}, [{",
            $others,
            "}, #-4]\n",
            "lsr {r}, {r}, {n}\n",
            "sxtb16 {b}, {r}\n",
            "sxtb16 {r}, {r}, ror #8\n",
            "smuad {b}, {b}, {b}\n",
            "smlad {r}, {r}, {r}, {b}\n",
            "sub {",
            $energy,
            "}, {",
            $energy,
            "}, {r}\n",
        )
    };
}

/// [`portable::dots_and_energies`], four pixels a turn at both places.
#[inline(always)]
pub(crate) fn dots_and_energies(own: &[u8], others: &[u8], at: [usize; 2], length: usize) -> [(i32, i32); 2] {
    let padded = length.next_multiple_of(4);
    let last = others.len().wrapping_sub(padded);
    if length == 0 || own.len() < padded || others.len() < padded || at[0] > last || at[1] > last {
        return [(0, 0); 2];
    }
    let (dot_0, energy_0, dot_1, energy_1): (i32, i32, i32, i32);
    // Words left but one, and the bits of the last one that count.
    let words_and_bits = (padded / 4 - 1) << 8 | (32 - 8 * (padded - length));
    // SAFETY: each turn reads four bytes of all three, which were checked to have as many; the last words of `others`
    // are read again. Both places lie in `others`.
    unsafe {
        asm!(
            "mov {dot_0}, #0",
            "mov {energy_0}, #0",
            "mov {dot_1}, #0",
            "mov {energy_1}, #0",
            "2:",
            "ldr {p}, [{own}], #4",
            "sxtb16 {a}, {p}",
            "sxtb16 {p}, {p}, ror #8",
            one_more_place!("others_0", "dot_0", "energy_0"),
            one_more_place!("others_1", "dot_1", "energy_1"),
            "subs {n}, {n}, #256",
            "bhs 2b",
            less_what_is_behind!("others_0", "energy_0"),
            less_what_is_behind!("others_1", "energy_1"),
            own = inout(reg) own.as_ptr() => _,
            others_0 = inout(reg) others.as_ptr().add(at[0]) => _,
            others_1 = inout(reg) others.as_ptr().add(at[1]) => _,
            n = inout(reg) words_and_bits => _,
            p = out(reg) _,
            r = out(reg) _,
            a = out(reg) _,
            b = out(reg) _,
            dot_0 = out(reg) dot_0,
            energy_0 = out(reg) energy_0,
            dot_1 = out(reg) dot_1,
            energy_1 = out(reg) energy_1,
            options(pure, readonly, nostack),
        );
    }
    [(dot_0, energy_0), (dot_1, energy_1)]
}

/// [`portable::moments`], four pixels a turn.
#[inline(always)]
pub(crate) fn moments(own: &[u8], others: &[u8]) -> [u32; 5] {
    let length = own.len().min(others.len());
    let (own, others) = (&own[..length], &others[..length]);
    let mut sums = [0u32; 5];
    let done = length & !3;
    if done > 0 {
        // SAFETY: each turn reads four bytes of both, as long as both have them.
        unsafe {
            asm!(
                "2:",
                "ldr {p}, [{own}], #4",
                "ldr {r}, [{others}], #4",
                "usada8 {sp}, {p}, {zero}, {sp}",
                "usada8 {sr}, {r}, {zero}, {sr}",
                "uxtb16 {a}, {p}",
                "uxtb16 {b}, {r}",
                "smlad {pp}, {a}, {a}, {pp}",
                "smlad {rr}, {b}, {b}, {rr}",
                "smlad {pr}, {a}, {b}, {pr}",
                "uxtb16 {p}, {p}, ror #8",
                "uxtb16 {r}, {r}, ror #8",
                "smlad {pp}, {p}, {p}, {pp}",
                "smlad {rr}, {r}, {r}, {rr}",
                "smlad {pr}, {p}, {r}, {pr}",
                "subs {n}, #4",
                "bne 2b",
                own = inout(reg) own.as_ptr() => _,
                others = inout(reg) others.as_ptr() => _,
                n = inout(reg) done => _,
                zero = in(reg) 0u32,
                p = out(reg) _,
                r = out(reg) _,
                a = out(reg) _,
                b = out(reg) _,
                sp = inout(reg) sums[0],
                sr = inout(reg) sums[1],
                pp = inout(reg) sums[2],
                rr = inout(reg) sums[3],
                pr = inout(reg) sums[4],
                options(pure, readonly, nostack),
            );
        }
    }
    portable::add_moments(&own[done..], &others[done..], &mut sums);
    sums
}

/// [`portable::dot4_rows`], sixteen products a turn.
///
/// Fast where `strides.0` is a multiple of four and `others` four bytes longer than what is read: 1.3 instructions a
/// product. Both should begin at a multiple of four.
#[inline(always)]
pub(crate) fn dot4_rows(own: &[u8], others: &[u8], strides: (usize, usize), every: usize) -> [i32; 4] {
    let (own_stride, other_stride) = (strides.0.max(1), strides.1);
    let every = every.max(1);
    let rows = (own.len() / own_stride).div_ceil(every);
    let reach = rows.saturating_sub(1).saturating_mul(every).saturating_mul(other_stride);
    if rows == 0 || !own_stride.is_multiple_of(4) || others.len() < reach.saturating_add(own_stride + 4) {
        return portable::dot4_rows(own, others, strides, every);
    }
    let mut sums = [0; 4];
    // SAFETY: every row of `own` is as long as its stride, and the last one begins below its end; of `others` each
    // turn reads from its own four bytes up to four beyond them, which the length checked holds for the last row.
    // The stack pointer is put back.
    unsafe {
        asm!(
            "sub sp, sp, #16",
            "str {n}, [sp]",
            "str {even}, [sp, #4]",
            "str {odd}, [sp, #8]",
            "str {pair}, [sp, #12]",
            "1:",
            "ldr {w}, [{r}]",
            "2:",
            "ldr {even}, [{p}], #4",
            "sxtb16 {odd}, {even}, ror #8",
            "sxtb16 {even}, {even}",
            // Pairs of others two apart, from 0, 1, 2, 3 and 4 on; each serves two sums. All are loaded where they are
            // aligned.
            "sxtb16 {pair}, {w}",
            "smlad {s0}, {even}, {pair}, {s0}",
            "sxtb16 {pair}, {w}, ror #8",
            "ldr {next}, [{r}, #4]!",
            "smlad {s0}, {odd}, {pair}, {s0}",
            "smlad {s1}, {even}, {pair}, {s1}",
            "ror {w}, {w}, #16",
            "pkhbt {w}, {w}, {next}, lsl #16",
            "sxtb16 {pair}, {w}",
            "smlad {s1}, {odd}, {pair}, {s1}",
            "smlad {s2}, {even}, {pair}, {s2}",
            "sxtb16 {pair}, {w}, ror #8",
            "mov {w}, {next}",
            "smlad {s2}, {odd}, {pair}, {s2}",
            "smlad {s3}, {even}, {pair}, {s3}",
            "sxtb16 {pair}, {next}",
            "subs {n}, #4",
            "smlad {s3}, {odd}, {pair}, {s3}",
            "bne 2b",
            "ldr {n}, [sp, #12]",
            "subs {n}, #1",
            "str {n}, [sp, #12]",
            "beq 3f",
            "ldrd {n}, {pair}, [sp]",
            "ldr {even}, [sp, #8]",
            "add {p}, {p}, {pair}",
            "add {r}, {r}, {even}",
            "b 1b",
            "3:",
            "add sp, sp, #16",
            p = inout(reg) own.as_ptr() => _,
            r = inout(reg) others.as_ptr() => _,
            n = inout(reg) own_stride => _,
            w = out(reg) _,
            next = out(reg) _,
            even = inout(reg) (every - 1).wrapping_mul(own_stride) => _,
            odd = inout(reg) every.wrapping_mul(other_stride).wrapping_sub(own_stride) => _,
            pair = inout(reg) rows => _,
            s0 = inout(reg) sums[0],
            s1 = inout(reg) sums[1],
            s2 = inout(reg) sums[2],
            s3 = inout(reg) sums[3],
        );
    }
    sums
}

/// [`portable::dot_and_energy`], four pixels a turn.
#[inline(always)]
pub(crate) fn dot_and_energy(own: &[u8], others: &[u8]) -> (i32, i32) {
    let length = own.len().min(others.len());
    let (own, others) = (&own[..length], &others[..length]);
    let (mut dot, mut energy) = (0i32, 0i32);
    let done = length & !3;
    if done > 0 {
        // SAFETY: each turn reads four bytes of both, as long as both have them.
        unsafe {
            asm!(
                "2:",
                "ldr {p}, [{own}], #4",
                "ldr {r}, [{others}], #4",
                "sxtb16 {a}, {p}",
                "sxtb16 {p}, {p}, ror #8",
                "sxtb16 {b}, {r}",
                "sxtb16 {r}, {r}, ror #8",
                "smlad {dot}, {a}, {b}, {dot}",
                "smlad {energy}, {b}, {b}, {energy}",
                "smlad {dot}, {p}, {r}, {dot}",
                "smlad {energy}, {r}, {r}, {energy}",
                "subs {n}, #4",
                "bne 2b",
                own = inout(reg) own.as_ptr() => _,
                others = inout(reg) others.as_ptr() => _,
                n = inout(reg) done => _,
                p = out(reg) _,
                r = out(reg) _,
                a = out(reg) _,
                b = out(reg) _,
                dot = inout(reg) dot,
                energy = inout(reg) energy,
                options(pure, readonly, nostack),
            );
        }
    }
    let mut sums = (dot, energy);
    portable::add_dot_and_energy(&own[done..], &others[done..], &mut sums);
    sums
}
