//! The penalised least-squares fit of paper 001 over one window of samples, and its value, rate and noise at an instant.
//!
//! Paper 001 minimises V'PV + α S'RS for a parametric part B x and a free part S. Where R penalises differences and B lies
//! in its null space, as a constant or a line does, the curve g = B x + S does not depend on how it is split:
//! (P + α R) g = P L. That is the system solved here, with P the weights, in O(n).

use super::band::{BELOW, Band, Column, Factors, WINDOW};
use super::penalty::{ALPHA_MAX, Order, Penalty, row};
use crate::math;

/// Samples of a window, times in nominal intervals from the instant asked for, oldest first.
#[derive(Clone, Debug)]
pub struct Samples<const C: usize> {
    times: Column,
    values: [Column; C],
    /// 1, or 0 for a rejected sample.
    weights: Column,
    count: usize,
}

/// Why there is no fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FitError {
    /// Fewer than five samples, or fewer than order + 3 accepted ones: their curve would not be determined.
    TooFew,
    /// More samples than a window holds.
    TooMany,
    /// A time is not after the one before.
    Backwards,
    /// A time, value or weight is not a number, or a weight is negative.
    NotANumber,
    /// α is not above zero, or above [`ALPHA_MAX`].
    Alpha,
    /// The instant lies before the samples, or further ahead of them than [`AHEAD_MAX`].
    Outside,
    /// Samples so close that single precision cannot solve for so stiff a curve.
    Condition,
}

/// The curve at the instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted<const C: usize> {
    /// Value of each channel.
    pub value: [f32; C],
    /// Rate of each channel, per nominal interval.
    pub rate: [f32; C],
    /// Standard deviation of a value for samples of standard deviation 1 and weight 1.
    pub gain: f32,
    /// Standard deviation of a rate for such samples.
    pub rate_gain: f32,
    /// Ratio of the samples' noise to its configured sigma, about 1 if that is right: by their differences, or by
    /// the median of their residuals if some may be outliers.
    pub scale: f32,
    /// Samples rejected by the gate.
    pub rejected: u8,
}

const NONE: Column = [0.0; WINDOW + BELOW];
/// Farthest extrapolation beyond the newest sample, intervals.
pub const AHEAD_MAX: f32 = 2.0;
/// Gate: residuals beyond so many standard deviations are outliers. Chosen: normal noise passes five once in 1.7
/// million.
const GATE: f32 = 5.0;
/// Most outliers that are rejected; in a window with more the scale of the residuals represents the noise.
const REJECTED_MAX: u8 = 3;
/// Largest share of the refinement in the weights of an estimate: the share that is left is its square, a thousandth.
const CORRECTION_MAX: f32 = 1.0 / 32.0;
/// Median of the largest size among one, two and three standard normal numbers: 2 Φ(x) − 1 = 0.5^(1/C).
const MEDIAN_OF_NORMAL: [f32; 3] = [0.674_49, 1.051_80, 1.263_81];

impl<const C: usize> Samples<C> {
    /// Empty.
    pub const fn new() -> Self {
        Samples { times: NONE, values: [NONE; C], weights: NONE, count: 0 }
    }

    /// Appends a sample.
    ///
    /// # Errors
    /// [`FitError::TooMany`], [`FitError::Backwards`], [`FitError::NotANumber`]; nothing changes then.
    pub fn push(&mut self, time: f32, value: [f32; C], weight: f32) -> Result<(), FitError> {
        if !(time.is_finite() && weight >= 0.0 && weight.is_finite() && value.iter().all(|v| v.is_finite())) {
            return Err(FitError::NotANumber);
        }
        if self.times().last().is_some_and(|last| *last >= time) {
            return Err(FitError::Backwards);
        }
        if self.count >= WINDOW {
            return Err(FitError::TooMany);
        }
        self.put(self.count, time, value, weight);
        self.count += 1;
        Ok(())
    }

    fn put(&mut self, at: usize, time: f32, value: [f32; C], weight: f32) {
        let slots = (self.times.get_mut(at), self.weights.get_mut(at));
        if let (Some(t), Some(w)) = slots {
            (*t, *w) = (time, weight);
        }
        for (column, value) in self.values.iter_mut().zip(value) {
            if let Some(v) = column.get_mut(at) {
                *v = value;
            }
        }
    }

    /// Drops all samples.
    pub fn clear(&mut self) {
        *self = Samples::new();
    }

    /// The times.
    pub fn times(&self) -> &[f32] {
        self.times.get(..self.count).unwrap_or(&self.times)
    }

    /// Whether at least so many samples in a row are identical in every channel.
    pub fn repeats(&self, least: usize) -> bool {
        self.repeat(least, |i| self.values.iter().all(|column| column.get(i) == column.get(i - 1)))
    }

