//! The grid of log-likelihoods under the surface.

use super::CAP;
use super::peak::Peak;
use crate::matching::directions::half::{MIDDLE, SHIFTS, Scores};
use crate::math::squared;

/// Evidence that changes the odds by about a factor of e: the slope of the risk's log-odds where a surface is half decided.
const EVIDENCE_PER_NAT: f32 = 20.0;
/// Floor of the evidence, below which differences do not matter.
const EVIDENCE_MIN: f32 = -400.0;
/// Least [process noise](LikelihoodGrid::add_process_noise) that is applied, one sigma, cells: below, a step of one cell costs more than it
/// can gain. Chosen.
pub(super) const PROCESS_NOISE_MIN: f32 = 0.1;

/// Evidence at every shift, and one value for all positions beyond the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct LikelihoodGrid {
    pub evidence: Scores,
    /// That of a position which no frame has covered.
    beyond: f32,
}

impl LikelihoodGrid {
    /// Uniform.
    pub const fn new() -> Self {
        LikelihoodGrid { evidence: [[0.0; SHIFTS]; SHIFTS], beyond: 0.0 }
    }

    /// Gaussian prior, (columns, rows) cells from the centre, one sigma of each axis in cells, 0 where unknown. Limited as a key frame is.
    pub fn from_prior((col, row): (f32, f32), sigma: f32) -> Self {
        let cost = if sigma > 0.0 { 0.5 * EVIDENCE_PER_NAT / squared(sigma) } else { 0.0 };
        let of = |at: usize, off: f32| squared(at as f32 - MIDDLE as f32 - off);
        let against = |at_row, at_col| (-cost * (of(at_col, col) + of(at_row, row))).max(-CAP);
        let evidence = core::array::from_fn(|row| core::array::from_fn(|col| against(row, col)));
        LikelihoodGrid { evidence, beyond: if cost > 0.0 { -CAP } else { 0.0 } }
    }

    /// Shifts it by so many cells to the right and downwards.
    pub fn shift(&mut self, cols: i16, rows: i16) {
        shift(&mut self.evidence, self.beyond, (cols, rows));
    }

    /// Scales all evidence (exponential forgetting).
    pub fn discount(&mut self, share: f32) {
        self.evidence.as_flattened_mut().iter_mut().chain([&mut self.beyond]).for_each(|own| *own *= share);
    }

    /// Process noise of Gaussian steps, `sigma` of each axis in cells: each cell takes the maximum over all cells of evidence less the cost
    /// of the step, along rows and then columns.
    pub fn add_process_noise(&mut self, sigma: f32) {
        let cost = 0.5 * EVIDENCE_PER_NAT / squared(sigma);
        let best = |line: &[f32; SHIFTS], at: usize| {
            let from = line.iter().enumerate().map(|(from, own)| own - cost * squared(from as f32 - at as f32));
            from.fold(f32::MIN, f32::max)
        };
        for line in self.evidence.iter_mut() {
            let before = *line;
            *line = core::array::from_fn(|at| best(&before, at));
        }
        for col in 0..SHIFTS {
            let before: [f32; SHIFTS] = core::array::from_fn(|row| self.evidence[row][col]);
            for (row, line) in self.evidence.iter_mut().enumerate() {
                line[col] = best(&before, row);
            }
        }
    }

    /// Adds scores times `weight`; `peak`: the highest score, below which evidence is cut at [`CAP`].
    pub fn add(&mut self, scores: &Scores, weight: f32, peak: f32) {
        let least = weight * peak - CAP;
        let of = |score: f32| (weight * score).max(least);
        for (own, score) in self.evidence.as_flattened_mut().iter_mut().zip(scores.as_flattened()) {
            *own += of(*score);
        }
        self.beyond += of(0.0);
    }

    /// Evidence against every cell by its squared distance from a place, (column, row): `evidence` from `within` cells on.
    pub fn penalise_distance(&mut self, evidence: f32, (col, row): (f32, f32), within: f32) {
        let cost = evidence / squared(within);
        for (line, at) in self.evidence.iter_mut().zip(0..) {
            for (own, beside) in line.iter_mut().zip(0..) {
                let distance = squared(at as f32 - row) + squared(beside as f32 - col);
                *own -= (cost * distance).min(evidence);
            }
        }
        self.beyond -= evidence;
    }

    /// Normalises: the peak becomes 0, everything else at least [`EVIDENCE_MIN`]. Returns the peak.
    pub fn normalise(&mut self) -> Peak {
        let peak = Peak::of(&self.evidence);
        for own in self.evidence.as_flattened_mut().iter_mut().chain([&mut self.beyond]) {
            *own = (*own - peak.score).max(EVIDENCE_MIN);
        }
        Peak { score: 0.0, ..peak }
    }

    /// The peak, and the evidence of the second peak.
    pub fn peaks(&self) -> (Peak, f32) {
        let peak = Peak::of(&self.evidence);
        (peak, peak.second_peak(&self.evidence).max(self.beyond))
    }
}

/// A grid stored in half the memory: fixed-point numbers of 1/64, which hold the range of normalised grids.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoredGrid {
    evidence: [[i16; SHIFTS]; SHIFTS],
    beyond: i16,
}

/// Steps a unit: −[`EVIDENCE_MIN`] times as many is less than 2^15.
const STEPS_PER_UNIT: f32 = 64.0;

impl StoredGrid {
    /// Uniform.
    pub const fn new() -> Self {
        StoredGrid { evidence: [[0; SHIFTS]; SHIFTS], beyond: 0 }
    }

    /// Stores a grid.
    pub fn of(grid: &LikelihoodGrid) -> Self {
        let of = |evidence: f32| (STEPS_PER_UNIT * evidence) as i16;
        StoredGrid { evidence: grid.evidence.map(|line| line.map(of)), beyond: of(grid.beyond) }
    }

    /// The stored grid, to 1/64.
    pub fn restored(&self) -> LikelihoodGrid {
        let of = |kept: i16| f32::from(kept) / STEPS_PER_UNIT;
        LikelihoodGrid { evidence: self.evidence.map(|line| line.map(of)), beyond: of(self.beyond) }
    }

    /// As [`LikelihoodGrid::shift`].
    pub fn shift(&mut self, cols: i16, rows: i16) {
        shift(&mut self.evidence, self.beyond, (cols, rows));
    }
}

fn shift<T: Copy>(evidence: &mut [[T; SHIFTS]; SHIFTS], beyond: T, (cols, rows): (i16, i16)) {
    let from = |at: usize, by: i16| usize::try_from(at as i16 - by).ok();
    let before = *evidence;
    for (row, line) in evidence.iter_mut().enumerate() {
        for (col, own) in line.iter_mut().enumerate() {
            let place = from(row, rows).and_then(|row| before.get(row)?.get(from(col, cols)?));
            *own = place.copied().unwrap_or(beyond);
        }
    }
}
