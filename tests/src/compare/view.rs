//! A camera over level ground at an attitude: for the core, for the oracle, and as one matrix for everybody else.

use super::{Failure, Grey};
use plumbline_core::camera::Camera;
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::tilt::{Attitude, camera_from_local, equivalent_tilt, follow_up_command};
use plumbline_core::units::Radians;
use plumbline_sim::oracle;
use std::fmt;

/// Attitude and follow-up, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Clockwise from north.
    pub heading_deg: f64,
    /// Nose up.
    pub pitch_deg: f64,
    /// Right wing down.
    pub roll_deg: f64,
    /// Whether the camera follows exactly; else it is fixed to the body.
    pub is_followed: bool,
}

/// What a frame is resampled to, and from where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Full field of view over the larger side of the frame, degrees; pixels are square.
    pub fov_deg: f64,
    /// Height above ground, metres.
    pub height_m: f64,
    /// A cell, metres.
    pub resolution_m: f64,
    /// Cells, (cols, rows).
    pub cells: (u16, u16),
}

/// Where both meet.
#[derive(Clone, Debug)]
pub struct View {
    camera: Camera,
    homography: Homography,
    judge: oracle::Camera,
    a: oracle::Matrix3,
    ground: Ground,
}

impl View {
    /// For frames of `size`, (cols, rows).
    ///
    /// # Errors
    /// A sentence where this is no camera, no patch, or where a part of the patch lies behind the camera.
    pub fn new(size: (u16, u16), ground: Ground, pose: Pose) -> Result<Self, Failure> {
        let (cols, rows) = (f64::from(size.0), f64::from(size.1));
        let positive = |value: f64| value.is_finite() && value > 0.0;
        if !positive(ground.height_m) || !positive(ground.resolution_m) || ground.cells.0 == 0 || ground.cells.1 == 0 {
            return Err("height, resolution and cells must be positive".into());
        }
        let tangent_per_px = (0.5 * ground.fov_deg.to_radians()).tan() / (0.5 * cols.max(rows));
        let fov = |px: f64| 2.0 * (0.5 * px * tangent_per_px).atan();
        let (fov_h_rad, fov_v_rad) = (fov(cols), fov(rows));
        let fovs = (Radians(fov_h_rad as f32), Radians(fov_v_rad as f32));
        let camera = Camera::new(size, fovs, (0.0, 0.0), None)
            .map_err(|why| format!("{size:?} pixels and {} degrees are no camera: {why:?}", ground.fov_deg))?;
        let angles = [pose.heading_deg, pose.pitch_deg, pose.roll_deg].map(f64::to_radians);
        let [heading, pitch, roll] = angles.map(|angle| Radians(angle as f32));
        let attitude = Attitude { heading, pitch, roll };
        if !attitude.looks_down() {
            return Err(format!("{pose}: the camera looks at or above the horizon"));
        }
        let beta = if pose.is_followed { oracle::follow_up_exact(angles[0], angles[1], angles[2]) } else { 0.0 };
        let view = View {
            camera,
            // As the application chooses: eq. 7 where the camera follows, eq. 3 otherwise.
            homography: if pose.is_followed {
                Homography::simplified(equivalent_tilt(attitude, follow_up_command(attitude)), &camera)
            } else {
                Homography::full(&camera_from_local(attitude, Radians(0.0)), &camera)
            },
            judge: oracle::Camera {
                cols: size.0.into(),
                rows: size.1.into(),
                fov_h_rad,
                fov_v_rad,
                offset_m_px: 0.0,
                offset_n_px: 0.0,
                distortion: oracle::Distortion::default(),
            },
            a: oracle::matrix_a(angles[0], angles[1], angles[2], beta),
            ground,
        };
        if view.corners().is_none() {
            return Err(format!("{pose}: a corner of the patch lies behind the camera"));
        }
        Ok(view)
    }

    /// What the frame is resampled to.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// Size of the frame, (cols, rows).
    pub fn frame_size(&self) -> (u16, u16) {
        (self.camera.cols(), self.camera.rows())
    }

    /// The core's map.
    pub fn map(&self) -> FrameFromPatch<'_> {
        let scale = (self.ground.height_m as f32, self.ground.resolution_m as f32);
        FrameFromPatch::new(self.homography, &self.camera, scale, self.ground.cells)
    }

    /// Frame pixels a cell spans at nadir.
    pub fn ratio(&self) -> f32 {
        self.camera.ratio(self.ground.height_m as f32, self.ground.resolution_m as f32)
    }

    /// The exact area average of every cell, row by row; `None` where a cell is not wholly in the frame, or `frame` is
    /// not of this camera.
    pub fn exact(&self, frame: &Grey) -> Vec<Option<f64>> {
        let (cols, rows) = (usize::from(self.ground.cells.0), usize::from(self.ground.cells.1));
        let (height_m, resolution_m) = (self.ground.height_m, self.ground.resolution_m);
        let grid = oracle::Grid { cols, rows, resolution_m, height_m };
        let values = frame.pixels.iter().map(|&pixel| f64::from(pixel)).collect();
        let image = oracle::Image::new(self.judge.cols, self.judge.rows, values);
        image.map_or_else(|| vec![None; cols * rows], |image| oracle::exact_area(&image, &self.a, &self.judge, &grid))
    }

    /// The core's map as a matrix, row by row: frame (col, row, 1) = matrix * patch (col, row, 1) up to a factor, pixel
    /// centres at integers on both sides. From the core's positions of the patch's four outer corners, so that it is the
    /// core's homography and not another one.
    pub fn frame_from_patch(&self) -> [f64; 9] {
        // Projective image of the unit square (Heckbert, 1989), then patch to unit square.
        let Some([a, b, c, d]) = self.corners() else { return [f64::NAN; 9] };
        let (dx1, dy1) = (b.0 - c.0, b.1 - c.1);
        let (dx2, dy2) = (d.0 - c.0, d.1 - c.1);
        let (sx, sy) = (a.0 - b.0 + c.0 - d.0, a.1 - b.1 + c.1 - d.1);
        let determinant = dx1 * dy2 - dx2 * dy1;
        let (g, h) = ((sx * dy2 - dx2 * sy) / determinant, (dx1 * sy - sx * dy1) / determinant);
        let (cols, rows) = (f64::from(self.ground.cells.0), f64::from(self.ground.cells.1));
        let row = |u: f64, v: f64, one: f64| [u / cols, v / rows, one + 0.5 * u / cols + 0.5 * v / rows];
        let [x, y, w] = [
            row(b.0 - a.0 + g * b.0, d.0 - a.0 + h * d.0, a.0),
            row(b.1 - a.1 + g * b.1, d.1 - a.1 + h * d.1, a.1),
            row(g, h, 1.0),
        ];
        [x[0], x[1], x[2], y[0], y[1], y[2], w[0], w[1], w[2]]
    }

    /// Frame positions of the patch's outer corners, clockwise from the top left.
    fn corners(&self) -> Option<[(f64, f64); 4]> {
        let map = self.map();
        let (right, bottom) = (f32::from(self.ground.cells.0) - 0.5, f32::from(self.ground.cells.1) - 0.5);
        let at = |col: f32, row: f32| map.frame_position(col, row).map(|(c, r)| (f64::from(c), f64::from(r)));
        Some([at(-0.5, -0.5)?, at(right, -0.5)?, at(right, bottom)?, at(-0.5, bottom)?])
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let camera = if self.is_followed { "followed" } else { "fixed" };
        write!(f, "heading {}, pitch {}, roll {}, {camera}", self.heading_deg, self.pitch_deg, self.roll_deg)
    }
}
