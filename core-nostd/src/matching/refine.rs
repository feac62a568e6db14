//! Least-squares matching: the sub-pixel shift around a correlation peak, with its covariance.
//!
//! The patch is modelled as gain x reference + offset, the reference read at positions shifted by (dx, dy) and, since
//! heading and height are known only so well, turned and scaled a little about the nadir. Turn and scale carry the
//! sigmas of heading and height as priors, so they are estimated where the picture shows them and held where it does
//! not, and what they leave uncertain in the shift stands in its covariance. Changed ground is weighed down by its
//! residuals (Geman-McClure). A parabola through the correlation scores leaves 0.12 px on the default scene, this
//! leaves less than 0.1, and a parabola has no covariance.

use super::View;
use super::histogram::Histogram;
use super::search::Peak;
use crate::math;
use crate::rectify::Run;
use nalgebra::{Matrix2, SMatrix, SVector};

/// Why no sub-pixel shift came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RefineError {
    /// Fewer inner pixels than unknowns need, or no texture in one direction.
    TooLittle,
    /// The solution left the peak's own pixel and its neighbours.
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
    /// Root mean square of the weighted residuals, grey levels of the patch.
    pub residual: f32,
    /// Effective number of pixels: the sum of their weights.
    pub weight: f32,
    /// Spread of the patch's own greys, as a normal distribution with its quartile range would have it: what the
    /// residuals would be if the reference explained nothing.
    pub texture: f32,
}

const UNKNOWNS: usize = 6;
const TRIANGLE: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;
/// Passes at most.
const PASSES: usize = 10;
/// Passes at least: the weights need a few to settle.
const PASSES_MIN: usize = 5;
/// A step below this ends the passes, pixels.
const SETTLED_PX: f32 = 0.003;
/// Residual, in sigmas, at which a pixel's weight has fallen to a quarter.
const OUTLIER: f32 = 2.5;
/// E[w e²]/E[w] of a normal distribution of sigma 1 under these weights (by simulation): what makes the weighted scale
/// a sigma.
const CONSISTENCY: f32 = 0.668;
/// Variance of a shift under these weights over what the weighted sums alone would say, for normal residuals (by
/// simulation): E[w² e²]/E[ψ']² over E[w e²]/E[w]².
const EFFICIENCY: f32 = 1.39;
/// Smallest scale, grey levels: half a level is what quantisation alone leaves in both pictures.
const SIGMA_MIN: f32 = 0.5;
/// One sigma of what residuals do not show, pixels along each axis: sampling of two pictures with different footprints,
/// radiometry that is not linear, relief. Measured on simulated flights, where matching alone is off by 0.05 to 0.065 px.
const SYSTEMATIC_PX: f32 = 0.05;
/// How far the solution may go from the whole-pixel peak, pixels.
const REACH_PX: f32 = 1.5;

/// Taken off the reference: gain and offset stay well apart in single precision.
const MID_GREY: f32 = 128.0;
/// First scale of the residuals as a share of the patch's quartile range: what a correlation of 0.9 leaves.
const START_SIGMA: f32 = 0.35;
/// The same at least, grey levels.
const START_SIGMA_MIN: f32 = 2.0;

type Normal = SMatrix<f32, UNKNOWNS, UNKNOWNS>;
type Vector = SVector<f32, UNKNOWNS>;

/// The sub-pixel shift around `peak`. `reference` is the view that was searched, `radius` the search's.
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
) -> Result<SubPixel, RefineError> {
    let mut state = State::new(patch, runs, reference, radius, peak).ok_or(RefineError::TooLittle)?;
    let mut last = None;
    for pass in 0..PASSES {
        let sums = accumulate(patch, runs, reference, &state);
        let (normal, sigma2) = sums.normal(prior, state.half)?;
        let right = sums.right(sigma2, prior, &state);
        let solution = normal.cholesky().ok_or(RefineError::TooLittle)?.solve(&right);
        state.step(&solution, sums.scale());
        let off = (state.shift.0 - peak.d_col as f32).abs().max((state.shift.1 - peak.d_row as f32).abs());
        if off.is_nan() || off > REACH_PX {
            return Err(RefineError::Diverged);
        }
        last = Some((normal, sums));
        if pass + 1 >= PASSES_MIN && solution[0].abs().max(solution[1].abs()) < SETTLED_PX {
            break;
        }
    }
    let (normal, sums) = last.ok_or(RefineError::TooLittle)?;
    // Noise has gradients too, half its variance in a central difference, and they say nothing about the place but
    // disturb it all the same. At most all of the residuals is the patch's own noise; what is left is information.
    let mut information = normal;
    for axis in 0..2 {
        information[(axis, axis)] -= 0.5 * sums.weight;
    }
    let inverse = information.cholesky().ok_or(RefineError::TooLittle)?.inverse();
    let covariance = inverse * normal * inverse;
    let inflation = EFFICIENCY * sums.correlation();
    let floor = Matrix2::identity() * (SYSTEMATIC_PX * SYSTEMATIC_PX);
    Ok(SubPixel {
        d_col: state.shift.0,
        d_row: state.shift.1,
        covariance: Matrix2::new(covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 0)], covariance[(1, 1)])
            * inflation
            + floor,
        residual: math::sqrt(sums.sigma2()),
        weight: sums.weight,
        texture: state.texture,
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
    texture: f32,
}

