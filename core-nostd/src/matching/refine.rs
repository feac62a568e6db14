//! Least-squares matching: the sub-pixel shift around a correlation peak, with its covariance.
//!
//! The reference is modelled as gain x patch + offset, read at positions shifted by (dx, dy) and, since heading and
//! height are uncertain, slightly rotated and scaled about the nadir. Rotation and scale have the sigmas of heading and
//! height as priors, so they are estimated where the picture determines them and held where it does not; what is left
//! of their uncertainty is in the shift's covariance.
//!
//! Noise and changed ground are in the reference, so it is the observation and the clean patch the model: the other way
//! round, changed ground would be a regressor, and no weight can correct a wrong regressor. The weights depend on the
//! residuals (Geman-McClure), whose scale is their median. Both pictures are smoothed by the same B-spline (module
//! `smooth`). A parabola through correlation scores leaves 0.12 px on the default scene, this 0.04 px, and a parabola
//! has no covariance.

pub(super) mod smooth;
pub(super) mod segment;
pub(super) mod estimate;
pub(super) mod normal_equations;

use super::histogram::Histogram;
use super::search::Peak;
use super::{Alone, Carried, Prior, Shift, valid};
use crate::budget::RUNS_MAX;
use crate::image::{Run, View};
use crate::math::squared;
use core::ops::AddAssign;
use estimate::Estimate;
use heapless::Vec;
use nalgebra::{Matrix2, Matrix4, Matrix6};
use normal_equations::{Sums, prior_px};
use segment::{Radiometry, Segment};
use smooth::{inner, smooth_into};

/// Why there is no sub-pixel shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RefineError {
    /// Fewer inner pixels than unknowns need, or no texture in one direction.
    TooLittle,
    /// The solution is too far from the peak, or would invert the picture.
    Diverged,
}

/// A sub-pixel match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubPixel {
    /// Rotation, clockwise as the picture is seen, radians, and scale less 1, about the patch's centre.
    pub turn_and_scale: (f32, f32),
    /// Covariance of (d_col, d_row, turn, scale).
    pub joint: Matrix4<f32>,
    /// Shift of the patch's centre, columns to the right, pixels.
    pub d_col: f32,
    /// Rows downwards.
    pub d_row: f32,
    /// Mean weight of the pixels, 0 to 1: the share of the picture that agrees.
    pub agreement: f32,
    /// Rotation and scale less 1 without their priors.
    pub alone: Alone,
}

impl SubPixel {
    /// The match for the point that lies `x` columns to the right of the patch's centre and `y` rows below it, which
    /// rotation and scale displace as well.
    #[must_use]
    pub fn at(self, (x, y): (f32, f32)) -> Self {
        let (turn, scale) = self.turn_and_scale;
        let mut by = Matrix4::identity();
        by.fixed_view_mut::<2, 2>(0, 2).copy_from(&Matrix2::new(-y, x, x, y));
        SubPixel {
            d_col: self.d_col + scale * x - turn * y,
            d_row: self.d_row + scale * y + turn * x,
            joint: by * self.joint * by.transpose(),
            ..self
        }
    }

