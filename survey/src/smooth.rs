//! Semi-parametric fit of a track or an attitude (paper 001), in double precision, on the ground: values, rates and
//! standard deviations at the samples and between them.
//!
//! The paper minimises V'PV + alpha S'RS over the curve B x + S, V = B x + S - L (eq. 3). With R = D'D of d-th differences,
//! whose null space holds B, the curve g = B x + S follows from (P + alpha R) g = P L alone, whatever the split into
//! parametric part and rest: a band of half-width d, solved in O(n). The paper asks for a positive definite R, which no
//! difference penalty is and which is not needed: P + alpha R is positive definite as soon as d samples count.
//!
//! 1. [`Epochs`]: instants, checked; plain differences where they are uniform, divided ones where they are not.
//! 2. [`smooth`]: one channel with its weights (0 where there is no sample), alpha given or by generalised cross validation.
//! 3. [`Fit`]: value, rate and sigma anywhere between the first and the last sample, by the natural cubic spline through
//!    g; sigma0 with the degrees of freedom that the curve leaves; what each sample is predicted by the others.
//! 4. [`Trend`]: the parametric part, split off afterwards.
//!
//! [`Samples`] reads the channels of a CSV file, [`Recorded`] those of a flight log's message, [`unwrap_turns`] makes angles
//! continuous.

mod angles;
mod band;
mod epochs;
mod error;
mod fit;
mod gate;
mod gcv;
mod problem;
mod recorded;
mod samples;
mod spline;
mod trend;

pub use angles::{turn_of, turned_over, unwrap_turns};
pub use epochs::{Epochs, GAP_SPACINGS};
pub use error::{Gap, SmoothError, TURN_MAX_DEG};
pub use fit::{Estimate, Fit};
pub use gcv::ALPHA_MIN;
pub use problem::{ALPHA_LEAST, ALPHA_MAX_CONDITION};
pub use recorded::{Fields, LOG_TIME, Recorded};
pub use samples::{Samples, read_instants};
pub use trend::{Line, Trend};

use problem::Problem;
use std::fmt;

/// Which differences measure roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// d = 2: straight lines are smooth.
    Second,
    /// d = 3: parabolas are smooth.
    Third,
}

impl Order {
    /// d.
    #[must_use]
    pub fn differences(self) -> usize {
        match self {
            Order::Second => 2,
            Order::Third => 3,
        }
    }

    /// The row of plain differences.
    pub(crate) fn plain(self) -> [f64; 4] {
        match self {
            Order::Second => [1.0, -2.0, 1.0, 0.0],
            Order::Third => [-1.0, 3.0, -3.0, 1.0],
        }
    }
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.differences())
    }
}

/// The smoothing factor, without unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// The minimum of generalised cross validation, n V'PV / (n - tr H)².
    Gcv,
    /// This one.
    Given(f64),
}

/// How a channel is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Differences of the penalty.
    pub order: Order,
    /// Smoothing factor.
    pub alpha: Alpha,
    /// Longest gap that is bridged, seconds; [`GAP_SPACINGS`] usual spacings unless given.
    pub gap_s: Option<f64>,
    /// Samples farther from the curve than so many standard deviations are left out; all are taken unless given.
    pub gate: Option<f64>,
}

impl Options {
    /// No outlier gate, the usual limit of gaps.
    #[must_use]
    pub fn new(order: Order, alpha: Alpha) -> Self {
        Options { order, alpha, gap_s: None, gate: None }
    }
}

/// Largest ratio of a weight above zero to the mean of these, and of the mean to a weight.
const WEIGHT_RATIO: f64 = 1e6;

/// Largest amount of a value: its squares can be summed.
const VALUE_MAX: f64 = 1e140;
/// Smallest amount that the largest value may have, for the same reason.
const VALUE_MIN: f64 = 1e-140;

/// Fits one channel: `values` in any unit, `weights` of the same length (inverse variances in units of sigma0²; 0 = no
/// sample, whose value is not looked at).
///
/// # Errors
/// [`SmoothError`]: too few samples, a value that is not finite, bad weights, a gap beyond the limit, equal samples, a
/// smoothing factor out of range, GCV without a minimum.
///
/// # Panics
/// When the three lengths differ.
pub fn smooth(epochs: &Epochs, values: &[f64], weights: &[f64], options: &Options) -> Result<Fit, SmoothError> {
    let n = epochs.t_s().len();
    assert!(values.len() == n && weights.len() == n, "a value and a weight for each epoch");
    check(values, weights, options.order)?;
    let limit_s = options.gap_s.unwrap_or_else(|| epochs.usual_gap_s());
    let gaps = epochs.gaps(weights, limit_s);
    if !gaps.is_empty() {
        return Err(SmoothError::GapTooLong { gaps, limit_s });
    }
    match options.gate {
        Some(gate) => gate::fit_without_outliers(epochs, values, weights, options, gate),
        None => fit_all(epochs, values, weights, options),
    }
}

/// The fit to all samples with a weight, which have been checked.
fn fit_all(epochs: &Epochs, values: &[f64], weights: &[f64], options: &Options) -> Result<Fit, SmoothError> {
    let problem = Problem::new(epochs, values, weights, options.order);
    let (alpha, at_bound) = match options.alpha {
        Alpha::Gcv => gcv::minimum(&problem)?,
        Alpha::Given(alpha) => (problem.checked(alpha)?, false),
    };
    let solution = problem.solved(alpha).ok_or(SmoothError::AlphaTooLarge { alpha, limit: problem.alpha_max() })?;
    Ok(Fit::new(epochs, &problem, solution, alpha, at_bound))
}

/// Values, weights and their number.
fn check(values: &[f64], weights: &[f64], order: Order) -> Result<(), SmoothError> {
    let needed = order.differences() + 1;
    if values.len() < needed {
        return Err(SmoothError::TooFew { samples: values.len(), order });
    }
    for (sample, &weight) in weights.iter().enumerate() {
        if !weight.is_finite() || weight < 0.0 {
            return Err(SmoothError::BadWeight { sample, weight });
        }
    }
    let counting = || (0..values.len()).filter(|&i| weights[i] > 0.0);
    let count = counting().count();
    if count < needed {
        return Err(SmoothError::RankDeficient { counting: count, order });
    }
    let mean = counting().map(|i| weights[i] / count as f64).sum::<f64>();
    for sample in counting() {
        if !values[sample].is_finite() {
            return Err(SmoothError::NotFinite { sample, what: "value" });
        }
        if values[sample].abs() > VALUE_MAX {
            return Err(SmoothError::NotFinite { sample, what: "value, squared and summed," });
        }
        let weight = weights[sample];
        if !(mean / WEIGHT_RATIO..=mean * WEIGHT_RATIO).contains(&weight) {
            return Err(SmoothError::BadWeight { sample, weight });
        }
    }
    let mut all = counting().map(|i| values[i]);
    match all.next() {
        Some(first) if all.all(|value| value == first) => return Err(SmoothError::AllEqual { value: first }),
        _ => {}
    }
    let largest = counting().map(|i| values[i].abs()).fold(0.0, f64::max);
    if largest < VALUE_MIN { Err(SmoothError::ValuesTooSmall { largest }) } else { Ok(()) }
}
