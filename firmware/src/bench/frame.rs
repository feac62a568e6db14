//! The whole chain, from a frame's first row to its fix: 512 x 512, 60°, 5 m, a patch of 35 x 35, a search of ±10 pixels, and
//! behind one in vain one of ±64 that gets a lost position back, or where the ground has changed what frames before have decided.

use super::poses::Pose;
use super::region::{Stand, region};
use super::scenery::Scene;
use core::hint::black_box;
use plumbline_core::camera::Camera;
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::math::tan;
use plumbline_core::mount::Mount;
use plumbline_core::navigation::Navigation;
use plumbline_core::navigation::filter::{Measurement, PriorSigmas};
use plumbline_core::navigation::reckoning::Moment;
use plumbline_core::navigation::surface::Surface;
use plumbline_core::pipeline::{
    Buffers, FollowUpMode, Latencies, Memory, Motions, Outcome, Pipeline, PositionSample, Refusal, Settings, Sigmas,
};
use plumbline_core::tile::{Geographic, Georeference, Local, Tile};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Metres, Micros, Radians};

/// Where a frame is searched.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The workload's name.
    pub name: &'static str,
    /// Side of the tile, pixels.
    pub tile_px: u16,
    /// How far off the predicted position is, pixels of the tile (east, south).
    pub off_px: (f32, f32),
    /// How far off the navigation says that it may be, one sigma of each axis, pixels: from half of the search's radius on the
    /// position counts as lost, and is searched far where the usual search finds nothing.
    pub doubt_px: f32,
    /// The ground is in another state than the map has it, and frames before have decided where the vehicle is.
    pub is_changed: bool,
    /// The frame before was matched elsewhere: its attitude is in doubt, and checked against the picture's perspective.
    pub is_doubted: bool,
    /// Whether every stage is measured, or the matching alone, as the rest is the same for both.
    pub has_stages: bool,
}

/// A frame as most are. The prediction is off by what is not whole, and not where a search begins.
pub const FRAME: Case = Case {
    name: "frame",
    tile_px: 192,
    off_px: (4.3, -5.6),
    doubt_px: 0.0,
    is_changed: false,
    is_doubted: false,
    has_stages: true,
};
/// One over a map of another year: the greys do not match, and the directions have to.
pub const ANOTHER_YEAR: Case = Case { name: "frame, another year", is_changed: true, has_stages: false, ..FRAME };
/// One whose match is far off where the one before was.
pub const DOUBTED: Case = Case { name: "frame, attitude in doubt", is_doubted: true, has_stages: false, ..FRAME };
/// A frame whose prediction has drifted. The tile holds the whole search around it.
pub const REACQUISITION: Case =
    Case { name: "re-acquisition", tile_px: 272, off_px: (50.0, -41.0), doubt_px: 32.0, has_stages: false, ..FRAME };
/// All of them.
pub const CASES: [Case; 4] = [FRAME, ANOTHER_YEAR, DOUBTED, REACQUISITION];
/// Side of a patch, pixels, and how long ago the frame before was, microseconds: frames further apart do not agree one after the other.
const PATCH_PX: f32 = 35.0;
const BEFORE_US: u64 = 2_000_000;
/// Radius of the usual search, pixels.
const SEARCH_PX: u16 = 10;
/// Side of the frame, pixels.
pub const FRAME_PX: u16 = 512;
/// Metres a pixel of it.
const RESOLUTION_M: f32 = 5.0;
/// By eq. 4 just above 35 pixels.
const HEIGHT_M: f32 = 152.0;
const FOV_DEG: f32 = 60.0;
/// When the shutter was open, microseconds, and how far apart samples are.
const MID_EXPOSURE: Micros = Micros(10_000_000);
const ATTITUDE_US: u64 = 5_000;
const RANGE_US: u64 = 20_000;
/// Attitudes that have come since the one after mid-exposure: as many as the pose lags.
const LATER: u64 = 2;

/// Metres of 1e-2 degrees, the polynomial's unit, of latitude and at 48° of longitude.
const NORTH_M: f32 = 1111.9;
const EAST_M: f32 = 744.0;
const CENTRE: Geographic = Geographic { lat_e7: 480_000_000, lon_e7: 160_000_000 };

/// How a frame ended, and what it should have found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flown {
    /// What the pipeline says.
    pub outcome: Outcome,
    /// Distance of its match from the truth, pixels of the tile.
    pub error_px: f32,
}

impl Flown {
    /// Whether it was found where it is. What a far search finds another frame has to confirm, and what contradicts the one
    /// before is no fix.
    pub fn is_found(&self) -> bool {
        matches!(self.outcome.fix, Ok(_) | Err(Refusal::Unconfirmed | Refusal::Contradicted)) && self.error_px < 0.5
    }
}

