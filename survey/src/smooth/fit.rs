//! The fitted curve of one channel.

use super::Epochs;
use super::band::Factors;
use super::error::{Gap, SmoothError};
use super::problem::{Problem, Solution};
use super::spline::Spline;
use super::trend::Trend;

/// What the curve says at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// In the channel's unit.
    pub value: f64,
    /// In the channel's unit a second.
    pub rate: f64,
    /// Standard deviation of the value.
    pub sigma: f64,
}

/// A curve with what it was made from and how good it is.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The smoothing factor.
    pub alpha: f64,
    /// Whether GCV found its minimum at an end of the range it searches: the samples are noise about a polynomial, or
    /// without any noise.
    pub alpha_at_bound: bool,
    /// tr H: the effective number of parameters.
    pub edf: f64,
    /// √(V'PV / (n - tr H)): standard deviation of a sample with weight 1. The paper's 0.11 m leaves tr H out. It says nothing
    /// where GCV ended at its least alpha ([`Fit::tells_noise`]).
    pub sigma0: f64,
    /// n V'PV / (n - tr H)².
    pub gcv: f64,
    /// V'PV.
    pub vpv: f64,
    /// g: the curve at the samples.
    pub values: Vec<f64>,
    /// V = g - L; 0 where there is no sample.
    pub residuals: Vec<f64>,
    /// h_ii, the share of each sample in the curve at its instant.
    pub leverage: Vec<f64>,
    /// Samples that the outlier gate left out.
    pub rejected: Vec<usize>,
    /// Gaps beyond the usual limit that were bridged since a longer one was allowed.
    pub gaps: Vec<Gap>,
    epochs: Epochs,
    /// Diagonal of (P + alpha R)^-1.
    inverse: Vec<f64>,
    factors: Factors,
    spline: Spline,
}

impl Fit {
    pub(super) fn new(
        epochs: &Epochs,
        problem: &Problem,
        solution: Solution,
        alpha: f64,
        alpha_at_bound: bool,
    ) -> Self {
        let Solution { factors, values, inverse, edf, freedom, vpv } = solution;
        let weights = &problem.weights;
        let residual = |i: usize| if weights[i] > 0.0 { values[i] - problem.samples[i] } else { 0.0 };
        Fit {
            alpha,
            alpha_at_bound,
            edf,
            sigma0: (vpv / freedom).sqrt(),
            gcv: problem.counting as f64 * vpv / (freedom * freedom),
            vpv,
            residuals: (0..values.len()).map(residual).collect(),
            leverage: weights.iter().zip(&inverse).map(|(weight, inverse)| weight * inverse).collect(),
            rejected: Vec::new(),
            gaps: epochs.gaps(weights, epochs.usual_gap_s()),
            epochs: epochs.clone(),
            spline: Spline::through(epochs.t_s(), &values),
            values,
            inverse,
            factors,
        }
    }

    /// Value, rate and sigma at sample `i`.
    ///
    /// sigma = sigma0 √((P + alpha R)^-1)_ii. That is the standard deviation where S is a random curve whose d-th
    /// differences have the variance sigma0² / alpha: it holds the noise that is left and what the smoothing takes off.
    #[must_use]
    pub fn at_sample(&self, i: usize) -> Estimate {
        let [value, rate] = self.spline.at(self.epochs.t_s()[i]);
        Estimate { value, rate, sigma: self.sigma0 * self.inverse[i].sqrt() }
    }

    /// Value, rate and sigma at an instant between the first and the last sample.
    ///
    /// The value is w'g, w being the natural spline's factors, and sigma = sigma0 √(w'(P + alpha R)^-1 w). How far the true
    /// curve bends away from the spline between two samples is not in it: for order 2 up to 0.011 sigma0² / alpha in the
    /// variance, which counts below alpha = 0.1 only.
    ///
    /// # Errors
    /// [`SmoothError::OutOfRange`]: nothing is extrapolated.
    pub fn at(&self, t_s: f64) -> Result<Estimate, SmoothError> {
        self.inside(t_s)?;
        if let Ok(i) = self.epochs.t_s().binary_search_by(|t| t.total_cmp(&t_s)) {
            return Ok(self.at_sample(i));
        }
        let [value, rate] = self.spline.at(t_s);
        let (from, shares) = self.spline.shares(t_s);
        let sigma = self.sigma0 * self.factors.quadratic_form(from, &shares).sqrt();
        Ok(Estimate { value, rate, sigma })
    }

    /// The value alone at an instant between the first and the last sample, for those who ask often.
    ///
    /// # Errors
    /// As [`Fit::at`].
    pub fn value(&self, t_s: f64) -> Result<f64, SmoothError> {
        self.inside(t_s).map(|()| self.spline.at(t_s)[0])
    }

    fn inside(&self, t_s: f64) -> Result<(), SmoothError> {
        let all = self.epochs.t_s();
        let (from_s, to_s) = (all[0], all[all.len() - 1]);
        if (from_s..=to_s).contains(&t_s) { Ok(()) } else { Err(SmoothError::OutOfRange { t_s, from_s, to_s }) }
    }

    /// Whether sigmas say something: where GCV ends at its least alpha the curve passes through the samples, which are so rough, or
    /// so free of noise, that what they leave of it is an accident of that alpha.
    #[must_use]
    pub fn tells_noise(&self) -> bool {
        let counting = self.leverage.iter().filter(|leverage| **leverage > 0.0).count();
        // At the other end the curve is a polynomial of few parameters, and the noise is all that it leaves.
        !self.alpha_at_bound || self.edf < 0.5 * counting as f64
    }

    /// What all other samples say at sample `i`, for the same alpha: L_i + V_i / (1 - h_ii). Nothing is fitted
    /// again.
    #[must_use]
    pub fn left_out(&self, i: usize) -> f64 {
        let leverage = self.leverage[i];
        self.values[i] + self.residuals[i] * leverage / (1.0 - leverage)
    }

    /// The parametric part: constant, and line.
    #[must_use]
    pub fn trend(&self) -> Trend {
        Trend::of(self.epochs.t_s(), &self.values)
    }

    /// The instants of the samples.
    #[must_use]
    pub fn epochs(&self) -> &Epochs {
        &self.epochs
    }
}
