//! Sums of products of signs at many shifts at once, by long multiplication.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::slide;
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::slide;

/// Pieces of rows of signs, −1, 0 and 1, as digits of numbers to the base 256, four a word from right to left, with where
/// each piece lies in another picture.
#[derive(Debug)]
pub(crate) struct Digits {
    /// For each piece: bytes from the end of the one before (and two words) to its start, its words, and the words
    /// themselves; no words at the end.
    stream: [u32; Digits::CAPACITY],
    used: usize,
    /// Where the last piece ends, and bytes that the other picture needs.
    end: usize,
    reach: usize,
}

impl Digits {
    /// Words of the stream: seven pieces of a whole strip, 20 words each. About half of a strip's 64 pixels count, and 255
    /// may count together.
    const CAPACITY: usize = 160;

    /// No pieces.
    pub(crate) const fn new() -> Self {
        Digits { stream: [0; Digits::CAPACITY], used: 0, end: 0, reach: 0 }
    }

    /// No pieces again.
    pub(crate) fn clear(&mut self) {
        (self.stream[0], self.stream[1], self.used, self.end, self.reach) = (0, 0, 0, 0, 0);
    }

    /// Whether a piece of `words` still fits.
    pub(crate) fn fits(&self, words: usize) -> bool {
        self.used + words.next_multiple_of(2) + 4 <= Digits::CAPACITY
    }

    /// Where the `words` of a piece go that lies at `start` of the other picture, a multiple of four; empty where they do
    /// not fit.
    pub(crate) fn add(&mut self, start: usize, words: usize) -> &mut [u32] {
        if words == 0 || !start.is_multiple_of(4) || !self.fits(words) {
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
}

#[cfg(test)]
mod tests {
    use super::{Digits, slide};

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
        slide(&digits, &others, &mut sums);
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
        slide(&digits, &others, &mut sums);
        assert_eq!(sums.iter().rev().fold(0i128, |total, &sum| (total << 32) + sum as i128), total, "none left");
    }
}
