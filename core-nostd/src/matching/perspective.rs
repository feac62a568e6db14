//! The tilt that the perspective of a matched picture shows, by itself.
//!
//! An error a of the attitude, a small rotation about a horizontal axis, displaces what is rectified to (x, y) from the
//! nadir by a (H + x²/H, xy/H), H the height. The first term is a shift like one of the position, so a match alone does
//! not tell them apart. The others no position, heading or height makes: they are fitted together with the unknowns of
//! least-squares matching, from its solution on. Only a slope of the ground that the plane of rectification does not
//! have looks the same.

use super::Prior;
use super::histogram::Histogram;
use super::refine::estimate::{Estimate, SIGMA_MIN};
use super::refine::normal_equations::prior_px;
use super::refine::segment::{Autocorrelation, RESIDUAL_STEPS, Radiometry, Segment, Sums as SegmentSums, WEIGHT_STEPS};
use super::refine::smooth::smooth_into;
use super::refine::{EFFICIENCY, Inner, OVERRELAXATION, REACH_PX, SubPixel};
use crate::image::{Run, View};
use crate::math::squared;
use nalgebra::{Matrix2, Matrix2x4, Matrix4, SMatrix, SVector, Vector2};

/// Shift along columns and rows, rotation, scale, and curvature along columns and rows: the displacements.
const DISPLACEMENTS: usize = 6;
/// With gain and offset.
const UNKNOWNS: usize = DISPLACEMENTS + 2;
/// Passes. Over 290 frames of the default scene five leave the same errors as three within a tenth; with one, tilts of
/// three degrees come out a third as large, since their residuals pass for changed ground.
const PASSES: usize = 3;
/// Pixels of a segment, within which the displacements are taken as constant. Over those frames segments of four leave
/// errors a tenth smaller, at half as much cost again; whole rows would not show the curvature along columns.
const SEGMENT: usize = 8;
/// Smallest Σ w: four pixels of full weight for each unknown. Chosen, as in least-squares matching.
const WEIGHT_MIN: f32 = 4.0 * UNKNOWNS as f32;
/// Largest last step of a displacement, pixels at the patch's edge: a solution that moves on has not converged. Chosen.
const CONVERGED_PX: f32 = 0.3;
/// Error of the first order, one sigma, as a share of the tilt: pictures of 34 and 64 pixels, rotated exactly by two to six
/// degrees, show up to a fifth too little.
const FIRST_ORDER_SHARE: f32 = 0.1;

type Vector = SVector<f32, UNKNOWNS>;

/// The curvature of the displacements over a picture, columns to the right and rows down, per pixel: a point (x, y)
/// pixels from the nadir is displaced by (x² k + x y l, x y k + y² l). A tilt that displaces the nadir of a camera H
/// pixels high by d makes (k, l) = d / H².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    /// k and l.
    pub per_px: Vector2<f32>,
    /// Displacement of the nadir with them, columns to the right and rows down, less that of the match without them, pixels.
    pub nadir: Vector2<f32>,
    /// Covariance of the nadir's displacement and of `per_px`.
    together: Matrix4<f32>,
}

impl Curvature {
    /// Covariance of `per_px`.
    pub fn covariance(&self) -> Matrix2<f32> {
        self.together.fixed_view::<2, 2>(2, 2).into_owned()
    }

    /// Displacement of the nadir less what the tilt displaces it by and less that of the match without it, for a camera so
    /// high, columns to the right and rows down, pixels, with its covariance.
    pub fn resected(&self, height_px: f32) -> (Vector2<f32>, Matrix2<f32>) {
        let less = -squared(height_px);
        let by = Matrix2x4::new(1.0, 0.0, less, 0.0, 0.0, 1.0, 0.0, less);
        (self.nadir + self.per_px * less, by * self.together * by.transpose())
    }
}

/// The displacements of a point, each for one unknown, pixels: shift of the patch's centre, rotation and scale about it,
/// curvature about the nadir less that of the centre; the last four in units of half the patch's longer side.
struct Field {
    by: [(f32, f32); DISPLACEMENTS],
}

impl Field {
    /// At (`c`, `r`) from the patch's centre. `nadir`: from there as well. `half`: half the patch's longer side.
    fn at((c, r): (f32, f32), nadir: (f32, f32), half: f32) -> Self {
        let (u, v) = (c / half, r / half);
        let (x0, y0) = (-nadir.0 / half, -nadir.1 / half);
        let (x, y) = (u + x0, v + y0);
        let product = x * y - x0 * y0;
        Field { by: [(1.0, 0.0), (0.0, 1.0), (-v, u), (u, v), (x * x - x0 * x0, product), (product, y * y - y0 * y0)] }
    }

