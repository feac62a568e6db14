//! A scenario made ready to fly: ground, motion, camera, reference tile and what lies in the firmware's flash.

mod along_plan;
pub mod elevation;
pub mod frames;
mod kept;
mod watched;
mod live;
pub mod planned;
mod procedural;

pub use along_plan::PlanToFly;
pub use live::Start;

use crate::camera::render::{Renderer, Station};
use crate::camera::render_camera;
use crate::configuration::configuration_of;
use crate::configuration::key::{key_of_file, store_of};
use crate::link::Flash;
use crate::scenario::footprint::{footprint_margin_at_m, footprint_margin_m};
use crate::scenario::{self, Payload, Scenario};
use crate::vehicle::aloft::Course;
use crate::vehicle::motion::{Area, AttitudeLog, Motion, TrueState};
use crate::vehicle::mount::{axis_station, payload_of};
use crate::world::reference::Radiometry;
use crate::world::tile::{Frame, SIDE_MAX, Tile};
use crate::world::{Bounds, Grid, Ground, Weather};
use frames::Pictures;
use planned::Planned;
use plumbline_firmware::stores::tiles::TileHead;
use plumbline_firmware::wire::signature::Key;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::{Raster, check_metric, check_picture};
use std::path::Path;

/// How far from the centre a flight goes at most, metres: larger grounds are not used to their borders, so that the
/// tile stays small.
const HALF_EXTENT_MAX_M: f64 = 500.0;
/// Reference kept around what patches and searches need, pixels.
const TILE_SLACK_PX: f64 = 12.0;
/// Largest patch on board, pixels.
const PATCH_PX: f64 = plumbline_core::budget::PATCH_MAX_PX as f64;
/// What two epochs of one land differ by in the default scene: a scanned picture's tone curve, sensor noise, a tenth of the
/// land ploughed or built upon. Chosen, not measured.
const SYNTHETIC: Radiometry =
    Radiometry { gamma: 0.8, gain: 1.0, offset: 0.0, noise_dn: 3.0, changed_fraction: 0.1, seed: 0 };
/// What a real vehicle's attitude does beside its slow tilts, one sigma: some, as the log of the Vienna flight has it.
const RECORDED_SHAKE_DEG: f64 = 1.0;
/// Rays along each side of a pixel.
const RENDER_SAMPLES: usize = 2;

/// Everything a flight needs.
#[derive(Debug)]
pub struct Setup {
    /// What was asked for.
    pub scenario: Scenario,
    /// The camera, and how it sits.
    pub payload: Payload,
    /// What is flown over.
    pub ground: Ground,
    /// What is in the air above it and on its water.
    pub weather: Weather,
    /// How the reference differs from it.
    pub radiometry: Radiometry,
    /// Its reference system.
    pub crs: Crs,
    /// Where the vehicle really is.
    pub motion: Motion,
    /// Where a flight goes that is kept by its fixes.
    pub course: Option<Course>,
    /// What its camera really sees.
    pub renderer: Renderer,
    /// What lies in flash.
    pub flash: Flash,
    /// Grid coordinates of the tile's centre: what fixes are relative to.
    pub tile_centre: [f64; 2],
    /// Grid convergence there.
    pub convergence_rad: f64,
    /// What both sides of the link sign their messages with, if they do.
    pub signing: Option<Key>,
    /// The plan that is flown.
    pub plan: Option<Planned>,
    /// The frames of a flight that are there already.
    pub pictures: Option<Pictures>,
    /// What a user has to know of the log that is replayed and of the elevation model.
    pub notes: Vec<String>,
}

impl Setup {
    /// Prepares a flight along a plan.
    ///
    /// # Errors
    /// One sentence for a plan, elevation model or orthophoto that cannot be flown over.
    pub fn along_plan(scenario: Scenario, plan: &PlanToFly) -> Result<Self, InputError> {
        along_plan::prepare(scenario, plan)
    }

