//! One camera file, three cameras: the core's, the oracle's and the renderer's.

pub mod faulty;
pub mod heads;
mod lens;
pub mod oriented;
pub mod render;
pub mod still;
pub mod still_match;
pub mod stitch;
pub mod unknown;

use crate::oracle;
use plumbline_core::camera::{Camera, CameraError, Distortion};
use plumbline_core::units::Radians;
use plumbline_survey::camera_file::{CameraFile, SIDE_MAX_PX};
use plumbline_survey::error::InputError;
use render::RenderCamera;
use std::path::Path;

/// Reads a camera file that the core can work with.
///
/// # Errors
/// One sentence for a file that is missing, broken or not a camera.
pub fn read(path: &Path) -> Result<CameraFile, InputError> {
    let file = CameraFile::read(path)?;
    core_camera(&file).map_err(|error| InputError::new(format!("{}: {error}", path.display())))?;
    Ok(file)
}

/// The core's camera, f32.
///
/// # Errors
/// A camera that single precision cannot hold, such as a field of view a hair below 180 degrees.
pub fn core_camera(file: &CameraFile) -> Result<Camera, InputError> {
    let distortion = file.distortion.map(|d| Distortion {
        k1: d.k1 as f32,
        k2: d.k2 as f32,
        k3: d.k3 as f32,
        p1: d.p1 as f32,
        p2: d.p2 as f32,
    });
    let fov = |degrees: f64| Radians(degrees.to_radians() as f32);
    Camera::new(
        (file.cols as u16, file.rows as u16),
        (fov(file.fov_h_deg), fov(file.fov_v_deg)),
        (file.offset_m_px as f32, file.offset_n_px as f32),
        distortion,
    )
    .map_err(|error| {
        InputError::new(match error {
            CameraError::Size => format!(
                "frames of cols {} and rows {} are not taken, only of 1 to {SIDE_MAX_PX} each",
                file.cols, file.rows
            ),
            CameraError::FieldOfView => {
                "a field of view is not between 0 and 180 degrees in single precision".to_owned()
            }
            CameraError::NotFinite => {
                "an offset or a distortion coefficient is no number in single precision".to_owned()
            }
        })
    })
}

/// The oracle's camera, f64.
pub fn oracle_camera(file: &CameraFile) -> oracle::Camera {
    oracle::Camera {
        cols: file.cols as usize,
        rows: file.rows as usize,
        fov_h_rad: file.fov_h_deg.to_radians(),
        fov_v_rad: file.fov_v_deg.to_radians(),
        offset_m_px: file.offset_m_px,
        offset_n_px: file.offset_n_px,
        distortion: file.distortion.map_or_else(oracle::Distortion::default, |d| oracle::Distortion {
            k1: d.k1,
            k2: d.k2,
            k3: d.k3,
            p1: d.p1,
            p2: d.p2,
        }),
    }
}

/// The renderer's camera, f64.
pub fn render_camera(file: &CameraFile) -> RenderCamera {
    RenderCamera {
        cols: file.cols as usize,
        rows: file.rows as usize,
        fov_h_rad: file.fov_h_deg.to_radians(),
        fov_v_rad: file.fov_v_deg.to_radians(),
        offset_m_px: file.offset_m_px,
        offset_n_px: file.offset_n_px,
        distortion: file.distortion.map(|d| [d.k1, d.k2, d.k3, d.p1, d.p2]),
    }
}
