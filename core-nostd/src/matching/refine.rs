//! Least-squares matching: the sub-pixel shift around a correlation peak, with its covariance.
//!
//! The reference is modelled as gain x patch + offset, read at positions shifted by (dx, dy) and, since heading and
//! height are known only so well, turned and scaled a little about the nadir. Turn and scale carry the sigmas of heading
//! and height as priors, so they are estimated where the picture shows them and held where it does not, and what they
//! leave uncertain in the shift stands in its covariance.
//!
//! The reference is what noise and changed ground are in, so it is the observation and the clean patch the model: the
//! other way round, changed ground would be a regressor, and no weight can mend a wrong regressor. It is weighed down by
//! its residuals (Geman-McClure), whose scale is their median. Both pictures are smoothed by the same B-spline
//! (module `smooth`). A parabola through correlation scores leaves 0.12 px on the default scene, this 0.04 px,
//! and a parabola has no covariance.

use super::View;
use super::detail::{CHUNK, details, rows};
use super::histogram::Histogram;
use super::search::Peak;
use super::smooth::{inner, smooth_into, spline};
use crate::rectify::Run;
use nalgebra::{Matrix2, SMatrix, SVector};

/// Why no sub-pixel shift came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RefineError {
    /// Fewer inner pixels than unknowns need, or no texture in one direction.
    TooLittle,
    /// The solution left the peak's own pixel and its neighbours, or would invert the picture.
    Diverged,
}

/// What is known of the picture's turn and scale before matching, one sigma each.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Prior {
    /// Of the heading, radians.
    pub turn_rad: f32,
    /// Of the height, as a share of it.
    pub scale: f32,
}

/// A sub-pixel match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubPixel {
    /// Shift of the patch's centre, columns to the right, pixels.
    pub d_col: f32,
    /// The same, rows downwards.
    pub d_row: f32,
    /// Covariance of (d_col, d_row), square pixels.
    pub covariance: Matrix2<f32>,
    /// Mean weight of the pixels, 0 to 1: how much of the picture agrees.
    pub agreement: f32,
}

const UNKNOWNS: usize = 6;
const TRIANGLE: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;
/// Passes at most.
const PASSES: usize = 7;
/// The first passes take every other row only, until a step is below this, pixels.
const NEAR_PX: f32 = 0.1;
/// A step below this ends the passes, pixels.
const SETTLED_PX: f32 = 0.01;
/// Residual, in sigmas, at which a pixel's weight has fallen to a quarter.
const OUTLIER: f32 = 2.5;
/// Sigma of a normal distribution over the median of its absolute values.
const SIGMA_PER_MEDIAN: f32 = 1.4826;
/// Variance of a shift under these weights over what the weighted sums alone would say, for normal residuals (by
/// simulation): E[w² e²]/E[ψ']² over E[w e²]/E[w]².
const EFFICIENCY: f32 = 1.39;
/// Smallest scale, grey levels: half a level is what quantisation alone leaves in both pictures.
const SIGMA_MIN: f32 = 0.5;
/// One sigma of what residuals do not show, pixels along each axis.
const SYSTEMATIC_PX: f32 = 0.005;
/// How far the solution may go from the whole-pixel peak, pixels.
const REACH_PX: f32 = 1.5;
/// Pixels around a patch pixel that have to be valid: one for the smoothing, one for the gradient.
const BORDER: u16 = 2;
/// Taken off the patch: gain and offset stay well apart in single precision.
const MID_GREY: f32 = 128.0;

type Normal = SMatrix<f32, UNKNOWNS, UNKNOWNS>;
type Vector = SVector<f32, UNKNOWNS>;

