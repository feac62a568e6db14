//! The inner loops of least-squares matching over pairs of pixels, whole: the compiler's own spill what fits the registers.

#[cfg(not(feature = "dsp"))]
use super::{ONES, SIGNS, bytes, dot, pack};
use super::{high, low};

/// The numbers of two pixels, two columns apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Pair {
    /// Grey difference of the neighbours along columns.
    pub x: u32,
    /// The same along rows.
    pub y: u32,
    /// Grey.
    pub p: u32,
    /// Weight.
    pub w: u32,
    /// Weight times residual.
    pub we: u32,
    /// Residual.
    pub e: u32,
}

/// Σ w of the products of (x, y, p): xx, xy, xp, yy, yp, pp; products with a weight fit 16 bits.
#[inline(always)]
pub fn weighed_products(pairs: &[Pair]) -> [i32; 6] {
    #[cfg(not(feature = "dsp"))]
    {
        let mut sums = [0; 6];
        for &Pair { x, y, p, w, .. } in pairs {
            let weigh = |z: u32| pack(low(w) * low(z), high(w) * high(z));
            let (wx, wy, wp) = (weigh(x), weigh(y), weigh(p));
            for (sum, (a, b)) in sums.iter_mut().zip([(wx, x), (wx, y), (wx, p), (wy, y), (wy, p), (wp, p)]) {
                *sum = dot(a, b, *sum);
            }
        }
        sums
    }
    #[cfg(feature = "dsp")]
    {
        let [mut xx, mut xy, mut xp, mut yy, mut yp, mut pp] = [0i32; 6];
        if !pairs.is_empty() {
            // SAFETY: each turn reads a pair, as long as there is one. What is
            // pushed is the compiler's own again at the end.
            unsafe {
                core::arch::asm!(
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
}

/// Σ w x, Σ w y, Σ w p, Σ w, then Σ w e of x, y, p, 1 and e.
#[inline(always)]
pub fn weighed_sums(pairs: &[Pair]) -> [i32; 9] {
    #[cfg(not(feature = "dsp"))]
    {
        let mut sums = [0; 9];
        for &Pair { x, y, p, w, we, e } in pairs {
            let terms = [(w, x), (w, y), (w, p), (w, ONES), (we, x), (we, y), (we, p), (we, ONES), (we, e)];
            for (sum, (a, b)) in sums.iter_mut().zip(terms) {
                *sum = dot(a, b, *sum);
            }
        }
        sums
    }
    #[cfg(feature = "dsp")]
    {
        let [mut x, mut y, mut p, mut xe, mut ye, mut pe, mut e, mut ee] = [0i32; 8];
        let mut w = 0u32;
        if !pairs.is_empty() {
            // SAFETY: each turn reads a pair, as long as there is one. What is
            // pushed is the compiler's own again at the end.
            unsafe {
                core::arch::asm!(
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
}

/// Four rows of a picture, `stride` bytes apart, the first at `pixels`, weighed by `weights` of at most 256 in all and
/// less 2^15: columns 0 and 1 of each four in a word, then 2 and 3. `None` where there are no such pixels.
#[inline(always)]
pub fn weigh_rows(pixels: &[u8], stride: usize, weights: [u32; 4], out: &mut [[u32; 2]]) -> Option<()> {
    let needed = stride.checked_mul(3)?.checked_add(4 * out.len())?;
    if pixels.len() < needed {
        return None;
    }
    #[cfg(feature = "dsp")]
    if !out.is_empty() {
        // SAFETY: each turn reads four bytes of all rows, which were checked to have as many as `out` words, and writes two
        // words, as long as there are any.
        unsafe {
            core::arch::asm!(
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
    #[cfg(not(feature = "dsp"))]
    for (index, out) in out.iter_mut().enumerate() {
        let rows = [0, 1, 2, 3].map(|row| {
            let four = pixels[row * stride + 4 * index..].first_chunk().copied().unwrap_or_default();
            bytes(u32::from_le_bytes(four))
        });
        let sum = |i: usize| rows.iter().zip(weights).map(|(row, weight)| row[i] * weight).sum::<u32>() ^ SIGNS;
        let (even, odd) = (sum(0), sum(1));
        *out = [(even & 0xffff) | odd << 16, even >> 16 | (odd & 0xffff_0000)];
    }
    Some(())
}

/// How a residual follows from a pixel, and its weight from that.
#[derive(Clone, Copy, Debug)]
pub struct Weighing<'a> {
    /// Weights of four columns, two a word.
    pub across: [u32; 2],
    /// Taken off for each grey level of the patch, and added to all.
    pub gain: i32,
    /// What is added to all.
    pub rest: i32,
    /// Bins per residual, Q16.
    pub bins: i32,
    /// Weights of the bins from −128 to 127.
    pub weights: &'a [u8; 256],
}

/// The instructions that give the residuals r11 and r12 of a pair their weights and store all at r0 + `$at`.
#[cfg(feature = "dsp")]
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

/// e, w and their product for fours of pixels, pixels 0 and 2, then 1 and 3. `columns`: of the reference, two a word, one
/// four more than pixels. e is limited to 13 bits.
#[inline(always)]
pub fn weigh_residuals(fours: &mut [[Pair; 2]], columns: &[[u32; 2]], weighing: &Weighing<'_>) {
    if columns.len() <= fours.len() {
        return;
    }
    let &Weighing { across, gain, rest, bins, weights } = weighing;
    #[cfg(feature = "dsp")]
    if !fours.is_empty() {
        // SAFETY: each turn reads one entry of `columns`, of which there is one more than turns, and works on one of
        // `fours`, as long as there is one; a bin of eight bits with sign lies within the table around its middle. What is
        // pushed is the compiler's again at the end.
        unsafe {
            core::arch::asm!(
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
    #[cfg(not(feature = "dsp"))]
    for ([even, odd], columns) in fours.iter_mut().zip(columns.windows(2)) {
        // Columns 0 1, 2 3 and 4 5, then 1 2, 3 4 and 5 6.
        let ([a, b], [c, d]) = (columns[0], columns[1]);
        let (ab, bc, cd) = (super::across(a, b), super::across(b, c), super::across(c, d));
        for (pair, (first, second, third)) in [(even, (a, b, c)), (odd, (ab, bc, cd))] {
            let e = [(low(pair.p), first, second), (high(pair.p), second, third)].map(|(p, first, second)| {
                let rest = rest.wrapping_sub(gain.wrapping_mul(p));
                (dot(second, across[1], dot(first, across[0], rest)) >> 12).clamp(-4096, 4095)
            });
            let w = e.map(|e| {
                let bin = (e.wrapping_mul(bins) >> 16).clamp(-128, 127);
                weights[(bin + 128) as usize] as i32
            });
            (pair.w, pair.we, pair.e) = (pack(w[0], w[1]), pack(w[0] * e[0], w[1] * e[1]), pack(e[0], e[1]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pack;
    use super::*;

    /// Numbers of pixels, which have nothing to do with each other.
    fn pairs() -> [Pair; 6] {
        let number = |i: usize, most: i32| (i as i32 * 7919 + 13 * (i * i) as i32).rem_euclid(2 * most + 1) - most;
        core::array::from_fn(|i| {
            let two = |k: usize, most| [number(12 * i + k, most), number(12 * i + k + 5, most)];
            let (x, y, p, e) = (two(0, 255), two(1, 255), two(2, 128), two(3, 500));
            let w = two(4, 32).map(|w| w + 32);
            let we = [w[0] * e[0], w[1] * e[1]];
            let [x, y, p, w, we, e] = [x, y, p, w, we, e].map(|[first, second]| pack(first, second));
            Pair { x, y, p, w, we, e }
        })
    }

    #[test]
    fn sums_are_over_all_pixels() {
        let (mut products, mut sums) = ([0; 6], [0; 9]);
        let pairs = pairs();
        for pair in &pairs {
            for half in [low, high] {
                let [x, y, p, w, e] = [pair.x, pair.y, pair.p, pair.w, pair.e].map(half);
                for (sum, term) in products.iter_mut().zip([x * x, x * y, x * p, y * y, y * p, p * p]) {
                    *sum += w * term;
                }
                for (sum, term) in sums.iter_mut().zip([x, y, p, 1, e * x, e * y, e * p, e, e * e]) {
                    *sum += w * term;
                }
            }
        }
        assert_eq!((weighed_products(&pairs), weighed_sums(&pairs)), (products, sums));
        assert_eq!((weighed_products(&[]), weighed_sums(&[])), ([0; 6], [0; 9]));
    }

    #[test]
    fn rows_and_residuals_are_weighed() {
        const STRIDE: usize = 17;
        let pixels: [u8; 4 * STRIDE] = core::array::from_fn(|i| (i * i * 31 + 7 * i) as u8);
        let (down, across) = ([10, 150, 90, 6], [40, 160, 50, 6]);
        let mut columns = [[0; 2]; 4];
        assert_eq!(weigh_rows(&pixels, STRIDE, down, &mut columns), Some(()));
        assert_eq!(weigh_rows(&pixels, STRIDE, down, &mut [[0; 2]; 5]), None, "a row too short");
        let column =
            |col: usize| (0..4).map(|row| down[row] as i32 * pixels[row * STRIDE + col] as i32).sum::<i32>() - 32_768;
        for col in 0..16 {
            let word = columns[col / 4][col % 4 / 2];
            assert_eq!([low(word), high(word)][col % 2], column(col), "column {col}");
        }
        let weights = core::array::from_fn(|i| 64 - (i as i32 - 128).unsigned_abs() as u8 / 2);
        let weighing = Weighing {
            across: [pack(across[0], across[1]), pack(across[2], across[3])],
            gain: 70_000,
            rest: -100_000,
            bins: 9_000,
            weights: &weights,
        };
        let mut fours = *pairs().as_chunks::<2>().0.first_chunk::<3>().unwrap();
        weigh_residuals(&mut fours, &columns, &weighing);
        for col in 0..12 {
            let (pair, half) = (&fours[col / 4][col % 2], if col % 4 < 2 { low } else { high });
            let read: i32 = (0..4).map(|i| across[i] * column(col + i)).sum();
            let e = ((read - 100_000 - 70_000 * half(pair.p)) >> 12).clamp(-4096, 4095);
            let w = weights[(((e * 9_000) >> 16).clamp(-128, 127) + 128) as usize] as i32;
            assert_eq!((half(pair.e), half(pair.w), half(pair.we)), (e, w, w * e), "pixel {col}");
        }
    }
}
