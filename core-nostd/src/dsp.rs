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

/// Adds the pixels of pairs of boxes, 6 wide each, to two sums a word (the first in the lower half); as many pairs as
/// both have. Sums that pass 2^16 are the caller's fault.
#[inline(always)]
pub fn add_sixes(row: &[u8], sums: &mut [[u16; 2]]) {
    let pairs = sums.len().min(row.len() / 12);
    #[cfg(feature = "dsp")]
    if pairs > 0 {
        // SAFETY: each turn reads 12 bytes of `row` and changes one pair of `sums`, as long as both have them.
        unsafe {
            core::arch::asm!(
                "2:",
                "ldr {a}, [{row}], #12",
                "ldr {b}, [{row}, #-8]",
                "ldr {sum}, [{sums}]",
                "usada8 {sum}, {a}, {zero}, {sum}",
                "uxth {a}, {b}",
                "lsr {b}, {b}, #16",
                "usada8 {sum}, {a}, {zero}, {sum}",
                "ldr {a}, [{row}, #-4]",
                "usad8 {b}, {b}, {zero}",
                "usada8 {b}, {a}, {zero}, {b}",
                "subs {n}, #1",
                "add {sum}, {sum}, {b}, lsl #16",
                "str {sum}, [{sums}], #4",
                "bne 2b",
                row = inout(reg) row.as_ptr() => _,
                sums = inout(reg) sums.as_mut_ptr() => _,
                n = inout(reg) pairs => _,
                zero = in(reg) 0u32,
                a = out(reg) _,
                b = out(reg) _,
                sum = out(reg) _,
                options(nostack),
            );
        }
    }
    #[cfg(not(feature = "dsp"))]
    for (pair, boxes) in sums.iter_mut().zip(row.chunks_exact(12)).take(pairs) {
        for (sum, pixels) in pair.iter_mut().zip(boxes.chunks_exact(6)) {
            *sum = sum.wrapping_add(pixels.iter().map(|&pixel| pixel as u16).sum());
        }
    }
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

    #[test]
    fn four_bytes_are_added() {
        assert_eq!(add_bytes(u32::from_le_bytes([1, 200, 255, 127]), 10), 10 + 1 + 200 + 255 + 127);
    }

    #[test]
    fn boxes_of_six_are_summed_in_pairs() {
        let row: [u8; 30] = core::array::from_fn(|i| (i * 9) as u8);
        let sum = |from: usize| row[from..from + 6].iter().map(|&p| p as u16).sum::<u16>();
        let mut sums = [[1, 2], [3, 4], [5, 6]];
        add_sixes(&row, &mut sums);
        assert_eq!(sums, [[1 + sum(0), 2 + sum(6)], [3 + sum(12), 4 + sum(18)], [5, 6]], "no half pair");
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
