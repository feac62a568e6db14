//! The normal equations of one channel, and their solution for one smoothing factor.

use super::band::{Band, Factors};
use super::error::SmoothError;
use super::{Epochs, Order};

/// Smallest alpha that may be given, for unit weights: residuals and the degrees of freedom that they have, both some six
/// times alpha, still have six digits.
pub const ALPHA_LEAST: f64 = 1e-10;
/// Condition number of the equations at the largest alpha, tried or given. For unit weights and uniform epochs it is
/// 1 + 16 alpha (order 2) or 1 + 64 alpha (order 3), so alpha ends at 6.2e11 or 1.6e11.
pub const ALPHA_MAX_CONDITION: f64 = 1e13;

/// Samples that are a polynomial but for their own rounding are nearer to it than this share of the largest: some tens of
/// 2^-53.
const ROUNDING: f64 = 1e-14;

/// (P + alpha R) g = P L with everything that alpha does not change.
///
/// The weighted least-squares polynomial of degree d - 1 is taken off L first. R does not see it, so it is part of the
/// solution for every alpha; what is left is small, and so are its rounding errors.
#[derive(Debug)]
pub struct Problem {
    pub order: Order,
    roughness: Band,
    pub weights: Vec<f64>,
    pub samples: Vec<f64>,
    polynomial: Vec<f64>,
    /// L minus the polynomial, 0 where there is no sample.
    rest: Vec<f64>,
    /// Samples with a weight.
    pub counting: usize,
}

/// The curve for one alpha.
#[derive(Debug)]
pub struct Solution {
    pub factors: Factors,
    /// g.
    pub values: Vec<f64>,
    /// Diagonal of (P + alpha R)^-1.
    pub inverse: Vec<f64>,
    /// tr H, the effective number of parameters.
    pub edf: f64,
    /// n - tr H, summed from 1 - h_ii, so that it keeps its digits where alpha is small.
    pub freedom: f64,
    /// V'PV.
    pub vpv: f64,
}

impl Problem {
    pub fn new(epochs: &Epochs, values: &[f64], weights: &[f64], order: Order) -> Self {
        let samples: Vec<f64> =
            values.iter().zip(weights).map(|(&value, &weight)| if weight > 0.0 { value } else { 0.0 }).collect();
        let polynomial = polynomial(epochs.t_s(), &samples, weights, order.differences());
        let rest =
            (0..samples.len()).map(|i| if weights[i] > 0.0 { samples[i] - polynomial[i] } else { 0.0 }).collect();
        Problem {
            order,
            roughness: epochs.roughness(order),
            weights: weights.to_vec(),
            polynomial,
            rest,
            counting: weights.iter().filter(|&&weight| weight > 0.0).count(),
            samples,
        }
    }

    /// Mean of the weights above zero.
    pub fn mean_weight(&self) -> f64 {
        self.weights.iter().sum::<f64>() / self.counting as f64
    }

    /// Largest alpha: beyond it the condition number, at most 1 + alpha |R| / P, passes [`ALPHA_MAX_CONDITION`].
    pub fn alpha_max(&self) -> f64 {
        ALPHA_MAX_CONDITION * self.mean_weight() / self.roughness.norm()
    }

    /// A given alpha, if it is one.
    pub fn checked(&self, alpha: f64) -> Result<f64, SmoothError> {
        if alpha.is_nan() || alpha <= 0.0 {
            return Err(SmoothError::AlphaNotPositive { alpha });
        }
        let least = ALPHA_LEAST * self.mean_weight();
        if alpha < least {
            return Err(SmoothError::AlphaTooSmall { alpha, limit: least });
        }
        let limit = self.alpha_max();
        if alpha > limit {
            return Err(SmoothError::AlphaTooLarge { alpha, limit });
        }
        Ok(alpha)
    }

    /// Whether the samples are a polynomial of degree d - 1 but for rounding.
    pub fn is_polynomial(&self) -> bool {
        let largest = |values: &[f64]| values.iter().fold(0.0, |max: f64, value| max.max(value.abs()));
        largest(&self.rest) <= ROUNDING * largest(&self.samples)
    }

    /// The curve; `None` where rounding leaves the equations without a positive pivot.
    pub fn solved(&self, alpha: f64) -> Option<Solution> {
        let factors = self.roughness.factored(&self.weights, alpha)?;
        let right: Vec<f64> = self.weights.iter().zip(&self.rest).map(|(weight, rest)| weight * rest).collect();
        let mut values = factors.solved(&right);
        let inverse = factors.inverse_diagonal();
        let (mut edf, mut freedom, mut vpv) = (0.0, 0.0, 0.0);
        for (i, &weight) in self.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let residual = values[i] - self.rest[i];
            let leverage = weight * inverse[i];
            edf += leverage;
            freedom += 1.0 - leverage;
            vpv += weight * residual * residual;
        }
        for (value, polynomial) in values.iter_mut().zip(&self.polynomial) {
            *value += polynomial;
        }
        Some(Solution { factors, values, inverse, edf, freedom, vpv })
    }
}

/// The weighted least-squares polynomial with `terms` terms at each instant, from polynomials that are orthogonal on the
/// samples.
fn polynomial(t: &[f64], samples: &[f64], weights: &[f64], terms: usize) -> Vec<f64> {
    let n = t.len();
    let (first, last) = (t[0], t[n - 1]);
    let x: Vec<f64> = t.iter().map(|t| (2.0 * (t - first) - (last - first)) / (last - first)).collect();
    let product = |a: &[f64], b: &[f64]| (0..n).map(|i| weights[i] * a[i] * b[i]).sum::<f64>();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut rest = samples.to_vec();
    let mut sum = vec![0.0; n];
    for _ in 0..terms {
        let mut next: Vec<f64> = match basis.last() {
            Some(before) => before.iter().zip(&x).map(|(value, x)| value * x).collect(),
            None => vec![1.0; n],
        };
        for earlier in &basis {
            let share = product(&next, earlier) / product(earlier, earlier);
            next.iter_mut().zip(earlier).for_each(|(value, earlier)| *value -= share * earlier);
        }
        basis.push(next);
    }
    // Twice: the second pass takes off what the first one's rounding left.
    for term in basis.iter().chain(&basis) {
        let share = product(&rest, term) / product(term, term);
        for i in 0..n {
            rest[i] -= share * term[i];
            sum[i] += share * term[i];
        }
    }
    sum
}
