//! The loops by packed instructions.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

#[cfg(doc)]
use super::portable;
use super::{CHANNELS, Four, RECIPROCALS, WIDTH};
use core::arch::asm;

/// [`portable::gradients`], four pixels a turn.
#[inline(always)]
pub(crate) fn gradients(rows: [&[u8; WIDTH]; 3], out: &mut [[Four; 2]]) {
    let count = out.len().min(WIDTH / 4 - 1);
    if count == 0 {
        return;
    }
    // SAFETY: a word of every row is read before the turns and one in each of them, `count` and one in all, which a row has; each turn
    // writes four words of `out`, which are one of its elements.
    unsafe {
        asm!(
            // Sums, weighed, and differences of the columns 0 and 2, and of 1 and 3.
            "ldr {sums_0}, [{above}], #4",
            "ldr {falls_0}, [{below}], #4",
            "ldr {t}, [{own}], #4",
            "uxtb16 {sums_1}, {sums_0}, ror #8",
            "uxtb16 {sums_0}, {sums_0}",
            "uxtb16 {falls_1}, {falls_0}, ror #8",
            "uxtb16 {falls_0}, {falls_0}",
            "uxtb16 {u}, {t}",
            "uxtb16 {t}, {t}, ror #8",
            "add {u}, {sums_0}, {u}, lsl #1",
            "add {t}, {sums_1}, {t}, lsl #1",
            "add {u}, {u}, {falls_0}",
            "add {t}, {t}, {falls_1}",
            "ssub16 {falls_0}, {falls_0}, {sums_0}",
            "ssub16 {falls_1}, {falls_1}, {sums_1}",
            "mov {sums_0}, {u}",
            "mov {sums_1}, {t}",
            "2:",
            // Those of 4 and 6.
            "ldr {t}, [{above}]",
            "ldr {u}, [{below}]",
            "uxtb16 {t}, {t}",
            "uxtb16 {u}, {u}",
            "ssub16 {v}, {u}, {t}",
            "add {t}, {t}, {u}",
            "ldr {u}, [{own}]",
            "uxtb16 {u}, {u}",
            "add {t}, {t}, {u}, lsl #1",
            // Along the row: 2 and 4 less 0 and 2.
            "lsr {u}, {sums_0}, #16",
            "pkhbt {u}, {u}, {t}, lsl #16",
            "ssub16 {u}, {u}, {sums_0}",
            "mov {sums_0}, {t}",
            "str {u}, [{out}]",
            // Downwards: 0 and 2, twice 1 and 3, 2 and 4; then 1 and 3, twice 2 and 4.
            "lsr {t}, {falls_0}, #16",
            "pkhbt {t}, {t}, {v}, lsl #16",
            "sadd16 {u}, {falls_1}, {t}",
            "sadd16 {falls_0}, {falls_0}, {falls_1}",
            "sadd16 {falls_0}, {falls_0}, {u}",
            "str {falls_0}, [{out}, #8]",
            "sadd16 {t}, {t}, {u}",
            "str {t}, [{out}, #12]",
            "mov {falls_0}, {v}",
            // Those of 5 and 7.
            "ldr {t}, [{above}], #4",
            "ldr {u}, [{below}], #4",
            "uxtb16 {t}, {t}, ror #8",
            "uxtb16 {u}, {u}, ror #8",
            "ssub16 {v}, {u}, {t}",
            "add {t}, {t}, {u}",
            "ldr {u}, [{own}], #4",
            "uxtb16 {u}, {u}, ror #8",
            "add {t}, {t}, {u}, lsl #1",
            // Along the row: 3 and 5 less 1 and 3.
            "lsr {u}, {sums_1}, #16",
            "pkhbt {u}, {u}, {t}, lsl #16",
            "ssub16 {u}, {u}, {sums_1}",
            "mov {sums_1}, {t}",
            "str {u}, [{out}, #4]",
            // Downwards: and 3 and 5.
            "lsr {t}, {falls_1}, #16",
            "ldr {u}, [{out}, #12]",
            "pkhbt {t}, {t}, {v}, lsl #16",
            "mov {falls_1}, {v}",
            "sadd16 {t}, {t}, {u}",
            "str {t}, [{out}, #12]",
            "add {out}, #16",
            "subs {n}, #1",
            "bne 2b",
            above = inout(reg) rows[0].as_ptr() => _,
            own = inout(reg) rows[1].as_ptr() => _,
            below = inout(reg) rows[2].as_ptr() => _,
            out = inout(reg) out.as_mut_ptr() => _,
            n = inout(reg) count => _,
            sums_0 = out(reg) _,
            sums_1 = out(reg) _,
            falls_0 = out(reg) _,
            falls_1 = out(reg) _,
            t = out(reg) _,
            u = out(reg) _,
            v = out(reg) _,
            options(nostack),
        );
    }
}

/// Both channels of the gradient whose x and y are in the halves of a word: the second one in its place.
macro_rules! direction {
    ($gradient:literal, $first:literal) => {
        concat!(
            "smlad {m}, {",
            $gradient,
            "}, {",
            $gradient,
            "}, {energy}\n",
            "clz {zeros}, {m}\n",
            "lsl {m}, {m}, {zeros}\n",
            "ubfx {m}, {m}, #23, #8\n",
            "ldr {m}, [{reciprocals}, {m}, lsl #2]\n",
            "smusd {",
            $first,
            "}, {",
            $gradient,
            "}, {",
            $gradient,
            "}\n",
            "smultb {",
            $gradient,
            "}, {",
            $gradient,
            "}, {",
            $gradient,
            "}\n",
            "lsl {",
            $gradient,
            "}, {",
            $gradient,
            "}, {zeros}\n",
            "sub {zeros}, #1\n",
            "lsl {",
            $first,
            "}, {",
            $first,
            "}, {zeros}\n",
            "smmul {",
            $gradient,
            "}, {",
            $gradient,
            "}, {m}\n",
            "smmul {",
            $first,
            "}, {",
            $first,
            "}, {m}\n",
        )
    };
}

