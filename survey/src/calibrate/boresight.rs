//! The boresight of a camera of one head from the fixes and poses of a flight: the part of paper 002's platform calibration
//! that such a camera needs.
//!
//! Where positions are independently known, the fixes' errors show how the camera really sits: see `boresight/model.rs` for
//! what a boresight does to a fix. It is estimated by least squares with Huber's loss: Gauss-Newton steps with the weights
//! of the residuals before, whose scale is their median's, held after some steps so that they converge. The covariance is
//! Huber's, s² (A'A)⁻¹ with s² = Σψ² / (2n − u) / m² ([`Moments`]).
//!
//! Neighbouring fixes see the same ground and share its errors, so the covariance is also taken from the sums of the gradients
//! over stretches of the flight (a sandwich estimator); they share the errors of an attitude that changes slowly, too, for which it is
//! taken once more (`boresight/correlated.rs`). The largest of the three stands.
//!
//! How the matching weighs the parts of a patch is not known. The nadir's ray alone and the whole patch are the two ends:
//! by them phi and omega differ by a tenth of the correction, kappa, whose arm is the tilt less the patch's own middle, by
//! half. Half of the one and all of the other is added to the standard deviations; a second flight with the new file takes
//! it off. It is a share of the correction and no matter of chance, and at the nadir's end a correction of kappa is
//! estimated 2.2 times too large: written as it is, it would be off by more than before. So a correction whose share is
//! beyond the limit is not written, but what is left of it without that share is given for a further flight
//! ([`Boresight::next_rad`]): at both ends that mount is off by half as much at most, and the flight with it shows the rest.
//!
//! Phi and omega move each fix by the height times the angle. Kappa turns the patch about the camera's axis and moves it by
//! the height times the angle times the tilt only, so a level flight does not show it.

mod correlated;
mod files;
mod model;
#[cfg(test)]
mod tests;

pub use files::{Joined, join, read};
pub use model::{Footprint, Sighting};

use super::OUTLIER_SIGMAS;
use crate::adjust::{Loss, Moments};
use correlated::Term;
use model::Rays;
use nalgebra::{SMatrix, SVector};
use std::fmt;

/// Fewest fixes that are adjusted: twenty equations for three or five unknowns.
pub const FIXES_MIN: usize = 10;
/// An angle of a larger standard deviation, all of it, is not determined, and the configured value is kept: 0.2 degrees. By its
/// model's share a correction of phi or omega beyond 4 degrees, of kappa beyond 0.4, takes a further flight.
pub const SD_MAX_RAD: f64 = 0.2 / 180.0 * std::f64::consts::PI;
/// How many times the variance of phi or omega may grow when an offset is estimated too. 25 is a correlation of 0.98, and
/// headings that span no more than 20 degrees either way.
const INFLATION_MAX: f64 = 25.0;
/// From there on Huber's loss grows with the residual's length, in its standard deviations.
const HUBER_SIGMAS: f64 = 2.0;
/// Median length of a normal pair of unit variances, √(2 ln 2).
const MEDIAN_LENGTH: f64 = 1.177_410_022_515_475;
/// Convergence: the last step's largest angle and offset.
const STEP_RAD: f64 = 1e-10;
const STEP_M: f64 = 1e-7;
const ITERATIONS_MAX: usize = 200;
/// Steps after which the residuals' scale is held.
const SCALED: usize = 20;
/// Stretches of a flight whose errors are taken as independent.
const STRETCHES: usize = 12;
/// Share of a correction of phi, omega, kappa by which it is uncertain beside the fixes' errors.
const MODEL_SHARES: [f64; 3] = [0.05, 0.05, 0.5];
/// Smallest pivot of the normal equations at unit diagonal.
const PIVOT_MIN: f64 = 1e-10;

/// Phi, omega, kappa, offset east and north.
const UNKNOWNS: usize = 5;
type Normal = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Vector = SVector<f64, UNKNOWNS>;

/// An estimated boresight.
#[derive(Clone, Debug, PartialEq)]
pub struct Boresight {
    /// Phi, omega, kappa of the mount from the camera, radians; of those that are not determined the configured values.
    pub angles_rad: [f64; 3],
    /// Their standard deviations, radians; of those that are not determined what it would have been, infinite where nothing
    /// shows the angle.
    pub sd_rad: [f64; 3],
    /// The part of them that comes from the fixes' errors.
    pub random_sd_rad: [f64; 3],
    /// Which of them are determined.
    pub determined: [bool; 3],
    /// Of an angle that the fixes show well enough, but whose correction is too large for one flight: its value for the next.
    pub next_rad: [Option<f64>; 3],
    /// Of each angle that the fixes show well enough, whatever the model's share: what they say it is.
    pub shown_rad: [Option<f64>; 3],
    /// Offset of the fixes against the positions, east and north, metres, and its standard deviations; where it was asked for.
    pub offset: Option<([f64; 2], [f64; 2])>,
    /// Standard deviation of a residual whose sigma is as stated: 1 where the fixes' sigmas are right.
    pub sigma0: f64,
    /// Indices of fixes off by more than [`OUTLIER_SIGMAS`].
    pub outliers: Vec<usize>,
    /// What is left of each fix less its position, east and north, metres.
    pub residuals_m: Vec<[f64; 2]>,
}

