//! Where the camera is, as options, and the ground below it.

use crate::verbs::finite;
use plumbline_sim::camera::oriented::{Cells, Terrain};
use plumbline_survey::crs::{Crs, System};
use plumbline_survey::dem::{DemFile, Heights};
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::GeoTransform;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub struct PlaceArgs {
    /// Where the camera is, metres east on the grid of --epsg
    #[arg(long, value_parser = finite, requires = "north_m", allow_negative_numbers = true)]
    east_m: Option<f64>,
    /// Metres north
    #[arg(long, value_parser = finite, requires = "east_m", allow_negative_numbers = true)]
    north_m: Option<f64>,
    /// Metres above the datum of --dem
    #[arg(long, value_parser = finite, requires_all = ["east_m", "dem"], allow_negative_numbers = true)]
    up_m: Option<f64>,
    /// EPSG code of the grid; the system of --dem unless given
    #[arg(long, requires = "east_m", allow_negative_numbers = true)]
    epsg: Option<u32>,
    /// Elevation model of the ground: each pixel is projected from its own height
    #[arg(long, requires_all = ["east_m", "up_m"])]
    pub dem: Option<PathBuf>,
}

/// What the options say.
pub struct Place {
    /// East and north; 0 where nothing is said.
    pub centre: [f64; 2],
    /// Whether it is said.
    pub is_known: bool,
    /// Above the datum.
    up_m: f64,
    crs: Option<Crs>,
    dem: Option<DemFile>,
}

impl PlaceArgs {
    /// Opens the elevation model.
    pub fn place(&self) -> Result<Place, InputError> {
        let dem = self.dem.as_deref().map(DemFile::open).transpose()?;
        let system = self.epsg.map(System::Epsg).or_else(|| dem.as_ref()?.system());
        let crs = system.map(Crs::new).transpose()?;
        if let Some(crs) = crs.as_ref().filter(|crs| crs.is_geographic()) {
            return Err(InputError::new(format!(
                "{} is in degrees: --east-m and --north-m are metres of a grid, name it with --epsg",
                crs.system()
            )));
        }
        let centre = [self.east_m.unwrap_or(0.0), self.north_m.unwrap_or(0.0)];
        if let (Some(crs), Some(_)) = (&crs, self.east_m) {
            on_grid(crs, centre)?;
        }
        Ok(Place { centre, is_known: self.east_m.is_some(), up_m: self.up_m.unwrap_or(0.0), crs, dem })
    }
}

/// How far the scale of a grid is from 1 at most where it is used.
const SCALE_OFF: f64 = 0.05;

/// Refuses a place that the grid does not have, or has so far outside that degrees or north before east were meant.
fn on_grid(crs: &Crs, [east, north]: [f64; 2]) -> Result<(), InputError> {
    let is_used =
        |east: f64, north: f64| crs.point_scale(east, north).is_ok_and(|scale| (scale - 1.0).abs() < SCALE_OFF);
    let system = crs.system();
    if east.abs() <= 180.0 && north.abs() <= 180.0 {
        return Err(InputError::new(format!(
            "--east-m {east} --north-m {north} look like degrees, and metres of {system} are needed: \
             echo LON LAT | gdaltransform -s_srs EPSG:4326 -t_srs {system} prints them"
        )));
    }
    crs.to_wgs84(east, north)?;
    if is_used(east, north) || !is_used(north, east) {
        return Ok(());
    }
    Err(InputError::new(format!(
        "--east-m {east} --north-m {north} is far outside of {system} ({}); were they swapped, type --east-m {north} --north-m {east}",
        crs.name()
    )))
}

impl Place {
    /// What names the grid.
    pub fn system(&self) -> Option<System> {
        self.crs.as_ref().map(Crs::system)
    }

    /// East, north and up of the camera, at a height above level ground at 0 where no model says more.
    pub fn position(&self, height_m: f64) -> [f64; 3] {
        let [east, north] = self.centre;
        [east, north, if self.dem.is_some() { self.up_m } else { height_m }]
    }

    /// The elevation model over some metres around the camera.
    pub fn heights(&self, around_m: f64) -> Result<Option<Heights>, InputError> {
        let [east, north] = self.centre;
        let area = [east - around_m, north - around_m, east + around_m, north + around_m];
        self.dem.as_ref().map(|file| Heights::over(file, self.crs.as_ref(), area)).transpose()
    }

    /// Height above the ground at the nadir.
    pub fn height_m(&self, heights: &Heights) -> Result<f64, InputError> {
        let [east, north] = self.centre;
        let name = self.dem.as_ref().map(|file| file.path().display().to_string()).unwrap_or_default();
        let ground = heights.at(east, north).ok_or_else(|| {
            InputError::new(format!("{name} knows no height below the camera at east {east} m, north {north} m"))
        })?;
        let height = self.up_m - ground;
        if height > 0.0 {
            return Ok(height);
        }
        Err(InputError::new(format!(
            "--up-m {}: the ground of {name} is at {ground:.1} m there, above the camera",
            self.up_m
        )))
    }

    /// Where the patch's pixels lie.
    pub fn georeference(&self, size: (usize, usize), resolution_m: f64) -> GeoTransform {
        let half = |count: usize| 0.5 * (count as f64 - 1.0) * resolution_m;
        let [east, north] = self.centre;
        GeoTransform { x0: east - half(size.0), y0: north + half(size.1), step_x: resolution_m, step_y: resolution_m }
    }

    /// The cells around it.
    pub fn cells(&self, size: (usize, usize), resolution_m: f64) -> Cells {
        Cells { centre: self.centre, size, resolution_m }
    }
}

/// The ground: the model, or level at 0.
pub fn terrain(heights: Option<&Heights>) -> Terrain<'_> {
    heights.map_or(Terrain::Plane(0.0), Terrain::Model)
}
