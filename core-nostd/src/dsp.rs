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
        // keeps both within.
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
                rows = inout(reg) rows.as_flattened()[4 * first..].as_ptr() => _,
                own = inout(reg) rows[own][4 * first + 2..].as_ptr() => _,
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

    /// Room for the `words` of a piece that lies at `start` of the other picture; empty where there is none.
    pub fn add(&mut self, start: usize, words: usize) -> &mut [u32] {
        if words == 0 || !self.has_room(words) {
            return &mut [];
        }
        let (even, at) = (words.next_multiple_of(2), self.used);
        self.used += even + 2;
        let from = core::mem::replace(&mut self.end, start + 4 * even + 8);
        self.reach = self.reach.max(self.end);
        self.stream[at] = start.wrapping_sub(from) as u32;
        self.stream[at + 1] = even as u32;
        self.stream[self.used - 1] = 0;
        self.stream[self.used + 1] = 0;
        &mut self.stream[at + 2..at + 2 + words]
    }

    /// Adds to `sums[m]` the products of every digit and the signs of `others`, `m` words further on each: a negative byte
    /// is 1, others are 0, as are those beyond the end.
    ///
    /// One multiplication makes sixteen products and adds up those of equal shift, each in a digit of its own, seven
    /// shifts in all: 0.15 instructions a product.
    #[inline(always)]
    pub fn slide(&self, others: &[u8], sums: &mut [i64; 3]) {
        #[cfg(feature = "dsp")]
        if self.used > 0 && others.len() >= self.reach {
            let mut halves = sums.map(|sum| (sum as u32, (sum >> 32) as u32));
            // SAFETY: reads the stream up to its end, which `add` set, and `others` up to `reach`, which was checked.
            unsafe {
                core::arch::asm!(
                    "ldrd {w}, {n}, [{p}], #8",
                    "3:",
                    "add {r}, {r}, {w}",
                    "ldr {a}, [{r}], #4",
                    "ldr {b}, [{r}], #4",
                    "and {a}, {ones}, {a}, lsr #7",
                    "and {b}, {ones}, {b}, lsr #7",
                    "2:",
                    "ldr {w}, [{p}], #4",
                    "smlal {l0}, {h0}, {w}, {a}",
                    "ldr {a}, [{r}], #4",
                    "smlal {l1}, {h1}, {w}, {b}",
                    "and {a}, {ones}, {a}, lsr #7",
                    "smlal {l2}, {h2}, {w}, {a}",
                    "ldr {w}, [{p}], #4",
                    "smlal {l0}, {h0}, {w}, {b}",
                    "ldr {b}, [{r}], #4",
                    "smlal {l1}, {h1}, {w}, {a}",
                    "and {b}, {ones}, {b}, lsr #7",
                    "subs {n}, #2",
                    "smlal {l2}, {h2}, {w}, {b}",
                    "bne 2b",
                    "ldrd {w}, {n}, [{p}], #8",
                    "cmp {n}, #0",
                    "bne 3b",
                    p = inout(reg) self.stream.as_ptr() => _,
                    r = inout(reg) others.as_ptr() => _,
                    n = out(reg) _,
                    ones = in(reg) 0x0101_0101u32,
                    w = out(reg) _,
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

/// Σ p r and Σ r² of the first `length` bytes of two's complement, p of `own` and r of `others`. `own` has zeros behind
/// them up to a multiple of four. (0, 0) where either is too short; at most 2^16 bytes.
#[inline(always)]
pub fn dot_and_energy_padded(own: &[u8], others: &[u8], length: usize) -> (i32, i32) {
    let padded = length.next_multiple_of(4);
    if length == 0 || own.len() < padded || others.len() < padded {
        return (0, 0);
    }
    #[cfg(feature = "dsp")]
    {
        let (mut dot, mut energy) = (0i32, 0i32);
        // SAFETY: each turn reads four bytes of both, which were checked to have as many; the last word of `others` is
        // read again.
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
                // What lies behind them is taken off again.
                "ldr {r}, [{others}, #-4]",
                "lsr {r}, {r}, {bits}",
                "sxtb16 {b}, {r}",
                "sxtb16 {r}, {r}, ror #8",
                "smuad {b}, {b}, {b}",
                "smlad {r}, {r}, {r}, {b}",
                "sub {energy}, {energy}, {r}",
                own = inout(reg) own.as_ptr() => _,
                others = inout(reg) others.as_ptr() => _,
                n = inout(reg) padded => _,
                bits = in(reg) 32 - 8 * (padded - length),
                p = out(reg) _,
                r = out(reg) _,
                a = out(reg) _,
                b = out(reg) _,
                dot = inout(reg) dot,
                energy = inout(reg) energy,
                options(pure, readonly, nostack),
            );
        }
        (dot, energy)
    }
    #[cfg(not(feature = "dsp"))]
    dot_and_energy(&own[..length], &others[..length])
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
        assert_eq!(dot_and_energy(&own[..3], &others), (4 - 10 - 18, 16 + 25 + 36));
    }

    #[test]
    fn padding_has_no_energy() {
        let others: [u8; 12] = core::array::from_fn(|i| (50 * i + 90) as u8);
        for length in 1..=8 {
            let own: [u8; 8] = core::array::from_fn(|i| if i < length { (i * 77 + 13) as u8 } else { 0 });
            assert_eq!(dot_and_energy_padded(&own, &others, length), dot_and_energy(&own[..length], &others));
        }
        assert_eq!(dot_and_energy_padded(&[1; 8], &[1; 6], 6), (0, 0), "too short");
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
