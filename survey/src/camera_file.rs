//! The camera file: what is known of a camera, as TOML.
//!
//! Six keys make a whole file:
//!
//! ```toml
//! cols = 640
//! rows = 480
//! fov_h_deg = 40.0      # full angle across, over the columns
//! fov_v_deg = 30.0      # full angle along, over the rows
//! offset_m_px = 0.0     # what is added to a frame point, to the right
//! offset_n_px = 0.0     # what is added to a frame point, forward
//! ```
//!
//! Optional are `pixel_mm`, `version`, `crc32` and the tables `distortion`, [`heads`], [`boresight`, `lever_arms` and
//! `covariance`](mounting). Any other key is an error; otherwise a misspelt distortion key would be read as 0.
//!
//! # Lens distortion
//! Brown-Conrady on normalised coordinates as OpenCV has it, from the ideal point to the distorted one. With m to the right
//! and n forward from the frame's centre, in pixels, and V_H, V_V the full fields of view:
//!
//! ```text
//! x = m tan(V_H/2) / (cols/2)          x to the right
//! y = -n tan(V_V/2) / (rows/2)         y DOWN the frame, against n
//! r2 = x^2 + y^2,  g = 1 + k1 r2 + k2 r2^2 + k3 r2^3
//! x' = x g + 2 p1 x y + p2 (r2 + 2 x^2)
//! y' = y g + p1 (r2 + 2 y^2) + 2 p2 x y
//! ```
//!
//! x', y' go back to pixels by the same factors, and the offsets are added after that.
//!
//! # Checksum
//! `crc32` is the CRC-32/ISO-HDLC (that of zip and PNG) of the file's text, byte for byte, without the line that holds the
//! `crc32` key and without that line's end. The line stands before the first table.

mod checksum;
pub mod heads;
pub mod imported;
mod keys;
mod lens;
pub mod mounting;
mod parse;

use serde::{Deserialize, Serialize};
use std::path::Path;

use crate::error::InputError;
use crate::io::input;
use crate::io::output::write_file;

pub use heads::Head;
pub use mounting::{ARM_MAX_M, BORESIGHT_MAX_DEG, Covariance};
pub use parse::{as_radians, no_pixel_mm};

/// A camera file's content, checked. Angles in degrees, as in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFile {
    /// Columns of a frame, or of the virtual image where there are heads, 1 to [`heads::VIRTUAL_SIDE_MAX_PX`]. The core takes
    /// frames of [`SIDE_MAX_PX`] at most; a flight can be planned for a larger one.
    pub cols: u32,
    /// Rows of a frame, likewise.
    pub rows: u32,
    /// Full field of view across (over the columns), degrees, more than 0 and less than 180.
    pub fov_h_deg: f64,
    /// Full field of view along (over the rows), degrees, more than 0 and less than 180.
    pub fov_v_deg: f64,
    /// Added to a frame point to the right, pixels.
    pub offset_m_px: f64,
    /// Added to a frame point forward, pixels.
    pub offset_n_px: f64,
    /// Side of a pixel on the sensor, mm, more than 0.
    pub pixel_mm: Option<f64>,
    /// Lens distortion; absent is none.
    pub distortion: Option<Distortion>,
    /// Version the calibration gave the file; kept, not interpreted.
    pub version: Option<u32>,
    /// Checksum found in the file, which it agreed with. Not used in writing: the writer computes its own.
    pub crc32: Option<u32>,
    /// φ, ω, κ of the vehicle from the camera, degrees.
    pub boresight: Option<[f64; 3]>,
    /// From the antenna to the camera: right, forward, up along the vehicle's axes, metres.
    pub lever_arms: Option<[f64; 3]>,
    /// How well the heads' angles are known.
    pub covariance: Option<Covariance>,
    /// Heads of a combined camera, none for an ordinary one.
    pub heads: Vec<Head>,
}

/// Brown-Conrady coefficients, dimensionless; the formulas are in the [module](self). Absent keys are 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Distortion {
    /// Radial, r^2.
    pub k1: f64,
    /// Radial, r^4.
    pub k2: f64,
    /// Radial, r^6.
    pub k3: f64,
    /// Tangential, mainly along y.
    pub p1: f64,
    /// Tangential, mainly along x.
    pub p2: f64,
}

/// Most columns and most rows of a frame on board, and of a head's.
pub const SIDE_MAX_PX: u32 = 8192;

impl Distortion {
    /// Its table under `title`.
    fn text(&self, title: &str) -> String {
        let Distortion { k1, k2, k3, p1, p2 } = self;
        format!("{title}\nk1 = {k1:?}\nk2 = {k2:?}\nk3 = {k3:?}\np1 = {p1:?}\np2 = {p2:?}\n")
    }
}

/// Writes a camera file, with a fresh checksum.
///
/// # Errors
/// The content is none that would be read again, or the file cannot be written.
pub fn write(path: &Path, camera: &CameraFile) -> Result<(), InputError> {
    write_file(path, camera.checked_toml_string(path)?.as_bytes())
}