    /// Covariance of (d_col, d_row), square pixels.
    #[must_use]
    pub fn covariance(&self) -> Matrix2<f32> {
        self.joint.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// The shift of the nadir, at this offset from the patch's centre, columns to the right and rows down.
    #[must_use]
    pub(crate) fn nadir(self, nadir: (i16, i16), prior: Prior) -> Shift {
        let is_aside = nadir != (0, 0);
        let there = if is_aside { self.at((nadir.0 as f32, nadir.1 as f32)) } else { self };
        Shift {
            d_col: there.d_col,
            d_row: there.d_row,
            covariance: there.covariance(),
            map_variance: 0.0,
            carried: if is_aside { there.determined(prior) } else { Carried::default() },
            alone: there.alone,
        }
    }

    /// Shares of rotation and scale that the picture determined: the reduction of the prior's variance.
    #[must_use]
    pub fn determined(&self, prior: Prior) -> Carried {
        let share = |axis: usize, sigma: f32| {
            let left = self.joint[(axis, axis)] / (sigma * sigma);
            if left < 1.0 { 1.0 - left } else { 0.0 }
        };
        Carried { turn: share(2, prior.turn_rad), scale: share(3, prior.scale) }
    }
}

/// Most passes, and how many of them may take every row if the patch is not large. Over the four series eight passes
/// were the most; five at most refuse five more of the 6,000 matches, twenty change none. Every row: chosen between
/// two, one after the first that is below [`CONVERGED_PX`], and all.
const PASSES: usize = 10;
const FULL_PASSES: usize = 4;
/// The first passes take part of the rows only, until a step is below this, pixels. Over the four series half as much
/// costs 0.2 passes over every row more and takes 2, 13, 2 and 0.5 % off the mean error, twice as much saves 0.15 and
/// adds 8, 22, 5 and 0.4 %.
const COARSE_UNTIL_PX: f32 = 0.07;
/// Fewest pixels of these passes, if the patch has them, and their largest stride of rows. 300 pixels are 50 for each
/// unknown. Over the four series half as many save 0.1 passes over every row, add 4, 3, 5 and 1 % to the mean error and
/// refuse ten more; twice as many cost 0.3 and take off 0, 5, 1 and 2 %.
const COARSE_PX: usize = 300;
const COARSE_STRIDE: usize = 4;
/// After a pass over every row with a step below this, one more is the last, pixels: each leaves a fifth of the
/// distance at most, two of them less than [`SYSTEMATIC_PX`].
const CONVERGED_PX: f32 = 0.1;
/// In patches of more pixels than this, one pass over every row follows those over a part of them. Chosen by its cost: a second
/// one in those of 790 pixels of the four series takes 2, 22, 5 and 2 % off the mean error, for 1.0 to 1.4 passes.
const LARGE_PX: usize = 600;
/// Overrelaxation: reweighting alone makes each step too short, the more so the more the weights depend on the
/// residuals. For normal ones it is E[ψ']/E[w] = 0.67 of the step (by quadrature), which passes over every row
/// compensate; passes over part of them, farther from the solution, are lengthened by less.
pub(super) const OVERRELAXATION: f32 = 1.5;
const COARSE_OVERRELAXATION: f32 = 1.3;
/// Ratio of the variance of a shift under these weights to that of the weighted sums alone, for normal residuals (by
/// simulation): E[w² e²]/E[ψ']² over E[w e²]/E[w]².
pub(super) const EFFICIENCY: f32 = 1.39;
/// Systematic error that residuals do not show, one sigma, pixels along each axis: positions rounded to 1/256 pixel,
/// and incomplete convergence.
const SYSTEMATIC_PX: f32 = 0.005;
/// Largest distance of the solution from the whole-pixel peak, pixels: the peak is off by a half, and by one more where
/// neighbouring shifts correlate alike.
pub(super) const REACH_PX: f32 = 1.5;
/// Smallest share of rotation or scale by the picture with which it is returned without its prior. Single precision
/// holds a hundredth of it.
const SHARE_MIN: f32 = 1e-3;
/// Side of the square around a patch pixel that has to be valid: to each side one for the smoothing, one for the
/// gradient.
const INNER_SIDE: usize = 5;

/// The sub-pixel shift around `peak`. `reference` is the view that was searched, `radius` the search's; `bytes`: space
/// for the smoothed patch.
///
/// # Errors
/// [`RefineError`].
pub fn refine(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    peak: &Peak,
    prior: Prior,
    bytes: &mut [u8],
) -> Result<SubPixel, RefineError> {
    let mut sizes = Histogram::new();
    let estimate = Estimate::new(patch, runs, reference, radius, (peak.at(), peak.vertex), &mut sizes);
    let mut estimate = estimate.ok_or(RefineError::TooLittle)?;
    let smooth = smooth_into(patch, runs, bytes).ok_or(RefineError::TooLittle)?;
    let pixels = valid(runs);
    let mut stride = (pixels / COARSE_PX).clamp(2, COARSE_STRIDE);
    let (mut full, mut step_px) = (0, f32::MAX);
    let mut segment = Segment::default();
    let inner = Inner::new(runs);
    let mut last = None;
    for _ in 0..PASSES {
        let is_last =
            stride == 1 && (pixels > LARGE_PX || full + 1 == FULL_PASSES || (full > 0 && step_px < CONVERGED_PX));
        let pass = Pass { smooth: &smooth, runs, inner: &inner, stride, reference, estimate: &estimate, is_last };
        let sums = pass.sums(&mut segment, &mut sizes);
        let normal =
            sums.normal(prior, &estimate).and_then(|normal| normal.cholesky()).ok_or(RefineError::TooLittle)?;
        let step = normal.solve(&sums.right(prior, &estimate))
            * if stride == 1 { OVERRELAXATION } else { COARSE_OVERRELAXATION };
        step_px = estimate.step(&step, Radiometry::median(&sizes));
        let off = (estimate.shift.0 - peak.d_col as f32).abs().max((estimate.shift.1 - peak.d_row as f32).abs());
        if off.is_nan() || off > REACH_PX || !estimate.is_radiometry() {
            return Err(RefineError::Diverged);
        }
        if is_last {
            last = Some((normal, sums));
            break;
        }
        full += usize::from(stride == 1);
        if step_px < COARSE_UNTIL_PX {
            stride = 1;
        }
    }
    let (normal, sums) = last.ok_or(RefineError::Diverged)?;
    let covariance = normal.inverse();
    let inflation = EFFICIENCY * sums.residuals.inflation();
    let floor = Matrix2::identity() * (SYSTEMATIC_PX * SYSTEMATIC_PX);
    // Rotation and scale are displacements at the patch's edge here.
    let per_px = Matrix4::from_diagonal(&[1.0, 1.0, 1.0 / estimate.half, 1.0 / estimate.half].into());
    let alone = alone(&covariance, prior, &estimate, inflation);
    let mut joint = per_px * covariance.fixed_view::<4, 4>(0, 0) * per_px * inflation;
    joint.fixed_view_mut::<2, 2>(0, 0).add_assign(&floor);
    Ok(SubPixel {
        turn_and_scale: (estimate.turn / estimate.half, estimate.scale / estimate.half),
        joint,
        d_col: estimate.shift.0,
        d_row: estimate.shift.1,
        agreement: sums.weight() / sums.count as f32,
        alone,
    })
}

/// Rotation and scale with the prior's share removed.
fn alone(covariance: &Matrix6<f32>, prior: Prior, estimate: &Estimate, inflation: f32) -> Alone {
    let (turn_px, scale_px) = prior_px(prior, estimate.half);
    let of = |axis: usize, off_px: f32, prior_px: f32| {
        // The reduction of the prior's variance is the picture's share, before the inflation for correlated residuals.
        let share = 1.0 - covariance[(axis, axis)] / squared(prior_px);
        let (off, variance) = (off_px / estimate.half, inflation * covariance[(axis, axis)] / squared(estimate.half));
        (share > SHARE_MIN).then_some((off / share, variance / share))
    };
    Alone { turn: of(2, estimate.turn, turn_px), scale: of(3, estimate.scale, scale_px) }
}

/// The pixels of each run whose surroundings are valid, computed once for patches of the size in flight.
pub(super) struct Inner {
    kept: Vec<Option<Run>, RUNS_MAX>,
}

impl Inner {
    pub(super) fn new(runs: &[Run]) -> Self {
        let mut kept = Vec::new();
        // Those beyond its capacity are computed each time.
        (0..runs.len()).map(|index| Inner::at(runs, index)).try_for_each(|run| kept.push(run)).unwrap_or(());
        Inner { kept }
    }

