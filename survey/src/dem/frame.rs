//! Where working coordinates lie: the metres that lines are planned in.

use crate::crs::{Crs, LATITUDE_MAX_DEG, System, radii_m};
use crate::error::InputError;

/// From the x and y of an elevation model to working coordinates, metres east and north, and to WGS 84.
///
/// A model on a grid is worked on in its own coordinates. One in degrees is worked on in metres from its centre, where x
/// is longitude times the radius of the parallel and y latitude times the radius of the meridian, both at the centre: the
/// plate carree with a scale of each axis. Along y that is right within 1e-4 over 100 km. Along x the parallels shrink
/// to the poles, so that at a distance n north of the centre lengths are too long by n tan(latitude) / R: 0.9e-3 at
/// 48 degrees and 5 km, 1.7e-3 at 10 km, 1.8e-3 at 36.6 degrees and 15 km. A base that is planned as 500 m is then 0.5
/// to 0.9 m off, overlaps by less than 0.1 %. Areas larger than some 20 km are better planned on a grid.
#[derive(Debug, Clone)]
pub enum Frame {
    /// Metres of which only the model's file knows where they are.
    Local,
    /// The model's own grid.
    Grid(Crs),
    /// Metres about a place.
    Degrees {
        /// The model's geographic system.
        crs: Crs,
        /// Longitude and latitude in that system where the working coordinates are 0, degrees.
        origin: [f64; 2],
        /// Metres a degree of longitude and of latitude, at the origin.
        m_per_deg: [f64; 2],
    },
}

impl Frame {
    /// The frame of a model by its reference system, and the centre of the area of interest in the model's x and y.
    ///
    /// The metres of a degree are those of the WGS 84 ellipsoid also where the system has another one: 1e-4 of a length.
    ///
    /// # Errors
    /// The system is one that [`Crs::new`] refuses, or the centre is no place in it.
    pub fn new(system: Option<System>, centre: [f64; 2]) -> Result<Self, InputError> {
        let Some(system) = system else { return Ok(Self::Local) };
        let crs = Crs::new(system)?;
        if !crs.is_geographic() {
            return Ok(Self::Grid(crs));
        }
        let [lon_deg, lat_deg] = centre;
        crs.to_wgs84(lon_deg, lat_deg)?;
        if lat_deg.abs() > LATITUDE_MAX_DEG {
            return Err(InputError::new(format!("latitude {lat_deg} is too near the pole to plan in metres")));
        }
        let [meridian_m, prime_vertical_m] = radii_m(lat_deg);
        let parallel_m = prime_vertical_m * lat_deg.to_radians().cos();
        Ok(Self::Degrees { crs, origin: centre, m_per_deg: [parallel_m.to_radians(), meridian_m.to_radians()] })
    }

