//! How much older than its stamp an estimated attitude is: true attitudes fitted to estimated ones.
//!
//! Beside each estimated attitude there is a true one, *shifted* against it by the same time each. Over a second of turning motion
//! the turn from the estimated to the true attitude is e = b + ω s: b the filter's error, which hardly changes within a second, ω
//! the rate of turning, s the shift. Each second gives a value of its own, by least squares over its samples less their
//! means; the shift is their mean with the weights Σ|ω − ω̄|², without those that stand apart.

use std::collections::VecDeque;

/// Samples of a block are this old at most, microseconds.
const BLOCK_US: f64 = 1e6;
/// Samples a block takes at least.
const SAMPLES_MIN: usize = 8;
/// Blocks that are kept: ten minutes.
const BLOCKS_MAX: usize = 600;
/// Turning by less than this within a block, one sigma, says nothing: 1 degree a second.
const TURNING_RAD_S: f64 = 0.017;
/// Blocks that a shift takes.
const BLOCKS_MIN: usize = 3;
/// Blocks off the middle by more than so many times the usual distance are left out.
const GATE: f64 = 3.0;
/// From the median of absolute distances to one sigma, of normal errors.
const SIGMA_OF_MEDIAN: f64 = 1.4826;

/// A turn and a rate, forward, right, down: of the true against the estimated attitude, and of turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// When, microseconds.
    pub at_us: f64,
    /// Radians.
    pub turn_rad: [f64; 3],
    /// Radians a second.
    pub rate_rad_s: [f64; 3],
}

/// The shift, microseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// How much younger than the estimated attitude the true one is.
    pub shift_us: f64,
    /// One sigma.
    pub sigma_us: f64,
    /// Seconds of turning motion that it is from.
    pub blocks: usize,
}

/// The fit.
#[derive(Debug, Default)]
pub struct ShiftFit {
    open: Vec<Turn>,
    /// Σ|ω − ω̄|² and Σ(ω − ω̄)·(e − ē) of each block.
    blocks: VecDeque<(f64, f64)>,
}

impl ShiftFit {
    /// Takes a sample.
    pub fn take(&mut self, turn: Turn) {
        if self.open.first().is_some_and(|first| turn.at_us - first.at_us > BLOCK_US || turn.at_us < first.at_us) {
            self.close();
        }
        self.open.push(turn);
    }

    fn close(&mut self) {
        let samples = std::mem::take(&mut self.open);
        if samples.len() < SAMPLES_MIN {
            return;
        }
        let count = samples.len() as f64;
        let mean = |pick: fn(&Turn) -> [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| samples.iter().map(|sample| pick(sample)[axis]).sum::<f64>() / count)
        };
        let (turn, rate) = (mean(|sample| sample.turn_rad), mean(|sample| sample.rate_rad_s));
        let (mut square, mut product) = (0.0, 0.0);
        for sample in &samples {
            for axis in 0..3 {
                let faster = sample.rate_rad_s[axis] - rate[axis];
                square += faster * faster;
                product += faster * (sample.turn_rad[axis] - turn[axis]);
            }
        }
        if square < count * TURNING_RAD_S * TURNING_RAD_S {
            return;
        }
        self.blocks.push_back((square, product));
        if self.blocks.len() > BLOCKS_MAX {
            self.blocks.pop_front();
        }
    }

    /// The shift; `None` where the vehicle has hardly turned.
    pub fn fitted(&self) -> Option<Fitted> {
        if self.blocks.len() < BLOCKS_MIN {
            return None;
        }
        let mut shifts: Vec<(f64, f64)> =
            self.blocks.iter().map(|(square, product)| (product / square, *square)).collect();
        shifts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let middle = weighted_middle(&shifts);
        // A block's distance counts by its weight.
        let mut distances: Vec<f64> =
            shifts.iter().map(|(shift, square)| (shift - middle).abs() * square.sqrt()).collect();
        distances.sort_by(f64::total_cmp);
        let usual = SIGMA_OF_MEDIAN * distances[distances.len() / 2];
        let is_kept = |(shift, square): &&(f64, f64)| (shift - middle).abs() * square.sqrt() <= GATE * usual;
        let kept: Vec<_> = shifts.iter().filter(is_kept).collect();
        let whole: f64 = kept.iter().map(|(_, square)| square).sum();
        let shift_s = kept.iter().map(|(shift, square)| shift * square).sum::<f64>() / whole;
        // Blocks are independent, samples of one are not.
        let spread: f64 = kept.iter().map(|(shift, square)| (square * (shift - shift_s)).powi(2)).sum();
        let few = kept.len() as f64 / (kept.len() as f64 - 1.0).max(1.0);
        Some(Fitted { shift_us: 1e6 * shift_s, sigma_us: 1e6 * (few * spread).sqrt() / whole, blocks: kept.len() })
    }
}

/// The value with half of the weight on each side, of sorted ones.
fn weighted_middle(sorted: &[(f64, f64)]) -> f64 {
    let half = 0.5 * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    for (value, weight) in sorted {
        sum += weight;
        if sum >= half {
            return *value;
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{GaussMarkov, White};

    /// Two minutes at 50 Hz of a vehicle that rolls by `roll_deg` with 0.3 Hz; its filter is off by half a degree that
    /// wanders within ten seconds, and its rates are noisy.
    fn fitted(roll_deg: f64, shift_us: f64, outliers: bool) -> Option<Fitted> {
        let mut fit = ShiftFit::default();
        let mut wander = GaussMarkov::new(0.5_f64.to_radians(), 10.0, 1, "wander");
        let mut noise = White::new(2e-4, 1, "white");
        for index in 0..6000 {
            let at_us = f64::from(index) * 20_000.0;
            let phase = 0.3 * std::f64::consts::TAU * at_us * 1e-6;
            let rate = roll_deg.to_radians() * 0.3 * std::f64::consts::TAU * phase.cos();
            let wrong = if outliers && index / 50 % 10 == 0 { 0.2 * phase.cos() } else { 0.0 };
            let off = wander.at(at_us as u64) + noise.draw() + wrong;
            let turn_rad = [rate * shift_us * 1e-6 + off, off, -off];
            fit.take(Turn { at_us, turn_rad, rate_rad_s: [rate * 1.02, 0.0, 0.0] });
        }
        fit.fitted()
    }

    #[test]
    fn the_shift_is_found_to_a_millisecond_within_its_sigma() {
        for (shift_us, outliers) in [(0.0, false), (7000.0, false), (7000.0, true)] {
            let fitted = fitted(15.0, shift_us, outliers).unwrap();
            println!("{shift_us} us: {fitted:?}");
            assert!((fitted.shift_us - shift_us).abs() < 1000.0, "{fitted:?}");
            // 2 % of the rate are an error of the shift too.
            assert!((fitted.shift_us - shift_us).abs() < 4.0 * fitted.sigma_us + 0.02 * shift_us, "{fitted:?}");
        }
    }

    #[test]
    fn who_does_not_turn_has_no_shift() {
        assert_eq!(fitted(0.1, 7000.0, false), None);
        assert_eq!(ShiftFit::default().fitted(), None);
    }
}
