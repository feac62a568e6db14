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