/// The sub-pixel shift around `peak`. `reference` is the view that was searched, `radius` the search's; `bytes`: room
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
    let mut state = State::new(patch, runs, reference, radius, peak).ok_or(RefineError::TooLittle)?;
    let smooth = smooth_into(patch, runs, bytes).ok_or(RefineError::TooLittle)?;
    let mut last = None;
    let mut every = 2;
    for _ in 0..PASSES {
        let sums = accumulate(&smooth, runs, every, reference, &state);
        let normal = sums.normal(prior, state.half)?;
        let right = sums.right(prior, &state);
        let normal = normal.cholesky().ok_or(RefineError::TooLittle)?;
        let step = normal.solve(&right);
        let went = state.step(&step, sums.sizes.median());
        let off = (state.shift.0 - peak.d_col as f32).abs().max((state.shift.1 - peak.d_row as f32).abs());
        if off.is_nan() || off > REACH_PX || state.gain <= 0.0 {
            return Err(RefineError::Diverged);
        }
        if every == 1 {
            last = Some((normal, sums));
            if went < SETTLED_PX {
                break;
            }
        } else if went < NEAR_PX {
            every = 1;
        }
    }
    let (normal, sums) = last.ok_or(RefineError::Diverged)?;
    let covariance = normal.inverse();
    let inflation = EFFICIENCY * sums.correlation();
    let floor = Matrix2::identity() * (SYSTEMATIC_PX * SYSTEMATIC_PX);
    Ok(SubPixel {
        d_col: state.shift.0,
        d_row: state.shift.1,
        covariance: covariance.fixed_view::<2, 2>(0, 0) * inflation + floor,
        agreement: sums.weight / sums.count as f32,
    })
}

/// The current estimate.
struct State {
    shift: (f32, f32),
    /// Displacement by turn and scale at the patch's edge, pixels.
    turn: f32,
    scale: f32,
    gain: f32,
    offset: f32,
    /// Robust sigma of the residuals of the pass before.
    sigma: f32,
    centre: (f32, f32),
    /// Half the patch's longer side: makes turn and scale pixels too, which keeps the normal matrix well scaled.
    half: f32,
    radius: f32,
}

impl State {
    /// Starts at the whole-pixel peak. The gain is that of the details, which changed ground hardly has a part in, the
    /// offset the median difference under it.
    fn new(patch: &View<'_>, runs: &[Run], reference: &View<'_>, radius: u16, peak: &Peak) -> Option<Self> {
        let (cols, rows) = patch.size();
        let shifted = |at: u16, d: i16| u16::try_from(at as i32 + radius as i32 + d as i32).ok();
        let gain = detail_gain(patch, runs, reference, peak, shifted)?;
        let residuals = |sink: &mut dyn FnMut(f32)| {
            for run in runs {
                let length = run.end.checked_sub(run.start)? as usize;
                let own = patch.run(run.row as usize, run.start as usize, length)?;
                let (row, start) = (shifted(run.row, peak.d_row)?, shifted(run.start, peak.d_col)?);
                for (&own, &other) in own.iter().zip(reference.run(row as usize, start as usize, length)?) {
                    sink(other as f32 - gain * (own as f32 - MID_GREY));
                }
            }
            Some(())
        };
        // Bins of 4 greys from −384 on hold what a gain of up to 4 can make.
        let mut differences = Histogram::new();
        residuals(&mut |difference| differences.add((0.25 * (difference + 384.0)) as u8))?;
        let offset = 4.0 * differences.median() - 384.0;
        let mut sizes = Histogram::new();
        residuals(&mut |difference| sizes.add(size_bin(difference - offset)))?;
        Some(State {
            shift: (peak.d_col as f32, peak.d_row as f32),
            turn: 0.0,
            scale: 0.0,
            gain,
            offset,
            sigma: sigma(sizes.median()),
            centre: (0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0)),
            half: 0.5 * cols.max(rows) as f32,
            radius: radius as f32,
        })
    }

    /// Position in the searched reference of the patch pixel at (`x`, `y`) from the centre.
    fn reference_position(&self, x: f32, y: f32) -> (f32, f32) {
        let (across, down) = self.per_column();
        let (centre, shift) = (&self.centre, &self.shift);
        (
            across * x - down * y + shift.0 + centre.0 + self.radius,
            across * y + down * x + shift.1 + centre.1 + self.radius,
        )
    }

    /// How the position goes on from one column of the patch to the next.
    fn per_column(&self) -> (f32, f32) {
        (1.0 + self.scale / self.half, self.turn / self.half)
    }

    /// Takes a step of the solution; how far it went, pixels along each axis. The products gain x displacement are what
    /// was solved for, and the new gain is the better one to divide them by.
    fn step(&mut self, step: &Vector, median_size: f32) -> f32 {
        let gain = self.gain + step[4];
        let ratio = self.gain / gain;
        self.shift.0 += ratio * step[0];
        self.shift.1 += ratio * step[1];
        self.turn += ratio * step[2];
        self.scale += ratio * step[3];
        self.gain = gain;
        self.offset += step[5];
        self.sigma = sigma(median_size);
        (ratio * step[0]).abs().max((ratio * step[1]).abs())
    }
}