/// Why there is no boresight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoresightError {
    /// So many fixes.
    TooFew(usize),
    /// The camera of this sighting, by its index, does not see the ground below it.
    Sky(usize),
    /// Neither phi nor omega is shown by the fixes to so many radians.
    Undetermined(f64),
    /// Phi or omega and the offset do the same to the fixes: how many times its variance grows.
    Inseparable(f64),
    /// No boresight explains the fixes.
    Diverged,
}

impl fmt::Display for BoresightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew(count) => write!(f, "{count} fixes with a pose, at least {FIXES_MIN} are needed"),
            Self::Sky(index) => write!(f, "the camera of sighting {index} does not see the ground below it"),
            Self::Undetermined(sd_max_rad) => {
                write!(f, "neither phi nor omega is known to {:.1} degrees from these fixes", sd_max_rad.to_degrees())
            }
            Self::Inseparable(inflation) => write!(
                f,
                "a boresight and an offset cannot be separated where the camera's heading hardly changes: together the \
                 variance is {inflation:.0} times as large, more than {INFLATION_MAX:.0}"
            ),
            Self::Diverged => write!(f, "no boresight explains the fixes' distances from the positions"),
        }
    }
}

/// The boresight of the camera that took `sightings`, while the board was configured with `configured_rad`, with a constant
/// offset of the fixes (east, north) where `with_offset`.
///
/// # Errors
/// [`BoresightError`].
pub fn estimate(
    sightings: &[Sighting],
    footprint: &Footprint,
    configured_rad: [f64; 3],
    with_offset: bool,
) -> Result<Boresight, BoresightError> {
    estimate_to(SD_MAX_RAD, sightings, footprint, configured_rad, with_offset)
}

/// As [`estimate`], where angles count as determined up to another standard deviation.
///
/// # Errors
/// [`BoresightError`].
pub fn estimate_to(
    sd_max_rad: f64,
    sightings: &[Sighting],
    footprint: &Footprint,
    configured_rad: [f64; 3],
    with_offset: bool,
) -> Result<Boresight, BoresightError> {
    if sightings.len() < FIXES_MIN {
        return Err(BoresightError::TooFew(sightings.len()));
    }
    let rays = |(index, sighting)| Rays::new(sighting, footprint, configured_rad).ok_or(BoresightError::Sky(index));
    let rays = sightings.iter().enumerate().map(rays).collect::<Result<Vec<_>, _>>()?;
    let mut adjustment =
        Adjustment { sightings, rays, configured_rad, free: [true, true, true, with_offset, with_offset] };
    let (mut sd_rad, mut random_sd_rad) = ([f64::INFINITY; 3], [f64::INFINITY; 3]);
    loop {
        let solved = match adjustment.solve() {
            // Nearly level flights hardly show kappa, which then runs away with the others.
            Err(BoresightError::Diverged) if adjustment.free[2] => None,
            other => other?,
        };
        if let Some(Solved { sd, inflation, unknowns, .. }) = &solved {
            if with_offset && *inflation > INFLATION_MAX {
                return Err(BoresightError::Inseparable(*inflation));
            }
            for k in (0..3).filter(|k| adjustment.free[*k]) {
                random_sd_rad[k] = sd[k];
                sd_rad[k] = sd[k].hypot(MODEL_SHARES[k] * (unknowns[k] - configured_rad[k]));
            }
        }
        // What a fix shows least goes first.
        let worst = match &solved {
            Some(_) => {
                (0..3).filter(|k| adjustment.free[*k]).max_by(|a, b| random_sd_rad[*a].total_cmp(&random_sd_rad[*b]))
            }
            None => Some(2).filter(|k| adjustment.free[*k]),
        };
        match (worst, solved) {
            // The model's share says how well the correction is known, and not whether there is one: an angle that is held for it alone would be
            // put down to the others.
            (Some(k), Some(solved)) if random_sd_rad[k] <= sd_max_rad => {
                let found = Boresight { sd_rad, random_sd_rad, ..adjustment.boresight(&solved) };
                return Ok(found.within(sd_max_rad, configured_rad));
            }
            (Some(k), _) => adjustment.free[k] = false,
            (None, None) if with_offset => return Err(BoresightError::Inseparable(f64::INFINITY)),
            (None, _) => return Err(BoresightError::Undetermined(sd_max_rad)),
        }
    }
}

