//! Intervals by drawing parts anew, each with replacement, where what lies in one part is not independent.

use crate::seeded::Random;

/// Draws, their seed, and the share of them below and above the interval.
const DRAWS: usize = 1000;
const SEED: u64 = 1;
const BEYOND: f64 = 0.025;

/// The interval that holds 95 % of the shares of as many parts drawn out of these. Of each part: how many of its members count, and how many it has.
#[must_use]
pub fn interval(parts: &[(f64, f64)]) -> [f64; 2] {
    let mut random = Random::new(SEED);
    let mut shares: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = (0..parts.len()).map(|_| parts[random.below(parts.len())]);
            let (count, all) = drawn.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
            count / all
        })
        .collect();
    shares.sort_by(f64::total_cmp);
    [BEYOND, 1.0 - BEYOND].map(|share| shares[(share * (DRAWS - 1) as f64).round() as usize])
}
