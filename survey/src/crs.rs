//! Coordinate reference systems: from grid or geographic coordinates to WGS 84 and back.
//!
//! A system is named by its EPSG code, or spelt out by a file. What is accepted, and why so little, is in [`Crs::new`].

mod bases;
mod definition;
pub(crate) mod system;

use std::fmt;

use proj4rs::proj::Proj;
use proj4rs::transform::transform;

use crate::error::InputError;
use definition::Definition;
pub use system::System;

/// A horizontal reference system with a known way to WGS 84.
///
/// Heights play no part: points are taken on the ellipsoid. At height h the datum shift differs by the shift's rotation
/// times h, some cm at 1000 m, and lengths on the ground by the factor 1 + h/R.
#[derive(Clone)]
pub struct Crs {
    system: System,
    name: String,
    geographic: bool,
    proj: Proj,
    wgs84: Proj,
}

impl fmt::Debug for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Crs({} {})", self.system, self.name)
    }
}

/// WGS 84 semi-major axis (m) and first eccentricity squared.
const WGS84_A_M: f64 = 6_378_137.0;
const WGS84_E2: f64 = 6.694_379_990_141_316e-3;

/// Half the length of meridian (degrees, 111 m) that convergence and scale are measured on. Long against the 0.1 mm to
/// which projections are inverted, short against the Earth: the cubic term is 1e-10 of the result.
const HALF_STEP_DEG: f64 = 0.001;

/// Beyond this latitude a meridian is too short to tell north by.
pub(crate) const LATITUDE_MAX_DEG: f64 = 89.99;

/// Largest error of a point converted there and back, metres on the ground. Chosen: far below a pixel of any orthophoto, far
/// above the rounding of the series.
const ROUND_TRIP_M: f64 = 0.05;
const M_PER_DEG: f64 = 111_320.0;

impl Crs {
    /// The system of an EPSG code: [`Self::new`].
    ///
    /// # Errors
    /// As there.
    pub fn from_epsg(epsg: u32) -> Result<Self, InputError> {
        Self::new(System::Epsg(epsg))
    }

    /// How to convert by a system.
    ///
    /// Accepted are projected systems in metres with east and north axes and a conformal projection (transverse Mercator
    /// and UTM, Lambert conformal conic, stereographic, Mercator on the ellipsoid, oblique and Swiss Mercator), and geographic
    /// systems in degrees; both on a datum whose shift to WGS 84 is three or seven parameters that were found to agree
    /// with the EPSG dataset (the list and how it was made are in `crs/bases.rs`).
    ///
    /// How good the shift is: ETRS89, NAD83, GDA94, NZGD2000 and their like count as WGS 84, from which plates have drifted
    /// by up to 2 m; three-parameter shifts of old national datums are good to 5 m or so, seven-parameter ones to 1 to 3 m.
    /// Grids that are better are not used. Points of one datum keep their relative places; what suffers is the bridge to WGS
    /// 84.
    ///
    /// # Errors
    /// Refused are: unknown and deprecated codes; datums without a trusted shift and those that need a grid file (NAD27);
    /// compound, vertical, geocentric and three-dimensional systems; feet, grads, west or south axes, prime meridians other
    /// than Greenwich; projections that are not conformal, on which one convergence and one scale do not turn and stretch a
    /// patch (equal-area grids; also EPSG:3857, whose metre is neither a ground metre nor the same in both directions), and
    /// Krovak's, on which the list of definitions does not tell the axes apart.
    pub fn new(system: System) -> Result<Self, InputError> {
        let (name, geographic, string) = match system {
            System::Epsg(code) => {
                let Definition { name, geographic, proj4, .. } = Definition::read(code)?;
                (name, geographic, proj4.to_owned())
            }
            System::UserDefined(spelt_out) => ("user-defined", false, spelt_out.proj4()?),
        };
        let proj = |text: &str| {
            Proj::from_proj_string(text).map_err(|error| InputError::new(format!("cannot use {system}: {error}")))
        };
        Ok(Self {
            system,
            name: name.to_owned(),
            geographic,
            proj: proj(&string)?,
            wgs84: proj("+proj=longlat +datum=WGS84 +no_defs")?,
        })
    }

    /// What names it.
    #[must_use]
    pub fn system(&self) -> System {
        self.system
    }

    /// The name in the EPSG list; "user-defined" where it has none.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether x and y are longitude and latitude in degrees instead of east and north in metres.
    #[must_use]
    pub fn is_geographic(&self) -> bool {
        self.geographic
    }

    /// WGS 84 latitude and longitude (degrees) of a point (x east, y north; longitude, latitude if geographic).
    ///
    /// # Errors
    /// The point lies so far off that the projection does not lead back to it within 5 cm, or is not finite.
    pub fn to_wgs84(&self, x: f64, y: f64) -> Result<(f64, f64), InputError> {
        self.wgs84_unchecked(x, y)
            .filter(|&(lat_deg, lon_deg)| {
                self.grid_unchecked(lat_deg, lon_deg).is_some_and(|(x2, y2)| self.same_place((x, y), (x2, y2), lat_deg))
            })
            .ok_or_else(|| self.outside(&format!("x {x}, y {y}")))
    }

