//! From a block and its observations to the heads' parameters with what they are worth.

use super::axes::is_from_corner;
use super::block::Block;
use super::check::check;
use super::observations::Observations;
use crate::adjust::rig::{HEAD, Rig, head_name};
use crate::adjust::{Adjustment, At, Cofactors, Loss, Model, Options, Redundancy, SolveError};
use crate::error::InputError;

/// Standardised residual from which an observation is reported as an outlier: one of 15,000 good ones.
pub const OUTLIER_SIGMAS: f64 = 4.0;
/// Redundancy below which a residual says nothing of its observation.
const REDUNDANCY_MIN: f64 = 1e-6;
/// Residual, as an angle in the image, that no calibrated camera leaves: two thousandths, 14 px of a head of 7,000.
const PLAUSIBLE_RAD: f64 = 2e-3;

/// An observation after the adjustment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Observed minus computed, x right and y up, pixels.
    pub v_px: [f64; 2],
    /// Parts of the redundancy: 0 is uncontrolled, 1 wholly controlled by the others.
    pub redundancy: [f64; 2],
    /// Residuals over their own standard deviations; 0 where uncontrolled.
    pub standardised: [f64; 2],
}

impl Residual {
    /// The larger standardised residual.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.standardised[0].abs().max(self.standardised[1].abs())
    }
}

/// An unknown of a head.
#[derive(Clone, Debug, PartialEq)]
pub struct HeadUnknown {
    /// Which head, from 0.
    pub head: usize,
    /// Which of its numbers.
    pub number: usize,
    /// Its value (rad, m, s or px).
    pub value: f64,
    /// Its standard deviation.
    pub sigma: f64,
}

/// How two unknowns go together: of the first unknown station, and of the heads with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// First unknown.
    pub a: String,
    /// Second unknown.
    pub b: String,
    /// Correlation coefficient.
    pub value: f64,
}

/// A calibrated block.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Standard deviation of unit weight, in pixels: times the mean a-priori sigma of an image coordinate.
    pub sigma0_px: f64,
    /// Standard deviation of unit weight, without unit: 1 where the a-priori sigmas are right.
    pub sigma0: f64,
    /// Steps taken.
    pub iterations: usize,
    /// Equations and unknowns.
    pub size: (usize, usize),
    /// Half the sums of squares before and after.
    pub cost: (f64, f64),
    /// Numbers of every head: angles (rad), centre (m), time (s), interior orientation.
    pub heads: Vec<[f64; HEAD]>,
    /// Unknowns of the heads, in the order of their covariance.
    pub unknowns: Vec<HeadUnknown>,
    /// Their covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Numbers of every station.
    pub stations: Vec<[f64; 6]>,
    /// Position of every point.
    pub points: Vec<[f64; 3]>,
    /// Standard deviations of every point, m; zero where known.
    pub point_sigmas_m: Vec<[f64; 3]>,
    /// One an observation.
    pub residuals: Vec<Residual>,
    /// Indices of the observations that are outliers, worst first.
    pub outliers: Vec<usize>,
    /// Angles against line elements of the first station: what a constraint is for.
    pub correlations: Vec<Correlation>,
    /// Reciprocal condition of the scaled reduced equations.
    pub eigenvalue_min: f64,
}

impl Calibration {
    /// Adjusts a block; `on_step` is called after each step with its number and the cost after it.
    ///
    /// # Errors
    /// What [`check`] refuses; unknowns that nothing determines; start values from which the steps do not come to an end;
    /// residuals that no camera leaves.
    pub fn new(
        block: &Block,
        observations: &Observations,
        on_step: &mut dyn FnMut(usize, f64),
    ) -> Result<Self, InputError> {
        let rig = block.rig(&observations.seen);
        check(block, observations, &rig)?;
        Self::of_rig(&rig, &options(block), on_step)
            .map_err(|error| refused(&error, &rig, observations))
            .and_then(|calibration| calibration.plausible(&observations.name))
    }

