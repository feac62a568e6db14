//! The whole chain, from a frame's first row to its fix: 512 x 512, 60°, 5 m, a patch of 35 x 35, a search of ±10 pixels.

use super::poses::Pose;
use super::region::{Stand, region};
use super::scenery::Scene;
use core::hint::black_box;
use plumbline_core::camera::Camera;
use plumbline_core::matching::judge::AcceptRule;
use plumbline_core::math::tan;
use plumbline_core::pipeline::{Buffers, FollowUpMode, Outcome, Pipeline, PositionSample, Refusal, Settings, Sigmas};
use plumbline_core::tile::{Geographic, Georeference, Tile};
use plumbline_core::units::{Metres, Micros, Radians};

/// The workload's name.
pub const NAME: &str = "frame";
/// Side of the frame, pixels.
pub const FRAME_PX: u16 = 512;
/// Side of the tile, pixels.
pub const TILE_PX: u16 = 192;
/// Metres a pixel of it.
const RESOLUTION_M: f32 = 5.0;
/// By eq. 4 just above 35 pixels.
const HEIGHT_M: f32 = 152.0;
const FOV_DEG: f32 = 60.0;
/// How far off the predicted position is, pixels of the tile (east, south): not whole, and not where a search begins.
const OFF_PX: (f32, f32) = (4.3, -5.6);
/// When the shutter was open, microseconds, and how far apart samples are.
const MID_EXPOSURE: Micros = Micros(10_000_000);
const ATTITUDE_US: u64 = 5_000;
const RANGE_US: u64 = 20_000;

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

/// Runs the chain once. `frame`: 512 x 512, overwritten; `tile`: 192 x 192 of ground.
///
/// # Errors
/// The [`Refusal`] of a stage: such a frame's figures would be of another path.
pub fn run(
    pose: &Pose,
    stand: &mut impl Stand,
    (frame, tile): (&mut [u8], &[u8]),
    (buffers, frame_memory): (&mut Buffers, &mut [u8]),
) -> Result<Flown, Refusal> {
    let fov = Radians::from_degrees(black_box(FOV_DEG));
    let scene = Scene {
        tile,
        tile_side: TILE_PX as usize,
        resolution_m: RESOLUTION_M,
        frame_side: FRAME_PX as usize,
        half_fov_tangent: tan(0.5 * fov.0),
        height_m: HEIGHT_M,
    };
    scene.render(pose, u32::from(pose.heading_deg), frame);
    let camera = Camera::new((FRAME_PX, FRAME_PX), (fov, fov), (0.0, 0.0), None).map_err(|_| Refusal::NoFootprint)?;
    let reference = Tile::new(tile, (TILE_PX, TILE_PX), Metres(RESOLUTION_M), georeference())
        .map_err(|_| Refusal::OutsideReference)?;
    let mut pipeline =
        Pipeline::new(settings(camera, pose), reference, buffers, frame_memory).map_err(|_| Refusal::NoFootprint)?;
    feed(&mut pipeline, pose);

    region(stand, (NAME, "begin"), pose, || pipeline.begin_frame())?;
    region(stand, (NAME, "rows"), pose, || pipeline.rows(frame))?;
    let situation = region(stand, (NAME, "situate"), pose, || pipeline.situate(MID_EXPOSURE))?;
    let situation = situation.ok_or(Refusal::NoAttitude)?;
    region(stand, (NAME, "rectify"), pose, || pipeline.rectify(&situation))?;
    let outcome = region(stand, (NAME, "register"), pose, || pipeline.register(&situation))?;
    let (col, row) = (outcome.d_col + OFF_PX.0, outcome.d_row + OFF_PX.1);
    Ok(Flown { outcome, error_px: plumbline_core::math::sqrt(col * col + row * row) })
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
            heading_rad: 0.009,
            follow_up_rad: 0.0,
            range_m: 0.3,
        },
        gap_us: 20_000,
        range_gap_us: 100_000,
        position_age_us: 1_000_000,
        patience_us: 100_000,
        search_px: 10,
        accept: AcceptRule::default(),
    }
}

/// Fills the streams: mid-exposure lies behind the newest sample but one, as in flight.
fn feed(pipeline: &mut Pipeline<'_>, pose: &Pose) {
    let attitude = pose.attitude();
    let slant = Metres(HEIGHT_M / attitude.cos_tilt());
    let metres = |px: f32| px * RESOLUTION_M;
    let position = Geographic {
        lat_e7: CENTRE.lat_e7 - (metres(OFF_PX.1) / NORTH_M * 1e5) as i32,
        lon_e7: CENTRE.lon_e7 + (metres(OFF_PX.0) / EAST_M * 1e5) as i32,
    };
    let streams = &mut pipeline.streams;
    // Rings longer than what they hold; a sample that is refused shows as a refused frame.
    for back in (0..48).rev() {
        let at = Micros(MID_EXPOSURE.0 + ATTITUDE_US / 2 - back * ATTITUDE_US);
        let _ = streams.attitude(at, attitude);
        let _ = streams.follow_up(at, pose.follow_up());
    }
    for back in (0..16).rev() {
        let _ = streams.slant(Micros(MID_EXPOSURE.0 + RANGE_US / 2 - back * RANGE_US), slant);
    }
    let _ =
        streams.position(PositionSample { sampled_at: MID_EXPOSURE, position, north_m_per_s: 0.0, east_m_per_s: 0.0 });
}

#[cfg(test)]
mod tests;
