//! How large residuals count: squares, or Huber's loss, which mistakes pull on less.

/// The loss of an observation, from the length of its whitened residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// By their squares.
    Squares,
    /// Huber's: by their length beyond so many standard deviations.
    Huber(f64),
}

/// What residuals say of the noise under a loss, as Huber (Robust Statistics, section 7.6) needs it: psi is a residual cut
/// at the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Sum of psi squared.
    pub squares: f64,
    /// Mean weight.
    pub weight: f64,
    /// Mean slope of psi, over both components.
    pub slope: f64,
}

impl Loss {
    /// The moments of residuals of these lengths.
    #[must_use]
    pub fn moments(self, lengths: impl IntoIterator<Item = f64>) -> Moments {
        let (mut count, mut sums) = (0usize, Moments { squares: 0.0, weight: 0.0, slope: 0.0 });
        for length in lengths {
            let weight = self.weight(length);
            sums.squares += if weight < 1.0 { weight * length } else { length }.powi(2);
            sums.weight += weight;
            // Beyond the limit psi keeps its length: no slope along the residual, the weight across.
            sums.slope += if weight < 1.0 { 0.5 * weight } else { 1.0 };
            count += 1;
        }
        let count = count.max(1) as f64;
        Moments { weight: sums.weight / count, slope: sums.slope / count, ..sums }
    }

    /// What turns the weighted sum of squares of residuals with so much redundancy into a variance, where the normal equations
    /// are weighted: s^2 = sum(psi^2) / r w / m^2, with w the mean weight and m the mean slope. One for squares.
    #[must_use]
    pub fn variance(self, residuals: &[[f64; 2]], of_priors: f64, redundancy: f64) -> f64 {
        let Moments { squares, weight, slope } = self.moments(residuals.iter().map(|[a, b]| a.hypot(*b)));
        (squares + of_priors) / redundancy * weight / slope.powi(2)
    }

    /// An observation's part of the cost.
    #[must_use]
    pub fn of(self, [a, b]: [f64; 2]) -> f64 {
        let squares = a * a + b * b;
        match self {
            Loss::Huber(limit) if squares > limit * limit => limit * (squares.sqrt() - 0.5 * limit),
            _ => 0.5 * squares,
        }
    }

    /// The weight under which squares have the slope of the loss, of a residual of this length.
    #[must_use]
    pub fn weight(self, length: f64) -> f64 {
        match self {
            Loss::Huber(limit) if length > limit => limit / length,
            _ => 1.0,
        }
    }
}
