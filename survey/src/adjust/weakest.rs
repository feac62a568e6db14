//! Which unknowns the observations hardly determine.

use super::error::SolveError;
use super::model::Model;
use super::normal::{NormalError, Reduced};
use super::solve::{Adjustment, solved};
use faer::sparse::linalg::solvers::Llt;

/// Rounds of inverse iteration. Each divides what is not weakest by the gap of the eigenvalues, which for a defect is
/// many powers of ten.
const ROUNDS: usize = 6;
/// Damping under which a singular system can be solved.
const DAMPING: f64 = 1e-9;
/// Smallest eigenvalue of the reduced equations, scaled to a diagonal of ones, that leaves digits: below it only rounding
/// decides.
pub(super) const EIGENVALUE_MIN: f64 = 1e-13;
/// Part of the largest below which an unknown is not named, and how many are.
const NAMED: (f64, usize) = (0.3, 6);

impl<M: Model> Adjustment<'_, M> {
    /// The smallest eigenvalue of the reduced equations scaled to a diagonal of ones, and its eigenvector.
    pub(super) fn weakest(&self, reduced: &Reduced, factor: &Llt<usize, f64>) -> (f64, Vec<f64>) {
        let scales: Vec<f64> =
            self.diagonal(reduced).into_iter().map(|diagonal| diagonal.max(f64::MIN_POSITIVE).sqrt()).collect();
        // Not perpendicular to anything in particular.
        let mut vector: Vec<f64> = (0..scales.len()).map(|k| 1.0 + (k as f64 * 0.618_034).fract()).collect();
        let mut eigenvalue = f64::INFINITY;
        for _ in 0..ROUNDS {
            let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
            let right: Vec<f64> = vector.iter().zip(&scales).map(|(v, scale)| v / length * scale).collect();
            vector = solved(factor, &right).into_iter().zip(&scales).map(|(v, scale)| v * scale).collect();
            eigenvalue = 1.0 / vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        }
        (eigenvalue, vector)
    }

    fn diagonal(&self, reduced: &Reduced) -> Vec<f64> {
        let pattern = &self.equations.layout.pattern;
        (0..pattern.start.len() - 1)
            .flat_map(|block| {
                let (size, offset) = (pattern.size(block), pattern.diagonal(block));
                (0..size).map(move |inner| reduced.values[offset + inner * (size + 1)])
            })
            .collect()
    }

    /// Why the equations at `x` cannot be solved.
    pub(super) fn singular(&self, x: &[f64]) -> SolveError {
        let reduced = match self.equations.reduced(x, 0.0) {
            Err(NormalError::Behind(observation)) => return SolveError::Behind { observation },
            Err(NormalError::Parallel(point)) => return SolveError::Parallel { point },
            Ok(reduced) => reduced,
        };
        // What no equation touches has no scale to be judged by.
        let untouched: Vec<f64> = self.diagonal(&reduced).iter().map(|d| f64::from(u8::from(*d == 0.0))).collect();
        if untouched.contains(&1.0) {
            return SolveError::Singular { along: largest(&untouched) };
        }
        let Ok(reduced) = self.equations.reduced(x, DAMPING) else { return SolveError::NotFinite };
        let Some(factor) = self.factor(&reduced) else { return SolveError::NotFinite };
        let (_, vector) = self.weakest(&reduced, &factor);
        SolveError::Singular { along: largest(&vector) }
    }
}

/// The largest parts of a vector, with their indices.
pub(super) fn largest(vector: &[f64]) -> Vec<(usize, f64)> {
    let most = vector.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let mut parts: Vec<(usize, f64)> =
        vector.iter().map(|v| v / most).enumerate().filter(|(_, part)| part.abs() >= NAMED.0).collect();
    parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()).then(a.0.cmp(&b.0)));
    parts.truncate(NAMED.1);
    parts
}
