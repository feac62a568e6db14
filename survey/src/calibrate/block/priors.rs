//! What a block knows beforehand of stations and points.

use super::super::fields::Field;
use crate::adjust::rig::{Point, Station};
use crate::error::InputError;
use nalgebra::SMatrix;

/// What is known of a station: expected values and whitening rows over phi, omega, kappa, X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct StationPrior {
    /// Which.
    pub station: usize,
    /// Expected values.
    pub target: [f64; 6],
    /// Rows of unit variance.
    pub rows: Vec<Vec<f64>>,
}

/// What is known of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointPrior {
    /// Which.
    pub point: usize,
    /// Expected position, m.
    pub position_m: [f64; 3],
    /// Its standard deviations, m.
    pub sigma_m: [f64; 3],
}

/// Rows of unit variance for single numbers with sigmas.
fn rows_of(sigmas: &[(usize, f64)]) -> Vec<Vec<f64>> {
    let row = |(index, sigma): &(usize, f64)| {
        let mut row = vec![0.0; 6];
        row[*index] = 1.0 / sigma;
        row
    };
    sigmas.iter().map(row).collect()
}

pub(super) fn station_priors(file: &Field<'_>, stations: &[Station]) -> Result<Vec<StationPrior>, InputError> {
    let Some(field) = file.key("station_priors") else { return Ok(Vec::new()) };
    let (mut priors, mut is_named): (Vec<StationPrior>, _) = (Vec::new(), vec![false; stations.len()]);
    for item in field.list()? {
        let station = item.needed("station")?.index(stations.len(), "station")?;
        if std::mem::replace(&mut is_named[station], true) {
            return Err(InputError::new(format!("{} is a second prior of station {station}", item.at)));
        }
        let start = stations[station].values;
        let mut target = start;
        let rows = match item.key("covariance") {
            Some(covariance) => {
                target = item.needed("values")?.numbers()?;
                whitening(&covariance)?
            }
            None => {
                let mut sigmas = Vec::new();
                for (values, sigma, first) in [("angles_rad", "sigma_rad", 0), ("position_m", "sigma_m", 3)] {
                    let Some(values) = item.key(values) else { continue };
                    target[first..first + 3].copy_from_slice(&values.numbers::<3>()?);
                    let of = item.needed(sigma)?.sigmas::<3>()?;
                    sigmas.extend(of.into_iter().enumerate().map(|(k, sigma)| (first + k, sigma)));
                }
                if sigmas.is_empty() {
                    return Err(InputError::new(format!("{} has neither position_m nor angles_rad", item.at)));
                }
                rows_of(&sigmas)
            }
        };
        // An angle is expected in the turn the start value is in.
        for (target, start) in target.iter_mut().zip(start).take(3) {
            *target += std::f64::consts::TAU * ((start - *target) / std::f64::consts::TAU).round();
        }
        priors.push(StationPrior { station, target, rows });
    }
    Ok(priors)
}

/// L^-1 of a covariance L L'.
fn whitening(field: &Field<'_>) -> Result<Vec<Vec<f64>>, InputError> {
    let rows = field.list()?;
    if rows.len() != 6 {
        return Err(field.wrong("6 rows of 6 numbers"));
    }
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    for (k, row) in rows.iter().enumerate() {
        matrix.row_mut(k).copy_from_slice(&row.numbers::<6>()?);
    }
    let is_symmetric = (matrix - matrix.transpose()).amax() <= 1e-9 * matrix.amax();
    let inverse = matrix.cholesky().filter(|_| is_symmetric).and_then(|factor| factor.l().try_inverse());
    let inverse = inverse.ok_or_else(|| {
        InputError::new(format!("{} is no covariance: not symmetric and positive definite", field.at))
    })?;
    Ok((0..6).map(|k| inverse.row(k).iter().copied().collect()).collect())
}

pub(super) fn point_priors(file: &Field<'_>, points: &[Point]) -> Result<Vec<PointPrior>, InputError> {
    let Some(field) = file.key("point_priors") else { return Ok(Vec::new()) };
    let (mut priors, mut is_named): (Vec<PointPrior>, _) = (Vec::new(), vec![false; points.len()]);
    for item in field.list()? {
        let point = item.needed("point")?.index(points.len(), "point")?;
        if std::mem::replace(&mut is_named[point], true) {
            return Err(InputError::new(format!("{} is a second prior of point {point}", item.at)));
        }
        if !points[point].is_free {
            return Err(InputError::new(format!("{} is a prior of point {point}, which fixed_points names", item.at)));
        }
        let position_m = match item.key("position_m") {
            Some(position) => position.numbers()?,
            None => points[point].position_m,
        };
        priors.push(PointPrior { point, position_m, sigma_m: item.needed("sigma_m")?.sigmas()? });
    }
    Ok(priors)
}
