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

use super::detail::{CHUNK, details, rows};
use super::histogram::Histogram;
use super::search::Peak;
use super::segment::{self, MID_GREY, Patch, RESIDUAL_STEPS, Radiometry, WEIGHT_STEPS};
use super::smooth::{inner, smooth_into};
use super::{View, valid};
use crate::dsp::dot_and_energy;
use crate::math;
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

/// Shift along columns and rows, turn, scale, gain and offset.
const UNKNOWNS: usize = 6;
/// Passes at most.
const PASSES: usize = 7;
/// The first passes take part of the rows only, until a step is below this, pixels.
const NEAR_PX: f32 = 0.1;
/// Pixels they take at least, where the patch has them, and every which row at least.
const COARSE_PX: usize = 300;
const COARSE_EVERY: usize = 4;
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
/// Largest gain, and grey levels of offset, between two pictures of the same ground.
const GAIN_MAX: f32 = 8.0;
const OFFSET_MAX: f32 = 1024.0;
/// Pixels around a patch pixel that have to be valid: one for the smoothing, one for the gradient.
const BORDER: u16 = 2;
/// How far turn and scale may move the position between the middle and the end of a segment, pixels.
const BEND_PX: f32 = 0.05;

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
    let mut sizes = Histogram::new();
    let mut state = State::new(patch, runs, reference, radius, peak, &mut sizes).ok_or(RefineError::TooLittle)?;
    let smooth = smooth_into(patch, runs, bytes).ok_or(RefineError::TooLittle)?;
    let mut last = None;
    let mut every = (valid(runs) / COARSE_PX).clamp(2, COARSE_EVERY);
    for _ in 0..PASSES {
        sizes.clear();
        let sums = accumulate(&smooth, runs, every, reference, &state, &mut sizes);
        let normal = sums.normal(prior, &state)?;
        let right = sums.right(prior, &state);
        let normal = normal.cholesky().ok_or(RefineError::TooLittle)?;
        let step = normal.solve(&right);
        let went = state.step(&step, sizes.median());
        let off = (state.shift.0 - peak.d_col as f32).abs().max((state.shift.1 - peak.d_row as f32).abs());
        if off.is_nan()
            || off > REACH_PX
            || state.gain <= 0.0
            || state.gain > GAIN_MAX
            || state.offset.abs() > OFFSET_MAX
        {
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
        agreement: sums.weight() / sums.count as f32,
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
    fn new(
        patch: &View<'_>,
        runs: &[Run],
        reference: &View<'_>,
        radius: u16,
        peak: &Peak,
        histogram: &mut Histogram,
    ) -> Option<Self> {
        let (cols, rows) = patch.size();
        let shifted = |at: u16, d: i16| u16::try_from(at as i32 + radius as i32 + d as i32).ok();
        let gain = detail_gain(patch, runs, reference, peak, shifted).filter(|&gain| gain <= GAIN_MAX)?;
        let gain_q8 = (256.0 * gain) as i32;
        // Median over every other row, like the first passes, of a bin made of the difference.
        let mut median = |bin: &dyn Fn(i32) -> i32| {
            histogram.clear();
            for run in runs.iter().step_by(2) {
                let length = run.end.checked_sub(run.start)? as usize;
                let own = patch.run(run.row as usize, run.start as usize, length)?;
                let (row, start) = (shifted(run.row, peak.d_row)?, shifted(run.start, peak.d_col)?);
                for (&own, &other) in own.iter().zip(reference.run(row as usize, start as usize, length)?) {
                    let difference = other as i32 - ((gain_q8 * (own as i32 - MID_GREY)) >> 8);
                    histogram.add(bin(difference).clamp(0, 255) as u8);
                }
            }
            Some(histogram.median())
        };
        // Bins of 8 greys from −1024 on hold what a gain of 8 makes of all but the extremes.
        let offset = 8.0 * median(&|difference| (difference + 1024) >> 3)? - 1024.0;
        let whole = offset as i32;
        let size = median(&|difference| 4 * (difference - whole).abs())?;
        Some(State {
            shift: (peak.d_col as f32 + peak.vertex.0, peak.d_row as f32 + peak.vertex.1),
            turn: 0.0,
            scale: 0.0,
            gain,
            offset,
            sigma: sigma(size),
            centre: (0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0)),
            half: 0.5 * cols.max(rows) as f32,
            radius: radius as f32,
        })
    }

    /// Position in the searched reference of the patch pixel at (`x`, `y`) from the centre.
    fn reference_position(&self, x: f32, y: f32) -> (f32, f32) {
        let (across, down) = (1.0 + self.scale / self.half, self.turn / self.half);
        let (centre, shift) = (&self.centre, self.read_shift());
        (
            across * x - down * y + shift.0 + centre.0 + self.radius,
            across * y + down * x + shift.1 + centre.1 + self.radius,
        )
    }

    /// The shift that the reference is read at: one that the spline's fractions hold exactly.
    fn read_shift(&self) -> (f32, f32) {
        let parts = segment::FRACTIONS as f32;
        let held = |shift: f32| math::round(shift * parts) / parts;
        (held(self.shift.0), held(self.shift.1))
    }

    /// Pixels a segment may have.
    fn segment(&self) -> usize {
        let bend = (self.turn.abs() + self.scale.abs()) / self.half;
        let reach = |length: usize| 0.5 * length as f32 * bend <= BEND_PX;
        [segment::LONGEST, segment::LONGEST / 2].into_iter().find(|&l| reach(l)).unwrap_or(segment::LONGEST / 4)
    }

    /// Takes a step of the solution; how far it went, pixels along each axis. The products gain x displacement are what
    /// was solved for, and the new gain is the better one to divide them by.
    fn step(&mut self, step: &Vector, median_size: f32) -> f32 {
        let gain = self.gain + step[4];
        let ratio = self.gain / gain;
        let (before, read) = (self.shift, self.read_shift());
        self.shift = (read.0 + ratio * step[0], read.1 + ratio * step[1]);
        self.turn += ratio * step[2];
        self.scale += ratio * step[3];
        self.gain = gain;
        self.offset += step[5];
        self.sigma = sigma(median_size);
        (self.shift.0 - before.0).abs().max((self.shift.1 - before.1).abs())
    }
}