    /// Adjusts a rig whose observations are known to be enough; `on_step` as above.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn of_rig(rig: &Rig, options: &Options, on_step: &mut dyn FnMut(usize, f64)) -> Result<Self, SolveError> {
        let adjustment = Adjustment::new(rig, options.loss)?;
        let solution = adjustment.solve(rig.start(), options, on_step)?;
        let x = &solution.x;
        let cofactors = adjustment.cofactors(x)?;
        let structure = rig.structure();
        let (equations, unknowns) = (structure.equations(), structure.unknowns());
        let at = rig.at(x);
        let whitened: Vec<[f64; 2]> =
            (0..rig.observations.len()).map(|index| at.residual(index).unwrap_or([0.0; 2])).collect();
        let of_priors = 2.0 * (solution.cost_end - whitened.iter().map(|v| options.loss.of(*v)).sum::<f64>());
        let sigma0 = options.loss.variance(&whitened, of_priors.max(0.0), (equations - unknowns) as f64).sqrt();
        let sigma_px = rig.sigma_px.iter().sum::<f64>() / rig.sigma_px.len() as f64;

        let (unknowns_of_heads, covariance) = of_heads(rig, x, &cofactors, sigma0);
        let (redundancies, cofactors_of_points) = cofactors.redundancies()?;
        let residuals = residuals(rig, &whitened, &redundancies, sigma0);
        let mut outliers: Vec<usize> =
            (0..residuals.len()).filter(|index| residuals[*index].worst() > OUTLIER_SIGMAS).collect();
        outliers.sort_by(|a, b| residuals[*b].worst().total_cmp(&residuals[*a].worst()));
        let mut of_points = cofactors_of_points.iter();
        let point_sigmas_m = rig
            .points
            .iter()
            .map(|point| match point.is_free.then(|| of_points.next()).flatten() {
                Some(own) => [0, 1, 2].map(|k| sigma0 * own[k][k].sqrt()),
                None => [0.0; 3],
            })
            .collect();
        Ok(Calibration {
            sigma0_px: sigma0 * sigma_px,
            sigma0,
            iterations: solution.iterations,
            size: (equations, unknowns),
            cost: (solution.cost_start, solution.cost_end),
            heads: (0..rig.heads.len()).map(|head| rig.head(x, head)).collect(),
            unknowns: unknowns_of_heads,
            covariance,
            stations: (0..rig.stations.len()).map(|station| rig.station(x, station)).collect(),
            points: (0..rig.points.len()).map(|point| rig.point(x, point)).collect(),
            point_sigmas_m,
            residuals,
            outliers,
            correlations: correlations(rig, &cofactors),
            eigenvalue_min: cofactors.eigenvalue_min,
        })
    }

    /// Refuses residuals that no camera leaves.
    pub(super) fn plausible(self, name: &str) -> Result<Self, InputError> {
        let f_px = self.heads.iter().map(|head| head[crate::adjust::rig::LENS]).fold(f64::INFINITY, f64::min);
        if self.sigma0_px <= PLAUSIBLE_RAD * f_px {
            return Ok(self);
        }
        Err(InputError::failed(format!(
            "{name}: the adjustment ends after {} iterations with a sigma0 of {:.1} px, which no camera leaves: the start \
             values lead to a wrong minimum, or the observations are another block's",
            self.iterations, self.sigma0_px
        )))
    }

    /// The standard deviation of a head's number, if it was unknown.
    #[must_use]
    pub fn sigma(&self, head: usize, number: usize) -> Option<f64> {
        self.unknowns
            .iter()
            .find(|unknown| (unknown.head, unknown.number) == (head, number))
            .map(|unknown| unknown.sigma)
    }
}

/// The heads' unknowns with their covariance.
fn of_heads(rig: &Rig, x: &[f64], cofactors: &Cofactors<'_, Rig>, sigma0: f64) -> (Vec<HeadUnknown>, Vec<Vec<f64>>) {
    let of_heads: Vec<(usize, usize, usize)> = (0..rig.heads.len())
        .flat_map(|head| rig.heads[head].free.iter().map(move |number| (head, *number)))
        .filter_map(|(head, number)| Some((head, number, rig.head_unknown(head, number)?)))
        .collect();
    let variance = sigma0 * sigma0;
    let mut covariance = cofactors.of(&of_heads.iter().map(|(_, _, unknown)| *unknown).collect::<Vec<_>>());
    covariance.iter_mut().flatten().for_each(|value| *value *= variance);
    let unknowns = of_heads
        .into_iter()
        .enumerate()
        .map(|(k, (head, number, unknown))| HeadUnknown {
            head,
            number,
            value: x[unknown],
            sigma: covariance[k][k].sqrt(),
        })
        .collect();
    (unknowns, covariance)
}

