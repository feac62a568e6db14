//! Images of patch and reference, and the scores of shifts.

use super::gradients::{CHANNELS, filter, typical_energy};
use crate::image::{Run, View};
use crate::matching::coarse_ranking::Ranking;
use crate::matching::high_pass::each_piece;
use crate::matching::histogram::Histogram;
use crate::matching::kernels::correlation::{dot_and_energy, dots_and_energies};
use crate::matching::search::images::{ScoredShift, normalised, padded, put};
use crate::matching::valid;

/// Pixels that the coarse ranking takes, if the patch has as many: over 330 of them no frame of the default scene is lost, see
/// `CANDIDATES` of [`crate::matching::search`].
pub(super) const RANKING_PX: usize = 300;
/// It takes every third run at least, so that all parts of a large patch take part.
const RANKING_STRIDE: usize = 3;
/// Share of the pieces that is taken, (part, whole): all, and a sample for the median.
pub(super) const ALL: (usize, usize) = (1, 1);
const PART: (usize, usize) = (1, 4);

/// The patch's image: the values of every piece, padded by zeros to a multiple of four, the first channel before the second.
pub(super) struct Patch<'a> {
    patch: &'a View<'a>,
    runs: &'a [Run],
    values: &'a [u8],
}

impl<'a> Patch<'a> {
    /// `None` where `buffer` is too small.
    pub(super) fn new(patch: &'a View<'a>, runs: &'a [Run], buffer: &'a mut [u8]) -> Option<Self> {
        let mut needed = 0;
        each_piece(patch, runs, |piece| needed += padded(&piece));
        let buffer = buffer.get_mut(..CHANNELS * needed)?;
        let (first, second) = buffer.split_at_mut_checked(needed)?;
        let energy = typical_energy(patch, runs.iter().copied());
        let mut at = 0;
        filter(patch, runs.iter().copied(), energy, |piece, channels| {
            let end = at + padded(&piece);
            for (channel, values) in channels.into_iter().zip([&mut *first, &mut *second]) {
                put(channel, values.get_mut(at..end).unwrap_or(&mut []));
            }
            at = end;
        });
        Some(Patch { patch, runs, values: buffer })
    }

    /// (columns, rows).
    pub(super) fn size(&self) -> (u16, u16) {
        self.patch.size()
    }

    /// Valid pixels.
    pub(super) fn valid(&self) -> usize {
        valid(self.runs)
    }

    /// Median absolute value.
    fn median(&self) -> u8 {
        let mut sizes = Histogram::new();
        self.each(PART, |_, _, values| values.iter().for_each(|&value| sizes.add((value as i8).unsigned_abs())));
        sizes.median() as u8
    }

    /// Calls `each` with the channel and the values of `part` pieces in every `whole`, evenly spaced.
    pub(super) fn each(&self, (part, whole): (usize, usize), mut each: impl FnMut(usize, Run, &[u8])) {
        let mut values = self.values;
        for channel in 0..CHANNELS {
            let mut due = 0;
            each_piece(self.patch, self.runs, |piece| {
                let Some((own, rest)) = values.split_at_checked(padded(&piece)) else { return };
                values = rest;
                let is_taken = due < part;
                due = if due >= whole - part { due + part - whole } else { due + part };
                if is_taken {
                    each(channel, piece, own);
                }
            });
        }
    }
}

/// Both images.
pub(super) struct Images<'a> {
    pub(super) patch: Patch<'a>,
    /// Σ p² over the patch.
    pub(super) energy: i64,
    /// The second channel below the first.
    pub(super) reference: View<'a>,
}

impl<'a> Images<'a> {
    pub(super) fn new(patch: Patch<'a>, reference: View<'a>) -> Self {
        let mut energy = 0;
        patch.each(ALL, |_, _, values| energy += dot_and_energy(values, values).0 as i64);
        Images { patch, energy, reference }
    }

    /// Whether the patch's image is zero throughout.
    pub(super) fn is_featureless(&self) -> bool {
        self.energy == 0
    }

    /// First row of a channel in the reference's image.
    pub(super) fn first_row(&self, channel: usize) -> usize {
        channel * (self.reference.size().1 as usize / CHANNELS)
    }

    /// Coarse scores of every shift, `side` a row, from a sample of the pieces; returns the number of large values in them. Not inlined: it
    /// needs a kilobyte of stack.
    #[inline(never)]
    pub(super) fn rank(&self, side: usize, scores: &mut [i16]) -> u32 {
        let whole = self.patch.valid().clamp(RANKING_PX, RANKING_STRIDE * RANKING_PX);
        // Twice the median, as the limit of the high-pass images.
        let threshold = self.patch.median().saturating_mul(2);
        let mut ranking = Ranking::new(&self.reference, threshold, side, scores);
        self.patch.each((RANKING_PX, whole), |channel, piece, values| {
            let row = piece.row + self.first_row(channel) as u16;
            ranking.add(Run { row, ..piece }, values);
        });
        ranking.flush();
        ranking.counted()
    }

    /// Scores shifts by the whole patch, two at a time; of an odd number the last one twice.
    pub(super) fn score(&self, shifts: &mut [ScoredShift]) {
        let stride = self.reference.stride();
        for shift in shifts.iter_mut() {
            shift.offset = shift.row as usize * stride + shift.col as usize;
        }
        let (pairs, single) = shifts.as_chunks_mut::<2>();
        self.patch.each(ALL, |channel, piece, own| {
            let length = (piece.end - piece.start) as usize;
            let base = (piece.row as usize + self.first_row(channel)) * stride + piece.start as usize;
            let sums = |a: &ScoredShift, b: &ScoredShift| {
                let at = [base + a.offset, base + b.offset];
                dots_and_energies(own, self.reference.from(0, 0), at, length)
            };
            for [a, b] in pairs.iter_mut() {
                let [first, second] = sums(a, b);
                a.add(first);
                b.add(second);
            }
            if let [single] = single {
                single.add(sums(single, single)[0]);
            }
        });
        for shift in shifts {
            shift.score = normalised(shift.products as f32, self.energy, shift.energy);
        }
    }
}