/// Σ p r / Σ p² of the details at a shift: the gain of the reference over the patch.
fn detail_gain(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    peak: &Peak,
    shifted: impl Fn(u16, i16) -> Option<u16>,
) -> Option<f32> {
    let (mut products, mut squares) = (0i64, 0i64);
    for (index, run) in runs.iter().enumerate() {
        let (near, own) = rows(reference.size(), shifted(run.row, peak.d_row)?);
        for start in (run.start..run.end).step_by(CHUNK) {
            let (mut chunk, mut other) = ([0; CHUNK], [0; CHUNK]);
            let p = details(patch, runs, index, start, &mut chunk);
            let r = details(reference, &near, own, shifted(start, peak.d_col)?, &mut other);
            for (&p, &r) in p.iter().zip(r) {
                products += (p as i32 * r as i32) as i64;
                squares += (p as i32 * p as i32) as i64;
            }
        }
    }
    (squares > 0 && products > 0).then(|| products as f32 / squares as f32)
}

/// Quarters of a grey: 64 greys are "large".
#[inline(always)]
fn size_bin(residual: f32) -> u8 {
    (4.0 * residual.abs()) as u8
}

fn sigma(median_bin: f32) -> f32 {
    (SIGMA_PER_MEDIAN * 0.25 * median_bin).max(SIGMA_MIN)
}

/// Sums of one pass over the pixels.
struct Sums {
    /// Lower triangle of Σ w j jᵀ, row by row, and Σ w j e.
    jj: [f32; TRIANGLE],
    je: [f32; UNKNOWNS],
    weight: f32,
    count: u32,
    /// Σ w e² of the residuals against the pass before.
    squares: f32,
    /// Σ s² and Σ s s(left neighbour) of the scores s = w e j of the two shifts: how far residuals are correlated.
    score: f32,
    neighbour: f32,
    sizes: Histogram,
}

impl Sums {
    fn sigma2(&self) -> f32 {
        // A perfect match must not claim certainty.
        (self.squares / (self.weight - UNKNOWNS as f32).max(1.0)).max(SIGMA_MIN * SIGMA_MIN)
    }

    /// The normal matrix in units of the inverse variance, priors included.
    fn normal(&self, prior: Prior, half: f32) -> Result<Normal, RefineError> {
        if self.weight < 4.0 * UNKNOWNS as f32 {
            return Err(RefineError::TooLittle);
        }
        let per_variance = 1.0 / self.sigma2();
        let mut normal = Normal::zeros();
        let mut triangle = self.jj.iter();
        for row in 0..UNKNOWNS {
            for (col, sum) in (0..=row).zip(&mut triangle) {
                normal[(row, col)] = sum * per_variance;
                normal[(col, row)] = sum * per_variance;
            }
        }
        let (turn, scale) = prior_px(prior, half);
        normal[(2, 2)] += 1.0 / (turn * turn);
        normal[(3, 3)] += 1.0 / (scale * scale);
        Ok(normal)
    }