/// Runs the chain once. `frame`: 512 x 512, overwritten; `tile`: the case's ground.
///
/// # Errors
/// The [`Refusal`] of a stage: such a frame's figures would be of another path.
pub fn run(
    case: &Case,
    pose: &Pose,
    stand: &mut impl Stand,
    (frame, tile): (&mut [u8], &[u8]),
    (buffers, frame_memory): (&mut Buffers, &mut [u8]),
) -> Result<Flown, Refusal> {
    let fov = Radians::from_degrees(black_box(FOV_DEG));
    let scene = Scene {
        tile,
        tile_side: case.tile_px as usize,
        resolution_m: RESOLUTION_M,
        frame_side: FRAME_PX as usize,
        half_fov_tangent: tan(0.5 * fov.0),
        height_m: HEIGHT_M,
    };
    scene.render(pose, u32::from(pose.heading_deg), frame);
    if case.is_changed {
        frame.iter_mut().for_each(|grey| *grey = changed(*grey));
    }
    let camera = Camera::new((FRAME_PX, FRAME_PX), (fov, fov), (0.0, 0.0), None).map_err(|_| Refusal::NoFootprint)?;
    let reference = Tile::new(tile, (case.tile_px, case.tile_px), Metres(RESOLUTION_M), georeference())
        .map_err(|_| Refusal::OutsideReference)?;
    let mut navigation = Navigation::new();
    if case.is_changed {
        decide(&mut navigation.surface);
    }
    if case.is_doubted {
        contradict(&mut navigation);
    }
    let memory = Memory { buffers, navigation: &mut navigation, frame: frame_memory };
    let mut pipeline = Pipeline::new(settings(camera, pose), reference, memory).map_err(|_| Refusal::NoFootprint)?;
    pipeline.added_sigmas.position_m = case.doubt_px * RESOLUTION_M;
    feed(&mut pipeline, pose, case.off_px);

    let (name, wait) = (case.name, pipeline.settings().wait());
    let situation = if case.has_stages {
        region(stand, (name, "begin"), pose, || pipeline.begin_frame())?;
        region(stand, (name, "rows"), pose, || pipeline.rows(frame))?;
        let situation = region(stand, (name, "situate"), pose, || pipeline.situate((MID_EXPOSURE, 1.0), wait))?;
        let situation = situation.ok_or(Refusal::NoAttitude)?;
        region(stand, (name, "rectify"), pose, || pipeline.rectify(&situation))?;
        situation
    } else {
        pipeline.begin_frame()?;
        pipeline.rows(frame)?;
        let situation = pipeline.situate((MID_EXPOSURE, 1.0), wait)?.ok_or(Refusal::NoAttitude)?;
        pipeline.rectify(&situation)?;
        situation
    };
    let outcome = region(stand, (name, "register"), pose, || pipeline.register(&situation))?;
    let (col, row) = (outcome.d_col + case.off_px.0, outcome.d_row + case.off_px.1);
    Ok(Flown { outcome, error_px: plumbline_core::math::sqrt(col * col + row * row) })
}

/// The ground in another state: what was dark is bright, and what was brightest is bright again.
fn changed(grey: u8) -> u8 {
    const BACK: u8 = 180;
    if grey <= BACK { 220 - grey } else { 40 + 2 * (grey - BACK) }
}

/// Frames whose own peaks agreed with the decision. Chosen: more than it takes.
const FRAMES_BEFORE: usize = 8;

/// Frames with valid least squares after which the map is of its own year. Chosen: more than it takes.
const SAME_YEAR_BEFORE: usize = 200;

/// Least squares have held twice where the vehicle is, a footprint before it, and the frames before were there by themselves.
fn decide(surface: &mut Surface) {
    let (truth, side_m) = (Local { east_m: 0.0, north_m: 0.0 }, PATCH_PX * RESOLUTION_M);
    let speed_m_per_s = side_m / (BEFORE_US as f32 * 1e-6);
    // The next frame has a velocity of 0.
    let velocity_m_per_s = [2.0 * speed_m_per_s, 0.0];
    let before = truth.moved([-side_m, 0.0]);
    surface.propagate(Moment { at: Micros(MID_EXPOSURE.0 - BEFORE_US), velocity_m_per_s }, [0.0; 2], 0.0);
    surface.recentre(before, (before, 0.0), side_m, RESOLUTION_M);
    surface.add_least_squares(before, RESOLUTION_M);
    surface.add_least_squares(before, RESOLUTION_M);
    (0..FRAMES_BEFORE).for_each(|_| surface.agreement.frame(Some((0.0, 0.0)), 1.0));
}

