//! The smoothing factor by generalised cross validation.

use super::error::SmoothError;
use super::problem::Problem;

/// Smallest alpha that is tried, for unit weights: the curve passes through the samples.
pub const ALPHA_MIN: f64 = 1e-6;
/// Values that are tried in each power of ten.
const PER_DECADE: f64 = 4.0;
/// The search ends when the decimal logarithm of alpha is known to this.
const PRECISE: f64 = 1e-4;

/// Alpha at the smallest n V'PV / (n - tr H)², and whether it lies at an end of the range.
///
/// The range from [`ALPHA_MIN`] to the largest that the equations bear is scanned in quarters of a power of ten, since the
/// score may have several minima; the golden section takes over between the neighbours of the lowest value.
pub fn minimum(problem: &Problem) -> Result<(f64, bool), SmoothError> {
    let order = problem.order;
    if problem.counting < order.differences() + 2 {
        return Err(SmoothError::TooFewForGcv { counting: problem.counting, order });
    }
    if problem.is_polynomial() {
        return Err(SmoothError::NothingToWeigh { order });
    }
    let (low, high) = ((ALPHA_MIN * problem.mean_weight()).log10(), problem.alpha_max().log10());
    let steps = ((high - low) * PER_DECADE).ceil().max(2.0);
    let exponent = |i: f64| low + (high - low) * i / steps;
    let (mut best, mut lowest) = (0.0, f64::INFINITY);
    let mut i = 0.0;
    while i <= steps {
        let score = score(problem, exponent(i));
        if score < lowest {
            (best, lowest) = (i, score);
        }
        i += 1.0;
    }
    if best == 0.0 || best == steps {
        return Ok((10f64.powf(exponent(best)), true));
    }
    Ok((10f64.powf(golden_section(|x| score(problem, x), exponent(best - 1.0), exponent(best + 1.0))), false))
}

/// The score at a decimal logarithm of alpha; infinite where it cannot be had.
fn score(problem: &Problem, log_alpha: f64) -> f64 {
    let Some(solution) = problem.solved(10f64.powf(log_alpha)) else { return f64::INFINITY };
    let score = problem.counting as f64 * solution.vpv / (solution.freedom * solution.freedom);
    if score.is_nan() { f64::INFINITY } else { score }
}

/// Where `f` is smallest between `low` and `high`.
fn golden_section(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let inner = |low: f64, high: f64| (high - share * (high - low), low + share * (high - low));
    let (mut left, mut right) = inner(low, high);
    let (mut at_left, mut at_right) = (f(left), f(right));
    while high - low > PRECISE {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = inner(low, high).0;
            at_left = f(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = inner(low, high).1;
            at_right = f(right);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_golden_section_finds_a_minimum() {
        for at in [0.1, 0.5, 0.93] {
            let found = golden_section(|x| (x - at) * (x - at), 0.0, 1.0);
            assert!((found - at).abs() < PRECISE, "{found} {at}");
        }
    }
}