impl Boresight {
    /// Without the corrections whose share is too much; what is left of them without it holds at both ends.
    fn within(mut self, sd_max_rad: f64, configured_rad: [f64; 3]) -> Self {
        for k in 0..3 {
            if !self.determined[k] || self.sd_rad[k] <= sd_max_rad {
                continue;
            }
            let correction_rad = self.angles_rad[k] - configured_rad[k];
            self.next_rad[k] = Some(configured_rad[k] + (1.0 - MODEL_SHARES[k]) * correction_rad);
            (self.determined[k], self.angles_rad[k]) = (false, configured_rad[k]);
        }
        self
    }
}

/// The problem, and which unknowns are free.
struct Adjustment<'a> {
    sightings: &'a [Sighting],
    rays: Vec<Rays>,
    configured_rad: [f64; 3],
    free: [bool; UNKNOWNS],
}

struct Solved {
    unknowns: Vector,
    sigma0: f64,
    sd: Vector,
    /// How much the variances of phi and omega gain by the offset, the larger.
    inflation: f64,
    outliers: Vec<usize>,
    residuals_m: Vec<[f64; 2]>,
}

/// A fix against the model: standardised residual, and its derivatives.
struct Row {
    residual: SVector<f64, 2>,
    by: SMatrix<f64, 2, UNKNOWNS>,
}

impl Row {
    /// On the axes that turn with the camera, a residual that is too long as the loss takes it.
    fn along(&self, sighting: &Sighting, loss: Loss, slope: f64) -> Term {
        let residual = self.residual * (loss.weight(self.residual.norm()) / slope);
        let [east_m, north_m] = sighting.sigma_m;
        let gain = sighting.height_m / (0.5 * (east_m * east_m + north_m * north_m)).sqrt();
        Term::new(residual, &self.by, sighting.attitude_rad[0], gain)
    }
}