/// Two pixels of a line, whose x and y lie so many bytes on: the upper halves of what is computed.
macro_rules! two_directions {
    ($x:literal, $y:literal) => {
        concat!(
            "ldr {m}, [{line}, #",
            $x,
            "]\n",
            "ldr {b}, [{line}, #",
            $y,
            "]\n",
            "pkhbt {a}, {m}, {b}, lsl #16\n",
            "pkhtb {b}, {b}, {m}, asr #16\n",
            direction!("a", "first_a"),
            direction!("b", "first_b"),
            "pkhtb {first_a}, {first_b}, {first_a}, asr #16\n",
            "pkhtb {a}, {b}, {a}, asr #16\n",
            "str {first_a}, [{line}, #",
            $x,
            "]\n",
            "str {a}, [{line}, #",
            $y,
            "]\n",
        )
    };
}

/// [`portable::directions`], four pixels a turn.
#[inline(always)]
pub(crate) fn directions(line: &mut [[Four; CHANNELS]], energy: u32) {
    if line.is_empty() {
        return;
    }
    // SAFETY: each turn reads and writes an element of `line`. The table has a word for each number of eight bits.
    unsafe {
        asm!(
            "2:",
            two_directions!("0", "8"),
            two_directions!("4", "12"),
            "add {line}, #16",
            "subs {n}, #1",
            "bne 2b",
            n = inout(reg) line.len() => _,
            line = inout(reg) line.as_mut_ptr() => _,
            energy = in(reg) energy,
            reciprocals = in(reg) RECIPROCALS.as_ptr(),
            m = out(reg) _,
            zeros = out(reg) _,
            a = out(reg) _,
            b = out(reg) _,
            first_a = out(reg) _,
            first_b = out(reg) _,
            options(nostack),
        );
    }
}

/// [`portable::smooth`], four pixels a turn.
#[inline(always)]
pub(crate) fn smooth(rows: [&[[Four; CHANNELS]]; 3], channel: usize, first: usize, out: &mut [[u8; 4]]) {
    let last = rows.iter().map(|row| row.len()).min().unwrap_or(0);
    let count = out.len().min(last.saturating_sub(first + 1));
    if count == 0 {
        return;
    }
    let [above, own, below] =
        rows.map(|row| row.as_ptr().wrapping_add(first).cast::<Four>().wrapping_add(channel % CHANNELS));
    // SAFETY: an element of every row is read before the turns and one in each of them, `count` and one in all, from the channel's own
    // place on: `count` keeps them within. Each turn writes a word of `out`.
    unsafe {
        asm!(
            // Sums of columns, weighed: 0 and 2, 1 and 3.
            "ldrd {even}, {odd}, [{above}], #16",
            "ldrd {t}, {u}, [{own}], #16",
            "sadd16 {even}, {even}, {t}",
            "sadd16 {odd}, {odd}, {u}",
            "sadd16 {even}, {even}, {t}",
            "sadd16 {odd}, {odd}, {u}",
            "ldrd {t}, {u}, [{below}], #16",
            "sadd16 {even}, {even}, {t}",
            "sadd16 {odd}, {odd}, {u}",
            "2:",
            // 4 and 6, 5 and 7.
            "ldrd {next_even}, {next_odd}, [{above}], #16",
            "ldrd {t}, {u}, [{own}], #16",
            "sadd16 {next_even}, {next_even}, {t}",
            "sadd16 {next_odd}, {next_odd}, {u}",
            "sadd16 {next_even}, {next_even}, {t}",
            "sadd16 {next_odd}, {next_odd}, {u}",
            "ldrd {t}, {u}, [{below}], #16",
            "sadd16 {next_even}, {next_even}, {t}",
            "sadd16 {next_odd}, {next_odd}, {u}",
            // 2 and 4, 3 and 5.
            "lsr {t}, {even}, #16",
            "lsr {u}, {odd}, #16",
            "pkhbt {t}, {t}, {next_even}, lsl #16",
            "pkhbt {u}, {u}, {next_odd}, lsl #16",
            // Of neighbours, and of those.
            "sadd16 {even}, {even}, {odd}",
            "sadd16 {odd}, {odd}, {t}",
            "sadd16 {t}, {t}, {u}",
            "sadd16 {even}, {even}, {odd}",
            "sadd16 {odd}, {odd}, {t}",
            "sadd16 {even}, {even}, {half}",
            "sadd16 {odd}, {odd}, {half}",
            "uxtb16 {even}, {even}, ror #8",
            "and {odd}, {odd}, #0xff00ff00",
            "orr {t}, {even}, {odd}",
            "mov {even}, {next_even}",
            "mov {odd}, {next_odd}",
            "str {t}, [{out}], #4",
            "subs {n}, #1",
            "bne 2b",
            above = inout(reg) above => _,
            own = inout(reg) own => _,
            below = inout(reg) below => _,
            out = inout(reg) out.as_mut_ptr() => _,
            n = inout(reg) count => _,
            half = in(reg) 0x0080_0080u32,
            even = out(reg) _,
            odd = out(reg) _,
            next_even = out(reg) _,
            next_odd = out(reg) _,
            t = out(reg) _,
            u = out(reg) _,
            options(nostack),
        );
    }
}
