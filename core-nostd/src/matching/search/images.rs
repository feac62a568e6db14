//! The high-pass images of patch and reference, and their scores for shifts.

use super::CLIPPING_STRIDE;
use crate::image::{Run, View};
use crate::matching::coarse_ranking::Ranking;
use crate::matching::high_pass::{ClippingThreshold, clip, each_piece, filter};
use crate::matching::kernels::correlation::{dot_and_energy, dots_and_energies};
use crate::matching::kernels::high_pass::STRIP;
use crate::matching::kernels::rows::{copy, fill};
use crate::matching::valid;
use crate::math;

/// Pixels of the coarse ranking, if the patch has them: over 330 of them no frame of the default scene is lost, see
/// [`super::CANDIDATES`].
pub(super) const RANKING_PX: usize = 300;
/// Largest stride of its runs, so that a large patch is ranked by all of its parts.
const RANKING_STRIDE: usize = 3;

/// A shift, from the upper left one on, and its sums over the whole patch.
#[derive(Clone, Copy, Default)]
pub(in crate::matching) struct ScoredShift {
    pub(in crate::matching) col: u16,
    pub(in crate::matching) row: u16,
    /// From the reference's first pixel to the one under the patch's.
    pub(in crate::matching) offset: usize,
    /// Σ p r, and Σ r² under the mask.
    pub(in crate::matching) products: i64,
    pub(in crate::matching) energy: i64,
    pub(in crate::matching) score: f32,
}

impl ScoredShift {
    /// A shift without its score.
    pub(in crate::matching) fn new(col: u16, row: u16) -> Self {
        ScoredShift { col, row, ..ScoredShift::default() }
    }

    /// Adds the sums of a piece.
    #[inline(always)]
    pub(in crate::matching) fn add(&mut self, (products, energy): (i32, i32)) {
        self.products += i64::from(products);
        self.energy += i64::from(energy);
    }

    /// Distance of another shift, the larger of both axes.
    pub(in crate::matching) fn apart(&self, other: &ScoredShift) -> u16 {
        self.col.abs_diff(other.col).max(self.row.abs_diff(other.row))
    }
}

/// The patch's high-pass image.
pub(super) struct Patch<'a> {
    patch: &'a View<'a>,
    runs: &'a [Run],
    threshold: u8,
    /// The clipped values of every piece, with zeros up to a multiple of four, if they fit.
    kept: Option<&'a [u8]>,
}

impl<'a> Patch<'a> {
    pub(super) fn new(patch: &'a View<'a>, runs: &'a [Run], buffer: &'a mut [u8]) -> Self {
        let mut threshold = ClippingThreshold::new();
        let mut count = 0;
        let mut add = |piece: &[u8]| {
            if count % CLIPPING_STRIDE == 0 {
                threshold.add(piece);
            }
            count += 1;
        };
        let mut needed = 0;
        each_piece(patch, runs, |piece| needed += padded(&piece));
        let Some(buffer) = buffer.get_mut(..needed) else {
            filter(patch, runs.iter().copied(), |_, values| add(values));
            return Patch { patch, runs, threshold: threshold.value(), kept: None };
        };
        let mut at = 0;
        filter(patch, runs.iter().copied(), |piece, values| {
            add(values);
            if let Some(kept) = buffer.get_mut(at..at + padded(&piece)) {
                put(values, kept);
                at += kept.len();
            }
        });
        let threshold = threshold.value();
        clip(threshold, buffer);
        Patch { patch, runs, threshold, kept: Some(buffer) }
    }

    /// Visits `part` pieces of every `whole`, evenly, with their clipped values.
    fn each(&self, (part, whole): (usize, usize), mut each: impl FnMut(Run, &[u8])) {
        let mut due = 0;
        let mut is_taken = || {
            let is_taken = due < part;
            due = if due >= whole - part { due + part - whole } else { due + part };
            is_taken
        };
        if let Some(mut kept) = self.kept {
            each_piece(self.patch, self.runs, |piece| {
                let Some((values, rest)) = kept.split_at_checked(padded(&piece)) else { return };
                kept = rest;
                if is_taken() {
                    each(piece, values);
                }
            });
            return;
        }
        filter(self.patch, self.runs.iter().copied(), |piece, values| {
            if is_taken() {
                let mut buffer = [0; STRIP];
                let buffer = &mut buffer[..padded(&piece).min(STRIP)];
                clip(self.threshold, values);
                put(values, buffer);
                each(piece, buffer);
            }
        });
    }
}

/// Bytes of a piece's values.
pub(in crate::matching) fn padded(piece: &Run) -> usize {
    ((piece.end - piece.start) as usize).next_multiple_of(4)
}

/// Copies values into a buffer, zeros behind them.
pub(in crate::matching) fn put(values: &[u8], buffer: &mut [u8]) {
    let (own, rest) = buffer.split_at_mut(values.len().min(buffer.len()));
    copy(values, own);
    fill(0, rest);
}

/// Both high-pass images.
pub(super) struct Images<'a> {
    patch: Patch<'a>,
    /// Σ p².
    energy: i64,
    reference: View<'a>,
}

impl<'a> Images<'a> {
    pub(super) fn new(patch: Patch<'a>, reference: View<'a>) -> Self {
        let mut energy = 0;
        patch.each((1, 1), |_, values| energy += dot_and_energy(values, values).0 as i64);
        Images { patch, energy, reference }
    }

    /// Whether the patch's image is zero throughout.
    pub(super) fn is_featureless(&self) -> bool {
        self.energy == 0
    }

    /// Coarse scores of every shift, `side` a row, over part of the pieces; returns how many large values they are of.
    /// Kept apart: it needs a kilobyte of stack.
    #[inline(never)]
    pub(super) fn rank(&self, side: usize, scores: &mut [i16]) -> u32 {
        let whole = valid(self.patch.runs).clamp(RANKING_PX, RANKING_STRIDE * RANKING_PX);
        let mut ranking = Ranking::new(&self.reference, self.patch.threshold, side, scores);
        self.patch.each((RANKING_PX, whole), |piece, values| ranking.add(piece, values));
        ranking.flush();
        ranking.counted()
    }

    /// Scores shifts by the whole patch, two at a time: an even number of them.
    pub(super) fn score(&self, shifts: &mut [ScoredShift]) {
        let stride = self.reference.stride();
        for shift in shifts.iter_mut() {
            shift.offset = shift.row as usize * stride + shift.col as usize;
        }
        self.patch.each((1, 1), |piece, own| {
            let length = (piece.end - piece.start) as usize;
            let base = piece.row as usize * stride + piece.start as usize;
            for [a, b] in shifts.as_chunks_mut::<2>().0 {
                let at = [base + a.offset, base + b.offset];
                let sums = dots_and_energies(own, self.reference.from(0, 0), at, length);
                a.add(sums[0]);
                b.add(sums[1]);
            }
        });
        for shift in shifts {
            shift.score = normalised(shift.products as f32, self.energy, shift.energy);
        }
    }
}

/// Products over the root of both energies.
pub(in crate::matching) fn normalised(products: f32, own: i64, other: i64) -> f32 {
    if own > 0 && other > 0 { products / (math::sqrt(own as f32) * math::sqrt(other as f32)) } else { 0.0 }
}