    /// Prepares a scenario.
    ///
    /// # Errors
    /// One sentence for files that are missing or broken, a ground without a usable reference system or smaller than
    /// the footprint, a replay that does not cover the flight.
    pub fn prepare(scenario: Scenario) -> Result<Self, InputError> {
        let payload = payload_of(&scenario)?;
        scenario.check_horizon(&payload)?;
        let (ground, reference) = grounds_of(&scenario)?;
        let crs = grid_of(&scenario, &ground)?;
        let doubt = elevation::doubt(&scenario, &ground)?;
        let log = scenario.run.replay.as_ref().map(|replay| AttitudeLog::load(&replay.att)).transpose()?;
        let margin_m = match &log {
            Some(log) => footprint_margin_at_m(&scenario, &payload, log.largest_tilt_rad(&scenario)?),
            None => footprint_margin_m(&scenario, &payload),
        };
        let height_m = scenario.run.flight.height_m[1];
        let area = match (area_of(&ground, margin_m, height_m), &log) {
            // The log's largest tilt may lean another way than a frame's corner: what its frames really show is less.
            (Err(_), Some(log)) => match log.reach(&scenario, &payload)? {
                0.0 => return Err(of_ground(&scenario, "in every attitude of the log frames see the horizon")),
                reach => area_of(&ground, height_m * reach, height_m),
            },
            (area, _) => area,
        };
        let area = area.map_err(|error| {
            let error = of_ground(&scenario, &error.to_string());
            if let Some(why) = &doubt { error.with(why) } else { error }
        })?;
        let course = kept::course(&scenario, &area)?;
        let notes = log.as_ref().map(|log| log.notes(&scenario)).transpose()?.unwrap_or_default();
        let motion = match log {
            _ if let Some(course) = &course => Motion::recorded(vec![(0.0, kept::start(course))]),
            Some(log) => Motion::replay(&scenario, &area, log)?,
            None => Motion::synthetic(&scenario, &area)?,
        };
        let wanted = wanted_of(&scenario, &area);
        let setup = Setup::finish(scenario, payload, (ground, reference), crs, motion, &wanted, Vec::new())?;
        Ok(Setup { course, notes: notes.into_iter().chain(doubt).collect(), ..setup })
    }

    /// Makes the reference tile over `wanted`, of the other orthophoto where there is one, and what lies in flash.
    fn finish(
        scenario: Scenario,
        payload: Payload,
        (ground, reference): (Ground, Option<Ground>),
        crs: Crs,
        motion: Motion,
        wanted: &Bounds,
        plan: Vec<u8>,
    ) -> Result<Self, InputError> {
        let radiometry = radiometry_of(&scenario);
        let tile = lay(&scenario, &radiometry, wanted, reference.as_ref().unwrap_or(&ground))?;
        let tile_centre = tile.centre();
        let model = elevation::of_flight(&scenario, &ground, &tile, !plan.is_empty())?;
        let head = TileHead { posts: model.as_ref().map(|model| model.posts), ..tile.head(&crs)? };
        let posts = model.map_or_else(Vec::new, |model| model.bytes);
        let convergence_rad = crs.convergence_rad(tile_centre[0], tile_centre[1])?;
        let shake_deg = if scenario.run.replay.is_some() { RECORDED_SHAKE_DEG } else { 0.0 };
        let configuration = configuration_of(&scenario.vehicle, &payload, shake_deg);
        let signing = scenario.run.link.signing_key_path.as_deref().map(key_of_file).transpose()?;
        let key = signing.map_or_else(Vec::new, |key| store_of(key, 0));
        let flash = Flash { configuration, head, tile: tile.pixels, posts, plan, key };
        flash.stores()?;
        let renderer = Renderer::new(render_camera(&payload.camera), RENDER_SAMPLES);
        let weather = Weather::new(scenario.run.seed, &scenario.world.weather, &scenario.world.land);
        Ok(Setup {
            scenario,
            payload,
            ground,
            weather,
            radiometry,
            crs,
            motion,
            course: None,
            renderer,
            flash,
            tile_centre,
            convergence_rad,
            signing,
            plan: None,
            pictures: None,
            notes: Vec::new(),
        })
    }

    /// Where the camera is in `state`, and where it looks.
    pub fn station(&self, state: &TrueState) -> Station {
        Station { boresight_rad: self.payload.mount.true_boresight_rad, ..axis_station(state) }
    }

    /// The laser's slant range in `state`: along the follow-up axis, to which it is strapped beside the camera, to where it
    /// really hits the ground.
    pub fn slant_m(&self, state: &TrueState) -> Option<f64> {
        let station = axis_station(state);
        let origin = [state.east_m, state.north_m, state.up_m];
        let hit = self.ground.intersect(origin, station.axes().down)?;
        Some(hit.iter().zip(origin).map(|(h, o)| (h - o) * (h - o)).sum::<f64>().sqrt())
    }
}

