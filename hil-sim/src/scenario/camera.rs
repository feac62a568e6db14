//! The camera that is simulated: keys of the scenario, or a camera file.

use plumbline_survey::camera_file::{CameraFile, Distortion};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Where the camera is described.
#[derive(Debug, Clone, PartialEq)]
pub enum Camera {
    /// In the scenario's `[camera]`.
    Keys(Frame),
    /// In a camera file.
    File(PathBuf),
}

impl Camera {
    /// The default scene's, of another size in pixels.
    #[must_use]
    pub fn of_size(cols: u16, rows: u16) -> Self {
        Camera::Keys(Frame { cols, rows, ..Frame::default() })
    }
}

impl Default for Camera {
    fn default() -> Self {
        Camera::Keys(Frame::default())
    }
}

/// `[camera]`: the six keys of every camera file, and distortion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Frame {
    /// Frame width, pixels.
    pub cols: u16,
    /// Frame height, pixels.
    pub rows: u16,
    /// Full field of view across, over the columns.
    pub fov_h_deg: f64,
    /// Full field of view along, over the rows.
    pub fov_v_deg: f64,
    /// Principal point right of the frame's centre, pixels.
    pub offset_m_px: f64,
    /// Principal point forward of the frame's centre, pixels.
    pub offset_n_px: f64,
    /// Brown-Conrady, ideal to distorted.
    pub distortion: Option<Distortion>,
}

impl Default for Frame {
    fn default() -> Self {
        Frame {
            cols: 512,
            rows: 512,
            fov_h_deg: 60.0,
            fov_v_deg: 60.0,
            offset_m_px: 0.0,
            offset_n_px: 0.0,
            distortion: None,
        }
    }
}

impl Frame {
    /// As a camera file has it.
    #[must_use]
    pub fn file(&self) -> CameraFile {
        CameraFile {
            offset_m_px: self.offset_m_px,
            offset_n_px: self.offset_n_px,
            distortion: self.distortion,
            ..CameraFile::new((self.cols.into(), self.rows.into()), (self.fov_h_deg, self.fov_v_deg))
        }
    }
}

/// The keys of a scenario that say where its camera is described.
#[derive(Deserialize)]
pub(super) struct Source {
    camera: Option<Frame>,
    camera_file: Option<PathBuf>,
}

impl TryFrom<Source> for Camera {
    type Error = &'static str;

    fn try_from(source: Source) -> Result<Self, Self::Error> {
        match (source.camera, source.camera_file) {
            (Some(_), Some(_)) => Err("both [camera] and camera_file are given, only one can fly"),
            (_, Some(path)) => Ok(Camera::File(path)),
            (frame, None) => Ok(Camera::Keys(frame.unwrap_or_default())),
        }
    }
}
