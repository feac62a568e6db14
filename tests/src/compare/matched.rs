//! What a kernel costs the matching: frames of known ground, taken from known places, and the ground's own area averages
//! as the reference.
//!
//! The reference has neither noise nor change, and the frames have no noise, so that the kernel is what is left. Rays and
//! reference are the simulator's; what the exact area average leaves is the matcher's own error and the frame's pixels.

use super::case::{Case, Purpose, RADIUS, Reference};
use super::view::{Ground, Pose, View};
use super::{Failure, Grey};
use plumbline_sim::camera::render::{RenderCamera, Renderer, Station};
use plumbline_sim::oracle::follow_up_exact;
use plumbline_sim::world;
use plumbline_sim::world::reference::{Radiometry, reference_tile};
use plumbline_survey::io::picture::Picture;

/// Rays along a side of a frame's pixel.
const RAYS: usize = 2;
/// Where the frames are taken from, cells east and south of the reference's centre: all parts of a cell, no whole ones.
const PLACES: [(f64, f64); 4] = [(0.3, -0.4), (1.7, 2.2), (-2.6, 0.9), (0.85, -3.15)];

/// A frame a pose and place over `land`, a square picture of which a pixel spans a frame's pixel at nadir.
///
/// # Errors
/// A sentence where the land is no ground, or does not reach as far as a frame sees.
pub fn cases(
    picture: &'static str,
    land: &Picture,
    frame: (u16, u16),
    ground: Ground,
    poses: &[Pose],
) -> Result<Vec<Case>, Failure> {
    let Some(&first) = poses.first() else { return Ok(Vec::new()) };
    let step_m = ground.resolution_m / f64::from(View::new(frame, ground, first)?.ratio());
    let land = surface(land, step_m)?;
    let tile = reference(&land, ground);
    let renderer = Renderer::new(camera(frame, ground), RAYS);
    let views = poses.iter().flat_map(|&pose| PLACES.map(|place| (pose, place)));
    views
        .map(|(pose, truth)| {
            let rendered = renderer.render(&land, &station(pose, truth, ground), 0.0, 0, 0);
            if rendered.outside > 0 {
                return Err(format!("{picture}: a frame sees beyond the land, {pose}"));
            }
            Ok(Case {
                picture,
                frame: Grey { pixels: rendered.pixels, size: frame },
                ground,
                poses: vec![pose],
                limits: None,
                purpose: Purpose::Matched,
                reference: Some(Reference { tile: tile.clone(), truth }),
            })
        })
        .collect()
}

/// The picture as level ground, its middle at the origin.
fn surface(picture: &Picture, step_m: f64) -> Result<world::Ground, Failure> {
    let half = |px: usize| 0.5 * (px as f64 - 1.0) * step_m;
    let grid = world::Grid {
        cols: picture.cols,
        rows: picture.rows,
        data: picture.pixels.iter().map(|&pixel| f32::from(pixel)).collect(),
        west_m: -half(picture.cols),
        north_m: half(picture.rows),
        step_m,
    };
    world::Ground::new(grid, None, 0).map_err(|error| error.to_string())
}

/// The land's area averages over the reference's cells.
fn reference(land: &world::Ground, ground: Ground) -> Picture {
    let (cols, rows) = (usize::from(ground.cells.0 + 2 * RADIUS), usize::from(ground.cells.1 + 2 * RADIUS));
    let corner = |cells: usize| 0.5 * (cells as f64 - 1.0) * ground.resolution_m;
    let as_it_is = Radiometry { gamma: 1.0, gain: 1.0, offset: 0.0, noise_dn: 0.0, changed_fraction: 0.0, seed: 0 };
    let pixels = reference_tile(land, -corner(cols), corner(rows), cols, rows, ground.resolution_m, &as_it_is);
    Picture { cols, rows, pixels }
}

fn camera(frame: (u16, u16), ground: Ground) -> RenderCamera {
    let fov = |px: u16| {
        let tangent = (0.5 * ground.fov_deg.to_radians()).tan() / f64::from(frame.0.max(frame.1));
        2.0 * (f64::from(px) * tangent).atan()
    };
    RenderCamera {
        cols: frame.0.into(),
        rows: frame.1.into(),
        fov_h_rad: fov(frame.0),
        fov_v_rad: fov(frame.1),
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: None,
    }
}

/// Where the camera is: `truth` in cells east and south of the reference's centre.
fn station(pose: Pose, truth: (f64, f64), ground: Ground) -> Station {
    let [heading_rad, pitch_rad, roll_rad] = [pose.heading_deg, pose.pitch_deg, pose.roll_deg].map(f64::to_radians);
    Station {
        east_m: truth.0 * ground.resolution_m,
        north_m: -truth.1 * ground.resolution_m,
        up_m: ground.height_m,
        heading_rad,
        pitch_rad,
        roll_rad,
        follow_up_rad: if pose.is_followed { follow_up_exact(heading_rad, pitch_rad, roll_rad) } else { 0.0 },
        boresight_rad: [0.0; 3],
    }
}
