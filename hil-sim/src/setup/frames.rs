//! A flight of frames that are there already: their files, and a vehicle that is where a table says.

mod path;
pub mod table;

use super::{Setup, grid_of, grounds_of};
use crate::camera::heads::turned;
use crate::scenario::{Scenario, footprint::half_tangents};
use crate::vehicle::motion::Motion;
use crate::vehicle::mount::payload_of;
use crate::vehicle::sensors::exposures;
use crate::world::{Bounds, Ground};
use plumbline_core::budget::REACQUIRE_PX;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Picture, read_grey};
use plumbline_survey::io::shell::quoted;
use std::path::PathBuf;
use table::Table;

/// What is flown.
#[derive(Clone, Copy, Debug)]
pub struct FramesToFly<'t> {
    /// The frames.
    pub table: &'t Table,
    /// Pixel side of reference and patches; unless given, the reference's own, or what has `patch_px` pixels in a footprint.
    pub resolution_m: Option<f64>,
    /// Pixels along the shorter side of a footprint at most, where no resolution is given.
    pub patch_px: f64,
    /// φ, ω, κ of the camera where they are not those of its file, degrees.
    pub boresight_deg: Option<[f64; 3]>,
}

/// The pictures of a flight, a file a frame.
#[derive(Clone, Debug)]
pub struct Pictures {
    files: Vec<PathBuf>,
    size: (usize, usize),
}

impl Pictures {
    /// Those of a table, each read once.
    fn of(table: &Table, size: (usize, usize)) -> Result<Self, InputError> {
        let pictures = Pictures { files: table.rows.iter().map(|row| row.file.clone()).collect(), size };
        for index in 0..pictures.files.len() {
            pictures.read(index).map_err(|error| InputError::new(format!("{}: {error}", table.line(index))))?;
        }
        Ok(pictures)
    }

    /// The grey picture of frame `index`.
    ///
    /// # Errors
    /// The file is missing, broken, or of another size than the camera's frames.
    pub fn read(&self, index: usize) -> Result<Picture, InputError> {
        let file = self.files.get(index).ok_or_else(|| InputError::new(format!("there is no frame {index}")))?;
        let picture = read_grey(file)?;
        if (picture.cols, picture.rows) != self.size {
            let (cols, rows) = self.size;
            return Err(InputError::new(format!(
                "{} has {} x {} pixels, the camera {cols} x {rows}",
                file.display(),
                picture.cols,
                picture.rows
            )));
        }
        Ok(picture)
    }
}

impl Setup {
    /// Prepares the flight of frames that are there already.
    ///
    /// # Errors
    /// One sentence for files that are missing or broken, a picture of another size than the camera's, a reference that shows none of the
    /// places or does not fit on board.
    pub fn of_frames(mut scenario: Scenario, frames: &FramesToFly<'_>) -> Result<Self, InputError> {
        let table = frames.table;
        let mut payload = payload_of(&scenario)?;
        if let Some(boresight_deg) = frames.boresight_deg {
            let boresight_rad = turned(boresight_deg, [0.0; 3]);
            (payload.mount.boresight_rad, payload.mount.true_boresight_rad) = (boresight_rad, boresight_rad);
        }
        let (ground, _) = grounds_of(&scenario)?;
        let crs = grid_of(&scenario, &ground)?;
        let notes = super::elevation::doubt(&scenario, &ground)?.into_iter().collect();
        let [right, up] = half_tangents(&payload.camera);
        let heights = table.rows.iter().map(|row| row.height_m);
        let lowest_m = heights.clone().fold(f64::INFINITY, f64::min);
        scenario.run.flight.height_m = [lowest_m, heights.fold(0.0, f64::max)];
        scenario.vehicle.resolution_m = frames.resolution_m.unwrap_or_else(|| {
            let footprint_m = 2.0 * lowest_m * right.min(up);
            // Rounded up to a tenth of a metre.
            let coarse_m = (10.0 * footprint_m / frames.patch_px).ceil() / 10.0;
            coarse_m.max(ground.albedo_grid().step_m)
        });
        scenario.check()?;
        let size = (payload.camera.cols as usize, payload.camera.rows as usize);
        let pictures = Pictures::of(table, size)?;
        let wanted = around(table, &scenario);
        shows(&ground, table)?;
        let mids_us: Vec<u64> = exposures(&scenario).map(|exposure| exposure.mid_us()).collect();
        let up_m = |[east_m, north_m]: [f64; 2]| ground.height(east_m, north_m);
        let motion = Motion::recorded(path::through(table, &mids_us, scenario.run.duration_us(), &up_m));
        let setup = Setup::finish(scenario, payload, (ground, None), crs, motion, &wanted, Vec::new())?;
        Ok(Setup { pictures: Some(pictures), notes, ..setup })
    }
}