/// Frames of the map's own year, and a match of a moment ago that is off by as much as an attitude of fourteen degrees.
fn contradict(navigation: &mut Navigation) {
    let Navigation { filter, surface, .. } = navigation;
    (0..SAME_YEAR_BEFORE).for_each(|_| surface.map_year.count(true));
    let prior = PriorSigmas { velocity_m_per_s: 0.1, tilt_rad: 0.002, extra_wander_rad: 0.0 };
    let before = |us: u64| Micros(MID_EXPOSURE.0 - us);
    filter.reported(Moment { at: before(400_000), velocity_m_per_s: [0.0; 2] }, &prior);
    filter.propagate(before(250_000), &prior);
    let measurement = Measurement {
        nadir: Local { east_m: 0.25 * HEIGHT_M, north_m: 0.0 },
        covariance: Default::default(),
        map_variance_m2: 0.0,
        inflation_m2: 0.0,
        transient_rad: 0.0,
        corrected_tilt_rad: [0.0; 2],
        height_m: HEIGHT_M,
        heading_rad: 0.0,
    };
    filter.matched(&measurement, None, &prior);
}

fn georeference() -> Georeference {
    Georeference {
        epsg: 0,
        centre: CENTRE,
        east: [EAST_M, 0.0, 0.0, 0.0, 0.0],
        north: [0.0, NORTH_M, 0.0, 0.0, 0.0],
        convergence: Radians(0.0),
        point_scale: 1.0,
    }
}

/// A fixed camera is one whose follow-up angle is measured as 0: the dearest way to know it.
fn settings(camera: Camera, pose: &Pose) -> Settings {
    Settings {
        camera,
        follow_up: if pose.is_followed { FollowUpMode::Followed } else { FollowUpMode::Measured },
        sigmas: Sigmas {
            tilt_white_rad: 0.002,
            tilt_drift_rad: 0.002,
            heading_white_rad: 0.002,
            heading_drift_rad: 0.009,
            follow_up_rad: 0.001,
            range_m: 0.3,
            // Half of what is searched.
            position_drift_m: 0.5 * RESOLUTION_M * f32::from(SEARCH_PX),
            velocity_m_per_s: 0.1,
            ..Sigmas::default()
        },
        mount: Mount::default(),
        motions: Motions::default(),
        latencies: Latencies::default(),
        readout_us: 0,
        lag: 2,
        gap_us: 20_000,
        range_gap_us: 100_000,
        position_age_us: 1_000_000,
        patience_us: 100_000,
        search_px: SEARCH_PX,
        accept: AcceptRule::default(),
    }
}

/// Fills the streams: mid-exposure lies so far behind the newest sample as the pose waits for, as in flight.
fn feed(pipeline: &mut Pipeline<'_>, pose: &Pose, off_px: (f32, f32)) {
    let attitude = pose.attitude();
    let slant = Metres(HEIGHT_M / attitude.cos_tilt());
    let metres = |px: f32| px * RESOLUTION_M;
    let position = Geographic {
        lat_e7: CENTRE.lat_e7 - (metres(off_px.1) / NORTH_M * 1e5) as i32,
        lon_e7: CENTRE.lon_e7 + (metres(off_px.0) / EAST_M * 1e5) as i32,
    };
    let streams = &mut pipeline.streams;
    // Rings longer than what they hold; a sample that is refused shows as a refused frame. They are not all the
    // same: a sensor that says so hangs.
    for back in (0..48).rev() {
        let at = Micros(MID_EXPOSURE.0 + LATER * ATTITUDE_US + ATTITUDE_US / 2 - back * ATTITUDE_US);
        let noise = |k: u64| ((back * k) % 7) as f32 * 1e-6 - 3e-6;
        let noisy = Attitude {
            heading: Radians(attitude.heading.0 + noise(5)),
            pitch: Radians(attitude.pitch.0 + noise(3)),
            roll: Radians(attitude.roll.0 + noise(2)),
        };
        let _ = streams.attitude(at, noisy);
        let _ = streams.follow_up(at, Radians(pose.follow_up().0 + noise(3)));
    }
    for back in (0..16).rev() {
        let _ = streams.slant(Micros(MID_EXPOSURE.0 + RANGE_US / 2 - back * RANGE_US), slant);
    }
    let sample = PositionSample::standing(position);
    let _ = pipeline.position(MID_EXPOSURE, sample);
}

#[cfg(test)]
mod tests;