    /// The displacement by these unknowns.
    fn displacement(&self, of: &Vector) -> (f32, f32) {
        self.by.iter().zip(of).fold((0.0, 0.0), |sum, (by, of)| (sum.0 + of * by.0, sum.1 + of * by.1))
    }
}

/// Sums of one pass, in the units of [`SegmentSums`], over (displacements, grey, 1).
struct Sums {
    /// Lower triangle.
    products: SMatrix<f32, UNKNOWNS, UNKNOWNS>,
    residual: Vector,
    squares: f32,
    residuals: Autocorrelation,
}

impl Sums {
    fn new() -> Self {
        Sums {
            products: SMatrix::zeros(),
            residual: Vector::zeros(),
            squares: 0.0,
            residuals: Autocorrelation::default(),
        }
    }

    fn add(&mut self, sums: &SegmentSums, field: &Field) {
        let [xx, xy, yy, xp, yp, pp] = [sums.xx, sums.xy, sums.yy, sums.xp, sums.yp, sums.pp].map(|sum| sum as f32);
        let [x, y, p, w] = [sums.x, sums.y, sums.p, sums.w].map(|sum| sum as f32);
        let [xe, ye, pe, e] = [sums.xe, sums.ye, sums.pe, sums.e].map(|sum| sum as f32);
        let (grey, one) = (DISPLACEMENTS, DISPLACEMENTS + 1);
        for (row, (a, b)) in field.by.iter().enumerate() {
            let (ax, ay) = (a * xx + b * xy, a * xy + b * yy);
            for (col, (c, d)) in field.by.iter().enumerate().take(row + 1) {
                self.products[(row, col)] += ax * c + ay * d;
            }
            self.products[(grey, row)] += a * xp + b * yp;
            self.products[(one, row)] += a * x + b * y;
            self.residual[row] += a * xe + b * ye;
        }
        self.products[(grey, grey)] += pp;
        self.products[(one, grey)] += p;
        self.products[(one, one)] += w;
        self.residual[grey] += pe;
        self.residual[one] += e;
        self.squares += sums.ee as f32;
    }

    /// Normal matrix and right-hand side in units of the inverse variance, with the priors of rotation and scale; `None`
    /// with too few pixels.
    fn normal(
        &self,
        gain: f32,
        prior_px: (f32, f32),
        at: &Vector,
    ) -> Option<(SMatrix<f32, UNKNOWNS, UNKNOWNS>, Vector)> {
        let weight = self.products[(UNKNOWNS - 1, UNKNOWNS - 1)] / WEIGHT_STEPS as f32;
        if weight < WEIGHT_MIN {
            return None;
        }
        let squares = self.squares / (WEIGHT_STEPS * RESIDUAL_STEPS * RESIDUAL_STEPS) as f32;
        let variance = (squares / (weight - UNKNOWNS as f32)).max(squared(SIGMA_MIN));
        // Half a difference over two pixels; the reference's gradient is the patch's times the gain.
        let unit = |index: usize| if index < DISPLACEMENTS { -0.5 * gain } else { 1.0 };
        let by = 1.0 / (variance * WEIGHT_STEPS as f32);
        let product = |row: usize, col: usize| self.products[(row.max(col), row.min(col))];
        let mut normal = SMatrix::from_fn(|row, col| product(row, col) * (unit(row) * unit(col) * by));
        let mut right = Vector::from_fn(|row, _| self.residual[row] * (unit(row) * by / RESIDUAL_STEPS as f32));
        for (index, sigma) in [(2, prior_px.0), (3, prior_px.1)] {
            normal[(index, index)] += 1.0 / squared(sigma);
            right[index] -= at[index] / squared(sigma);
        }
        Some((normal, right))
    }
}

/// One pass over the pixels whose surroundings are valid.
struct Pass<'a> {
    smooth: &'a View<'a>,
    runs: &'a [Run],
    inner: &'a Inner,
    reference: &'a View<'a>,
    estimate: &'a Estimate,
    nadir: (f32, f32),
    /// Whether the correlation of residuals is computed, instead of their sizes for the next pass.
    is_last: bool,
}