fn sigma(median_bin: f32) -> f32 {
    (SIGMA_PER_MEDIAN * 0.25 * median_bin).max(SIGMA_MIN)
}

/// Σ p r / Σ p² of the details at a shift, in every third run: the gain of the reference over the patch. Not of limited
/// details: still water limits those of a patch more than those of its surroundings.
fn detail_gain(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    peak: &Peak,
    shifted: impl Fn(u16, i16) -> Option<u16>,
) -> Option<f32> {
    let (mut products, mut squares) = (0i64, 0i64);
    for index in (0..runs.len()).step_by(3) {
        let run = runs[index];
        let (near, own) = rows(reference.size(), shifted(run.row, peak.d_row)?);
        for start in (run.start..run.end).step_by(CHUNK) {
            let (mut chunk, mut other) = ([0; CHUNK], [0; CHUNK]);
            let p = details(patch, runs, index, start, &mut chunk);
            let r = details(reference, &near, own, shifted(start, peak.d_col)?, &mut other);
            let (product, square) = dot_and_energy(&r[..p.len().min(r.len())], p);
            products += product as i64;
            squares += square as i64;
        }
    }
    (squares > 0 && products > 0).then(|| products as f32 / squares as f32)
}

/// Sums of one pass over the pixels, in the units of [`segment::Sums`]. Turn and scale stand as the patch's own x and y
/// do: t = x · row − y · column and s = x · column + y · row, where row and column are measured from the centre.
struct Sums {
    /// Lower triangle of the products of (x, y, t, s, p, 1), row by row.
    products: [[f32; UNKNOWNS]; UNKNOWNS],
    /// Products of the same with the residual.
    residual: [f32; UNKNOWNS],
    squares: f32,
    score: f32,
    neighbour: f32,
    count: u32,
}

