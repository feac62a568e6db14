//! The normal equations of least-squares matching, from the sums of its segments.

use super::estimate::{Estimate, SIGMA_MIN, UNKNOWNS, Vector};
use super::segment::{Autocorrelation, RESIDUAL_STEPS, Sums as SegmentSums, WEIGHT_STEPS};
use crate::matching::Prior;
use nalgebra::SMatrix;

/// Smallest Σ w: four pixels of full weight for each unknown. Chosen; [`crate::matching::acceptance`] requires more.
const WEIGHT_MIN: f32 = 4.0 * UNKNOWNS as f32;

pub(super) type Normal = SMatrix<f32, UNKNOWNS, UNKNOWNS>;

/// Sums of one pass over the pixels, in the units of [`SegmentSums`]. The derivatives by rotation and scale are formed
/// like the patch's x and y: t = x · row − y · column and s = x · column + y · row, where row and column are measured
/// from the centre.
#[derive(Default)]
pub(super) struct Sums {
    /// Lower triangle of the products of (x, y, t, s, p, 1), row by row.
    products: [[f32; UNKNOWNS]; UNKNOWNS],
    /// Products of (x, y, t, s, p, 1) with the residual.
    residual: [f32; UNKNOWNS],
    squares: f32,
    pub(super) residuals: Autocorrelation,
    pub(super) count: u32,
}

impl Sums {
    /// Adds a segment whose middle is at (`c`, `r`) from the patch's centre.
    #[inline(never)]
    pub(super) fn add(&mut self, sums: &SegmentSums, (c, r): (f32, f32), pixels: u32) {
        let [xx, xy, yy, xp, yp, pp] = [sums.xx, sums.xy, sums.yy, sums.xp, sums.yp, sums.pp].map(|sum| sum as f32);
        let [x, y, p, w] = [sums.x, sums.y, sums.p, sums.w].map(|sum| sum as f32);
        let [xe, ye, pe, e] = [sums.xe, sums.ye, sums.pe, sums.e].map(|sum| sum as f32);
        let (tx, ty, sx, sy) = (r * xx - c * xy, r * xy - c * yy, c * xx + r * xy, c * xy + r * yy);
        let rows = [
            [xx, 0.0, 0.0, 0.0, 0.0, 0.0],
            [xy, yy, 0.0, 0.0, 0.0, 0.0],
            [tx, ty, r * tx - c * ty, 0.0, 0.0, 0.0],
            [sx, sy, c * tx + r * ty, c * sx + r * sy, 0.0, 0.0],
            [xp, yp, r * xp - c * yp, c * xp + r * yp, pp, 0.0],
            [x, y, r * x - c * y, c * x + r * y, p, w],
        ];
        for (index, (own, add)) in self.products.iter_mut().zip(&rows).enumerate() {
            for (own, add) in own.iter_mut().zip(add).take(index + 1) {
                *own += add;
            }
        }
        let residual = [xe, ye, r * xe - c * ye, c * xe + r * ye, pe, e];
        for (own, add) in self.residual.iter_mut().zip(&residual) {
            *own += add;
        }
        self.squares += sums.ee as f32;
        self.count += pixels;
    }

    /// Σ w.
    pub(super) fn weight(&self) -> f32 {
        self.products[5][5] / WEIGHT_STEPS as f32
    }

    /// Variance of a residual of weight 1, square grey levels.
    fn sigma2(&self) -> f32 {
        let squares = self.squares / (WEIGHT_STEPS * RESIDUAL_STEPS * RESIDUAL_STEPS) as f32;
        // A perfect match must not have a zero variance.
        (squares / (self.weight() - UNKNOWNS as f32).max(1.0)).max(SIGMA_MIN * SIGMA_MIN)
    }

    /// Derivative of the residual by each unknown over what the products hold.
    fn units(estimate: &Estimate) -> [f32; UNKNOWNS] {
        // Half a difference over two pixels; the reference's gradient is the patch's times the gain.
        let gradient = 0.5 * estimate.gain;
        [-gradient, -gradient, gradient / estimate.half, -gradient / estimate.half, 1.0, 1.0]
    }

    /// The normal matrix in units of the inverse variance, priors included; `None` with too few pixels.
    pub(super) fn normal(&self, prior: Prior, estimate: &Estimate) -> Option<Normal> {
        if self.weight() < WEIGHT_MIN {
            return None;
        }
        let per_variance = 1.0 / (self.sigma2() * WEIGHT_STEPS as f32);
        let units = Sums::units(estimate);
        let mut normal = Normal::from_fn(|row, col| {
            self.products[row.max(col)][row.min(col)] * (units[row] * units[col]) * per_variance
        });
        let (turn, scale) = prior_px(prior, estimate.half);
        normal[(2, 2)] += 1.0 / (turn * turn);
        normal[(3, 3)] += 1.0 / (scale * scale);
        Some(normal)
    }

    /// The right-hand side; the priors draw rotation and scale to zero.
    pub(super) fn right(&self, prior: Prior, estimate: &Estimate) -> Vector {
        let per_variance = 1.0 / (self.sigma2() * (WEIGHT_STEPS * RESIDUAL_STEPS) as f32);
        let units = Sums::units(estimate);
        let mut right = Vector::from_fn(|row, _| self.residual[row] * units[row] * per_variance);
        let (turn, scale) = prior_px(prior, estimate.half);
        right[2] -= estimate.turn / (turn * turn);
        right[3] -= estimate.scale / (scale * scale);
        right
    }
}

/// Prior sigmas as displacements at the patch's edge, with a floor that keeps the division finite.
pub(in crate::matching) fn prior_px(prior: Prior, half: f32) -> (f32, f32) {
    ((prior.turn_rad * half).max(1e-3), (prior.scale * half).max(1e-3))
}