/// What is flown over, and what the reference is made of where that is another picture.
fn grounds_of(scenario: &Scenario) -> Result<(Ground, Option<Ground>), InputError> {
    let scenario::Ground::Ortho { ortho, dem, reference } = &scenario.world.ground else {
        return Ok(procedural::grounds(scenario));
    };
    let ground = picture(ortho, dem.as_deref(), false)?;
    let reference = reference.as_ref().map(|path| picture(path, None, false)).transpose()?;
    if let (Some(other), Some(path)) = (&reference, scenario_reference(scenario))
        && other.epsg() != ground.epsg()
    {
        return Err(InputError::new(format!(
            "{}: the reference is in EPSG:{}, the ground in EPSG:{}",
            path.display(),
            other.epsg(),
            ground.epsg()
        )));
    }
    Ok((ground, reference))
}

/// The ground's reference system, a projected grid in metres.
fn grid_of(scenario: &Scenario, ground: &Ground) -> Result<Crs, InputError> {
    let crs = Crs::from_epsg(ground.epsg()).map_err(|error| of_ground(scenario, &error.to_string()))?;
    if crs.is_geographic() {
        let why = format!("it is in degrees (EPSG:{}); a projected grid in metres is needed", ground.epsg());
        return Err(of_ground(scenario, &why));
    }
    Ok(crs)
}

/// A sentence about the ground, with its file's name.
fn of_ground(scenario: &Scenario, why: &str) -> InputError {
    match &scenario.world.ground {
        scenario::Ground::Ortho { ortho, .. } => InputError::new(format!("{}: {why}", ortho.display())),
        scenario::Ground::Procedural => InputError::new(why),
    }
}

/// An orthophoto to make a reference of, unknown (NaN) where it says that it knows nothing.
///
/// # Errors
/// One sentence for a file that is missing, broken, without a reference system or of pixels that are not square.
pub fn orthophoto(path: &Path) -> Result<Ground, InputError> {
    picture(path, None, true)
}

/// Whether a sample, counted row by row, says something.
fn is_known(raster: &Raster, index: usize, band: usize) -> bool {
    raster.sample(index % raster.cols, index / raster.cols, band).is_some()
}

fn scenario_reference(scenario: &Scenario) -> Option<&Path> {
    match &scenario.world.ground {
        scenario::Ground::Ortho { reference, .. } => reference.as_deref(),
        scenario::Ground::Procedural => None,
    }
}

fn picture(path: &Path, model: Option<&Path>, knows_nodata: bool) -> Result<Ground, InputError> {
    let raster = Raster::read(path)?;
    check_picture(path, raster.sample_type, &raster.scalings)?;
    let system = raster.crs.ok_or_else(|| {
        InputError::new(format!(
            "{}: the orthophoto names no reference system; where it is known: gdal_edit.py -a_srs EPSG:CODE {}",
            path.display(),
            path.display()
        ))
    })?;
    check_metric(path, &raster.geo, system, (raster.cols, raster.rows))?;
    let epsg = system.epsg().map_err(|error| error.at(path.display().to_string()))?;
    let surface = model.map(|model| elevation::surface(model, (path, epsg))).transpose()?;
    let mut grey = raster.grey();
    if knows_nodata {
        let known = |index: usize| (0..raster.bands.min(3)).any(|band| is_known(&raster, index, band));
        grey.iter_mut().enumerate().filter(|(index, _)| !known(*index)).for_each(|(_, grey)| *grey = f32::NAN);
    }
    Ground::new(grid(&raster, grey), surface, epsg)
        .map_err(|error| InputError::new(format!("{}: {error}", path.display())))
}

/// Of square pixels.
fn grid(raster: &Raster, data: Vec<f32>) -> Grid {
    let geo = &raster.geo;
    Grid { cols: raster.cols, rows: raster.rows, west_m: geo.x0, north_m: geo.y0, step_m: geo.step_x, data }
}

