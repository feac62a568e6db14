//! A plan made ready to fly.

use super::planned::terrain::Terrain;
use super::planned::{Planned, camera, store};
use super::{Setup, TILE_SLACK_PX, grounds_of};
use crate::scenario::footprint::footprint_margin_m;
use crate::scenario::{Camera, Ground as GroundOf, Payload, Scenario};
use crate::vehicle::motion::{Motion, PlannedTrack};
use crate::vehicle::mount::payload_of;
use crate::world::{Bounds, Ground, draped};
use plumbline_core::budget::PATCH_MAX_PX;
use plumbline_survey::crs::{Crs, System};
use plumbline_survey::error::InputError;
use std::path::PathBuf;

/// Standard deviations that the deviations from the track are taken to stay within.
const SIGMAS: f64 = 4.0;
/// Slant ranges end here: what a DISTANCE_SENSOR message can carry, metres.
const RANGE_MAX_M: f64 = 655.0;
/// Least height above the ground that anything is made ready for, metres.
const HEIGHT_MIN_M: f64 = 1.0;

/// What is asked for of a flight along a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanToFly {
    /// The plan.
    pub file: PathBuf,
    /// The elevation model in the place of the plan's own.
    pub dem: Option<PathBuf>,
    /// Whether the scenario's `resolution_m` is what somebody wants; otherwise it is chosen.
    pub has_resolution: bool,
}

/// Setup for a plan.
///
/// # Errors
/// One sentence for a plan, elevation model or orthophoto that cannot be flown over.
pub(super) fn prepare(scenario: Scenario, plan: &PlanToFly) -> Result<Setup, InputError> {
    if scenario.run.replay.is_some() {
        return Err(InputError::new(format!(
            "{}: a plan is flown along its own courses; a recorded attitude cannot be replayed on it",
            plan.file.display()
        )));
    }
    if scenario.world.navigation.is_some() {
        return Err(InputError::new(format!(
            "{}: a plan is flown along its own courses; [navigation] has waypoints of its own",
            plan.file.display()
        )));
    }
    if scenario.vehicle.auto_exposure.is_on {
        return Err(InputError::new(format!(
            "{}: a flight along a plan keeps its exposure: leave auto_exposure.is_on out, or say exposure_us",
            scenario.file
        )));
    }
    if let Some(key) = scenario.of_procedural_ground() {
        return Err(InputError::new(format!(
            "{}: {key} is of the procedural ground of flights without a plan",
            scenario.file
        )));
    }
    let mut planned = Planned::read(&plan.file)?;
    let mut scenario = outfitted(scenario, plan, &mut planned);
    let payload = payload_of(&scenario)?;
    let track = planned.track(scenario.run.plan.deviation_m, scenario.run.seed);
    let flown = bounds_of(&track, scenario.run.plan.deviation_m[0]);
    // So that the flight ends behind the track; nothing is exposed at intervals.
    let between_ms = (track.duration_s() * 1000.0 / f64::from(scenario.run.frames)).ceil();
    scenario.run.frame_interval_ms = (between_ms as u32).clamp(scenario.run.frame_interval_ms, 3_600_000);

    let (terrain, sight_m) = terrain(&mut scenario, &payload, plan, &planned, &flown)?;
    if let Some(other) = &plan.dem {
        planned.notes.extend(terrain.instead_of(&planned, &plan.file, other)?);
    }
    scenario.check()?;
    scenario.check_horizon(&payload)?;
    choose_resolution(&mut scenario, &payload, plan, &mut planned, &flown);
    let highest_m = scenario.run.flight.height_m[1];
    if highest_m > RANGE_MAX_M {
        planned.notes.push(format!(
            "the ground lies up to {highest_m:.0} m below, and range messages end at {RANGE_MAX_M} m: photos beyond are stamped and get no fix"
        ));
    }
    let r = scenario.vehicle.resolution_m;
    let search_px = f64::from(scenario.vehicle.search_px);
    let wanted = flown.grown(r * (0.5 * PATCH_MAX_PX as f64 + search_px + TILE_SLACK_PX));
    let seen = wanted.grown((sight_m - (wanted.east_m - flown.east_m)).max(0.0));
    let (ground, reference) = ground(&scenario, &planned, &terrain, &seen)?;
    let motion = Motion::planned(&scenario, track);
    let crs = Crs::from_epsg(ground.epsg())?;
    let store = store::of_flight(&planned)?;
    let mut setup = Setup::finish(scenario, payload, (ground, reference), crs, motion, &wanted, store)?;
    setup.plan = Some(planned);
    Ok(setup)
}

/// The scenario with what the plan says of camera, speed, photos and navigation. Errors found from here on name the plan's
/// file.
fn outfitted(scenario: Scenario, plan: &PlanToFly, planned: &mut Planned) -> Scenario {
    let file = &planned.file;
    let (camera, factor) = camera::binned(file);
    if factor > 1 {
        planned.notes.push(format!(
            "the camera's {} x {} pixels are binned {factor} x {factor} to {} x {}, which the board's memory takes",
            file.camera.cols, file.camera.rows, camera.cols, camera.rows
        ));
    }
    let mut scenario = Scenario { file: plan.file.display().to_string(), camera: Camera::Keys(camera), ..scenario };
    scenario.vehicle.head = None;
    scenario.vehicle.flight.speed_m_s = file.speed_m_s;
    scenario.vehicle.position.sigma_m.get_or_insert(file.noise.position_m);
    scenario.run.frames = scenario.run.frames.min(planned.photos.len() as u32);
    scenario
}

