//! A scenario made ready to fly: ground, motion, camera, reference tile and what lies in the firmware's flash.

mod georeference;
mod stamps;

use crate::camera::render_camera;
use crate::flight::{Area, AttitudeLog, Motion, TrueState, footprint_margin_at_m, footprint_margin_m};
use crate::link::Flash;
use crate::reference::{Radiometry, reference_tile};
use crate::render::{Renderer, Station};
use crate::scenario::{self, FollowUpMode, Scenario};
use crate::world::{Grid, Ground, procedural};
use plumbline_firmware::mission::{Mission, VERSION};
use plumbline_survey::camera_file::{CameraFile, Distortion};
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use plumbline_survey::raster::Raster;
use std::f64::consts::TAU;
use std::path::Path;

/// How far from the centre a flight goes at most, metres: larger grounds are not used to their borders, so that the
/// tile stays small.
const HALF_EXTENT_MAX_M: f64 = 500.0;
/// Reference kept around what patches and searches need, pixels.
const TILE_SLACK_PX: f64 = 12.0;
/// Largest patch on board, pixels.
const PATCH_PX: f64 = plumbline_core::budget::PATCH_MAX_PX as f64;
/// How fast the synthetic track turns at most, radians a second: see [`crate::flight`].
const WEAVE_RAD_S: f64 = 0.35;
/// Rays along each side of a pixel.
const RENDER_SAMPLES: usize = 2;

/// Everything a flight needs.
#[derive(Debug)]
pub struct Stage {
    /// What was asked for.
    pub scenario: Scenario,
    /// The camera, as its file would say.
    pub camera: CameraFile,
    /// What is flown over.
    pub ground: Ground,
    /// Its reference system.
    pub crs: Crs,
    /// Where the vehicle really is.
    pub motion: Motion,
    /// What its camera really sees.
    pub renderer: Renderer,
    /// What lies in flash.
    pub flash: Flash,
    /// Grid coordinates of the tile's centre: what fixes are relative to.
    pub tile_centre: [f64; 2],
    /// Grid convergence there.
    pub convergence_rad: f64,
}

impl Stage {
    /// Prepares a scenario.
    ///
    /// # Errors
    /// One sentence for files that are missing or broken, a ground without a usable reference system or smaller than
    /// the footprint, a replay that does not cover the flight.
    pub fn prepare(scenario: Scenario) -> Result<Self, InputError> {
        let mut scenario = scenario;
        let camera = camera_of(&mut scenario)?;
        let (ground, reference) = grounds(&scenario)?;
        let crs = Crs::from_epsg(ground.epsg()).map_err(|error| of_ground(&scenario, &error.to_string()))?;
        if crs.is_geographic() {
            let why = format!("it is in degrees (EPSG:{}); a projected grid in metres is needed", ground.epsg());
            return Err(of_ground(&scenario, &why));
        }
        let log = scenario.replay.as_ref().map(|replay| AttitudeLog::load(&replay.att)).transpose().map_err(refuse)?;
        let margin_m = match &log {
            Some(log) => footprint_margin_at_m(&scenario, log.largest_tilt_rad(&scenario).map_err(refuse)?),
            None => footprint_margin_m(&scenario),
        };
        if !margin_m.is_finite() {
            return Err(InputError::new(match &scenario.replay {
                Some(replay) => format!("{}: tilted that far, frames see the horizon", replay.att.display()),
                None => "the horizon comes into the frame: field of view or tilt are too large".to_owned(),
            }));
        }
        let area = area_of(&ground, margin_m, scenario.flight.height_m[1])
            .map_err(|error| of_ground(&scenario, &error.to_string()))?;
        let motion = match log {
            Some(log) => Motion::replay(&scenario, &area, log).map_err(refuse)?,
            None => Motion::synthetic(&scenario, &area).map_err(refuse)?,
        };
        let tile = Tile::lay(&scenario, &area, reference.as_ref().unwrap_or(&ground))?;
        let centre = tile.centre();
        let fit = georeference::fit(&crs, centre, 0.5 * tile.size_m())?;
        let convergence_rad = crs.convergence_rad(centre[0], centre[1])?;
        let mission = Mission {
            version: VERSION,
            frame: (camera.cols as u16, camera.rows as u16),
            fov_rad: (camera.fov_h_deg.to_radians() as f32, camera.fov_v_deg.to_radians() as f32),
            offset_px: (camera.offset_m_px as f32, camera.offset_n_px as f32),
            distortion: camera.distortion.map(|d| [d.k1, d.k2, d.k3, d.p1, d.p2].map(|k| k as f32)),
            follow_up: match scenario.follow_up.mode {
                FollowUpMode::Followed => 0,
                FollowUpMode::Measured => 1,
                FollowUpMode::Fixed => 2,
            },
            lever_arm_m: scenario.mount.lever_arm_m.map(|m| m as f32),
            boresight_rad: scenario.mount.boresight_deg.map(|deg| deg.to_radians() as f32),
            sigmas: sigmas_of(&scenario),
            motions: motions_of(&scenario),
            latencies_us: latencies_of(&scenario),
            readout_us: scenario.rolling_shutter_us() as u32,
            lag: scenario.attitude.lag,
            limits_us: limits_of(&scenario),
            search_px: scenario.search_px,
            tile: (tile.cols as u16, tile.rows as u16),
            resolution_m: scenario.resolution_m as f32,
            epsg: ground.epsg(),
            centre_e7: fit.centre_e7,
            east: fit.east,
            north: fit.north,
            convergence_rad: convergence_rad as f32,
            point_scale: crs.point_scale(centre[0], centre[1])? as f32,
            send_patches: true,
            stamps: stamps::of(&scenario),
        };
        let flash = Flash { mission, tile: tile.pixels };
        flash.encoded()?;
        let renderer = Renderer::new(render_camera(&camera), RENDER_SAMPLES);
        Ok(Stage { scenario, camera, ground, crs, motion, renderer, flash, tile_centre: centre, convergence_rad })
    }

