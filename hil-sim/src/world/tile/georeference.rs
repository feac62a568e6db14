//! The tile's polynomial between geographic and grid coordinates, fitted against the full projection.

use nalgebra::{SMatrix, SVector};
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;

/// Points along each side of the fit.
const SIDE: usize = 9;
/// Largest residual that is accepted, metres: a hundredth of the finest pixel that is matched.
const RESIDUAL_MAX_M: f64 = 0.02;

/// The fit around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Latitude and longitude of the centre, 1e-7 degrees.
    pub centre_e7: (i32, i32),
    /// East, coefficients of q, p, q², qp, p² with (q, p) = (longitude, latitude) in 1e-2 degrees from the centre.
    pub east: [f32; 5],
    /// North, the same.
    pub north: [f32; 5],
}

/// Fits the square of ±`half_m` around `centre`.
///
/// # Errors
/// A point that the projection cannot convert, or an area so large that a second-order polynomial is not enough.
pub fn fit(crs: &Crs, centre: [f64; 2], half_m: f64) -> Result<Fit, InputError> {
    let (lat, lon) = crs.to_wgs84(centre[0], centre[1])?;
    let e7 = |degrees: f64| (degrees * 1e7).round();
    let mut normal = SMatrix::<f64, 5, 5>::zeros();
    let (mut right_east, mut right_north) = (SVector::<f64, 5>::zeros(), SVector::<f64, 5>::zeros());
    let mut points = Vec::with_capacity(SIDE * SIDE);
    for index in 0..SIDE * SIDE {
        let at = |i: usize| half_m * (2.0 * i as f64 / (SIDE - 1) as f64 - 1.0);
        let (east, north) = (at(index % SIDE), at(index / SIDE));
        let (point_lat, point_lon) = crs.to_wgs84(centre[0] + east, centre[1] + north)?;
        let (q, p) = ((point_lon - e7(lon) * 1e-7) * 100.0, (point_lat - e7(lat) * 1e-7) * 100.0);
        let terms = SVector::<f64, 5>::from([q, p, q * q, q * p, p * p]);
        normal += terms * terms.transpose();
        right_east += terms * east;
        right_north += terms * north;
        points.push((terms, east, north));
    }
    let singular = || InputError::new("the reference tile is too small to be georeferenced");
    let inverse = normal.try_inverse().ok_or_else(singular)?;
    let (east, north) = (inverse * right_east, inverse * right_north);
    let worst =
        points.iter().map(|(terms, e, n)| (terms.dot(&east) - e).hypot(terms.dot(&north) - n)).fold(0.0, f64::max);
    if worst.is_nan() || worst > RESIDUAL_MAX_M {
        return Err(InputError::new(format!(
            "the reference tile spans {:.0} m, too much for its georeference: {worst:.3} m off",
            2.0 * half_m
        )));
    }
    let coefficients = |fit: &SVector<f64, 5>| [0, 1, 2, 3, 4].map(|i| fit[i] as f32);
    Ok(Fit { centre_e7: (e7(lat) as i32, e7(lon) as i32), east: coefficients(&east), north: coefficients(&north) })
}
