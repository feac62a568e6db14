//! Where on Earth a plan lies.

use crate::crs::radii_m;
use crate::dem::Frame;
use crate::error::InputError;

/// Working coordinates, and where on Earth they are, if that is known.
#[derive(Debug, Clone)]
pub struct Place {
    frame: Frame,
    origin_deg: Option<[f64; 2]>,
}

/// Farthest from its given origin that a local grid is taken for a plane, metres.
const LOCAL_MAX_M: f64 = 100_000.0;
/// Nearest to a pole that a local grid may lie.
const LATITUDE_MAX_DEG: f64 = 85.0;

impl Place {
    /// A frame, and for one of local metres the latitude and longitude of its x = 0, y = 0.
    ///
    /// # Errors
    /// The frame has a reference system of its own; the origin is no place, or at a pole.
    pub fn new(frame: Frame, origin_deg: Option<[f64; 2]>) -> Result<Self, InputError> {
        if let (Some(system), Some(_)) = (frame.system(), origin_deg) {
            return Err(InputError::new(format!(
                "--origin is for an elevation model without a reference system, and this one is in {system}"
            )));
        }
        if let Some([lat, lon]) = origin_deg
            && !(lat.abs() <= LATITUDE_MAX_DEG && lon.abs() <= 180.0)
        {
            let is_swapped = lon.abs() <= LATITUDE_MAX_DEG && lat.abs() <= 180.0;
            let meant =
                if is_swapped { format!("; were they swapped, write --origin {lon},{lat}") } else { String::new() };
            return Err(InputError::new(format!(
                "--origin {lat},{lon} is no latitude within {LATITUDE_MAX_DEG} and longitude within 180 degrees{meant}"
            )));
        }
        Ok(Place { frame, origin_deg })
    }

    /// The working coordinates' frame.
    #[must_use]
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Latitude and longitude of a local grid's origin, where they were given.
    #[must_use]
    pub fn origin_deg(&self) -> Option<[f64; 2]> {
        self.origin_deg
    }

    /// Whether anybody knows where on Earth the plan lies.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.frame.system().is_some() || self.origin_deg.is_some()
    }

    /// Latitude and longitude (WGS 84, degrees) of working coordinates; `None` where nobody knows. A local grid is laid on the
    /// ellipsoid by its radii at the origin: 1e-4 of a length within 10 km at middle latitudes, and its north is true north.
    ///
    /// # Errors
    /// A place that its system cannot express, or too far from a local grid's origin.
    pub fn wgs84(&self, metres: [f64; 2]) -> Result<Option<(f64, f64)>, InputError> {
        let Some([lat_deg, lon_deg]) = self.origin_deg else {
            return Ok(self.frame.wgs84(metres)?.map(|(lat, lon)| (lat, wrapped_deg(lon))));
        };
        let [x, y] = metres;
        if !(x.abs() <= LOCAL_MAX_M && y.abs() <= LOCAL_MAX_M) {
            return Err(InputError::new(format!(
                "x {x}, y {y} is farther from the local grid's origin than {LOCAL_MAX_M} m, so its position on Earth is not known: where these are \
                 coordinates of a grid with a name, gdal_translate -a_srs EPSG:CODE MODEL OUT.tif names it, and --origin is not needed"
            )));
        }
        let [meridian_m, prime_vertical_m] = radii_m(lat_deg);
        let lat = lat_deg + (y / meridian_m).to_degrees();
        let lon = lon_deg + (x / (prime_vertical_m * lat_deg.to_radians().cos())).to_degrees();
        Ok(Some((lat, wrapped_deg(lon))))
    }
}

/// A longitude within 180 degrees; one that is stays as it is, to the last bit.
fn wrapped_deg(lon: f64) -> f64 {
    if lon.abs() <= 180.0 { lon } else { (lon + 180.0).rem_euclid(360.0) - 180.0 }
}