    pub(super) fn of(&self, runs: &[Run], index: usize) -> Option<Run> {
        self.kept.get(index).copied().unwrap_or_else(|| Inner::at(runs, index))
    }

    fn at(runs: &[Run], index: usize) -> Option<Run> {
        let (row, cols) = inner::<INNER_SIDE>(runs, index)?;
        Some(Run { row: row as u16, start: cols.start, end: cols.end })
    }
}

/// A pass over the pixels whose surroundings are valid.
struct Pass<'a> {
    smooth: &'a View<'a>,
    runs: &'a [Run],
    inner: &'a Inner,
    /// Stride of the rows.
    stride: usize,
    reference: &'a View<'a>,
    estimate: &'a Estimate,
    /// Whether the correlation of residuals is computed, instead of their sizes for the next pass.
    is_last: bool,
}

impl Pass<'_> {
    fn sums(&self, segment: &mut Segment, sizes: &mut Histogram) -> Sums {
        let estimate = self.estimate;
        let mut sums = Sums::default();
        let radiometry = Radiometry::new(estimate.gain, estimate.offset, estimate.outlier());
        let longest = estimate.segment();
        sizes.clear();
        for index in (0..self.runs.len()).step_by(self.stride) {
            let Some(Run { row, start, end }) = self.inner.of(self.runs, index) else { continue };
            let (row, end) = (row as usize, end as usize);
            for start in (start as usize..end).step_by(longest) {
                let length = longest.min(end - start);
                let half = 0.5 * (length as f32 - 1.0);
                let middle = (start as f32 + half - estimate.centre.0, row as f32 - estimate.centre.1);
                let (u, v) = estimate.reference_position(middle.0, middle.1);
                if !segment.load(self.smooth, (start, row, length), self.reference, (u - half, v), &radiometry) {
                    continue;
                }
                sums.add(&segment.sums(), middle, length as u32);
                if self.is_last {
                    // Every other row is enough.
                    if row % 2 == 0 {
                        segment.correlate(&mut sums.residuals);
                    }
                } else {
                    segment.count(&radiometry, sizes);
                }
            }
        }
        sums
    }
}
