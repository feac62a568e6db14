//! Packed arithmetic of Armv7E-M, and twins with the same bits for every other machine.
//!
//! The compiler does not find such instructions by itself, and where single ones are put into its loops it spends as much
//! on moving bytes as they save; so the inner loops over bytes stand here whole. Whether the machine has them is said by
//! the feature `dsp`: the target's own name does not tell.

/// `left` as it is, though the compiler does not know that: a loop that counts it down is not unrolled. For loops that
/// matter little, whose copies would take the room of those that matter.
#[inline(always)]
pub fn opaque(left: usize) -> usize {
    #[cfg(feature = "dsp")]
    {
        let same: usize;
        // SAFETY: nothing happens.
        unsafe { core::arch::asm!("/* {} */", inlateout(reg) left => same, options(nomem, nostack, preserves_flags)) }
        same
    }
    #[cfg(not(feature = "dsp"))]
    {
        left
    }
}

/// Square root (VSQRT), correctly rounded.
#[inline(always)]
pub fn sqrt(value: f32) -> f32 {
    #[cfg(feature = "dsp")]
    {
        let root: u32;
        // SAFETY: changes registers only, and puts s0 back: the target has no name for it as an operand.
        unsafe {
            core::arch::asm!(
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
    #[cfg(not(feature = "dsp"))]
    {
        libm::sqrtf(value)
    }
}

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

/// Whether all rows begin at a word of the memory.
#[cfg(feature = "dsp")]
fn are_words<const N: usize>(rows: [&[u8]; N]) -> bool {
    rows.iter().all(|row| row.as_ptr().addr().is_multiple_of(4))
}

/// Prefix sums of (mean − 128) over the boxes of 2 x 2 of two rows: `sums[i]` up to and with box `i`, at most 256,
/// little-endian, of as many fours of boxes as all have. How many those are, and 4 times the last sum. The mean of two is
/// rounded down from row to row and up along the row, so that on the whole it is neither.
#[inline(always)]
pub fn prefix_pairs([a, b]: [&[u8]; 2], sums: &mut [[u8; 2]]) -> (usize, i32) {
    let done = sums.len().min(a.len() / 2).min(b.len() / 2) & !3;
    #[cfg(feature = "dsp")]
    let total = {
        let mut base = 0u32;
        if done > 0 {
            // SAFETY: each turn reads eight bytes of both rows and writes four sums, as long as all have them.
            unsafe {
                core::arch::asm!(
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
        base as i16
    };
    #[cfg(not(feature = "dsp"))]
    let total = {
        let mut total = 0i16;
        let pairs = a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0);
        for (sum, ([a0, a1], [b0, b1])) in sums.iter_mut().zip(pairs).take(done) {
            let column = |a: u8, b: u8| (a as i16 + b as i16) >> 1;
            total = total.wrapping_add(((column(*a0, *b0) + column(*a1, *b1) + 1) >> 1) - 128);
            *sum = total.to_le_bytes();
        }
        total
    };
    (done, 4 * total as i32)
}

/// Prefix sums of (mean − 128) over the boxes of 4 x 4 of four rows, rounded down: `sums[i]` up to and with box `i`, at
/// most 256, little-endian. How many it has made, and 16 times the last one before rounding: it makes them where the
/// machine has instructions for it, and none elsewhere.
#[inline(always)]
pub fn prefix_fours(rows: [&[u8]; 4], sums: &mut [[u8; 2]]) -> (usize, i32) {
    #[cfg(feature = "dsp")]
    if are_words(rows) {
        let done = rows.iter().fold(sums.len(), |least, row| least.min(row.len() / 4)) & !1;
        let mut total = 0i32;
        if done > 0 {
            // SAFETY: each turn reads eight bytes of all rows, which are aligned as LDRD wants them, and writes two sums, as
            // long as all have them.
            unsafe {
                core::arch::asm!(
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
        return (done, total);
    }
    let _ = (rows, sums);
    (0, 0)
}

/// A corner between cells of the rectifier, and the integrals along the borders that begin there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Node {
    /// (x, y) from the upper left corner of the boxes, Q8 of a box.
    pub at: [i32; 2],
    /// To the next node of its line, and to the node below.
    pub integrals: [u32; 2],
}

/// The instructions between two nodes in different rows of boxes, `x`, `f` not below `t`, `n`; the result is in `f`.
#[cfg(feature = "dsp")]
macro_rules! from_row_to_row {
    () => {
        concat!(
            "strd {t}, {n}, [sp, #16]\n",
            "sub {t}, {t}, {x}\n",
            "sub {slope}, {n}, {f}\n",
            "lsl {t}, {t}, #15\n",
            // Q15 of a box a row.
            "sdiv {slope}, {t}, {slope}\n",
            "rsb {n}, {u}, {n}, asr #8\n",
            "ubfx {f}, {f}, #0, #8\n",
            "lsl {x}, {x}, #8\n",
            "rsb {f}, {f}, #256\n",
            "mul {t}, {slope}, {f}\n",
            "add {t}, {x}, {t}, asr #8\n",
            "asr {u}, {t}, #16\n",
            "ubfx {t}, {t}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "smuad {u}, {u}, {t}\n",
            "subs {n}, {n}, #1\n",
            "beq 8f\n",
            // Whole rows, at their middles.
            "add {t}, {f}, #128\n",
            "mov {whole}, #0\n",
            "mul {t}, {slope}, {t}\n",
            "mul {f}, {u}, {f}\n",
            "add {x}, {x}, {t}, asr #7\n",
            "2:\n",
            "asr {u}, {x}, #16\n",
            "add {row}, {row}, {stride}\n",
            "ubfx {t}, {x}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "add {x}, {x}, {slope}, lsl #1\n",
            "subs {n}, {n}, #1\n",
            "smlad {whole}, {u}, {t}, {whole}\n",
            "bne 2b\n",
            "add {f}, {f}, {whole}, lsl #8\n",
            "b 3f\n",
            "8:\n",
            "mul {f}, {u}, {f}\n",
            // The last piece, from its end.
            "3:\n",
            "ldrd {t}, {n}, [sp, #16]\n",
            "add {row}, {row}, {stride}\n",
            "ubfx {n}, {n}, #0, #8\n",
            "lsl {t}, {t}, #8\n",
            "mul {u}, {slope}, {n}\n",
            "sub {t}, {t}, {u}, asr #8\n",
            "asr {u}, {t}, #16\n",
            "ubfx {t}, {t}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "smuad {u}, {u}, {t}\n",
            "mla {f}, {u}, {n}, {f}",
        )
    };
}

/// Integral `which` of each of `count` nodes from `first` on: ∫ F dy from there to the node `further` nodes
/// behind it, in 2⁻¹⁵ of a grey level times the area of a box, modulo 2^32. F(x, y) is the sum of the boxes of the row at
/// y up to x: `sums` points to the first row of two-byte sums, entry `i` + 1 up to border `i`; rows are `stride` bytes
/// apart.
///
/// The way is cut where it passes from one row to the next, and F read at the middle of each piece.
///
/// # Safety
/// All these nodes lie in one object and in the table: 0 ≤ x < boxes of a row, 0 ≤ y < rows, and `sums` holds them all. No
/// two lie 256 boxes apart along a row. `which` is 0 or 1.
// All that is read lies between the nodes: the slope is rounded to 0, t is at most dy, and what is rounded down at the
// end are whole 2⁻¹⁶, of which both x are some. Products stay below 2^31: dx is below 2^16, and slope · t at most 2^15 dx.
#[inline(never)]
pub unsafe fn border_integrals(
    (sums, stride): (*const u8, usize),
    first: *mut Node,
    (which, further): (usize, isize),
    count: usize,
) {
    #[cfg(feature = "dsp")]
    if count > 0 {
        // SAFETY: reads nodes and, by the caller's word and the reasons above, sums of the table; writes integrals of the
        // same nodes. The stack pointer is put back.
        unsafe {
            core::arch::asm!(
                "sub sp, sp, #24",
                "strd {row}, {u}, [sp]",
                "strd {x}, {n}, [sp, #8]",
                "1:",
                "ldrd {row}, {u}, [sp]",
                "ldrd {x}, {f}, [{node}]",
                "add {u}, {node}, {u}",
                "ldrd {t}, {n}, [{u}]",
                "asr {u}, {f}, #8",
                "cmp {u}, {n}, asr #8",
                "bgt 6f",
                "mla {row}, {u}, {stride}, {row}",
                "beq 4f",
                from_row_to_row!(),
                "5:",
                "ldrd {t}, {u}, [sp, #8]",
                "str {f}, [{node}, {t}]",
                "add {node}, {node}, #16",
                "cmp {node}, {u}",
                "bne 1b",
                "b 9f",
                // Within one row, in any direction.
                "4:",
                "sub {f}, {n}, {f}",
                "add {t}, {t}, {x}",
                "lsl {t}, {t}, #7",
                "asr {u}, {t}, #16",
                "ubfx {t}, {t}, #9, #7",
                "ldr {u}, [{row}, {u}, lsl #1]",
                "mla {t}, {t}, {k}, {one}",
                "smuad {u}, {u}, {t}",
                "mul {f}, {u}, {f}",
                "b 5b",
                // Upwards: the same way downwards, and its negative.
                "6:",
                "asr {u}, {n}, #8",
                "mla {row}, {u}, {stride}, {row}",
                "mov {slope}, {x}",
                "mov {x}, {t}",
                "mov {t}, {slope}",
                "mov {slope}, {f}",
                "mov {f}, {n}",
                "mov {n}, {slope}",
                from_row_to_row!(),
                "rsb {f}, {f}, #0",
                "b 5b",
                "9:",
                "add sp, sp, #24",
                node = inout(reg) first => _,
                row = inout(reg) sums.wrapping_add(2) => _,
                n = inout(reg) first.wrapping_add(count) => _,
                u = inout(reg) 16 * further => _,
                stride = in(reg) stride,
                k = in(reg) 0xffff,
                one = in(reg) 128,
                x = inout(reg) 8 + 4 * which => _,
                f = out(reg) _,
                t = out(reg) _,
                slope = out(reg) _,
                whole = out(reg) _,
            );
        }
    }
    #[cfg(not(feature = "dsp"))]
    for index in 0..count {
        // SAFETY: the caller's word.
        unsafe {
            let node = first.add(index);
            let other = *node.offset(further);
            (*node).integrals[which] = if other.at[1] >> 8 >= (*node).at[1] >> 8 {
                border_integral(sums, stride, (*node).at, other.at)
            } else {
                border_integral(sums, stride, other.at, (*node).at).wrapping_neg()
            };
        }
    }
}

/// The means of cells between an upper and a lower line of nodes, one more than `means`, of the integrals along their
/// borders, which are 2^`shift` times what is given; and the areas of all of them, each in Q15 of that of a box, ORed.
///
/// A mean is true where the OR is below 2^22: a cell of no area, a twisted one and one of more than 128 boxes has a
/// higher bit in it. None is made where a line is too short.
pub fn cell_means(upper: &[Node], lower: &[Node], shift: u32, means: &mut [u8]) -> u32 {
    if upper.len() <= means.len() || lower.len() <= means.len() {
        return u32::MAX;
    }
    let mut areas = 0;
    #[cfg(feature = "dsp")]
    if !means.is_empty() {
        // SAFETY: reads one node more than `means` has room for from both lines, as was checked, and fills `means`.
        unsafe {
            core::arch::asm!(
                "2:",
                // The diagonals, and half their product.
                "ldrd {a}, {b}, [{upper}]",
                "ldrd {c}, {d}, [{lower}, #16]",
                "sub {c}, {c}, {a}",
                "sub {d}, {d}, {b}",
                "ldrd {a}, {b}, [{lower}]",
                "ldrd {e}, {f}, [{upper}, #16]!",
                "sub {a}, {a}, {e}",
                "sub {b}, {b}, {f}",
                "mul {e}, {c}, {b}",
                "mls {e}, {d}, {a}, {e}",
                "ldrd {a}, {b}, [{upper}, #-8]",
                "ldr {c}, [{upper}, #12]",
                "ldr {d}, [{lower}, #8]",
                "asr {e}, {e}, #2",
                "orr {e}, {e}, #1",
                "sub {a}, {a}, {b}",
                "sub {c}, {c}, {d}",
                "add {a}, {a}, {c}",
                "orr {areas}, {areas}, {e}",
                "lsl {a}, {a}, {shift}",
                "add {a}, {a}, {e}, lsl #7",
                "add {lower}, {lower}, #16",
                "add {a}, {a}, {e}, lsr #1",
                "sdiv {a}, {a}, {e}",
                "usat {a}, #8, {a}",
                "subs {n}, {n}, #1",
                "strb {a}, [{means}], #1",
                "bne 2b",
                upper = inout(reg) upper.as_ptr() => _,
                lower = inout(reg) lower.as_ptr() => _,
                means = inout(reg) means.as_mut_ptr() => _,
                n = inout(reg) means.len() => _,
                areas = inout(reg) areas,
                shift = in(reg) shift,
                a = out(reg) _,
                b = out(reg) _,
                c = out(reg) _,
                d = out(reg) _,
                e = out(reg) _,
                f = out(reg) _,
                options(nostack),
            );
        }
    }
    #[cfg(not(feature = "dsp"))]
    for ((mean, upper), lower) in means.iter_mut().zip(upper.windows(2)).zip(lower.windows(2)) {
        let ([a, b], [c, d]) = ([upper[0], upper[1]], [lower[0], lower[1]]);
        let falling = [d.at[0] - a.at[0], d.at[1] - a.at[1]];
        let rising = [c.at[0] - b.at[0], c.at[1] - b.at[1]];
        let product = falling[0].wrapping_mul(rising[1]).wrapping_sub(falling[1].wrapping_mul(rising[0]));
        let area = (product >> 2) as u32 | 1;
        areas |= area;
        let right = a.integrals[0].wrapping_add(b.integrals[1]);
        let around = right.wrapping_sub(c.integrals[0]).wrapping_sub(a.integrals[1]);
        // Rounded to nearest; the boxes are 128 grey levels brighter.
        let total = (around << shift).wrapping_add(area << 7).wrapping_add(area >> 1);
        // A black cell may come out a trifle below black.
        *mean = (total as i32).wrapping_div(area as i32).clamp(0, 255) as u8;
    }
    areas
}

/// One of [`border_integrals`], from `a` to `b`, not in a row above.
///
/// # Safety
/// As there.
#[cfg(not(feature = "dsp"))]
unsafe fn border_integral(sums: *const u8, stride: usize, [ax, ay]: [i32; 2], [bx, by]: [i32; 2]) -> u32 {
    // 128 F in a row at x, Q16 of a box.
    let read = |row: i32, x: i64| {
        let at = row as usize * stride + 2 * (x >> 16) as usize + 2;
        // SAFETY: the caller's word.
        let both = unsafe { sums.add(at).cast::<[[u8; 2]; 2]>().read() }.map(i16::from_le_bytes);
        let share = (x >> 9) as i32 & 0x7f;
        (both[0] as i32 * (128 - share) + both[1] as i32 * share) as u32
    };
    let (first, rows, dy) = (ay >> 8, (by >> 8) - (ay >> 8), by - ay);
    if rows == 0 {
        return read(first, (ax as i64 + bx as i64) << 7).wrapping_mul(dy as u32);
    }
    let slope = ((bx as i64 - ax as i64) << 15) / dy as i64;
    let (upper, lower) = ((256 - (ay & 0xff)) as i64, (by & 0xff) as i64);
    let (from, to) = ((ax as i64) << 8, (bx as i64) << 8);
    let mut total = read(first, from + ((slope * upper) >> 8)).wrapping_mul(upper as u32);
    let whole = from + ((slope * (upper + 128)) >> 7);
    for row in 1..rows {
        total = total.wrapping_add(read(first + row, whole + 2 * slope * (row as i64 - 1)) << 8);
    }
    total.wrapping_add(read(first + rows, to - ((slope * lower) >> 8)).wrapping_mul(lower as u32))
}

/// Columns and rows of the surroundings of a pixel.
pub const SIDE: usize = 5;
/// Pixels of a row that [`details`] makes at most.
pub const STRIP: usize = 64;
/// Bytes of a row that it reads for them.
pub const WIDTH: usize = STRIP + 8;

/// Each pixel less the mean of the 5 x 5 around it, in steps of 0.16 (a quarter of 25 times the difference), rounded to
/// nearest.
///
/// `rows`: the five rows around, aligned to four, in any order, `own` the middle one; each begins two columns before the
/// pixels. `first`: the first pixel over four; `out`: four pixels each, as bytes of two's complement, limited to what
/// they hold.
#[inline(always)]
pub fn details<'o>(rows: &[[u8; WIDTH]; SIDE], own: usize, first: usize, out: &'o mut [u32]) -> &'o mut [u8] {
    let count = out.len().min((WIDTH / 4 - 2).saturating_sub(first));
    let own = own % SIDE;
    #[cfg(feature = "dsp")]
    if count > 0 {
        // SAFETY: each turn reads a word of every row, one beyond the pixels at most, and writes one of `out`: `count`
        // keeps both within, and `first` lies in a row since `count` is not 0.
        unsafe {
            core::arch::asm!(
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
    #[cfg(not(feature = "dsp"))]
    for (word, out) in (first..).zip(out.iter_mut().take(count)) {
        let detail = |i: usize| {
            let at = 4 * word + i;
            let sum: i32 = rows.iter().flat_map(|row| &row[at..at + SIDE]).map(|&pixel| pixel as i32).sum();
            let detail = (SIDE * SIDE) as i32 * rows[own][at + SIDE / 2] as i32 + 2 - sum;
            (detail.clamp(-512, 511) >> 2) as u8
        };
        *out = u32::from_le_bytes(core::array::from_fn(detail));
    }
    let length = 4 * out.len();
    // SAFETY: words are bytes of any value, and bytes need no alignment.
    unsafe { core::slice::from_raw_parts_mut(out.as_mut_ptr().cast(), length) }
}

/// Pieces of rows of signs, −1, 0 and 1, as digits of numbers to the base 256, four a word from right to left, with where
/// each piece lies in another picture.
#[derive(Debug)]
pub struct Digits {
    /// For each piece: bytes from the end of the one before (and two words) to its start, its words, and the words
    /// themselves; no words at the end.
    stream: [u32; Digits::ROOM],
    used: usize,
    /// Where the last piece ends, and bytes that the other picture needs.
    end: usize,
    reach: usize,
}

impl Digits {
    const ROOM: usize = 160;

    /// No pieces.
    pub const fn new() -> Self {
        Digits { stream: [0; Digits::ROOM], used: 0, end: 0, reach: 0 }
    }

    /// No pieces again.
    pub fn clear(&mut self) {
        (self.stream[0], self.stream[1], self.used, self.end, self.reach) = (0, 0, 0, 0, 0);
    }

    /// Whether a piece of `words` still finds room.
    pub fn has_room(&self, words: usize) -> bool {
        self.used + words.next_multiple_of(2) + 4 <= Digits::ROOM
    }

    /// Room for the `words` of a piece that lies at `start` of the other picture, a multiple of four; empty where there is
    /// none.
    pub fn add(&mut self, start: usize, words: usize) -> &mut [u32] {
        if words == 0 || !start.is_multiple_of(4) || !self.has_room(words) {
            return &mut [];
        }
        let even = words.next_multiple_of(2);
        let Some([skipped, length, rest @ ..]) = self.stream.get_mut(self.used..) else { return &mut [] };
        let Some((piece, [_, next_length, ..])) = rest.split_at_mut_checked(even) else { return &mut [] };
        let from = core::mem::replace(&mut self.end, start + 4 * even + 8);
        self.used += even + 2;
        self.reach = self.reach.max(self.end);
        (*skipped, *length, *next_length) = (start.wrapping_sub(from) as u32, even as u32, 0);
        if let Some(last) = piece.last_mut() {
            *last = 0;
        }
        piece.get_mut(..words).unwrap_or(&mut [])
    }

    /// Adds to `sums[m]` the products of every digit and the signs of `others`, `m` words further on each: a negative byte
    /// is 1, others are 0, as are those beyond the end.
    ///
    /// One multiplication makes sixteen products and adds up those of equal shift, each in a digit of its own, seven
    /// shifts in all: 0.15 instructions a product.
    #[inline(always)]
    pub fn slide(&self, others: &[u8], sums: &mut [i64; 3]) {
        #[cfg(feature = "dsp")]
        if self.used > 0 && others.len() >= self.reach && are_words([others]) {
            let mut halves = sums.map(|sum| (sum as u32, (sum >> 32) as u32));
            // SAFETY: reads the stream up to its end, which `add` set, and `others` up to `reach`, which was checked. `others`
            // begins at a word and `add` takes starts of words only, as LDRD wants them.
            unsafe {
                core::arch::asm!(
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
                    p = inout(reg) self.stream.as_ptr() => _,
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
            return;
        }
        let signs = |at: usize| {
            let byte = |i: usize| others.get(at + i).map_or(0, |&byte| byte >> 7);
            u32::from_le_bytes(core::array::from_fn(byte)) as i64
        };
        let (mut at, mut from) = (0, 0);
        while let Some(&[delta, words]) = self.stream.get(at..at + 2).filter(|_| at < self.used) {
            from += delta as i32 as isize;
            let own = self.stream.get(at + 2..at + 2 + words as usize).unwrap_or(&[]);
            for (start, &own) in (from as usize..).step_by(4).zip(own) {
                for (m, sum) in sums.iter_mut().enumerate() {
                    *sum = sum.wrapping_add(own as i32 as i64 * signs(start + 4 * m));
                }
            }
            from += 4 * words as isize + 8;
            at += 2 + words as usize;
        }
    }
}

impl Default for Digits {
    fn default() -> Self {
        Digits::new()
    }
}

/// Loads a word of others' bytes, adds their products with the own ones in `{a}` and `{p}`, and their squares.
#[cfg(feature = "dsp")]
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
#[cfg(feature = "dsp")]
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

/// Σ p r and Σ r² of `length` bytes of two's complement at two places at once: p of `own`, r of `others` from each of `at`
/// on. `own` has zeros behind them up to a multiple of four. 0 where any of them is too short; at most 2^16 bytes.
#[inline(always)]
pub fn dots_and_energies(own: &[u8], others: &[u8], at: [usize; 2], length: usize) -> [(i32, i32); 2] {
    let padded = length.next_multiple_of(4);
    let last = others.len().wrapping_sub(padded);
    if length == 0 || own.len() < padded || others.len() < padded || at[0] > last || at[1] > last {
        return [(0, 0); 2];
    }
    #[cfg(feature = "dsp")]
    {
        let (dot_0, energy_0, dot_1, energy_1): (i32, i32, i32, i32);
        // Words left but one, and the bits of the last one that count.
        let words_and_bits = (padded / 4 - 1) << 8 | (32 - 8 * (padded - length));
        // SAFETY: each turn reads four bytes of all three, which were checked to have as many; the last words of `others`
        // are read again. Both places lie in `others`.
        unsafe {
            core::arch::asm!(
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
    #[cfg(not(feature = "dsp"))]
    at.map(|at| dot_and_energy(&own[..length], &others[at..at + length]))
}

/// Σ p, Σ r, Σ p², Σ r² and Σ p r of bytes, p of `own` and r of `others`, over as many as both have. At most 2^16 bytes.
#[inline(always)]
pub fn moments(own: &[u8], others: &[u8]) -> [u32; 5] {
    let length = own.len().min(others.len());
    let (own, others) = (&own[..length], &others[..length]);
    let mut sums = [0u32; 5];
    #[cfg(not(feature = "dsp"))]
    let done = 0;
    #[cfg(feature = "dsp")]
    let done = length & !3;
    #[cfg(feature = "dsp")]
    if done > 0 {
        // SAFETY: each turn reads four bytes of both, as long as both have them.
        unsafe {
            core::arch::asm!(
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
    for (&p, &r) in own.iter().zip(others).skip(done) {
        let (p, r) = (p as u32, r as u32);
        for (sum, add) in sums.iter_mut().zip([p, r, p * p, r * r, p * r]) {
            *sum = sum.wrapping_add(add);
        }
    }
    sums
}

/// Σ `own[i] others[i + k]` for k = 0 to 3, both as bytes of two's complement, over every `every`th row of `own`, rows of
/// `strides.0` bytes, at the same rows of `others`, `strides.1` bytes apart; others beyond the end as 0. At most 2^16 bytes
/// of `own`.
///
/// Fast where `strides.0` is a multiple of four and `others` four bytes longer than what is read: 1.3 instructions a
/// product. Both should begin at a word.
#[inline(always)]
pub fn dot4_rows(own: &[u8], others: &[u8], strides: (usize, usize), every: usize) -> [i32; 4] {
    let (own_stride, other_stride) = (strides.0.max(1), strides.1);
    let every = every.max(1);
    #[cfg(feature = "dsp")]
    {
        let rows = (own.len() / own_stride).div_ceil(every);
        let reach = rows.saturating_sub(1).saturating_mul(every).saturating_mul(other_stride);
        if rows > 0 && own_stride.is_multiple_of(4) && others.len() >= reach.saturating_add(own_stride + 4) {
            let mut sums = [0; 4];
            // SAFETY: every row of `own` is as long as its stride, and the last one begins below its end; of `others` each
            // turn reads from its own four bytes up to four beyond them, which the length checked holds for the last row.
            // The stack pointer is put back.
            unsafe {
                core::arch::asm!(
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
            return sums;
        }
    }
    let mut sums = [0; 4];
    for (row, own) in own.chunks_exact(own_stride).enumerate().step_by(every) {
        let others = others.get(row * other_stride..).unwrap_or(&[]);
        let at = |i: usize| others.get(i).map_or(0, |&r| r as i8 as i32);
        for (i, &p) in own.iter().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += p as i8 as i32 * at(i + k);
            }
        }
    }
    sums
}

/// Σ `own[i] others[i]` and Σ `others[i]²`, both as bytes of two's complement, over as many as both have. At most 2^16
/// bytes.
#[inline(always)]
pub fn dot_and_energy(own: &[u8], others: &[u8]) -> (i32, i32) {
    let length = own.len().min(others.len());
    let (own, others) = (&own[..length], &others[..length]);
    let (mut dot, mut energy) = (0i32, 0i32);
    #[cfg(not(feature = "dsp"))]
    let done = 0;
    #[cfg(feature = "dsp")]
    let done = length & !3;
    #[cfg(feature = "dsp")]
    if done > 0 {
        // SAFETY: each turn reads four bytes of both, as long as both have them.
        unsafe {
            core::arch::asm!(
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
    for (&p, &r) in own.iter().zip(others).skip(done) {
        let (p, r) = (p as i8 as i32, r as i8 as i32);
        dot += p * r;
        energy += r * r;
    }
    (dot, energy)
}

/// Copies as many bytes as both have, word by word: the rows of a patch are too short for a call.
#[inline(always)]
pub fn copy(from: &[u8], to: &mut [u8]) {
    let length = from.len().min(to.len());
    let (from, to) = (&from[..length], &mut to[..length]);
    #[cfg(not(feature = "dsp"))]
    to.copy_from_slice(from);
    #[cfg(feature = "dsp")]
    {
        let words = length & !3;
        if words > 0 {
            // SAFETY: each turn reads and writes four bytes, as long as both have them.
            unsafe {
                core::arch::asm!(
                    "2:",
                    "ldr {word}, [{from}], #4",
                    "subs {n}, #4",
                    "str {word}, [{to}], #4",
                    "bne 2b",
                    from = inout(reg) from.as_ptr() => _,
                    to = inout(reg) to.as_mut_ptr() => _,
                    n = inout(reg) words => _,
                    word = out(reg) _,
                    options(nostack),
                );
            }
        }
        if words > 0 && length > words {
            // SAFETY: both have four bytes before their ends.
            unsafe {
                let last = from.as_ptr().add(length - 4).cast::<u32>().read_unaligned();
                to.as_mut_ptr().add(length - 4).cast::<u32>().write_unaligned(last);
            }
            return;
        }
        let mut at = words;
        while at < length {
            // Volatile, lest the compiler makes a call of it again.
            // SAFETY: `at` is below the length of both.
            unsafe { to.as_mut_ptr().add(at).write_volatile(*from.as_ptr().add(at)) };
            at += 1;
        }
    }
}

/// Fills bytes, word by word: what lies beside the rows of a patch is too short for a call.
#[inline(always)]
pub fn fill(value: u8, to: &mut [u8]) {
    #[cfg(not(feature = "dsp"))]
    to.fill(value);
    #[cfg(feature = "dsp")]
    {
        let words = to.len() & !3;
        if words > 0 {
            let word = value as u32 * 0x0101_0101;
            // SAFETY: each turn writes four bytes, as long as there are so many; what is left lies in the last four.
            unsafe {
                core::arch::asm!(
                    "2:",
                    "subs {n}, #4",
                    "str {word}, [{to}], #4",
                    "bne 2b",
                    to = inout(reg) to.as_mut_ptr() => _,
                    n = inout(reg) words => _,
                    word = in(reg) word,
                    options(nostack),
                );
                to.as_mut_ptr().add(to.len() - 4).cast::<u32>().write_unaligned(word);
            }
            return;
        }
        for at in 0..to.len() {
            // Volatile, lest the compiler makes a call of it again.
            // SAFETY: `at` is below the length.
            unsafe { to.as_mut_ptr().add(at).write_volatile(value) };
        }
    }
}

/// Limits each of four bytes of two's complement to ±`limit`, 1 to 127 (by saturating additions).
#[inline(always)]
pub fn clamp_bytes(word: u32, limit: u8) -> u32 {
    #[cfg(feature = "dsp")]
    {
        let room = (127 - limit as u32) * 0x0101_0101;
        let result: u32;
        // SAFETY: reads and writes registers only. The lower side saturates at −128 first, so it takes one step more.
        unsafe {
            core::arch::asm!(
                "qadd8 {w}, {w}, {room}",
                "qsub8 {w}, {w}, {room}",
                "qsub8 {w}, {w}, {more}",
                "qadd8 {w}, {w}, {more}",
                w = inout(reg) word => result,
                room = in(reg) room,
                more = in(reg) room + 0x0101_0101,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        result
    }
    #[cfg(not(feature = "dsp"))]
    {
        let limit = limit as i8;
        u32::from_le_bytes(word.to_le_bytes().map(|byte| (byte as i8).clamp(-limit, limit) as u8))
    }
}

/// A stretch of positions in a picture, Q16 of a pixel: column and row. Two readings share a step of Q24 / 2^24 pixels
/// each; then the steps grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// Where the first reading is.
    pub at: [i32; 2],
    /// From one reading to the next.
    pub step: [i32; 2],
    /// What two readings add to the step.
    pub growth: [i32; 2],
}

/// Taken from both halves of a word of blended rows, so that they have a sign: 127.5 greys in 1/256. The half that is left
/// over rounds to the nearest.
const MIDDLE: u32 = 0x7f80_7f80;

/// The bilinear reading of four pixels, `[top left, top right, bottom left, bottom right]` from the lowest byte up, rounded
/// to the nearest grey level. `right` in 1/256, `down` in 1/65536, both up to 1.
#[inline(always)]
pub fn blend(four: u32, right: u32, down: u32) -> u8 {
    // Both rows at once, in the halves of a word; a negative top takes 1/256 grey from the bottom.
    let (lefts, rights) = (four & 0x00ff_00ff, (four >> 8) & 0x00ff_00ff);
    let rows = rights.wrapping_sub(lefts).wrapping_mul(right).wrapping_add((lefts << 8).wrapping_sub(MIDDLE));
    let difference = (rows as i16 as i32 - (rows >> 16) as i16 as i32) as u32;
    ((rows << 16).wrapping_sub(difference.wrapping_mul(down)) >> 24) as u8 ^ 0x80
}

/// [`blend`]ed readings along `stretch`, four a turn, of a picture at `pixels` with rows of `stride`.
///
/// 20.75 instructions a reading: weights are the positions' own bits, both rows are blended at once, and four results
/// leave in a word.
///
/// # Safety
/// Every position has a column and a row that are not negative, and their four pixels belong to the picture. `stride` is
/// below 2^15. Steps do not leave an i32.
#[inline(always)]
pub unsafe fn blend_along(pixels: *const u8, stride: u16, stretch: &Stretch, out: &mut [[u8; 4]]) {
    let ([x, y], [dx, dy]) = (stretch.at, stretch.step);
    #[cfg(feature = "dsp")]
    if !out.is_empty() {
        // One reading, its byte on top of the result: r0, r1 the position, r2, r3 the step, r4 one in both halves, r5 the
        // stride, r8 the first pixel, r10 what makes rows signed; r6, r7 and lr are scratch.
        macro_rules! reading {
            ($result:literal) => {
                concat!(
                    "smlatb lr, r1, r5, r8\n",
                    "add lr, lr, r0, lsr #16\n",
                    "ldrh r6, [lr, r5]\n",
                    "ldrh lr, [lr]\n",
                    "ubfx r7, r0, #8, #8\n",
                    "add r0, r0, r2, asr #8\n",
                    "orr lr, lr, r6, lsl #16\n",
                    "uxtb16 r6, lr, ror #8\n",
                    "uxtb16 lr, lr\n",
                    "sub r6, r6, lr\n",
                    "add lr, r10, lr, lsl #8\n",
                    "mla lr, r6, r7, lr\n",
                    "uxth r7, r1\n",
                    "add r1, r1, r3, asr #8\n",
                    "smusd r6, lr, r4\n",
                    "lsl lr, lr, #16\n",
                    "mls ",
                    $result,
                    ", r6, r7, lr"
                )
            };
        }
        // SAFETY: the positions' pixels are the picture's, as the caller says; each turn writes one word of `out`, as
        // long as there is one. What is pushed is popped; r6 and r7 are the compiler's own again before the end.
        unsafe {
            core::arch::asm!(
                "push {{r6, r7, r11, r12, lr}}",
                "2:",
                reading!("r11"),
                reading!("r12"),
                "ldrd r6, r7, [sp, #12]",
                "add r2, r2, r6",
                "add r3, r3, r7",
                reading!("lr"),
                "pkhtb r11, lr, r11, asr #16",
                reading!("lr"),
                "pkhtb r12, lr, r12, asr #16",
                "ldrd r6, r7, [sp, #12]",
                "add r2, r2, r6",
                "add r3, r3, r7",
                "and r12, r12, #0xff00ff00",
                "uxtab16 r12, r12, r11, ror #8",
                "ldr lr, [sp, #8]",
                "eor r12, r12, #0x80808080",
                "str r12, [r9], #4",
                "cmp r9, lr",
                "bne 2b",
                "pop {{r6, r7, r11, r12, lr}}",
                inout("r0") x => _,
                inout("r1") y => _,
                inout("r2") dx => _,
                inout("r3") dy => _,
                in("r4") 0x0001_0001,
                in("r5") stride as u32,
                in("r8") pixels,
                inout("r9") out.as_mut_ptr() => _,
                in("r10") MIDDLE.wrapping_neg(),
                inout("r11") out.as_mut_ptr_range().end => _,
                inout("r12") stretch.growth[0] => _,
                inout("lr") stretch.growth[1] => _,
            );
        }
    }
    #[cfg(not(feature = "dsp"))]
    {
        let ((mut x, mut y), (mut dx, mut dy)) = ((x, y), (dx, dy));
        for pair in out.as_flattened_mut().as_chunks_mut::<2>().0 {
            for pixel in pair {
                // SAFETY: as the caller says.
                *pixel = unsafe { blend_at(pixels, stride, x, y) };
                (x, y) = (x.wrapping_add(dx >> 8), y.wrapping_add(dy >> 8));
            }
            (dx, dy) = (dx.wrapping_add(stretch.growth[0]), dy.wrapping_add(stretch.growth[1]));
        }
    }
}

/// One reading at (`x`, `y`), Q16.
///
/// # Safety
/// As [`blend_along`].
#[inline(always)]
pub unsafe fn blend_at(pixels: *const u8, stride: u16, x: i32, y: i32) -> u8 {
    // SAFETY: as the caller says.
    let (top, bottom) = unsafe {
        let first = pixels.add((y >> 16) as usize * stride as usize + (x >> 16) as usize);
        (first.cast::<u16>().read_unaligned(), first.add(stride as usize).cast::<u16>().read_unaligned())
    };
    blend(u16::from_le(top) as u32 | (u16::from_le(bottom) as u32) << 16, (x as u32 >> 8) & 0xff, y as u32 & 0xffff)
}

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::Vec;

    #[test]
    fn four_bytes_are_added() {
        assert_eq!(add_bytes(u32::from_le_bytes([1, 200, 255, 127]), 10), 10 + 1 + 200 + 255 + 127);
    }

    /// Rows whose pixels have nothing to do with each other.
    fn rows<const N: usize>() -> [[u8; 45]; N] {
        core::array::from_fn(|row| core::array::from_fn(|col| ((row * 57 + col * 91 + row * col * 13) ^ 0x55) as u8))
    }

    #[test]
    fn rows_are_multiplied_at_four_shifts() {
        let bytes: Vec<u8, 256> = (0..256u32).map(|i| (i * 91 + i * i * 13) as u8).collect();
        for (strides, rows, every) in
            [((8, 12), 5, 1), ((8, 19), 5, 2), ((4, 7), 7, 3), ((7, 9), 4, 1), ((8, 40), 6, 1)]
        {
            let own = &bytes[..strides.0 * rows];
            let others = &bytes[3..];
            let product = |k: usize| -> i32 {
                let pixels = (0..rows).step_by(every).flat_map(|row| (0..strides.0).map(move |col| (row, col)));
                let other = |at: usize| others.get(at).map_or(0, |&r| r as i8 as i32);
                pixels.map(|(r, c)| own[r * strides.0 + c] as i8 as i32 * other(r * strides.1 + c + k)).sum()
            };
            let expected = [0, 1, 2, 3].map(product);
            assert_eq!(dot4_rows(own, others, strides, every), expected, "{strides:?}, every {every}");
        }
    }

    #[test]
    fn pairs_are_rounded_down_and_up() {
        let [a, b] = rows::<2>();
        let mut sums = [[7, 0]; 24];
        assert_eq!(prefix_pairs([&a, &b], &mut sums).0, 20);
        let mut total = 0;
        for (i, &sum) in sums.iter().enumerate().take(20) {
            let column = |c: usize| (a[c] as i32 + b[c] as i32).div_euclid(2);
            total += (column(2 * i) + column(2 * i + 1) + 1).div_euclid(2) - 128;
            assert_eq!(i16::from_le_bytes(sum) as i32, total, "box {i}");
        }
        assert_eq!(sums[20..], [[7, 0]; 4], "no half four");
    }

    #[test]
    fn products_are_of_signed_bytes() {
        let bytes = |values: [i8; 8]| values.map(|value| value as u8);
        let (own, others) = (bytes([1, -2, 3, 127, 0, 0, 0, 0]), bytes([4, 5, -6, -127, 7, 8, -9, 10]));
        assert_eq!(dot_and_energy(&own[..3], &others), (4 - 10 - 18, 16 + 25 + 36));
    }

    #[test]
    fn padding_has_no_energy() {
        let others: [u8; 12] = core::array::from_fn(|i| (50 * i + 90) as u8);
        for length in 1..=8 {
            let own: [u8; 8] = core::array::from_fn(|i| if i < length { (i * 77 + 13) as u8 } else { 0 });
            let expected = [0, 3].map(|at| dot_and_energy(&own[..length], &others[at..]));
            assert_eq!(dots_and_energies(&own, &others, [0, 3], length), expected);
        }
        assert_eq!(dots_and_energies(&[1; 8], &[1; 8], [0, 1], 6), [(0, 0); 2], "too short");
    }

    #[test]
    fn moments_are_of_unsigned_bytes() {
        assert_eq!(moments(&[200, 1, 2, 3, 4], &[255, 1, 1, 1, 250]), [210, 508, 40030, 127528, 52006]);
    }

    #[test]
    fn details_are_what_the_mean_around_leaves() {
        let rows: [[u8; WIDTH]; SIDE] = core::array::from_fn(|row| {
            core::array::from_fn(|col| ((row * 97 + col * 57) as u8).wrapping_mul(col as u8 | 1))
        });
        for first in [0, 3] {
            let mut out = [0; 5];
            for (i, &detail) in details(&rows, 3, first, &mut out).iter().enumerate() {
                let at = 4 * first + i;
                let mean = rows.iter().flat_map(|row| &row[at..at + 5]).map(|&p| p as f32).sum::<f32>() / 25.0;
                let exact = 6.25 * (rows[3][at + 2] as f32 - mean);
                assert!((detail as i8 as f32 - exact.clamp(-128.0, 127.0)).abs() <= 0.501, "{exact} at {at}");
            }
        }
    }

    #[test]
    fn digits_add_products_of_equal_shift() {
        let others: [u8; 64] = core::array::from_fn(|i| (i * i * 37 + i * 11) as u8);
        let signs = [[1i32, 0, -1, -1, 0, 1], [0, -1, 1, 1, -1, 1]];
        let mut digits = Digits::new();
        for (start, signs) in [8, 4].into_iter().zip(&signs) {
            for (word, four) in digits.add(start, 2).iter_mut().zip(signs.chunks(4)) {
                *word = (0..4).fold(0, |word, i| 256 * word + four.get(i).unwrap_or(&0)) as u32;
            }
        }
        let mut sums = [0; 3];
        digits.slide(&others, &mut sums);
        // Together they are one number whose digit k + 3 is the sum at shift k.
        let total = sums.iter().rev().fold(0i128, |total, &sum| (total << 32) + sum as i128);
        let mut rest = total;
        for k in -3..=8 {
            let digit = rest as i8 as i128;
            rest = (rest - digit) >> 8;
            let sum = |(start, signs): (i32, &[i32; 6])| -> i32 {
                let negative = |i: i32| others[(start + i + k) as usize] as i32 >> 7;
                (0..6).map(|i| signs[i as usize] * negative(i)).sum()
            };
            if (0..=8).contains(&k) {
                assert_eq!(digit as i32, [8, 4].into_iter().zip(&signs).map(sum).sum::<i32>(), "shift {k}");
            }
        }
        digits.clear();
        digits.slide(&others, &mut sums);
        assert_eq!(sums.iter().rev().fold(0i128, |total, &sum| (total << 32) + sum as i128), total, "none left");
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