impl State {
    /// Starts at the whole-pixel peak. Gain and offset come from the medians and quartiles of both pictures there: a
    /// least-squares gain would follow whatever is bright in one picture only, and then nothing would look changed.
    fn new(patch: &View<'_>, runs: &[Run], reference: &View<'_>, radius: u16, peak: &Peak) -> Option<Self> {
        let (cols, rows) = patch.size();
        let shifted = |at: u16, d: i16| usize::try_from(at as i32 + radius as i32 + d as i32).ok();
        let (mut own, mut others) = (Histogram::new(), Histogram::new());
        for run in runs {
            let length = run.end.checked_sub(run.start)? as usize;
            own.add(patch.run(run.row as usize, run.start as usize, length)?);
            others.add(reference.run(shifted(run.row, peak.d_row)?, shifted(run.start, peak.d_col)?, length)?);
        }
        let (own, others) = (own.quartiles(), others.quartiles());
        let gain = (own[2] - own[0]).max(1.0) / (others[2] - others[0]).max(1.0);
        Some(State {
            shift: (peak.d_col as f32, peak.d_row as f32),
            turn: 0.0,
            scale: 0.0,
            gain,
            offset: own[1] - gain * (others[1] - MID_GREY),
            sigma: (START_SIGMA * (own[2] - own[0])).max(START_SIGMA_MIN),
            centre: (0.5 * (cols as f32 - 1.0), 0.5 * (rows as f32 - 1.0)),
            half: 0.5 * cols.max(rows) as f32,
            radius: radius as f32,
            texture: (own[2] - own[0]) / 1.349,
        })
    }

    /// Position in the searched reference of the patch pixel at (`x`, `y`) from the centre.
    fn reference_position(&self, x: f32, y: f32) -> (f32, f32) {
        let (turn, scale) = (self.turn / self.half, self.scale / self.half);
        (
            x + self.shift.0 + scale * x - turn * y + self.centre.0 + self.radius,
            y + self.shift.1 + turn * x + scale * y + self.centre.1 + self.radius,
        )
    }

    fn step(&mut self, solution: &Vector, sigma: f32) {
        self.shift.0 += solution[0];
        self.shift.1 += solution[1];
        self.turn += solution[2];
        self.scale += solution[3];
        self.gain = solution[4];
        self.offset = solution[5];
        self.sigma = sigma;
    }
}

/// Sums of one pass over the pixels.
struct Sums {
    /// Lower triangle of Σ w j jᵀ, row by row, and Σ w j p.
    jj: [f32; TRIANGLE],
    jp: [f32; UNKNOWNS],
    weight: f32,
    /// Σ w e² of the residuals against the pass before.
    squares: f32,
    /// Σ s² and Σ s s(left neighbour) of the scores s = w e j of the two shifts: how far residuals are correlated.
    score: f32,
    neighbour: f32,
}

impl Sums {
    fn sigma2(&self) -> f32 {
        // A perfect match must not claim certainty.
        (self.squares / (self.weight - UNKNOWNS as f32).max(1.0)).max(SIGMA_MIN * SIGMA_MIN)
    }

    /// Robust sigma of the residuals, from their weighted squares: changed ground does not count.
    fn scale(&self) -> f32 {
        math::sqrt(self.squares / (CONSISTENCY * self.weight.max(1.0))).max(SIGMA_MIN)
    }

    /// The normal matrix in units of the inverse variance, priors included.
    fn normal(&self, prior: Prior, half: f32) -> Result<(Normal, f32), RefineError> {
        if self.weight < 4.0 * UNKNOWNS as f32 {
            return Err(RefineError::TooLittle);
        }
        let sigma2 = self.sigma2();
        let mut normal = Normal::zeros();
        let mut triangle = self.jj.iter();
        for row in 0..UNKNOWNS {
            for (col, sum) in (0..=row).zip(&mut triangle) {
                normal[(row, col)] = sum / sigma2;
                normal[(col, row)] = sum / sigma2;
            }
        }
        let (turn, scale) = prior_px(prior, half);
        normal[(2, 2)] += 1.0 / (turn * turn);
        normal[(3, 3)] += 1.0 / (scale * scale);
        Ok((normal, sigma2))
    }