    /// The right-hand side; the priors pull turn and scale back to zero.
    fn right(&self, prior: Prior, state: &State) -> Vector {
        let mut right = Vector::from(self.je) / self.sigma2();
        let (turn, scale) = prior_px(prior, state.half);
        right[2] -= state.turn / (turn * turn);
        right[3] -= state.scale / (scale * scale);
        right
    }

    /// By how much correlated residuals enlarge the variance: (1 + 2 ρ)² for a correlation ρ to each neighbour along
    /// both axes. Never below 1.
    fn correlation(&self) -> f32 {
        let rho = if self.score > 0.0 { (self.neighbour / self.score).clamp(0.0, 0.6) } else { 0.0 };
        (1.0 + 2.0 * rho) * (1.0 + 2.0 * rho)
    }
}

/// Prior sigmas as displacements at the patch's edge, with a floor that keeps the division finite.
fn prior_px(prior: Prior, half: f32) -> (f32, f32) {
    ((prior.turn_rad * half).max(1e-3), (prior.scale * half).max(1e-3))
}

/// Residuals and derivatives of every pixel whose surroundings are valid, in `every` first, second... row, summed up.
fn accumulate(smooth: &View<'_>, runs: &[Run], every: usize, reference: &View<'_>, state: &State) -> Sums {
    let mut sums = Sums {
        jj: [0.0; TRIANGLE],
        je: [0.0; UNKNOWNS],
        weight: 0.0,
        count: 0,
        squares: 0.0,
        score: 0.0,
        neighbour: 0.0,
        sizes: Histogram::new(),
    };
    let half_gain = 0.5 * state.gain;
    let per_half = 1.0 / state.half;
    let per_column = state.per_column();
    let per_outlier = 1.0 / (OUTLIER * state.sigma);
    for index in (0..runs.len()).step_by(every) {
        let Some((row, cols)) = inner(runs, index, BORDER) else { continue };
        let line = |row: usize| smooth.run(row, 0, smooth.size().0 as usize);
        let (Some(up), Some(here), Some(down)) = (line(row - 1), line(row), line(row + 1)) else { continue };
        let y = row as f32 - state.centre.1;
        let mut left = [0.0f32; 2];
        let mut x = cols.start as f32 - state.centre.0 - 1.0;
        let (mut u, mut v) = state.reference_position(x, y);
        for col in cols.start as usize..cols.end as usize {
            (x, u, v) = (x + 1.0, u + per_column.0, v + per_column.1);
            let Some(value) = spline(reference, u, v) else { continue };
            // Gradient of the reference, as the patch shows it.
            let gx = half_gain * (here[col + 1] as f32 - here[col - 1] as f32);
            let gy = half_gain * (down[col] as f32 - up[col] as f32);
            let p = here[col] as f32 - MID_GREY;
            let e = value - state.gain * p - state.offset;
            let t = e * per_outlier;
            let q = 1.0 / (1.0 + t * t);
            let w = q * q;
            let j = [-gx, -gy, (gx * y - gy * x) * per_half, -(gx * x + gy * y) * per_half, p, 1.0];
            let mut triangle = sums.jj.iter_mut();
            for (row, je) in sums.je.iter_mut().enumerate() {
                let wj = w * j[row];
                *je += wj * e;
                for (&j, sum) in j[..=row].iter().zip(&mut triangle) {
                    *sum += wj * j;
                }
            }
            sums.weight += w;
            sums.count += 1;
            sums.squares += w * e * e;
            sums.sizes.add(size_bin(e));
            let score = [w * e * gx, w * e * gy];
            sums.score += score[0] * score[0] + score[1] * score[1];
            sums.neighbour += score[0] * left[0] + score[1] * left[1];
            left = score;
        }
    }
    sums
}