/// The observations after the adjustment, from their residuals over their standard deviations.
fn residuals(rig: &Rig, whitened: &[[f64; 2]], redundancies: &[Redundancy], sigma0: f64) -> Vec<Residual> {
    rig.observations
        .iter()
        .zip(whitened.iter().zip(redundancies))
        .map(|(seen, (whitened, redundancy))| {
            let sigma = rig.sigma_px[seen.head];
            let standardised = [0, 1].map(|k| {
                let scale = sigma0 * redundancy[k].max(0.0).sqrt();
                if redundancy[k] > REDUNDANCY_MIN && scale > 0.0 { -whitened[k] / scale } else { 0.0 }
            });
            Residual { v_px: whitened.map(|v| -v * sigma), redundancy: *redundancy, standardised }
        })
        .collect()
}

/// Angles with line elements: of the first unknown station with itself and, for the heads, angles with the station's.
fn correlations(rig: &Rig, cofactors: &Cofactors<'_, Rig>) -> Vec<Correlation> {
    let Some(first) = (0..rig.stations.len()).find_map(|station| rig.station_unknown(station)) else {
        return Vec::new();
    };
    let mut unknowns: Vec<usize> = (first..first + 6).collect();
    for head in 0..rig.heads.len() {
        unknowns.extend((0..3).filter_map(|angle| rig.head_unknown(head, angle)));
    }
    let q = cofactors.of(&unknowns);
    let mut correlations = Vec::new();
    for (i, a) in unknowns.iter().enumerate() {
        for (j, b) in unknowns.iter().enumerate().skip(i + 1) {
            let is_angle_with_line = i < 3 && j >= 3 || (3..6).contains(&i) && j >= 6;
            if is_angle_with_line {
                let value = q[i][j] / (q[i][i] * q[j][j]).sqrt();
                correlations.push(Correlation { a: rig.name(*a), b: rig.name(*b), value });
            }
        }
    }
    correlations.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()));
    correlations
}

/// How a block is to be adjusted: reweighting takes more steps.
pub(super) fn options(block: &Block) -> Options {
    let iterations_max = if block.loss == Loss::Squares { 50 } else { 500 };
    Options { loss: block.loss, iterations_max, ..Options::default() }
}

/// What the solver says, in the words of the files.
fn refused(error: &SolveError, rig: &Rig, observations: &Observations) -> InputError {
    let name = &observations.name;
    let has_failed = matches!(error, SolveError::NotConverged { .. } | SolveError::Stuck { .. } | SolveError::TooLarge);
    let sentence = match error {
        SolveError::Behind { observation } => {
            let seen = &rig.observations[*observation];
            format!(
                "{name}, line {}: point {} comes to lie behind head {} of station {}",
                observations.lines[*observation], seen.point, seen.head, seen.station
            )
        }
        SolveError::Parallel { point } => {
            let point = rig.free_point(*point).unwrap_or(*point);
            format!("{name}: the rays of point {point} are parallel, its position cannot be determined")
        }
        SolveError::Singular { along } => {
            let parts: Vec<String> = along.iter().map(|(unknown, _)| rig.name(*unknown)).collect();
            format!("{name}: the observations do not determine {}", parts.join(", "))
        }
        SolveError::NotConverged { iterations, cost_start, cost } => format!(
            "{name}: not converged after {iterations} iterations: the sum of squares still falls (from {:.4e} to {:.4e} sigmas squared), \
             the start values are too far off",
            2.0 * cost_start,
            2.0 * cost
        ),
        SolveError::Stuck { iterations, cost_start, cost } => format!(
            "{name}: not converged: after {iterations} iterations no step lowers the sum of squares any more (from {:.4e} to \
             {:.4e} sigmas squared), the start values are too far off",
            2.0 * cost_start,
            2.0 * cost
        ),
        SolveError::NotFinite => format!("{name}: the start values lead to numbers that are not finite"),
        SolveError::TooLarge => format!("{name}: there is no memory for the equations of this block"),
    };
    let is_far = matches!(error, SolveError::NotConverged { .. } | SolveError::Stuck { .. });
    let sentence = if is_far && is_from_corner(observations) {
        format!(
            "{sentence}, or image coordinates, none of which is negative, are counted from the frame's corner and not from its middle"
        )
    } else {
        sentence
    };
    if has_failed { InputError::failed(sentence) } else { InputError::new(sentence) }
}

/// Name of an unknown of a head, with the head, counted from 1.
#[must_use]
pub fn unknown_name(unknown: &HeadUnknown) -> String {
    format!("{} of head {}", head_name(unknown.number), unknown.head + 1)
}
