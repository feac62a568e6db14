//! Errors that neighbouring fixes share: those of an attitude that changes slowly are a tilt of the camera's for as long as they last.
//!
//! A fix is off by noise of its stated sigma times a scale, and along the camera's axes by the height times an angle that is a Gauss-Markov
//! process of first order, alike on both axes. How large the angle is and for how many fixes it lasts is not known: over a grid of both, each
//! pair counts by its restricted likelihood (which allows for what the unknowns take out of the residuals; H. D. Patterson, R. Thompson,
//! Biometrika 58, 1971), and the covariance of the estimate is the mean over all pairs. Likelihoods are by a Kalman filter, one pass over the
//! fixes each. An angle that lasts longer than the flight is the camera's tilt to it.

use super::{Normal, Vector};
use nalgebra::{Matrix2, SMatrix, Vector2};

/// How much larger than a fix's own noise what the angle does to it may be, as variances: by half decades from a tenth, and nothing. Chosen:
/// below there is nothing to find, above the noise is nothing.
const RATIOS: usize = 10;
const RATIO_MIN: f64 = 0.1;
/// Residual and derivatives by the unknowns.
const COLUMNS: usize = 6;

/// A fix: its standardised residual and the derivatives, on the axes that turn with the camera, and how the angle comes into both.
pub(super) struct Term {
    columns: SMatrix<f64, 2, COLUMNS>,
    /// Sigmas a radian.
    gain: f64,
}

impl Term {
    /// On the axes of a camera that heads so, clockwise from north. The noise of a standardised residual has no direction.
    pub(super) fn new(
        residual: Vector2<f64>,
        by: &SMatrix<f64, 2, { COLUMNS - 1 }>,
        heading_rad: f64,
        gain: f64,
    ) -> Self {
        let (sin, cos) = heading_rad.sin_cos();
        let mut columns = SMatrix::<f64, 2, COLUMNS>::zeros();
        columns.fixed_columns_mut::<1>(0).copy_from(&residual);
        columns.fixed_columns_mut::<{ COLUMNS - 1 }>(1).copy_from(by);
        Term { columns: Matrix2::new(cos, -sin, sin, cos) * columns, gain }
    }
}

/// The angle: its variance against that of a fix's noise of one sigma, and how much of it is left one fix later.
#[derive(Clone, Copy)]
struct Angle {
    variance: f64,
    left: f64,
}

/// The covariance of unknowns that were estimated as if all fixes were independent; `inverse`: of the normal equations, 0 where an unknown
/// is bound.
pub(super) fn covariance(terms: &[Term], inverse: &Normal) -> Normal {
    let angles = angles(terms);
    let weighed: Vec<(f64, f64)> = angles.iter().map(|angle| likelihood(terms, inverse, *angle)).collect();
    let best = weighed.iter().map(|(likelihood, _)| *likelihood).fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut weights) = (Normal::zeros(), 0.0);
    for (angle, (likelihood, noise)) in angles.iter().zip(weighed) {
        let weight = (likelihood - best).exp();
        sum += weight * noise * inverse * middle(terms, *angle) * inverse;
        weights += weight;
    }
    sum / weights
}

/// Those that are tried: each ratio with times of 1, 2, 4 and more fixes, up to the flight's.
fn angles(terms: &[Term]) -> Vec<Angle> {
    let squares = terms.iter().map(|term| term.gain * term.gain).sum::<f64>() / terms.len() as f64;
    let lasting = (0..).map(|power| f64::from(1u32 << power)).take_while(|fixes| *fixes <= terms.len() as f64);
    let mut angles = vec![Angle { variance: 0.0, left: 0.0 }];
    for left in lasting.map(|fixes| (-1.0 / fixes).exp()) {
        let ratio = |index: usize| RATIO_MIN * 10f64.powf(0.5 * index as f64);
        angles.extend((0..RATIOS).map(|index| Angle { variance: ratio(index) / squares, left }));
    }
    angles
}

/// The restricted likelihood's logarithm but for a constant, and the variance of a fix's noise that goes with it.
fn likelihood(terms: &[Term], inverse: &Normal, angle: Angle) -> (f64, f64) {
    let mut products = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    let (mut state, mut variance, mut logarithms) = (SMatrix::<f64, 2, COLUMNS>::zeros(), angle.variance, 0.0);
    for Term { columns, gain } in terms {
        let spread = gain * gain * variance + 1.0;
        let innovation = columns - *gain * state;
        products += innovation.transpose() * innovation / spread;
        // Both axes.
        logarithms += 2.0 * f64::ln(spread);
        state += innovation * (variance * gain / spread);
        variance /= spread;
        state *= angle.left;
        variance = angle.left * angle.left * variance + angle.variance * (1.0 - angle.left * angle.left);
    }
    let is_free = |k: usize| inverse[(k, k)] > 0.0;
    let mut normal: Normal = products.fixed_view::<{ COLUMNS - 1 }, { COLUMNS - 1 }>(1, 1).into_owned();
    (0..COLUMNS - 1).filter(|k| !is_free(*k)).for_each(|k| normal[(k, k)] = 1.0);
    let right: Vector = products.fixed_view::<{ COLUMNS - 1 }, 1>(1, 0).into_owned();
    let Some(factor) = normal.cholesky() else { return (f64::NEG_INFINITY, 0.0) };
    let left_over = products[(0, 0)] - right.dot(&factor.solve(&right));
    let freedom = (2 * terms.len()) as f64 - (0..COLUMNS - 1).filter(|k| is_free(*k)).count() as f64;
    let determinant: f64 = factor.l_dirty().diagonal().iter().map(|pivot| 2.0 * pivot.ln()).sum();
    (-0.5 * (logarithms + determinant + freedom * left_over.ln()), left_over / freedom)
}

/// A' C A: the derivatives' products by the covariance of the fixes' errors.
fn middle(terms: &[Term], angle: Angle) -> Normal {
    let mut sum = Normal::zeros();
    // What the fixes before have in common with this one.
    let mut before = SMatrix::<f64, 2, { COLUMNS - 1 }>::zeros();
    for Term { columns, gain } in terms {
        let by = columns.fixed_columns::<{ COLUMNS - 1 }>(1);
        let shared = angle.variance * gain * by.transpose() * before;
        sum += (1.0 + angle.variance * gain * gain) * by.transpose() * by + shared + shared.transpose();
        before = angle.left * (before + *gain * by);
    }
    sum
}