    /// Whether at least so many samples in a row differ by at most `by` in one channel.
    pub fn is_constant(&self, channel: usize, least: usize, by: f32) -> bool {
        let Some(column) = self.values.get(channel) else { return false };
        let step = |i: usize| column.get(i).zip(column.get(i - 1)).map(|(one, before)| (one - before).abs());
        self.repeat(least, |i| step(i).is_some_and(|step| step <= by))
    }

    fn repeat(&self, least: usize, is_same: impl Fn(usize) -> bool) -> bool {
        let mut run = 1;
        (1..self.count).any(|i| {
            run = if is_same(i) { run + 1 } else { 1 };
            run >= least
        })
    }

    /// Fits, and evaluates at time 0. `sigmas` are the channels' standard deviations for the outlier test; a channel
    /// with sigma 0 is not tested.
    ///
    /// # Errors
    /// [`FitError`].
    pub fn fit(&self, order: Order, alpha: f32, sigmas: [f32; C]) -> Result<Fitted<C>, FitError> {
        if !(alpha > 0.0 && alpha <= ALPHA_MAX) {
            return Err(FitError::Alpha);
        }
        if self.count < 5 {
            return Err(FitError::TooFew);
        }
        let times = self.times();
        let inside = times.first().zip(times.last()).is_some_and(|(first, last)| *first <= 0.0 && *last >= -AHEAD_MAX);
        if !inside {
            return Err(FitError::Outside);
        }
        let penalty = Penalty::new(times, order, alpha);
        let mut weights = self.weights;
        if accepted(&weights) < order.number() + 3 {
            return Err(FitError::TooFew);
        }
        let mut line = self.line(&weights);
        let mut detrended = self.detrended(&line);
        let mut rejected = 0;
        let mut factors = Factors::NONE;
        self.factor(&penalty, &weights, &mut factors)?;
        let scale = match noise(&penalty, &detrended, sigmas) {
            Some(scale) => scale,
            // To find the outliers, the curves are needed, and a new factorisation after each.
            None => loop {
                let (worst, scale) = worst(&factors, &penalty, &weights, &detrended, sigmas);
                let may_go = rejected < REJECTED_MAX && accepted(&weights) > order.number() + 3;
                let Some(worst) = worst.filter(|_| may_go) else { break scale };
                weights[worst] = 0.0;
                rejected += 1;
                line = self.line(&weights);
                detrended = self.detrended(&line);
                self.factor(&penalty, &weights, &mut factors)?;
            },
        };
        // The estimate is a weighted sum of the samples: one solution serves every channel.
        let (value, rate) = &row(times, 0.0, order);
        let ((mut value, correction), mut rate) = (refined(&factors, &penalty, &weights, value), factors.solve(rate));
        // False for a NaN as well.
        let is_solved = value.iter().all(|x| x.is_finite()) && correction <= CORRECTION_MAX * largest(&value);
        if !is_solved {
            return Err(FitError::Condition);
        }
        let (gain, rate_gain) = (estimator(&mut value, &weights), estimator(&mut rate, &weights));
        Ok(Fitted {
            value: core::array::from_fn(|c| line[c].0 + dot(&value, &detrended[c])),
            rate: core::array::from_fn(|c| line[c].1 + dot(&rate, &detrended[c])),
            gain,
            rate_gain,
            scale,
            rejected,
        })
    }

    fn factor(&self, penalty: &Penalty, weights: &Column, factors: &mut Factors) -> Result<(), FitError> {
        let mut band = Band::diagonal(weights.get(..self.count).unwrap_or(weights));
        penalty.add_to(&mut band);
        band.factor_into(factors).then_some(()).ok_or(FitError::TooFew)
    }

    /// Value at 0 and slope of the line through the first and the last accepted sample. The fit is of the differences
    /// from this line, which are small enough for single precision; the penalty of a line is zero.
    fn line(&self, weights: &Column) -> [(f32, f32); C] {
        let mut accepted = (0..self.count).filter(|i| weights.get(*i).is_some_and(|w| *w > 0.0));
        let (Some(a), Some(b)) = (accepted.next(), accepted.next_back()) else { return [(0.0, 0.0); C] };
        let at = |column: &Column, i: usize| column.get(i).copied().unwrap_or(0.0);
        let (t0, t1) = (at(&self.times, a), at(&self.times, b));
        let reciprocal = 1.0 / (t1 - t0);
        core::array::from_fn(|c| {
            let column = &self.values[c];
            let slope = (at(column, b) - at(column, a)) * reciprocal;
            (at(column, a) - slope * t0, slope)
        })
    }