    /// The right-hand side; the priors pull turn and scale back to zero.
    fn right(&self, sigma2: f32, prior: Prior, state: &State) -> Vector {
        let mut right = Vector::from(self.jp) / sigma2;
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

fn accumulate(patch: &View<'_>, runs: &[Run], reference: &View<'_>, state: &State) -> Sums {
    let mut sums =
        Sums { jj: [0.0; TRIANGLE], jp: [0.0; UNKNOWNS], weight: 0.0, squares: 0.0, score: 0.0, neighbour: 0.0 };
    for (index, run) in runs.iter().enumerate() {
        let Some((above, below)) = neighbours(runs, index) else { continue };
        let start = (run.start + 1).max(above.start).max(below.start) as usize;
        let end = run.end.saturating_sub(1).min(above.end).min(below.end) as usize;
        let row = run.row as usize;
        let (Some(here), Some(up), Some(down)) =
            (line(patch, row), line(patch, row.wrapping_sub(1)), line(patch, row + 1))
        else {
            continue;
        };
        let y = row as f32 - state.centre.1;
        let mut left = [0.0f32; 2];
        for col in start..end {
            let x = col as f32 - state.centre.0;
            let (u, v) = state.reference_position(x, y);
            let Some(value) = cubic(reference, u, v).map(|grey| grey - MID_GREY) else { continue };
            let gx = 0.5 * (here[col + 1] as f32 - here[col - 1] as f32);
            let gy = 0.5 * (down[col] as f32 - up[col] as f32);
            let p = here[col] as f32;
            let e = p - state.gain * value - state.offset;
            let w = weight(e, state.sigma);
            let inverse = 1.0 / state.half;
            let j = [gx, gy, (gy * x - gx * y) * inverse, (gx * x + gy * y) * inverse, value, 1.0];
            // Gain and offset are solved for anew in each pass, so the right-hand side is the patch itself.
            let mut triangle = sums.jj.iter_mut();
            for (row, jp) in sums.jp.iter_mut().enumerate() {
                let wj = w * j[row];
                *jp += wj * p;
                for (&j, sum) in j[..=row].iter().zip(&mut triangle) {
                    *sum += wj * j;
                }
            }
            sums.weight += w;
            sums.squares += w * e * e;
            let score = [w * e * gx, w * e * gy];
            sums.score += score[0] * score[0] + score[1] * score[1];
            sums.neighbour += score[0] * left[0] + score[1] * left[1];
            left = score;
        }
    }
    sums
}

/// Geman-McClure weight of a residual.
fn weight(e: f32, sigma: f32) -> f32 {
    let t = e / (OUTLIER * sigma);
    let q = 1.0 / (1.0 + t * t);
    q * q
}

/// The runs above and below that overlap run `index` most, which the gradient across rows needs.
fn neighbours(runs: &[Run], index: usize) -> Option<(Run, Run)> {
    let run = runs.get(index)?;
    let overlap = |other: &Run| other.end.min(run.end).saturating_sub(other.start.max(run.start));
    let best = |row: u16, candidates: &[Run]| {
        candidates.iter().filter(|r| r.row == row && overlap(r) > 0).max_by_key(|r| overlap(r)).copied()
    };
    // Runs are sorted by row: neighbours stand close by, whatever a row holds.
    let from = index.saturating_sub(16);
    let above = best(run.row.checked_sub(1)?, &runs[from..index])?;
    let below = best(run.row + 1, &runs[index + 1..runs.len().min(index + 17)])?;
    Some((above, below))
}

fn line<'a>(patch: &View<'a>, row: usize) -> Option<&'a [u8]> {
    patch.run(row, 0, patch.size().0 as usize)
}

/// Keys' cubic convolution (a = −1/2) of the reference at (`u`, `v`); `None` where its 4 x 4 neighbourhood leaves it.
/// Bilinear reading would smooth by up to half a pixel's worth and draw the shift towards whole pixels.
fn cubic(reference: &View<'_>, u: f32, v: f32) -> Option<f32> {
    let (fu, fv) = (math::floor(u), math::floor(v));
    if !(fu >= 1.0 && fv >= 1.0) {
        return None;
    }
    let (col, row) = (fu as usize - 1, fv as usize - 1);
    let (wu, wv) = (keys(u - fu), keys(v - fv));
    let mut sum = 0.0;
    for (k, wv) in wv.iter().enumerate() {
        let r = reference.run(row + k, col, 4)?;
        sum += wv * (wu[0] * r[0] as f32 + wu[1] * r[1] as f32 + wu[2] * r[2] as f32 + wu[3] * r[3] as f32);
    }
    Some(sum)
}

fn keys(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]
}