/// The first axis, right or forward, along which a principal point `offset` pixels off the middle is not on a frame of so many pixels.
fn off_frame(size: [u32; 2], offset: [f64; 2]) -> Option<usize> {
    let is_on = |k: usize| offset[k].abs() < 0.5 * f64::from(size[k]);
    (0..2).find(|k| !is_on(*k))
}

/// Part of a side that a principal point may be off the middle unasked: lenses are centred within a twentieth, and a frame may be a part of
/// the sensor's.
const FAR_OFF: f64 = 0.25;

impl CameraFile {
    /// A camera of (columns, rows) and full fields of view (across, along) in degrees, and nothing else. Not checked.
    #[must_use]
    pub fn new((cols, rows): (u32, u32), (fov_h_deg, fov_v_deg): (f64, f64)) -> Self {
        CameraFile {
            cols,
            rows,
            fov_h_deg,
            fov_v_deg,
            offset_m_px: 0.0,
            offset_n_px: 0.0,
            pixel_mm: None,
            distortion: None,
            version: None,
            crc32: None,
            boresight: None,
            lever_arms: None,
            covariance: None,
            heads: Vec::new(),
        }
    }

    /// Tangent of a pixel, across and along: kH = tan(V_H/2)/(cols/2) and kV likewise.
    #[must_use]
    pub fn tangent_per_px(&self) -> (f64, f64) {
        let per_px = |fov_deg: f64, count: u32| (0.5 * fov_deg.to_radians()).tan() / (0.5 * f64::from(count));
        (per_px(self.fov_h_deg, self.cols), per_px(self.fov_v_deg, self.rows))
    }

    /// Whether the principal point is farther off the middle than lenses are centred.
    #[must_use]
    pub fn is_off_centre(&self) -> bool {
        let is_far = |offset_px: f64, side: u32| offset_px.abs() > FAR_OFF * f64::from(side);
        is_far(self.offset_m_px, self.cols) || is_far(self.offset_n_px, self.rows)
    }

    /// What else the file may mean: a principal point far off the middle.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let [cols, rows] = [self.cols, self.rows].map(f64::from);
        if !self.is_off_centre() {
            return None;
        }
        Some(format!(
            "offset_m_px = {} and offset_n_px = {} count from the middle of a frame of {cols} x {rows}, which few principal points are so far \
             from; were they OpenCV's cx, cy, write offset_m_px = {} and offset_n_px = {}",
            self.offset_m_px,
            self.offset_n_px,
            self.offset_m_px - 0.5 * (cols - 1.0),
            0.5 * (rows - 1.0) - self.offset_n_px
        ))
    }

    /// Reads and checks a camera file.
    ///
    /// # Errors
    /// The file cannot be read; otherwise as [`Self::from_toml_str`].
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::from_toml_str(&input::text(path)?, &path.display().to_string())
    }

    /// Reads and checks the text of a camera file; `name` is what errors call it.
    ///
    /// # Errors
    /// The text is not TOML; a key is missing, unknown, of the wrong type, not finite or out of its range; the checksum
    /// does not agree.
    pub fn from_toml_str(text: &str, name: &str) -> Result<Self, InputError> {
        parse::camera_file(text, name)
    }

    /// [`Self::to_toml_string`] for a file at `path`, if it would be read again.
    ///
    /// # Errors
    /// As [`Self::from_toml_str`].
    pub fn checked_toml_string(&self, path: &Path) -> Result<String, InputError> {
        let text = self.to_toml_string();
        Self::from_toml_str(&text, &path.display().to_string())?;
        Ok(text)
    }

    /// The file's text, with a fresh checksum in its first line. Reading it gives the same content, to the last bit.
    #[must_use]
    pub fn to_toml_string(&self) -> String {
        let mut text = String::new();
        let mut line = |key: &str, value: String| text.push_str(&format!("{key} = {value}\n"));
        line("cols", self.cols.to_string());
        line("rows", self.rows.to_string());
        // Debug is Rust's shortest form that reads back the same, and always a TOML float.
        line("fov_h_deg", format!("{:?}", self.fov_h_deg));
        line("fov_v_deg", format!("{:?}", self.fov_v_deg));
        line("offset_m_px", format!("{:?}", self.offset_m_px));
        line("offset_n_px", format!("{:?}", self.offset_n_px));
        if let Some(pixel_mm) = self.pixel_mm {
            line("pixel_mm", format!("{pixel_mm:?}"));
        }
        if let Some(version) = self.version {
            line("version", version.to_string());
        }
        if let Some(distortion) = &self.distortion {
            text.push_str(&distortion.text("\n[distortion]"));
        }
        if let Some([phi, omega, kappa]) = self.boresight {
            text.push_str(&format!("\n[boresight]\nphi_deg = {phi:?}\nomega_deg = {omega:?}\nkappa_deg = {kappa:?}\n"));
        }
        if let Some(arm) = self.lever_arms {
            text.push_str(&format!("\n[lever_arms]\nantenna_to_camera_m = {arm:?}\n"));
        }
        if let Some(covariance) = &self.covariance {
            text.push_str(&covariance.text());
        }
        for head in &self.heads {
            text.push_str(&head.text());
        }
        checksum::with_checksum(&text)
    }
}

#[cfg(test)]
mod tests;