impl Adjustment<'_> {
    fn rows(&self, unknowns: &Vector) -> Result<Vec<Row>, BoresightError> {
        let row = |(sighting, rays): (&Sighting, &Rays)| {
            let angles_rad = [unknowns[0], unknowns[1], unknowns[2]];
            let (mean, by_angles) = rays.displacement(angles_rad).ok_or(BoresightError::Diverged)?;
            let mut row = Row { residual: SVector::zeros(), by: SMatrix::zeros() };
            for axis in 0..2 {
                let sigma_m = sighting.sigma_m[axis];
                let model_m = sighting.height_m * mean[axis] + unknowns[3 + axis];
                row.residual[axis] = (sighting.fix_m[axis] - sighting.position_m[axis] - model_m) / sigma_m;
                for k in (0..3).filter(|k| self.free[*k]) {
                    row.by[(axis, k)] = sighting.height_m * by_angles[(axis, k)] / sigma_m;
                }
                if self.free[3 + axis] {
                    row.by[(axis, 3 + axis)] = 1.0 / sigma_m;
                }
            }
            Ok(row)
        };
        self.sightings.iter().zip(&self.rays).map(row).collect()
    }

    /// `None` where the normal equations are singular.
    fn solve(&self) -> Result<Option<Solved>, BoresightError> {
        let [phi, omega, kappa] = self.configured_rad;
        let mut unknowns = Vector::from([phi, omega, kappa, 0.0, 0.0]);
        let mut scale_now = 0.0;
        for iteration in 0..ITERATIONS_MAX {
            let rows = self.rows(&unknowns)?;
            if iteration < SCALED {
                scale_now = scale(&rows);
            }
            let loss = Loss::Huber(HUBER_SIGMAS * scale_now);
            let (mut normal, mut right) = (Normal::zeros(), Vector::zeros());
            for row in &rows {
                let weight = loss.weight(row.residual.norm());
                normal += weight * row.by.transpose() * row.by;
                right += weight * row.by.transpose() * row.residual;
            }
            let Some(inverse) = self.inverse(&normal) else { return Ok(None) };
            let step = inverse * right;
            unknowns += step;
            if !unknowns.iter().all(|value| value.is_finite()) {
                return Err(BoresightError::Diverged);
            }
            if step.fixed_rows::<3>(0).amax() < STEP_RAD && step.fixed_rows::<2>(3).amax() < STEP_M {
                return self.solved(unknowns, scale_now);
            }
        }
        Err(BoresightError::Diverged)
    }

    fn solved(&self, unknowns: Vector, scale: f64) -> Result<Option<Solved>, BoresightError> {
        let rows = self.rows(&unknowns)?;
        let loss = Loss::Huber(HUBER_SIGMAS * scale);
        let lengths: Vec<f64> = rows.iter().map(|row| row.residual.norm()).collect();
        let Moments { squares, slope, .. } = loss.moments(lengths.iter().copied());
        let count = self.free.iter().filter(|free| **free).count();
        let sigma0 = (squares / (2 * rows.len() - count) as f64).sqrt() / slope;
        let normal: Normal = rows.iter().map(|row| row.by.transpose() * row.by).sum();
        let Some(inverse) = self.inverse(&normal) else { return Ok(None) };
        let mut middle = Normal::zeros();
        for stretch in rows.chunks(rows.len().div_ceil(STRETCHES)) {
            let gradient: Vector =
                stretch.iter().map(|row| row.by.transpose() * row.residual * loss.weight(row.residual.norm())).sum();
            middle += gradient * gradient.transpose();
        }
        let sandwich = inverse * middle * inverse / (slope * slope);
        let terms: Vec<Term> =
            rows.iter().zip(self.sightings).map(|(row, sighting)| row.along(sighting, loss, slope)).collect();
        let correlated = correlated::covariance(&terms, &inverse);
        let larger = |k: usize| (sigma0 * sigma0 * inverse[(k, k)]).max(sandwich[(k, k)]).max(correlated[(k, k)]);
        let sd = Vector::from_fn(|k, _| larger(k).sqrt());
        // The same flight without the offset.
        let mut angles_only = normal;
        for k in 3..UNKNOWNS {
            angles_only.row_mut(k).fill(0.0);
            angles_only.column_mut(k).fill(0.0);
        }
        let alone = self.inverse(&angles_only);
        let gained = |k: usize| alone.as_ref().map_or(f64::INFINITY, |alone| inverse[(k, k)] / alone[(k, k)]);
        let inflation = (0..2).filter(|k| self.free[*k]).map(gained).fold(1.0, f64::max);
        let outliers = (0..rows.len()).filter(|index| lengths[*index] > OUTLIER_SIGMAS * scale).collect();
        let metres =
            |(row, sighting): (&Row, &Sighting)| [0, 1].map(|axis| row.residual[axis] * sighting.sigma_m[axis]);
        let residuals_m = rows.iter().zip(self.sightings).map(metres).collect();
        Ok(Some(Solved { unknowns, sigma0, sd, inflation, outliers, residuals_m }))
    }

    /// The inverse over the free unknowns, 0 elsewhere.
    fn inverse(&self, normal: &Normal) -> Option<Normal> {
        // An unknown that is held, or that an equation was cleared of, has an equation of its own.
        let is_bound = |k: usize| normal.row(k).amax() == 0.0;
        if (0..3).any(|k| self.free[k] && is_bound(k)) {
            return None;
        }
        let size = Vector::from_fn(|k, _| if is_bound(k) { 1.0 } else { normal[(k, k)].sqrt() });
        let unit = Normal::from_fn(|i, j| if i == j { 1.0 } else { normal[(i, j)] / (size[i] * size[j]) });
        let factor = unit.cholesky()?;
        if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot < PIVOT_MIN) {
            return None;
        }
        let inverse = factor.inverse();
        Some(Normal::from_fn(
            |i, j| {
                if is_bound(i) || is_bound(j) { 0.0 } else { inverse[(i, j)] / (size[i] * size[j]) }
            },
        ))
    }

    /// The result with the standard deviations of the fixes' errors alone.
    fn boresight(&self, solved: &Solved) -> Boresight {
        let (x, sd) = (&solved.unknowns, &solved.sd);
        Boresight {
            angles_rad: [x[0], x[1], x[2]],
            sd_rad: [sd[0], sd[1], sd[2]],
            random_sd_rad: [sd[0], sd[1], sd[2]],
            next_rad: [None; 3],
            shown_rad: [0, 1, 2].map(|k| self.free[k].then_some(x[k])),
            determined: [self.free[0], self.free[1], self.free[2]],
            offset: self.free[3].then(|| ([x[3], x[4]], [solved.sd[3], solved.sd[4]])),
            sigma0: solved.sigma0,
            outliers: solved.outliers.clone(),
            residuals_m: solved.residuals_m.clone(),
        }
    }
}

/// Standard deviation of a standardised residual, from the median of their lengths.
fn scale(rows: &[Row]) -> f64 {
    let mut lengths: Vec<f64> = rows.iter().map(|row| row.residual.norm()).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    let middle = lengths.len() / 2;
    0.5 * (lengths[middle] + lengths[(lengths.len() - 1) / 2]) / MEDIAN_LENGTH
}
