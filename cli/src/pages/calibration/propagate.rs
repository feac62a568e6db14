//! What the covariance of the heads' unknowns makes of anything computed from the heads.

use plumbline_survey::adjust::rig::HEAD;
use plumbline_survey::calibrate::Calibration;

/// Quantities' changes by one standard deviation of every unknown, and how the unknowns go together.
///
/// The law of propagation, D R D' with R the correlations and D central differences under sigma-sized steps: no derivative
/// has to be written for each quantity, and a step is as large as the error it stands for.
#[derive(Clone, Debug)]
pub struct Propagated {
    /// An unknown a row.
    changes: Vec<Vec<f64>>,
    correlations: Vec<Vec<f64>>,
}

impl Propagated {
    /// Steps every unknown of the heads up and down; `None` where the quantities cannot be computed there, or are not as many.
    #[must_use]
    pub fn new(calibration: &Calibration, quantities: impl Fn(&[[f64; HEAD]]) -> Option<Vec<f64>>) -> Option<Self> {
        let at = |unknown: usize, sigmas: f64| {
            let mut heads = calibration.heads.clone();
            let of = &calibration.unknowns[unknown];
            heads[of.head][of.number] += sigmas * of.sigma;
            quantities(&heads)
        };
        let change = |unknown: usize| {
            let (up, down) = (at(unknown, 1.0)?, at(unknown, -1.0)?);
            (up.len() == down.len()).then(|| up.iter().zip(&down).map(|(up, down)| 0.5 * (up - down)).collect())
        };
        let changes: Vec<Vec<f64>> = (0..calibration.unknowns.len()).map(change).collect::<Option<_>>()?;
        let alike = changes.windows(2).all(|pair| pair[0].len() == pair[1].len());
        let sigma = |k: usize| calibration.unknowns[k].sigma;
        let correlation = |a: usize, b: usize| {
            let scale = sigma(a) * sigma(b);
            // Observations without noise leave no sigma.
            if scale > 0.0 { calibration.covariance[a][b] / scale } else { 0.0 }
        };
        let all = 0..changes.len();
        let correlations = all.clone().map(|a| all.clone().map(|b| correlation(a, b)).collect()).collect();
        alike.then_some(Propagated { changes, correlations })
    }

    /// Variance of a quantity.
    #[must_use]
    pub fn variance(&self, quantity: usize) -> f64 {
        let mut sum = 0.0;
        for (a, row) in self.changes.iter().zip(&self.correlations) {
            for (b, correlation) in self.changes.iter().zip(row) {
                sum += a[quantity] * correlation * b[quantity];
            }
        }
        sum.max(0.0)
    }
}
