//! A plan as files for other programs: `plan.json`, a mission, GeoJSON, KML, the coverage raster.
//!
//! Coordinates come from the working metres in which was planned. Heights are the elevation model's; from those of the mission and of KML,
//! which are above mean sea level, the geoid's are subtracted where one is given.

mod coverage;
mod geojson;
mod kml;
mod mission;
#[cfg(test)]
mod tests;
pub mod vehicle;

use crate::dem::Geoid;
use crate::error::InputError;
use crate::io::output::{check_file, write_files};
use crate::plan::flown::{Leg, flown};
use crate::plan::place::Place;
use crate::plan::{PlanFile, Planned};
use std::path::{Path, PathBuf};

pub use mission::ITEMS_MAX;
use vehicle::Vehicle;

/// The files that may be written.
pub const FILES: [&str; 6] = ["plan.json", "plan.plan", "plan.geojson", "plan.kml", "coverage.tif", "report.html"];

/// A plan on its way out.
#[derive(Debug)]
pub struct Outputs<'p> {
    /// The plan with its rasters.
    pub planned: &'p Planned<'p>,
    /// The plan as its file has it.
    pub file: &'p PlanFile,
    /// Where it lies.
    pub place: &'p Place,
    /// Whether the autopilot's mission has every photo.
    pub trigger_items: bool,
    /// Who flies it.
    pub vehicle: Vehicle,
    /// The geoid above the ellipsoid, where the elevation model's heights are above that.
    pub geoid: Option<&'p Geoid>,
}

impl Outputs<'_> {
    /// All files but the page, whole, before the first is written. The plan for an autopilot and KML are left out where
    /// nobody knows where on Earth it lies.
    ///
    /// # Errors
    /// What a file cannot express.
    pub fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
        let json = serde_json::to_string_pretty(self.file)
            .map_err(|error| InputError::new(format!("the plan cannot be written as JSON: {error}")))?;
        let mut files = vec![("plan.json", format!("{json}\n").into_bytes())];
        if self.place.is_known() {
            files.push(("plan.plan", self.mission()?.into_bytes()));
            files.push(("plan.kml", self.kml()?.into_bytes()));
        }
        files.push(("plan.geojson", self.geojson()?.into_bytes()));
        files.push(("coverage.tif", self.coverage()?));
        Ok(files)
    }

    /// The strips as they are flown: the order of `plan.json`.
    pub fn legs(&self) -> impl Iterator<Item = Leg<'_>> {
        flown(&self.planned.strips)
    }

    /// Corners of the area, working metres, counter-clockwise, the first not repeated.
    #[must_use]
    pub fn area(&self) -> Vec<[f64; 2]> {
        let layout = &self.planned.layout;
        counter_clockwise(layout.area.corners().iter().map(|corner| layout.axes.point(*corner)).collect())
    }

    /// A height of the elevation model above mean sea level, at a place.
    fn above_sea_m(&self, up_m: f64, [lon, lat]: [f64; 2]) -> Result<f64, InputError> {
        let Some(geoid) = self.geoid else { return Ok(up_m) };
        let geoid_m = geoid.height_m(lat, lon).ok_or_else(|| {
            InputError::new(format!(
                "cannot use geoid {}: it does not cover latitude {lat}, longitude {lon}",
                geoid.name()
            ))
        })?;
        Ok(up_m - geoid_m)
    }

    /// Longitude and latitude (WGS 84) of working coordinates, to the 1e-7 degrees that MAVLink has; `None` where nobody knows.
    fn lon_lat(&self, metres: [f64; 2]) -> Result<Option<[f64; 2]>, InputError> {
        Ok(self.place.wgs84(metres)?.map(|(lat, lon)| [lon, lat].map(|deg| (deg * 1e7).round() / 1e7)))
    }
}

/// A ring the way round that GeoJSON and KML want, the first corner not repeated.
fn counter_clockwise(mut ring: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let Some([x0, y0]) = ring.first().copied() else { return ring };
    let next = ring.iter().cycle().skip(1);
    let doubled: f64 = ring.iter().zip(next).map(|(a, b)| (a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0)).sum();
    if doubled < 0.0 {
        ring.reverse();
    }
    ring
}

/// Writes the files, all or none; those of [`FILES`] that an earlier plan left and this one does not have are removed, as
/// they would be taken for this one's.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Path, files: &[(&'static str, Vec<u8>)]) -> Result<(), InputError> {
    for name in FILES {
        check_file(&folder.join(name))?;
    }
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    let pairs: Vec<(&Path, &[u8])> =
        paths.iter().zip(files).map(|(path, (_, bytes))| (path.as_path(), bytes.as_slice())).collect();
    write_files(&pairs)?;
    let stale = FILES.iter().filter(|name| files.iter().all(|(written, _)| written != *name));
    for path in stale.map(|name| folder.join(name)).filter(|path| path.exists()) {
        std::fs::remove_file(&path).map_err(|error| {
            InputError::failed(format!("cannot remove {}, which is of another plan: {error}", path.display()))
        })?;
    }
    Ok(())
}