impl Sums {
    /// Adds a segment whose middle is at (`c`, `r`) from the patch's centre.
    fn add(&mut self, sums: &segment::Sums, (c, r): (f32, f32), pixels: u32) {
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
        self.score += sums.score as f32;
        self.neighbour += sums.neighbour as f32;
        self.count += pixels;
    }

    /// Σ w.
    fn weight(&self) -> f32 {
        self.products[5][5] / WEIGHT_STEPS as f32
    }

    /// Variance of a residual of weight 1, square grey levels.
    fn sigma2(&self) -> f32 {
        let squares = self.squares / (RESIDUAL_STEPS * RESIDUAL_STEPS) as f32;
        // A perfect match must not claim certainty.
        (squares / (self.weight() - UNKNOWNS as f32).max(1.0)).max(SIGMA_MIN * SIGMA_MIN)
    }

    /// Derivative of the residual by each unknown over what the products hold.
    fn units(state: &State) -> [f32; UNKNOWNS] {
        // Half a difference over two pixels; the reference's gradient is the patch's times the gain.
        let gradient = 0.5 * state.gain;
        [-gradient, -gradient, gradient / state.half, -gradient / state.half, 1.0, 1.0]
    }

    /// The normal matrix in units of the inverse variance, priors included.
    fn normal(&self, prior: Prior, state: &State) -> Result<Normal, RefineError> {
        if self.weight() < 4.0 * UNKNOWNS as f32 {
            return Err(RefineError::TooLittle);
        }
        let per_variance = 1.0 / (self.sigma2() * WEIGHT_STEPS as f32);
        let units = Sums::units(state);
        let mut normal = Normal::from_fn(|row, col| {
            self.products[row.max(col)][row.min(col)] * (units[row] * units[col]) * per_variance
        });
        let (turn, scale) = prior_px(prior, state.half);
        normal[(2, 2)] += 1.0 / (turn * turn);
        normal[(3, 3)] += 1.0 / (scale * scale);
        Ok(normal)
    }

    /// The right-hand side; the priors pull turn and scale back to zero.
    fn right(&self, prior: Prior, state: &State) -> Vector {
        let per_variance = 1.0 / (self.sigma2() * (WEIGHT_STEPS * RESIDUAL_STEPS) as f32);
        let units = Sums::units(state);
        let mut right = Vector::from_fn(|row, _| self.residual[row] * units[row] * per_variance);
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

/// Sums over every pixel whose surroundings are valid, of the first and then every `every`th row; `sizes` counts the sizes
/// of the residuals.
fn accumulate(
    smooth: &View<'_>,
    runs: &[Run],
    every: usize,
    reference: &View<'_>,
    state: &State,
    sizes: &mut Histogram,
) -> Sums {
    let mut sums = Sums {
        products: [[0.0; UNKNOWNS]; UNKNOWNS],
        residual: [0.0; UNKNOWNS],
        squares: 0.0,
        score: 0.0,
        neighbour: 0.0,
        count: 0,
    };
    let radiometry = Radiometry::new(state.gain, state.offset, OUTLIER * state.sigma);
    let longest = state.segment();
    for index in (0..runs.len()).step_by(every) {
        let Some((row, cols)) = inner(runs, index, BORDER) else { continue };
        let mut start = cols.start as usize;
        let mut left = (0, 0);
        while start < cols.end as usize {
            let length = longest.min(cols.end as usize - start);
            let line = |row: usize| smooth.run(row, start - 1, length + 2);
            let (Some(above), Some(own), Some(below)) = (line(row - 1), line(row), line(row + 1)) else { break };
            let middle = (start as f32 + 0.5 * (length as f32 - 1.0) - state.centre.0, row as f32 - state.centre.1);
            let (u, v) = state.reference_position(middle.0, middle.1);
            let first = (u - 0.5 * (length as f32 - 1.0), v);
            let patch = Patch { above, own, below };
            if let Some(segment) = segment::sums(&patch, reference, first, &radiometry, sizes, &mut left) {
                sums.add(&segment, middle, length as u32);
            }
            start += length;
        }
    }
    sums
}
