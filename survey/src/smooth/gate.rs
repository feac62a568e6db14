//! An outlier gate, for those who ask for one.

use super::error::SmoothError;
use super::fit::Fit;
use super::{Epochs, Options, fit_all};

/// Samples on each side that an outlier pulls towards itself: the farthest of them is taken first.
const NEIGHBOURS: usize = 3;
/// Residuals of rounding, as a share of the largest value.
const ROUNDING: f64 = 1e-12;
/// The median amount of a normal variable with deviation 1.
const MEDIAN: f64 = 0.674_489_75;

/// Fits, leaves out what lies more than `gate` standard deviations off, and fits again until nothing does.
///
/// A residual is measured by its own deviation, sigma √((1 - h_ii) / p_i), and sigma by the median of all, which outliers
/// do not move. Of neighbouring ones only the farthest goes in a round, since it pulls the others off.
pub fn fit_without_outliers(
    epochs: &Epochs,
    values: &[f64],
    weights: &[f64],
    options: &Options,
    gate: f64,
) -> Result<Fit, SmoothError> {
    let mut kept = weights.to_vec();
    let counting = kept.iter().filter(|&&weight| weight > 0.0).count();
    let mut rejected = Vec::new();
    loop {
        let mut fit = fit_all(epochs, values, &kept, options)?;
        let outliers = outliers(&fit, &kept, gate);
        if outliers.is_empty() {
            rejected.sort_unstable();
            fit.rejected = rejected;
            return Ok(fit);
        }
        for &sample in &outliers {
            kept[sample] = 0.0;
        }
        rejected.extend(outliers);
        if 4 * rejected.len() > counting {
            return Err(SmoothError::GateRejects { rejected: rejected.len(), counting });
        }
    }
}

/// Samples beyond the gate that are farther off than their neighbours.
fn outliers(fit: &Fit, weights: &[f64], gate: f64) -> Vec<usize> {
    let n = weights.len();
    let off = |i: usize| {
        let redundancy = 1.0 - fit.leverage[i];
        if weights[i] > 0.0 && redundancy > 0.0 {
            fit.residuals[i].abs() * (weights[i] / redundancy).sqrt()
        } else {
            0.0
        }
    };
    let all: Vec<f64> = (0..n).map(off).collect();
    let mut sorted: Vec<f64> = (0..n).filter(|&i| weights[i] > 0.0).map(|i| all[i]).collect();
    let middle = sorted.len() / 2;
    let sigma = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN;
    // Samples on a polynomial have residuals of rounding only, none of which is an outlier.
    let largest = (0..n).map(|i| fit.values[i].abs() * weights[i].sqrt()).fold(0.0, f64::max);
    let limit = gate * sigma.max(ROUNDING * largest);
    let farthest = |i: usize| {
        let around = i.saturating_sub(NEIGHBOURS)..n.min(i + NEIGHBOURS + 1);
        around.into_iter().all(|j| all[j] < all[i] || (all[j] == all[i] && j >= i))
    };
    (0..n).filter(|&i| all[i] > limit && farthest(i)).collect()
}