    /// The samples' differences from the channels' lines.
    fn detrended(&self, line: &[(f32, f32); C]) -> [Column; C] {
        let mut detrended = [NONE; C];
        for ((detrended, values), line) in detrended.iter_mut().zip(&self.values).zip(line) {
            for (detrended, (time, value)) in detrended.iter_mut().zip(self.times.iter().zip(values)).take(self.count) {
                *detrended = value - (line.0 + line.1 * time);
            }
        }
        detrended
    }
}

/// Number of accepted samples.
fn accepted(weights: &Column) -> usize {
    weights.iter().filter(|weight| **weight > 0.0).count()
}

/// Ratio of the samples' noise to its configured sigma, from their differences; `None` if one of these is a spike.
fn noise<const C: usize>(penalty: &Penalty, detrended: &[Column; C], sigmas: [f32; C]) -> Option<f32> {
    let roughness = penalty.roughness(detrended, sigmas);
    let scale = if roughness.norms > 0.0 { math::sqrt(roughness.squares / roughness.norms) } else { 0.0 };
    (!roughness.is_spiked).then_some(scale)
}

/// The sample with the largest residual, if that is an outlier, and the residuals' scale by their median, which
/// outliers do not affect.
fn worst<const C: usize>(
    factors: &Factors,
    penalty: &Penalty,
    weights: &Column,
    detrended: &[Column; C],
    sigmas: [f32; C],
) -> (Option<usize>, f32) {
    let mut sizes = [0.0f32; WINDOW + BELOW];
    for (detrended, sigma) in detrended.iter().zip(sigmas).filter(|(_, sigma)| *sigma > 0.0) {
        let (g, _) = refined(factors, penalty, weights, &core::array::from_fn(|i| weights[i] * detrended[i]));
        for ((size, weight), (detrended, g)) in sizes.iter_mut().zip(weights).zip(detrended.iter().zip(g)) {
            if *weight > 0.0 {
                *size = size.max((detrended - g).abs() / sigma);
            }
        }
    }
    let largest =
        sizes.iter().enumerate().fold((0, 0.0), |worst, (i, size)| if *size > worst.1 { (i, *size) } else { worst });
    // Zeros of rejected samples come first.
    let accepted = accepted(weights);
    sort(&mut sizes);
    let median = sizes.get(sizes.len() - accepted + accepted / 2).copied().unwrap_or(0.0);
    let scale = median / MEDIAN_OF_NORMAL[(C - 1).min(2)];
    ((largest.1 > GATE * scale.max(1.0)).then_some(largest.0), scale)
}

/// Sorts a few numbers, smallest first: an insertion sort in one loop that cannot be unrolled. The library's sort has a
/// panicking branch for an inconsistent order.
#[inline(never)]
fn sort(sizes: &mut [f32]) {
    let mut at = 0;
    while let Some([below, above]) = sizes.get_mut(at..at + 2) {
        if *below > *above {
            core::mem::swap(below, above);
            at = at.saturating_sub(1);
        } else {
            at += 1;
        }
    }
}

/// Turns `x` into the samples' weights in an estimate; returns the estimate's standard deviation for samples of
/// standard deviation 1 and weight 1.
///
/// With (P + α R) g = P L it is row'g = (P x)'L, where x = (P + α R)⁻¹ row.
fn estimator(x: &mut Column, weights: &Column) -> f32 {
    // The noise of a sample of weight P has variance 1/P.
    let mut variance = 0.0;
    for (x, weight) in x.iter_mut().zip(weights) {
        variance += *x * *x * weight;
        *x *= weight;
    }
    math::sqrt(variance)
}

fn dot(weights: &Column, samples: &Column) -> f32 {
    weights.iter().zip(samples).map(|(weight, sample)| weight * sample).sum()
}

/// x of (P + α R) x = `right` after one step of iterative refinement: the factors' rounding, times the condition
/// number, would be a hundredth of the noise at the largest α; a thousandth of that is left. Also the largest
/// correction: its share of x is about the condition number times the rounding.
fn refined(factors: &Factors, penalty: &Penalty, weights: &Column, right: &Column) -> (Column, f32) {
    let mut x = factors.solve(right);
    let mut left = penalty.times(&x);
    for (((left, right), weight), x) in left.iter_mut().zip(right).zip(weights).zip(&x) {
        *left = right - weight * x - *left;
    }
    let correction = factors.solve(&left);
    for (x, correction) in x.iter_mut().zip(&correction) {
        *x += correction;
    }
    (x, largest(&correction))
}

/// Largest magnitude; NaNs are ignored.
fn largest(column: &Column) -> f32 {
    column.iter().fold(0.0, |most: f32, x| most.max(x.abs()))
}

impl<const C: usize> Default for Samples<C> {
    fn default() -> Self {
        Samples::new()
    }
}
