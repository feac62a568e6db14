//! Frames rectified onto the ground plane, north-up, centred on the nadir.

use super::frames::{COLS, Exposure, ROWS};
use plumbline_core::camera::Camera;
use plumbline_core::homography::Homography;
use plumbline_core::tilt::camera_from_local;
use plumbline_core::units::Radians;
use plumbline_sim::camera::still::{Patch, Target, rectify};
use plumbline_survey::io::picture::Picture;

/// Half the picture's width over the focal length. By the EXIF's 20 mm equivalent, which relates to the diagonal of the
/// sensor's 4000 x 3000 pixels as 20 mm to that of 36 x 24 mm: 2311 pixels of 4000 columns, 94.5° over that diagonal
/// (the maker says 94°). The rows are those of a 16:9 cut. A focal length rounded to 20 mm is known to 2.5 %.
fn half_width_tangent() -> f64 {
    let focal_px = 20.0 * 4000f64.hypot(3000.0) / 36f64.hypot(24.0);
    2000.0 / focal_px
}

/// The camera at the common picture size, without distortion: the maker states none.
pub fn camera() -> Camera {
    let across = half_width_tangent();
    let along = across * ROWS as f64 / COLS as f64;
    let fov = |tangent: f64| Radians(2.0 * tangent.atan() as f32);
    Camera::new((COLS as u16, ROWS as u16), (fov(across), fov(along)), (0.0, 0.0), None).expect("a camera")
}

/// A rectified frame with its valid pixels.
#[derive(Debug)]
pub struct Ground {
    /// Greys.
    pub patch: Patch,
    /// 255 where valid.
    pub mask: Picture,
    /// A pixel, metres.
    pub resolution_m: f64,
}

impl Ground {
    /// Rectifies `frame` by the core. The patch is a square of an odd number of pixels that holds the whole footprint,
    /// its middle pixel on the nadir.
    pub fn new(frame: &Picture, exposure: &Exposure, stored_turn_deg: f64, resolution_m: f64) -> Self {
        let camera = camera();
        let attitude = exposure.attitude(stored_turn_deg);
        // The gimbal's attitude is the camera's own: eq. 3 with β = 0.
        let homography = Homography::full(&camera_from_local(attitude, Radians(0.0)), &camera);
        let diagonal_m = exposure.rel_alt_m * half_width_tangent() * 2.0 * 1f64.hypot(9.0 / 16.0);
        let side = 2 * (0.5 * diagonal_m / resolution_m).ceil() as usize + 3;
        let target = Target { height_m: exposure.rel_alt_m, resolution_m, size: Some((side, side)) };
        let patch = rectify(&camera, frame, homography, &target).unwrap_or_else(|error| panic!("{error}"));
        let mask = patch.mask();
        Ground { patch, mask, resolution_m }
    }

    /// Grey at (`col`, `row`) from the nadir, 0 where there is none.
    pub fn grey(&self, col: i32, row: i32) -> u8 {
        at(&self.patch.picture, col, row)
    }

    /// Whether the pixel at (`col`, `row`) from the nadir is valid.
    pub fn is_valid(&self, col: i32, row: i32) -> bool {
        at(&self.mask, col, row) != 0
    }
}

/// Pixel at (`col`, `row`) from the middle one, 0 outside.
fn at(picture: &Picture, col: i32, row: i32) -> u8 {
    let (col, row) = (col + (picture.cols / 2) as i32, row + (picture.rows / 2) as i32);
    let inside = (0..picture.cols as i32).contains(&col) && (0..picture.rows as i32).contains(&row);
    if inside { picture.pixels[row as usize * picture.cols + col as usize] } else { 0 }
}