/// What the frames may show and the search reach.
fn around(table: &Table, scenario: &Scenario) -> Bounds {
    let aside_m = scenario.vehicle.resolution_m
        * (super::PATCH_PX + f64::from(scenario.vehicle.search_px) + REACQUIRE_PX as f64 + super::TILE_SLACK_PX);
    let places = table.rows.iter().map(|row| row.place_m);
    let nothing =
        Bounds { west_m: f64::INFINITY, east_m: f64::NEG_INFINITY, south_m: f64::INFINITY, north_m: f64::NEG_INFINITY };
    let bounds = places.fold(nothing, |bounds, [east_m, north_m]| Bounds {
        west_m: bounds.west_m.min(east_m),
        east_m: bounds.east_m.max(east_m),
        south_m: bounds.south_m.min(north_m),
        north_m: bounds.north_m.max(north_m),
    });
    bounds.grown(aside_m)
}

/// Refuses a reference that shows none of the places.
fn shows(ground: &Ground, table: &Table) -> Result<(), InputError> {
    let bounds = ground.bounds();
    if table.rows.iter().any(|row| bounds.contains(row.place_m[0], row.place_m[1])) {
        return Ok(());
    }
    let [east_m, north_m] = table.rows[0].place_m;
    let hint = if bounds.contains(north_m, east_m) {
        "; with east and north swapped it would".to_owned()
    } else {
        in_degrees(ground, table).unwrap_or_default()
    };
    Err(InputError::new(format!(
        "{}: east_m {east_m}, north_m {north_m} is not on the reference (EPSG:{}, {:.0} to {:.0} m east, {:.0} to {:.0} m north), nor is any other frame{hint}",
        table.line(0),
        ground.epsg(),
        bounds.west_m,
        bounds.east_m,
        bounds.south_m,
        bounds.north_m
    )))
}

/// What to type where the places are on the reference as longitudes and latitudes, or the other way round, or look like them.
fn in_degrees(ground: &Ground, table: &Table) -> Option<String> {
    let crs = Crs::from_epsg(ground.epsg()).ok()?;
    let [one, other] = table.rows[0].place_m;
    let is_there = |lat_deg, lon_deg| {
        crs.from_wgs84(lat_deg, lon_deg).is_ok_and(|(east_m, north_m)| ground.bounds().contains(east_m, north_m))
    };
    let [east, north, ..] = table.columns.map(|column| column + 1);
    let look_like_degrees = || table.rows.iter().all(|row| row.place_m.iter().all(|number| number.abs() <= 180.0));
    let (why, [lon, lat]) = match (is_there(other, one), is_there(one, other)) {
        (true, _) => ("as longitude and latitude in degrees it would", [east, north]),
        (_, true) => ("as latitude and longitude in degrees it would", [north, east]),
        _ if look_like_degrees() => ("they look like longitude and latitude in degrees: if they are", [east, north]),
        _ => return None,
    };
    let colon = if why.ends_with("are") { "," } else { ":" };
    Some(format!(
        "; {why}{colon} awk -F, 'NR > 1 {{ print ${lon}, ${lat} }}' {} | gdaltransform -s_srs EPSG:4326 -t_srs EPSG:{} -output_xy \
         prints east and north of each row",
        quoted(&table.name),
        ground.epsg()
    ))
}
