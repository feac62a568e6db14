//! Where a plan lies: from its coordinates to a grid in metres that a flight can happen on.

use crate::world::PROCEDURAL_PLACE;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::utm_zone;
use plumbline_survey::plan::PlanFile;

/// From a plan's coordinates to those of a grid.
#[derive(Debug)]
pub struct Place {
    /// The grid.
    pub crs: Crs,
    /// Direction of the grid's north in the plan's coordinates, clockwise: 0 where both are one.
    pub convergence_rad: f64,
    way: Way,
}

/// How it is done.
#[derive(Debug)]
enum Way {
    /// The plan is on this grid.
    Same,
    /// The plan is in degrees of this system.
    Degrees(Box<Crs>),
    /// The plan is in metres of its own, which are moved by this much; and whether the plan said whereto.
    Moved([f64; 2], bool),
}

impl Place {
    /// The place of a plan.
    ///
    /// # Errors
    /// A reference system that is not known, a place that no UTM zone has.
    pub fn of(file: &PlanFile) -> Result<Self, InputError> {
        let photos = || file.strips.iter().flat_map(|strip| &strip.photos);
        let middle = |of: fn(&plumbline_survey::plan::file::Photo) -> f64| {
            let (low, high) = photos().map(of).fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            0.5 * (low + high)
        };
        let centre = [middle(|photo| photo.x), middle(|photo| photo.y)];
        match (file.epsg, file.origin_deg) {
            (Some(epsg), _) => {
                let crs = Crs::from_epsg(epsg)?;
                if !crs.is_geographic() {
                    return Ok(Place { crs, convergence_rad: 0.0, way: Way::Same });
                }
                let (lat_deg, lon_deg) = crs.to_wgs84(centre[0], centre[1])?;
                let grid = Crs::from_epsg(utm_zone(lat_deg, lon_deg).0)?;
                let (east, north) = grid.from_wgs84(lat_deg, lon_deg)?;
                let convergence_rad = grid.convergence_rad(east, north)?;
                Ok(Place { crs: grid, convergence_rad, way: Way::Degrees(Box::new(crs)) })
            }
            (None, Some([lat_deg, lon_deg])) => {
                let grid = Crs::from_epsg(utm_zone(lat_deg, lon_deg).0)?;
                let (east, north) = grid.from_wgs84(lat_deg, lon_deg)?;
                Ok(Place { crs: grid, convergence_rad: 0.0, way: Way::Moved([east, north], true) })
            }
            (None, None) => {
                let (epsg, [east, north]) = PROCEDURAL_PLACE;
                let moved = [east - centre[0].round(), north - centre[1].round()];
                Ok(Place { crs: Crs::from_epsg(epsg)?, convergence_rad: 0.0, way: Way::Moved(moved, false) })
            }
        }
    }

    /// Grid east and north of a plan's x and y.
    ///
    /// # Errors
    /// A place that the grid does not have.
    pub fn grid(&self, [x, y]: [f64; 2]) -> Result<[f64; 2], InputError> {
        match &self.way {
            Way::Same => Ok([x, y]),
            Way::Degrees(crs) => {
                let (lat_deg, lon_deg) = crs.to_wgs84(x, y)?;
                let (east, north) = self.crs.from_wgs84(lat_deg, lon_deg)?;
                Ok([east, north])
            }
            Way::Moved([east, north], _) => Ok([x + east, y + north]),
        }
    }

    /// A plan's x and y of grid east and north, the inverse.
    ///
    /// # Errors
    /// A place that the plan's system does not have.
    pub fn plan(&self, [east_m, north_m]: [f64; 2]) -> Result<[f64; 2], InputError> {
        match &self.way {
            Way::Same => Ok([east_m, north_m]),
            Way::Degrees(crs) => {
                let (lat_deg, lon_deg) = self.crs.to_wgs84(east_m, north_m)?;
                let (x, y) = crs.from_wgs84(lat_deg, lon_deg)?;
                Ok([x, y])
            }
            Way::Moved([east, north], _) => Ok([east_m - east, north_m - north]),
        }
    }

    /// What a reader should know of it.
    pub fn note(&self) -> Option<String> {
        let grid = format!("{} ({})", self.crs.system(), self.crs.name());
        match &self.way {
            Way::Same => None,
            Way::Degrees(_) => Some(format!("the plan is in degrees and is flown on the grid of {grid}")),
            Way::Moved(_, true) => Some(format!("the plan's local metres begin at its origin on the grid of {grid}")),
            Way::Moved([east, north], false) => Some(format!(
                "the plan names no place: its x and y are flown {east} m further east and {north} m further north on the grid of {grid}"
            )),
        }
    }
}