/// Where the vehicle may fly so that no frame looks over the ground's border; `margin_m` is how far frames see from
/// `height_m` above level ground.
fn area_of(ground: &Ground, margin_m: f64, height_m: f64) -> Result<Area, InputError> {
    let bounds = ground.bounds();
    let [centre_east_m, centre_north_m] = bounds.centre();
    let half_m = 0.5 * (bounds.east_m - bounds.west_m).min(bounds.north_m - bounds.south_m);
    let (mean_m, low_m) = heights(ground, half_m);
    // Terrain below its mean height is seen farther out.
    let sight_m = margin_m * (1.0 + (mean_m - low_m) / height_m);
    let half_extent_m = (half_m - sight_m).min(HALF_EXTENT_MAX_M);
    if half_extent_m.is_nan() || half_extent_m < 1.0 {
        return Err(InputError::new(format!(
            "the orthophoto is smaller than the footprint: frames see {sight_m:.0} m far, and it ends {half_m:.0} m from its centre"
        )));
    }
    let (base_up_m, _) = heights(ground, half_extent_m);
    Ok(Area { centre_east_m, centre_north_m, half_extent_m, base_up_m })
}

/// Mean and lowest height of the ground within ±`half_m` of its centre, from a fixed grid of points.
fn heights(ground: &Ground, half_m: f64) -> (f64, f64) {
    const SIDE: usize = 41;
    let [east, north] = ground.bounds().centre();
    let at = |i: usize| half_m * (2.0 * i as f64 / (SIDE - 1) as f64 - 1.0);
    let points = (0..SIDE * SIDE).map(|i| ground.height(east + at(i % SIDE), north + at(i / SIDE)));
    let (sum, low) = points.fold((0.0, f64::INFINITY), |(sum, low), height| (sum + height, height.min(low)));
    (sum / (SIDE * SIDE) as f64, low)
}

/// Where the vehicle flies, what a patch shows around it, and the search.
fn wanted_of(scenario: &Scenario, area: &Area) -> Bounds {
    let r = scenario.vehicle.resolution_m;
    let reach_m = area.half_extent_m + r * (0.5 * PATCH_PX + f64::from(scenario.vehicle.search_px) + TILE_SLACK_PX);
    let (east, north) = (area.centre_east_m, area.centre_north_m);
    Bounds { west_m: east - reach_m, east_m: east + reach_m, south_m: north - reach_m, north_m: north + reach_m }
}

/// How the reference differs from the ground: as the scenario says, and where it says nothing by the synthetic differences
/// of procedural ground; nothing is added to a picture of the world.
pub(crate) fn radiometry_of(scenario: &Scenario) -> Radiometry {
    let default = match scenario.world.ground {
        scenario::Ground::Procedural => SYNTHETIC,
        scenario::Ground::Ortho { .. } => Radiometry::SAME,
    };
    let given = &scenario.world.reference;
    Radiometry {
        gamma: given.gamma.unwrap_or(default.gamma),
        gain: given.gain.unwrap_or(default.gain),
        offset: given.offset_dn.unwrap_or(default.offset),
        noise_dn: given.noise_dn.unwrap_or(default.noise_dn),
        changed_fraction: given.changed_fraction.unwrap_or(default.changed_fraction),
        seed: scenario.run.seed,
    }
}

/// The tile over `wanted`.
fn lay(scenario: &Scenario, radiometry: &Radiometry, wanted: &Bounds, reference: &Ground) -> Result<Tile, InputError> {
    let r = scenario.vehicle.resolution_m;
    let [aside_east_m, aside_north_m] = scenario.world.reference.aside_m;
    let frame = Frame::within(reference, &wanted.moved([aside_east_m, aside_north_m]), r);
    let needed = PATCH_PX.min(16.0) + 2.0 * f64::from(scenario.vehicle.search_px);
    if !(frame.cols >= needed && frame.rows >= needed) {
        let (cols, rows) = (frame.cols, frame.rows);
        return Err(InputError::new(format!(
            "the reference has {cols} x {rows} pixels of {r} m over the flight, at least {needed} x {needed} are needed"
        )));
    }
    if frame.area() > plumbline_firmware::shared_memory::AREA_MAX as f64
        || frame.cols > SIDE_MAX
        || frame.rows > SIDE_MAX
    {
        let (cols, rows) = (frame.cols, frame.rows);
        return Err(InputError::new(format!("a reference of {cols} x {rows} pixels does not fit the board's flash")));
    }
    let tile = Tile::lay(reference, &frame, radiometry);
    let [east_m, north_m] = scenario.world.reference.bias_m;
    let (east_m, north_m) = (east_m - aside_east_m, north_m - aside_north_m);
    Ok(Tile { west_m: tile.west_m + east_m, north_m: tile.north_m + north_m, ..tile })
}

#[cfg(test)]
mod tests;