/// The reference's resolution, unless somebody wants one.
fn choose_resolution(
    scenario: &mut Scenario,
    payload: &Payload,
    plan: &PlanToFly,
    planned: &mut Planned,
    flown: &Bounds,
) {
    if plan.has_resolution {
        return;
    }
    let (height_m, extent_m) = (planned.file.height_m, [flown.east_m - flown.west_m, flown.north_m - flown.south_m]);
    let resolution_m = camera::resolution_m(&payload.camera, height_m, extent_m);
    scenario.vehicle.resolution_m = resolution_m;
    planned.notes.push(format!(
        "the reference's resolution is {resolution_m} m, so that the footprint from {height_m:.0} m fits a patch and the flight the reference"
    ));
}

/// The elevation model as far as frames see, and how far that is; heights above ground go into the scenario.
fn terrain(
    scenario: &mut Scenario,
    payload: &Payload,
    plan: &PlanToFly,
    planned: &Planned,
    flown: &Bounds,
) -> Result<(Terrain, f64), InputError> {
    let heights = || planned.lines.iter().flat_map(|line| &line.heights).map(|point| point[1]);
    let up = |pick: fn(f64, f64) -> f64, start: f64| heights().fold(start, pick);
    let off_m = SIGMAS * scenario.run.plan.deviation_m[1];
    let (lowest_m, highest_m) = (up(f64::min, f64::MAX) - off_m, up(f64::max, f64::MIN) + off_m);
    scenario.run.flight.height_m = [planned.file.height_m + off_m; 2];
    let mut sight_m = footprint_margin_m(scenario, payload);
    loop {
        if !sight_m.is_finite() {
            return Err(InputError::new("the horizon comes into the frame: field of view or tilt are too large"));
        }
        let terrain =
            Terrain::read(&planned.file, &plan.file, plan.dem.as_deref(), &planned.place, &flown.grown(sight_m))?;
        let [low_m, high_m] = terrain.range_m();
        scenario.run.flight.height_m = [(lowest_m - high_m).max(HEIGHT_MIN_M), (highest_m - low_m).max(HEIGHT_MIN_M)];
        // Ground below the base plane is seen farther out, and may be lower still there.
        let farther_m = footprint_margin_m(scenario, payload);
        if farther_m <= sight_m {
            return Ok((terrain, sight_m));
        }
        sight_m = 1.1 * farther_m;
    }
}

/// What is flown over, and the other picture that the reference is made of, if there is one.
fn ground(
    scenario: &Scenario,
    planned: &Planned,
    terrain: &Terrain,
    seen: &Bounds,
) -> Result<(Ground, Option<Ground>), InputError> {
    let grid = planned.place.crs.system();
    let GroundOf::Ortho { ortho, .. } = &scenario.world.ground else {
        // A square, as the texture is.
        let side_m = (seen.east_m - seen.west_m).max(seen.north_m - seen.south_m);
        let square = Bounds { east_m: seen.west_m + side_m, south_m: seen.north_m - side_m, ..*seen };
        let surface = terrain.surface(&planned.place, &square)?;
        let ground = draped(scenario.run.seed, &square, surface, grid.epsg()?);
        return Ok((ground.map_err(|error| InputError::new(error.to_string()))?, None));
    };
    let (picture, reference) = grounds_of(scenario)?;
    let of_ortho = |why: String| InputError::new(format!("{}: {why}", ortho.display()));
    if System::Epsg(picture.epsg()) != grid {
        return Err(of_ortho(format!("it is in EPSG:{}, and the plan is flown in {grid}", picture.epsg())));
    }
    let bounds = picture.bounds();
    let corners = [(seen.west_m, seen.south_m), (seen.east_m, seen.north_m)];
    if !corners.iter().all(|&(east, north)| bounds.contains(east, north)) {
        return Err(of_ortho("it does not cover all that the plan's photos see".to_owned()));
    }
    let surface = terrain.surface(&planned.place, &bounds)?;
    let ground = picture.with_surface(Some(surface)).map_err(|error| of_ortho(error.to_string()))?;
    Ok((ground, reference))
}

/// Where the track goes, with what it deviates.
fn bounds_of(track: &PlannedTrack, deviation_m: f64) -> Bounds {
    let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut bounds = Bounds { west_m: low, east_m: high, south_m: low, north_m: high };
    for half_second in 0..=(2.0 * track.duration_s()) as u64 + 1 {
        let [east, north, _] = track.at(0.5 * half_second as f64).place_m;
        bounds.west_m = bounds.west_m.min(east);
        bounds.east_m = bounds.east_m.max(east);
        bounds.south_m = bounds.south_m.min(north);
        bounds.north_m = bounds.north_m.max(north);
    }
    bounds.grown(SIGMAS * deviation_m)
}