    /// Point (x east, y north; longitude, latitude if geographic) of a WGS 84 latitude and longitude in degrees.
    ///
    /// # Errors
    /// As for [`Self::to_wgs84`].
    pub fn from_wgs84(&self, lat_deg: f64, lon_deg: f64) -> Result<(f64, f64), InputError> {
        self.grid_unchecked(lat_deg, lon_deg)
            .filter(|&(x, y)| {
                self.wgs84_unchecked(x, y).is_some_and(|(lat2, lon2)| {
                    let turn = (lon2 - lon_deg + 180.0).rem_euclid(360.0) - 180.0;
                    let east_m = turn * lat_deg.to_radians().cos() * M_PER_DEG;
                    east_m.hypot((lat2 - lat_deg) * M_PER_DEG) < ROUND_TRIP_M
                })
            })
            .ok_or_else(|| self.outside(&format!("latitude {lat_deg}, longitude {lon_deg}")))
    }

    /// Grid convergence at a point, radians: the clockwise angle from true north to grid north, so that
    /// `heading_grid = heading_true - convergence`.
    ///
    /// It is positive east of the central meridian in the northern hemisphere. True north is that of the WGS 84 meridian,
    /// which is what a satellite receiver and an attitude filter know. Zero for a geographic system. It is measured on two
    /// points of the meridian, 222 m apart.
    ///
    /// # Errors
    /// As for [`Self::to_wgs84`]; also within 1 km of a pole.
    pub fn convergence_rad(&self, x: f64, y: f64) -> Result<f64, InputError> {
        let (d_x, d_y, _) = self.meridian_step(x, y)?;
        // The meridian's grid bearing is atan2(d_x, d_y); grid north lies the same angle on its other side.
        Ok(if self.geographic { 0.0 } else { (-d_x).atan2(d_y) })
    }

    /// Grid metres a ground metre at a point, on the WGS 84 ellipsoid, the same in every direction as all accepted
    /// projections are conformal.
    ///
    /// # Errors
    /// As for [`Self::convergence_rad`]; also for a geographic system, whose units are not metres.
    pub fn point_scale(&self, x: f64, y: f64) -> Result<f64, InputError> {
        if self.geographic {
            return Err(InputError::new(format!(
                "{} ({}) is in degrees and has no point scale",
                self.system, self.name
            )));
        }
        let (d_x, d_y, ground_m) = self.meridian_step(x, y)?;
        Ok(d_x.hypot(d_y) / ground_m)
    }

    /// A short step along the WGS 84 meridian through a point: its grid components and its length on the ellipsoid (m).
    fn meridian_step(&self, x: f64, y: f64) -> Result<(f64, f64, f64), InputError> {
        let (lat_deg, lon_deg) = self.to_wgs84(x, y)?;
        if lat_deg.abs() > LATITUDE_MAX_DEG {
            return Err(InputError::new(format!(
                "latitude {lat_deg} is too near the pole to tell grid north from true north"
            )));
        }
        let end = |lat_deg| self.grid_unchecked(lat_deg, lon_deg).ok_or_else(|| self.outside(&format!("x {x}, y {y}")));
        let (south_x, south_y) = end(lat_deg - HALF_STEP_DEG)?;
        let (north_x, north_y) = end(lat_deg + HALF_STEP_DEG)?;
        let ground_m = radii_m(lat_deg)[0] * (2.0 * HALF_STEP_DEG).to_radians();
        Ok((north_x - south_x, north_y - south_y, ground_m))
    }

    fn wgs84_unchecked(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let mut point = if self.geographic { (x.to_radians(), y.to_radians(), 0.0) } else { (x, y, 0.0) };
        transform(&self.proj, &self.wgs84, &mut point).ok()?;
        finite(point.1.to_degrees(), point.0.to_degrees())
    }

    fn grid_unchecked(&self, lat_deg: f64, lon_deg: f64) -> Option<(f64, f64)> {
        if !(-90.0..=90.0).contains(&lat_deg) || !(-360.0..=360.0).contains(&lon_deg) {
            return None;
        }
        let mut point = (lon_deg.to_radians(), lat_deg.to_radians(), 0.0);
        transform(&self.wgs84, &self.proj, &mut point).ok()?;
        if self.geographic { finite(point.0.to_degrees(), point.1.to_degrees()) } else { finite(point.0, point.1) }
    }

    fn same_place(&self, (x, y): (f64, f64), (x2, y2): (f64, f64), lat_deg: f64) -> bool {
        if self.geographic {
            let turn = (x2 - x + 180.0).rem_euclid(360.0) - 180.0;
            let east_m = turn * lat_deg.to_radians().cos() * M_PER_DEG;
            east_m.hypot((y2 - y) * M_PER_DEG) < ROUND_TRIP_M
        } else {
            (x2 - x).hypot(y2 - y) < ROUND_TRIP_M
        }
    }

    fn outside(&self, place: &str) -> InputError {
        InputError::new(format!("{place} is outside what {} ({}) can express", self.system, self.name))
    }
}

/// Radii of curvature of the WGS 84 ellipsoid at a latitude (m): in the meridian, and across it (prime vertical).
pub(crate) fn radii_m(lat_deg: f64) -> [f64; 2] {
    let w2 = 1.0 - WGS84_E2 * lat_deg.to_radians().sin().powi(2);
    [WGS84_A_M * (1.0 - WGS84_E2) / (w2 * w2.sqrt()), WGS84_A_M / w2.sqrt()]
}

fn finite(a: f64, b: f64) -> Option<(f64, f64)> {
    (a.is_finite() && b.is_finite()).then_some((a, b))
}

#[cfg(test)]
mod tests;