    /// Where the camera's mount is in `state`, and where the follow-up axis has it look: the camera's own station less its
    /// boresight.
    pub fn mount_station(state: &TrueState) -> Station {
        Station {
            east_m: state.east_m,
            north_m: state.north_m,
            up_m: state.up_m,
            heading_rad: state.heading_rad,
            pitch_rad: state.pitch_rad,
            roll_rad: state.roll_rad,
            follow_up_rad: state.follow_up_rad,
            boresight_rad: [0.0; 3],
        }
    }

    /// Where the camera is in `state`, and where it looks.
    pub fn station(&self, state: &TrueState) -> Station {
        let boresight_rad = self.scenario.mount.boresight_deg.map(f64::to_radians);
        Station { boresight_rad, ..Stage::mount_station(state) }
    }

    /// The laser's slant range in `state`: along the follow-up axis, to which it is strapped beside the camera, to where it
    /// really hits the ground.
    pub fn slant_m(&self, state: &TrueState) -> Option<f64> {
        let station = Stage::mount_station(state);
        let origin = [state.east_m, state.north_m, state.up_m];
        let hit = self.ground.intersect(origin, station.axes().down)?;
        Some(hit.iter().zip(origin).map(|(h, o)| (h - o) * (h - o)).sum::<f64>().sqrt())
    }
}

fn refuse(error: scenario::ScenarioError) -> InputError {
    InputError::new(error.to_string())
}

/// The scenario's camera; a camera file's replaces it in the scenario too.
fn camera_of(scenario: &mut Scenario) -> Result<CameraFile, InputError> {
    if let Some(path) = &scenario.camera_file {
        let file = crate::camera::read(path)?;
        scenario.camera = scenario::Camera {
            cols: file.cols as u16,
            rows: file.rows as u16,
            fov_h_deg: file.fov_h_deg,
            fov_v_deg: file.fov_v_deg,
            offset_m_px: file.offset_m_px,
            offset_n_px: file.offset_n_px,
            distortion: file.distortion.map(|d| scenario::Distortion {
                k1: d.k1,
                k2: d.k2,
                k3: d.k3,
                p1: d.p1,
                p2: d.p2,
            }),
        };
        scenario.check(&path.display().to_string()).map_err(refuse)?;
        return Ok(file);
    }
    let camera = &scenario.camera;
    Ok(CameraFile {
        cols: camera.cols.into(),
        rows: camera.rows.into(),
        fov_h_deg: camera.fov_h_deg,
        fov_v_deg: camera.fov_v_deg,
        offset_m_px: camera.offset_m_px,
        offset_n_px: camera.offset_n_px,
        pixel_mm: None,
        distortion: camera.distortion.map(|d| Distortion { k1: d.k1, k2: d.k2, k3: d.k3, p1: d.p1, p2: d.p2 }),
        version: None,
        crc32: None,
        boresight: None,
        heads: None,
        lever_arms: None,
        covariance: None,
    })
}