    /// The working coordinates of an area, x0, y0, x1, y1: in degrees with the longest degree of longitude and of latitude
    /// that it has, so that nothing in it is farther apart than the working coordinates say. What is planned with a
    /// guarantee there keeps it.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn over(system: Option<System>, [x0, y0, x1, y1]: [f64; 4]) -> Result<Self, InputError> {
        let frame = Self::new(system, [0.5 * (x0 + x1), 0.5 * (y0 + y1)])?;
        let Self::Degrees { crs, origin, .. } = frame else { return Ok(frame) };
        let nearest_equator = if y0 <= 0.0 && y1 >= 0.0 { 0.0 } else { y0.abs().min(y1.abs()) };
        let [_, prime_vertical_m] = radii_m(nearest_equator);
        let [meridian_m, _] = radii_m(y0.abs().max(y1.abs()).min(LATITUDE_MAX_DEG));
        let parallel_m = prime_vertical_m * nearest_equator.to_radians().cos();
        Ok(Self::Degrees { crs, origin, m_per_deg: [parallel_m.to_radians(), meridian_m.to_radians()] })
    }

    /// Working coordinates of a model's (x, y).
    #[must_use]
    pub fn metres(&self, world: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Local | Self::Grid(_) => world,
            Self::Degrees { origin, m_per_deg, .. } => {
                [0, 1].map(|axis| (world[axis] - origin[axis]) * m_per_deg[axis])
            }
        }
    }

    /// A model's (x, y) of working coordinates, the inverse of [`Self::metres`].
    #[must_use]
    pub fn world(&self, metres: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Local | Self::Grid(_) => metres,
            Self::Degrees { origin, m_per_deg, .. } => [0, 1].map(|axis| origin[axis] + metres[axis] / m_per_deg[axis]),
        }
    }

    /// WGS 84 latitude and longitude (degrees) of working coordinates; `None` where nobody knows.
    ///
    /// # Errors
    /// As [`Crs::to_wgs84`].
    pub fn wgs84(&self, metres: [f64; 2]) -> Result<Option<(f64, f64)>, InputError> {
        let [x, y] = self.world(metres);
        self.crs().map(|crs| crs.to_wgs84(x, y)).transpose()
    }

    /// Working coordinates of a WGS 84 latitude and longitude (degrees); `None` where nobody knows.
    ///
    /// # Errors
    /// As [`Crs::from_wgs84`].
    pub fn from_wgs84(&self, lat_deg: f64, lon_deg: f64) -> Result<Option<[f64; 2]>, InputError> {
        let world = self.crs().map(|crs| crs.from_wgs84(lat_deg, lon_deg)).transpose()?;
        Ok(world.map(|(x, y)| self.metres([x, y])))
    }

    /// What names the model's system.
    #[must_use]
    pub fn system(&self) -> Option<System> {
        self.crs().map(Crs::system)
    }

    /// The model's system.
    fn crs(&self) -> Option<&Crs> {
        match self {
            Self::Local => None,
            Self::Grid(crs) | Self::Degrees { crs, .. } => Some(crs),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place on the Tennessee model.
    const CENTRE: [f64; 2] = [-84.25, 36.59];

    /// pyproj 3.7.2, `Geod(ellps="WGS84").inv` over 0.001 degrees about the centre: north, then east.
    const GEODESIC_M_PER_DEG: [f64; 2] = [89_487.307_014_973_8, 110_969.974_582_178_92];

    fn degrees() -> Frame {
        Frame::new(Some(System::Epsg(4326)), CENTRE).expect("geographic")
    }

    #[test]
    fn degrees_are_metres_as_geodesics_measure_them() {
        let frame = degrees();
        assert_eq!((frame.metres(CENTRE), frame.system()), ([0.0, 0.0], Some(System::Epsg(4326))));
        let [east_m, north_m] = frame.metres([CENTRE[0] + 1.0, CENTRE[1] + 1.0]);
        // An arc of 111 m against its tangent: 1e-11 of it.
        assert!((east_m / GEODESIC_M_PER_DEG[0] - 1.0).abs() < 1e-9, "{east_m}");
        assert!((north_m / GEODESIC_M_PER_DEG[1] - 1.0).abs() < 1e-9, "{north_m}");
    }

    #[test]
    fn degrees_are_as_far_off_as_the_documentation_says() {
        // pyproj: Transformer to "+proj=aeqd +lat_0=36.59 +lon_0=-84.25 +ellps=WGS84", right near its centre within
        // 13 km^3 / (6 R^2) = 1 cm, of (-84.15, 36.68).
        let [east_m, north_m] = [8_938.331_252_279_811, 9_992.026_153_165_245];
        let found = degrees().metres([-84.15, 36.68]);
        let bend = 36.59_f64.to_radians().tan() / 6_378_000.0;
        let wanted = [east_m * (1.0 + bend * north_m), north_m - bend * east_m * east_m / 2.0];
        assert!((found[0] - wanted[0]).hypot(found[1] - wanted[1]) < 0.1, "{found:?} {wanted:?}");
        assert!((found[0] - east_m - 10.4).abs() < 0.1 && (north_m - found[1] - 4.7).abs() < 0.1);
    }

    #[test]
    fn there_and_back_is_the_same_place() {
        for frame in [degrees(), Frame::new(Some(System::Epsg(31287)), [0.0, 0.0]).expect("grid"), Frame::Local] {
            let metres = [551_234.5, 432_109.25];
            let back = frame.metres(frame.world(metres));
            assert!((back[0] - metres[0]).abs() < 1e-8 && (back[1] - metres[1]).abs() < 1e-8, "{frame:?} {back:?}");
        }
    }

    #[test]
    fn wgs84_is_the_model_s_place() {
        // pyproj 3.7.2, `Transformer.from_crs(31287, 4326)`, by the transformation "MGI to WGS 84 (3)" as everywhere here.
        let grid = Frame::new(Some(System::Epsg(31287)), [0.0, 0.0]).expect("grid");
        let (lat_deg, lon_deg) =
            grid.wgs84([554_883.275_826_701_3, 432_676.184_330_590_4]).expect("inside").expect("known");
        assert!((lat_deg - 47.775).abs() < 2e-7 && (lon_deg - 15.4).abs() < 2e-7, "{lat_deg} {lon_deg}");
        let frame = degrees();
        let (lat_deg, lon_deg) = frame.wgs84([1000.0, -2000.0]).expect("inside").expect("known");
        let wanted = [CENTRE[0] + 1000.0 / GEODESIC_M_PER_DEG[0], CENTRE[1] - 2000.0 / GEODESIC_M_PER_DEG[1]];
        assert!((lon_deg - wanted[0]).abs() < 1e-9 && (lat_deg - wanted[1]).abs() < 1e-9);
        let back = frame.from_wgs84(lat_deg, lon_deg).expect("inside").expect("known");
        assert!((back[0] - 1000.0).abs() < 1e-3 && (back[1] + 2000.0).abs() < 1e-3, "{back:?}");
        assert_eq!((Frame::Local.wgs84([1.0, 2.0]), Frame::Local.from_wgs84(47.0, 15.0)), (Ok(None), Ok(None)));
        assert!(grid.wgs84([1e9, 0.0]).is_err() && frame.from_wgs84(95.0, 0.0).is_err());
    }

    #[test]
    fn doubtful_frames_are_refused() {
        assert!(Frame::new(Some(System::Epsg(3857)), [0.0, 0.0]).is_err(), "not conformal");
        for centre in [[16.0, 89.999], [16.0, 91.0], [f64::NAN, 48.0]] {
            assert!(Frame::new(Some(System::Epsg(4326)), centre).is_err(), "{centre:?}");
        }
    }
}
