//! The coarse ranking: which shifts deserve the whole patch.
//!
//! Of the patch's high-pass image only the large values count, by their sign: larger than the median size, which is half of
//! them.
//! Of the reference's only the sign. So the reference has the same energy under the patch at every shift, nothing has to
//! be divided, and the products are so small that one multiplication makes sixteen ([`slide`]). Coarse values lose
//! a third of a pixel's information; more rows make up for it, at a tenth of the cost each.
use super::kernels::signs::{Digits, slide};
use crate::arch::{add_bytes, clamp_bytes};
use crate::image::{Run, View};

/// Large values that are ranked together: sums of their signs fit a digit.
const TOGETHER: usize = u8::MAX as usize;
/// Digits of a product before the one of the first shift.
const BEFORE: usize = 3;
/// Sums of products that are made at a time, each with four shifts that no other begins with.
const SUMS: usize = 3;

/// Scores of shifts while they are summed.
pub(super) struct Ranking<'a> {
    reference: &'a View<'a>,
    /// Of every shift, `side` a row.
    scores: &'a mut [i16],
    side: usize,
    /// Size from which on a value counts.
    large: u8,
    digits: Digits,
    /// Large values among them, and negative ones.
    count: u32,
    negative: u32,
    /// Large values in all.
    counted: u32,
}

impl<'a> Ranking<'a> {
    /// Ranks shifts in `reference`, whose rows are aligned to four, by values of a patch clipped to `threshold`.
    pub(super) fn new(reference: &'a View<'a>, threshold: u8, side: usize, scores: &'a mut [i16]) -> Self {
        scores.fill(0);
        let large = threshold.div_ceil(2).max(2);
        Ranking { reference, scores, side, large, digits: Digits::new(), count: 0, negative: 0, counted: 0 }
    }

    /// Adds a piece of a row of the patch, zeros behind it up to a multiple of four.
    pub(super) fn add(&mut self, piece: Run, own: &[u8]) {
        let (length, head) = ((piece.end - piece.start) as usize, piece.start as usize % 4);
        let needed = (head + length).div_ceil(4);
        if self.count as usize + length > TOGETHER || !self.digits.fits(needed) {
            self.flush();
        }
        let start = piece.row as usize * self.reference.stride() + piece.start as usize - head;
        let shift = 8 * head as u32;
        let mut before = 0u32;
        let mut own = own.as_chunks::<4>().0.iter();
        for word in self.digits.add(start, needed) {
            let next = own.next().map_or(0, |four| u32::from_le_bytes(*four));
            let values = (((next as u64) << 32 | before as u64) << shift >> 32) as u32;
            before = next;
            // Where a value is large, the two limits differ by one; as a difference of whole numbers that is a digit.
            let limited = |limit| (clamp_bytes(values, limit) ^ 0x8080_8080).swap_bytes();
            let (outer, inner) = (limited(self.large), limited(self.large - 1));
            *word = outer.wrapping_sub(inner);
            let large = (outer ^ inner) & 0x0101_0101;
            self.count = add_bytes(large, self.count);
            self.negative = add_bytes(large & !(outer >> 7), self.negative);
        }
    }

    /// Scores with what was added so far.
    pub(super) fn flush(&mut self) {
        // Makes every digit positive.
        let bias = (self.negative as u8 as u32 * 0x0101_0101) as i64;
        for (down, scores) in self.scores.chunks_exact_mut(self.side.max(1)).enumerate() {
            let mut carry = 0;
            for first in (0..(self.side + BEFORE).div_ceil(4)).step_by(SUMS) {
                let mut sums = [0; SUMS];
                slide(&self.digits, self.reference.from(down, 4 * first), &mut sums);
                let mut digits = [0; 4 * SUMS];
                for (sum, digits) in sums.iter().zip(digits.as_chunks_mut::<4>().0) {
                    carry = sum + (carry >> 32) + bias;
                    *digits = (carry as u32).to_le_bytes();
                }
                let (at, skipped) = if first == 0 { (0, BEFORE) } else { (4 * first - BEFORE, 0) };
                for (score, &negatives) in scores.iter_mut().skip(at).zip(digits.iter().skip(skipped)) {
                    *score -= negatives as i16;
                }
            }
        }
        self.digits.clear();
        self.counted += self.count;
        (self.count, self.negative) = (0, 0);
    }

    /// Large values that were scored.
    pub(super) fn counted(&self) -> u32 {
        self.counted
    }
}