impl Pass<'_> {
    fn sums(&self, at: &Vector, segment: &mut Segment, sizes: &mut Histogram) -> Sums {
        let estimate = self.estimate;
        let mut sums = Sums::new();
        let radiometry = Radiometry::new(estimate.gain, estimate.offset, estimate.outlier());
        sizes.clear();
        for index in 0..self.runs.len() {
            let Some(Run { row, start, end }) = self.inner.of(self.runs, index) else { continue };
            let (row, end) = (row as usize, end as usize);
            for start in (start as usize..end).step_by(SEGMENT) {
                let length = SEGMENT.min(end - start);
                let aside = 0.5 * (length as f32 - 1.0);
                let middle = (start as f32 + aside - estimate.centre.0, row as f32 - estimate.centre.1);
                let field = Field::at(middle, self.nadir, estimate.half);
                let by = field.displacement(at);
                let position = (start as f32 + by.0 + estimate.radius, row as f32 + by.1 + estimate.radius);
                if !segment.load(self.smooth, (start, row, length), self.reference, position, &radiometry) {
                    continue;
                }
                sums.add(&segment.sums(), &field);
                if self.is_last {
                    segment.correlate(&mut sums.residuals);
                } else {
                    segment.count(&radiometry, sizes);
                }
            }
        }
        sums
    }
}

/// The curvature of the match `found` of the patch's centre, around the whole-pixel `peak` in a reference that exceeds
/// the patch by `radius`; `None` if the picture does not determine it. `nadir`: from the patch's centre. `bytes`: space
/// for the smoothed patch.
pub fn curvature(
    (patch, runs): (&View<'_>, &[Run]),
    (reference, radius): (&View<'_>, u16),
    (peak, found): ((i16, i16), &SubPixel),
    nadir: (i16, i16),
    prior: Prior,
    bytes: &mut [u8],
) -> Option<Curvature> {
    let mut sizes = Histogram::new();
    let mut estimate = Estimate::new(patch, runs, reference, radius, (peak, (0.0, 0.0)), &mut sizes)?;
    let smooth = smooth_into(patch, runs, bytes)?;
    let inner = Inner::new(runs);
    let (half, nadir) = (estimate.half, (nadir.0 as f32, nadir.1 as f32));
    let mut at = Vector::zeros();
    (at[0], at[1]) = (found.d_col, found.d_row);
    (at[2], at[3]) = (found.turn_and_scale.0 * half, found.turn_and_scale.1 * half);
    let begun = at;
    let mut segment = Segment::default();
    let mut last = None;
    for pass in 0..PASSES {
        let is_last = pass + 1 == PASSES;
        let pass = Pass { smooth: &smooth, runs, inner: &inner, reference, estimate: &estimate, nadir, is_last };
        let sums = pass.sums(&at, &mut segment, &mut sizes);
        let (normal, right) = sums.normal(estimate.gain, prior_px(prior, half), &at)?;
        let normal = normal.cholesky()?;
        let step = normal.solve(&right) * OVERRELAXATION;
        let step = estimate.radiometric(&step, (!is_last).then(|| Radiometry::median(&sizes)));
        at += step;
        let off = (at[0] - found.d_col).abs().max((at[1] - found.d_row).abs());
        if off.is_nan() || off > REACH_PX || !estimate.is_radiometry() {
            return None;
        }
        if is_last && step.fixed_rows::<DISPLACEMENTS>(0).amax() < CONVERGED_PX {
            last = Some((normal.inverse(), sums.residuals.inflation()));
        }
    }
    let (covariance, inflation) = last?;
    let per_px = 1.0 / squared(half);
    // Columns: what the unknowns displace the nadir by, and the curvature.
    let there = Field::at(nadir, nadir, half);
    let mut by = SMatrix::<f32, UNKNOWNS, 4>::zeros();
    for (index, (col, row)) in there.by.into_iter().enumerate() {
        (by[(index, 0)], by[(index, 1)]) = (col, row);
    }
    (by[(DISPLACEMENTS - 2, 2)], by[(DISPLACEMENTS - 1, 3)]) = (per_px, per_px);
    let found = Vector2::new(at[DISPLACEMENTS - 2], at[DISPLACEMENTS - 1]) * per_px;
    let moved = by.fixed_columns::<2>(0).transpose() * (at - begun);
    let mut together = by.transpose() * covariance * by * (EFFICIENCY * inflation);
    for axis in 2..4 {
        together[(axis, axis)] += squared(FIRST_ORDER_SHARE * found.norm());
    }
    Some(Curvature { per_px: found, nadir: moved, together })
}
