//! Packed arithmetic of Armv7E-M, and twins with the same bits for every other machine.
//!
//! The compiler does not find such instructions by itself, and where single ones are put into its loops it spends as much
//! on moving bytes as they save; so the inner loops over bytes stand here whole. Whether the machine has them is said by
//! the feature `dsp`: the target's own name does not tell.

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

/// `sum` plus the products of the halves of both words as numbers of two's complement (SMLAD), modulo 2^32.
#[inline(always)]
pub fn dot2(a: u32, b: u32, sum: i32) -> i32 {
    #[cfg(feature = "dsp")]
    {
        let total: i32;
        // SAFETY: reads and writes registers only; the overflow flag it may set is declared.
        unsafe {
            core::arch::asm!("smlad {}, {}, {}, {}", lateout(reg) total, in(reg) a, in(reg) b, in(reg) sum,
                options(pure, nomem, nostack));
        }
        total
    }
    #[cfg(not(feature = "dsp"))]
    {
        let product = |a: u32, b: u32| a as i16 as i32 * b as i16 as i32;
        sum.wrapping_add(product(a, b)).wrapping_add(product(a >> 16, b >> 16))
    }
}

/// Whether all rows begin at a word of the memory.
#[cfg(feature = "dsp")]
fn are_words<const N: usize>(rows: [&[u8]; N]) -> bool {
    rows.iter().all(|row| row.as_ptr().addr().is_multiple_of(4))
}