/// What is flown over, and what the reference is made of where that is another picture.
fn grounds(scenario: &Scenario) -> Result<(Ground, Option<Ground>), InputError> {
    let scenario::Ground::Ortho { ortho, dem, reference } = &scenario.ground else {
        return Ok((procedural(scenario.seed), None));
    };
    let surface = dem.as_ref().map(|path| surface(path)).transpose()?;
    let ground = picture(ortho, surface)?;
    let reference = reference.as_ref().map(|path| picture(path, None)).transpose()?;
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

/// A sentence about the ground, with its file's name.
fn of_ground(scenario: &Scenario, why: &str) -> InputError {
    match &scenario.ground {
        scenario::Ground::Ortho { ortho, .. } => InputError::new(format!("{}: {why}", ortho.display())),
        scenario::Ground::Procedural => InputError::new(why),
    }
}

fn scenario_reference(scenario: &Scenario) -> Option<&Path> {
    match &scenario.ground {
        scenario::Ground::Ortho { reference, .. } => reference.as_deref(),
        scenario::Ground::Procedural => None,
    }
}

fn picture(path: &Path, surface: Option<(Grid, Option<u32>)>) -> Result<Ground, InputError> {
    let raster = Raster::read(path)?;
    let epsg = raster.crs.ok_or_else(|| {
        InputError::new(format!("{}: the orthophoto names no reference system (EPSG)", path.display()))
    })?;
    let surface = match surface {
        Some((_, Some(other))) if other != epsg => {
            return Err(InputError::new(format!(
                "{} is in EPSG:{epsg}, but the elevation model in EPSG:{other}",
                path.display()
            )));
        }
        surface => surface.map(|(grid, _)| grid),
    };
    let grid = grid(&raster, raster.grey(), path)?;
    Ground::new(grid, surface, epsg).map_err(|error| InputError::new(format!("{}: {error}", path.display())))
}

fn surface(path: &Path) -> Result<(Grid, Option<u32>), InputError> {
    let raster = Raster::read(path)?;
    let heights = (0..raster.rows * raster.cols)
        .map(|index| raster.sample(index % raster.cols, index / raster.cols, 0).unwrap_or(f32::NAN))
        .collect();
    Ok((grid(&raster, heights, path)?, raster.crs))
}

fn grid(raster: &Raster, data: Vec<f32>, path: &Path) -> Result<Grid, InputError> {
    let geo = &raster.geo;
    if (geo.step_x - geo.step_y).abs() > 1e-6 * geo.step_x {
        return Err(InputError::new(format!(
            "{}: pixels of {} x {} m are not square",
            path.display(),
            geo.step_x,
            geo.step_y
        )));
    }
    Ok(Grid { cols: raster.cols, rows: raster.rows, west_m: geo.x0, north_m: geo.y0, step_m: geo.step_x, data })
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

/// One sigma of each source, as its data sheet would say: tilt white and drift, heading white and drift, follow-up, range,
/// position white and drift, velocity.
fn sigmas_of(scenario: &Scenario) -> [f32; 9] {
    let attitude = &scenario.attitude;
    let follow_up = if scenario.follow_up.mode == FollowUpMode::Measured { scenario.follow_up.noise_deg } else { 0.0 };
    let radians = |deg: f64| deg.to_radians() as f32;
    // A centimetre is what the message resolves, of range and of velocity.
    let resolved = |sigma: f64| sigma.hypot(0.003) as f32;
    [
        radians(attitude.white_deg),
        radians(attitude.drift_deg),
        radians(attitude.heading_white_deg.unwrap_or(attitude.white_deg)),
        radians(attitude.heading_drift_deg.unwrap_or(attitude.drift_deg)),
        radians(follow_up),
        resolved(scenario.range.sigma_m),
        scenario.position.white_m as f32,
        scenario.position_sigma_m() as f32,
        resolved(scenario.position.velocity_sigma_m_s),
    ]
}

/// What the vehicle may do, as who prepares a flight would know it: tilts as large and as fast as the scenario's, in a
/// replayed log a shake beside them.
fn motions_of(scenario: &Scenario) -> [(u32, [f32; 4]); 2] {
    let interval_us = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let radians = |deg: f64| deg.to_radians() as f32;
    let period_s = (1.0 / scenario.flight.tilt_hz[1]) as f32;
    let tilt = radians(scenario.flight.tilt_max_deg.max(1.0));
    let shake = if scenario.replay.is_some() { radians(1.0) } else { 0.0 };
    let weave_m = (scenario.flight.speed_m_s / WEAVE_RAD_S) as f32;
    let weave = [weave_m, (TAU / WEAVE_RAD_S) as f32, 0.0, 1.0];
    let position = (interval_us(scenario.position.rate_hz), weave);
    [(interval_us(scenario.attitude.rate_hz), [tilt, period_s, shake, 0.7]), position]
}

/// How much older than their stamps the sensors' values are, microseconds: calibrated.
fn latencies_of(scenario: &Scenario) -> [u32; 4] {
    [scenario.attitude.delay_us, scenario.follow_up.delay_us, scenario.range.delay_us, scenario.position.delay_us]
}

/// Attitude gap, range gap, position age, patience, microseconds: a few sample intervals of each stream.
fn limits_of(scenario: &Scenario) -> [u32; 4] {
    let interval = |rate_hz: u32| 1_000_000 / rate_hz.max(1);
    let attitude = (4 * interval(scenario.attitude.rate_hz)).max(100_000);
    let range = (4 * interval(scenario.range.rate_hz)).max(100_000);
    [attitude, range, 1_000_000, 200_000]
}

/// The reference tile and where it lies.
struct Tile {
    west_m: f64,
    north_m: f64,
    cols: usize,
    rows: usize,
    resolution_m: f64,
    pixels: Vec<u8>,
}

impl Tile {
    /// Covers where the vehicle flies, what a patch shows around it, and the search.
    fn lay(scenario: &Scenario, area: &Area, reference: &Ground) -> Result<Self, InputError> {
        let r = scenario.resolution_m;
        let reach_m = area.half_extent_m + r * (0.5 * PATCH_PX + f64::from(scenario.search_px) + TILE_SLACK_PX);
        let bounds = reference.bounds();
        // Whole cells within the reference.
        let west = (area.centre_east_m - reach_m).max(bounds.west_m);
        let east = (area.centre_east_m + reach_m).min(bounds.east_m);
        let north = (area.centre_north_m + reach_m).min(bounds.north_m);
        let south = (area.centre_north_m - reach_m).max(bounds.south_m);
        let (cols, rows) = (((east - west) / r).floor(), ((north - south) / r).floor());
        let needed = PATCH_PX.min(16.0) + 2.0 * f64::from(scenario.search_px);
        if !(cols >= needed && rows >= needed) {
            return Err(InputError::new(format!(
                "the reference has {cols} x {rows} pixels of {r} m over the flight, at least {needed} x {needed} are needed"
            )));
        }
        if cols * rows > plumbline_firmware::window::AREA_MAX as f64 || cols > 65535.0 || rows > 65535.0 {
            return Err(InputError::new(format!(
                "a reference of {cols} x {rows} pixels does not fit the board's flash"
            )));
        }
        let (cols, rows) = (cols as usize, rows as usize);
        let radiometry = &scenario.reference;
        let radiometry = Radiometry {
            gamma: radiometry.gamma,
            gain: radiometry.gain,
            offset: radiometry.offset_dn,
            noise_dn: radiometry.noise_dn,
            changed_fraction: radiometry.changed_fraction,
            seed: scenario.seed,
        };
        let (west_m, north_m) = (west + 0.5 * r, north - 0.5 * r);
        let pixels = reference_tile(reference, west_m, north_m, cols, rows, r, &radiometry);
        Ok(Tile { west_m, north_m, cols, rows, resolution_m: r, pixels })
    }

    fn centre(&self) -> [f64; 2] {
        let half = |count: usize| 0.5 * (count as f64 - 1.0) * self.resolution_m;
        [self.west_m + half(self.cols), self.north_m - half(self.rows)]
    }

    fn size_m(&self) -> f64 {
        self.cols.max(self.rows) as f64 * self.resolution_m
    }
}