/// Prefix sums of (mean − 128) over the boxes of 2 x 2 of two rows: `sums[i]` up to and with box `i`, as many as all have,
/// at most 256, little-endian. The mean of two is rounded down from row to row and up along the row, so that on the whole it is neither.
#[inline(always)]
pub fn prefix_pairs([a, b]: [&[u8]; 2], sums: &mut [[u8; 2]]) {
    let boxes = sums.len().min(a.len() / 2).min(b.len() / 2);
    #[cfg(not(feature = "dsp"))]
    let (done, last) = (0, 0i16);
    #[cfg(feature = "dsp")]
    let (done, last) = {
        let (done, mut base) = (if are_words([a, b]) { boxes & !3 } else { 0 }, 0u32);
        if done > 0 {
            // SAFETY: each turn reads eight bytes of both rows, which are aligned as LDRD wants them, and writes four sums,
            // as long as all have them.
            unsafe {
                core::arch::asm!(
                    "2:",
                    "ldrd {p}, {r}, [{a}], #8",
                    "ldrd {q}, {s}, [{b}], #8",
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
        (done, base as i16)
    };
    let mut total = last;
    let pairs = a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0);
    for (sum, (a, b)) in sums.iter_mut().zip(pairs).take(boxes).skip(done) {
        let column = |i: usize| (a[i] as i16 + b[i] as i16) >> 1;
        total = total.wrapping_add(((column(0) + column(1) + 1) >> 1) - 128);
        *sum = total.to_le_bytes();
    }
}

/// Prefix sums of (mean − 128) over the boxes of 4 x 4 of four rows, rounded down: `sums[i]` up to and with box `i`, as
/// many as all have, at most 256, little-endian.
#[inline(always)]
pub fn prefix_fours(rows: [&[u8]; 4], sums: &mut [[u8; 2]]) {
    let boxes = rows.iter().fold(sums.len(), |least, row| least.min(row.len() / 4));
    #[cfg(not(feature = "dsp"))]
    let (done, last) = (0, 0i32);
    #[cfg(feature = "dsp")]
    let (done, last) = {
        let (done, mut total) = (if are_words(rows) { boxes & !1 } else { 0 }, 0i32);
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
        (done, total)
    };
    let mut total = last;
    for (index, sum) in sums.iter_mut().enumerate().take(boxes).skip(done) {
        for row in rows {
            total += row[4 * index..4 * index + 4].iter().map(|&pixel| pixel as i32 - 128).sum::<i32>();
        }
        *sum = ((total >> 4) as i16).to_le_bytes();
    }
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

/// `WHICH` of the integrals of each of `count` nodes from `first` on: ∫ F dy from there to the node `further` nodes
/// behind it, in 2⁻¹⁵ of a grey level times the area of a box, modulo 2^32. F(x, y) is the sum of the boxes of the row at
/// y up to x: `sums` points to the first row of two-byte sums, entry `i` + 1 up to border `i`; rows are `stride` bytes
/// apart.
///
/// The way is cut where it passes from one row to the next, and F read at the middle of each piece.
///
/// # Safety
/// All these nodes lie in one object and in the table: 0 ≤ x < boxes of a row, 256 at most, 0 ≤ y < rows, and `sums`
/// holds them all. `WHICH` is 0 or 1.
// All that is read lies between the nodes: the slope is rounded to 0, t is at most dy, and what is rounded down at the
// end are whole 2⁻¹⁶, of which both x are some. Products stay below 2^31: dx is below 2^16, and slope · t at most 2^15 dx.
#[inline(never)]
pub unsafe fn border_integrals<const WHICH: usize>(
    sums: *const u8,
    stride: usize,
    first: *mut Node,
    further: isize,
    count: usize,
) {
    #[cfg(feature = "dsp")]
    if count > 0 {
        // SAFETY: reads nodes and, by the caller's word and the reasons above, sums of the table; writes integrals of the
        // same nodes. The stack pointer is put back.
        unsafe {
            core::arch::asm!(
                "sub sp, sp, #24",
                "str {row}, [sp]",
                "str {n}, [sp, #4]",
                "str {u}, [sp, #8]",
                "1:",
                "ldr {u}, [sp, #8]",
                "ldrd {x}, {f}, [{node}]",
                "ldr {row}, [sp]",
                "add {u}, {node}, {u}",
                "ldrd {t}, {n}, [{u}]",
                "asr {u}, {f}, #8",
                "cmp {u}, {n}, asr #8",
                "bgt 6f",
                "mla {row}, {u}, {stride}, {row}",
                "beq 4f",
                from_row_to_row!(),
                "5:",
                "str {f}, [{node}, #{at}]",
                "ldr {u}, [sp, #4]",
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
                at = const 8 + 4 * WHICH,
                node = inout(reg) first => _,
                row = inout(reg) sums.wrapping_add(2) => _,
                n = inout(reg) first.wrapping_add(count) => _,
                u = inout(reg) 16 * further => _,
                stride = in(reg) stride,
                k = in(reg) 0xffff,
                one = in(reg) 128,
                x = out(reg) _,
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
            (*node).integrals[WHICH] = if other.at[1] >> 8 >= (*node).at[1] >> 8 {
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
/// A mean is true where the OR is below 2^23: a cell of no area, a twisted one and one of more than 256 boxes has a
/// higher bit in it. None is made where a line is too short.
pub fn cell_means(upper: &[Node], lower: &[Node], shift: u32, means: &mut [u8]) -> u32 {
    if upper.len() <= means.len() || lower.len() <= means.len() {
        return u32::MAX;
    }
    let mut areas = 0;
    #[cfg(feature = "dsp")]
    if shift == 0 && !means.is_empty() {
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
                "add {a}, {a}, {e}, lsl #7",
                "add {lower}, {lower}, #16",
                "add {a}, {a}, {e}, lsr #1",
                "udiv {a}, {a}, {e}",
                "usat {a}, #8, {a}",
                "subs {n}, {n}, #1",
                "strb {a}, [{means}], #1",
                "bne 2b",
                upper = inout(reg) upper.as_ptr() => _,
                lower = inout(reg) lower.as_ptr() => _,
                means = inout(reg) means.as_mut_ptr() => _,
                n = inout(reg) means.len() => _,
                areas = inout(reg) areas,
                a = out(reg) _,
                b = out(reg) _,
                c = out(reg) _,
                d = out(reg) _,
                e = out(reg) _,
                f = out(reg) _,
                options(nostack),
            );
        }
        return areas;
    }
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
        *mean = (total / area).min(255) as u8;
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

/// Σ `own[i] others[i + k]` for k = 0 to 3, both as bytes of two's complement, others beyond the end as 0. At most 2^16
/// bytes.
///
/// Fast where `own` is a multiple of four long and `others` four longer: 1.2 instructions a product.
#[inline(always)]
pub fn dot4(own: &[u8], others: &[u8]) -> [i32; 4] {
    #[cfg(feature = "dsp")]
    if !own.is_empty() && own.len().is_multiple_of(4) && others.len() >= own.len() + 4 {
        let mut sums = [0; 4];
        // SAFETY: each turn reads four bytes of `own` and, of `others`, from its own four up to four beyond them; both
        // lengths were checked.
        unsafe {
            core::arch::asm!(
                "ldr {w}, [{r}]",
                "2:",
                "ldr {even}, [{p}], #4",
                "sxtb16 {odd}, {even}, ror #8",
                "sxtb16 {even}, {even}",
                // Pairs of others two apart, from 0, 1, 2, 3 and 4 on; each serves two sums.
                "sxtb16 {pair}, {w}",
                "smlad {s0}, {even}, {pair}, {s0}",
                "sxtb16 {pair}, {w}, ror #8",
                "ldr {w}, [{r}, #2]",
                "smlad {s0}, {odd}, {pair}, {s0}",
                "smlad {s1}, {even}, {pair}, {s1}",
                "sxtb16 {pair}, {w}",
                "smlad {s1}, {odd}, {pair}, {s1}",
                "smlad {s2}, {even}, {pair}, {s2}",
                "sxtb16 {pair}, {w}, ror #8",
                "ldr {w}, [{r}, #4]!",
                "smlad {s2}, {odd}, {pair}, {s2}",
                "smlad {s3}, {even}, {pair}, {s3}",
                "sxtb16 {pair}, {w}",
                "subs {n}, #4",
                "smlad {s3}, {odd}, {pair}, {s3}",
                "bne 2b",
                p = inout(reg) own.as_ptr() => _,
                r = inout(reg) others.as_ptr() => _,
                n = inout(reg) own.len() => _,
                w = out(reg) _,
                even = out(reg) _,
                odd = out(reg) _,
                pair = out(reg) _,
                s0 = inout(reg) sums[0],
                s1 = inout(reg) sums[1],
                s2 = inout(reg) sums[2],
                s3 = inout(reg) sums[3],
                options(pure, readonly, nostack),
            );
        }
        return sums;
    }
    let at = |i: usize| others.get(i).map_or(0, |&r| r as i8 as i32);
    let mut sums = [0; 4];
    for (i, &p) in own.iter().enumerate() {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += p as i8 as i32 * at(i + k);
        }
    }
    sums
}

/// Σ of [`dot4`] over every `every`th row of `own`, rows of `strides.0` bytes, at the same rows of `others`, `strides.1` bytes
/// apart; others beyond the end as 0. At most 2^16 bytes of `own`.
///
/// Fast where `strides.0` is a multiple of four and `others` four bytes longer than what is read: 1.3 instructions a product. Both should begin at a word.
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
                    // As in dot4, but all others are loaded where they are aligned.
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

#[cfg(test)]
mod tests {
    use super::*;
    use heapless::Vec;

    #[test]
    fn four_bytes_are_added() {
        assert_eq!(add_bytes(u32::from_le_bytes([1, 200, 255, 127]), 10), 10 + 1 + 200 + 255 + 127);
    }

    #[test]
    fn halves_are_multiplied_with_their_signs() {
        let word = |low: i16, high: i16| low as u16 as u32 | (high as u16 as u32) << 16;
        assert_eq!(dot2(word(-3, 200), word(100, -7), 11), 11 - 300 - 1400);
        assert_eq!(dot2(word(i16::MIN, i16::MIN), word(i16::MIN, i16::MIN), -1), i32::MAX, "modulo 2^32");
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
        prefix_pairs([&a, &b], &mut sums);
        let mut total = 0;
        for (i, &sum) in sums.iter().enumerate().take(22) {
            let column = |c: usize| (a[c] as i32 + b[c] as i32).div_euclid(2);
            total += (column(2 * i) + column(2 * i + 1) + 1).div_euclid(2) - 128;
            assert_eq!(i16::from_le_bytes(sum) as i32, total, "box {i}");
        }
        assert_eq!(sums[22..], [[7, 0]; 2], "no half box");
    }

    #[test]
    fn fours_are_exact_but_for_the_last_rounding() {
        let all = rows::<4>();
        let mut sums = [[7, 0]; 12];
        prefix_fours([&all[0], &all[1], &all[2], &all[3]], &mut sums);
        let mut total = 0;
        for (i, &sum) in sums.iter().enumerate().take(11) {
            total += all.iter().flat_map(|row| &row[4 * i..4 * i + 4]).map(|&p| p as i32 - 128).sum::<i32>();
            assert_eq!(i16::from_le_bytes(sum) as i32, total.div_euclid(16), "box {i}");
        }
        assert_eq!(sums[11], [7, 0], "no half box");
    }

    #[test]
    fn products_are_of_signed_bytes() {
        let bytes = |values: [i8; 8]| values.map(|value| value as u8);
        let (own, others) = (bytes([1, -2, 3, 127, 0, 0, 0, 0]), bytes([4, 5, -6, -127, 7, 8, -9, 10]));
        let expected = [4 - 10 - 18 - 127 * 127, 5 + 12 - 381 + 889, -6 + 254 + 21 + 127 * 8, -127 - 14 + 24 - 127 * 9];
        assert_eq!(dot4(&own[..4], &others), expected);
        assert_eq!(dot4(&own, &others), expected, "others beyond the end are 0");
        assert_eq!(dot_and_energy(&own[..3], &others), (4 - 10 - 18, 16 + 25 + 36));
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
