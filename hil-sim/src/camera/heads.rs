//! The heads of a combined camera in f64: where each looks, and where a pixel of the virtual image lies in its frame.
//!
//! Paper 002, section 3.2, read backwards: a ray v = (X, Y, −1) of the virtual camera, X to the right and Y forward in
//! tangents, is seen by head i along u = Rᵢ'(v − dᵢ/H) where it meets a plane H below the virtual projection centre,
//! square to its axis, and along Rᵢ'v where it ends far away. Both are linear in (X, Y, 1), so a head is a homography of the
//! form of paper 003's eq. 3, and the core's rectifier makes the virtual image from a frame as it makes a patch.
//!
//! The paper's axes are right, forward, up (an image point is (x, y, −f)); the core's forward, up, right: the same axes in
//! another order. Heads are counted from 0 here and from 1 in files, options and reports.

use crate::camera::render::{RenderCamera, Station};
use crate::camera::{core_camera, render_camera};
use nalgebra::{Matrix3, Vector3};
use plumbline_core::camera::Camera;
use plumbline_core::homography::Homography;
use plumbline_survey::camera_file::{CameraFile, Head};
use plumbline_survey::error::InputError;

/// R = Rφ Rω Rκ of angles in radians, on (right, forward, up).
#[must_use]
pub fn rotation([phi, omega, kappa]: [f64; 3]) -> Matrix3<f64> {
    let ((sp, cp), (so, co), (sk, ck)) = (phi.sin_cos(), omega.sin_cos(), kappa.sin_cos());
    let by_phi = Matrix3::new(cp, 0.0, -sp, 0.0, 1.0, 0.0, sp, 0.0, cp);
    let by_omega = Matrix3::new(1.0, 0.0, 0.0, 0.0, co, -so, 0.0, so, co);
    let by_kappa = Matrix3::new(ck, -sk, 0.0, sk, ck, 0.0, 0.0, 0.0, 1.0);
    by_phi * by_omega * by_kappa
}

/// A matrix on (right, forward, up) as one on the core's (forward, up, right).
fn on_core_axes(m: &Matrix3<f64>) -> Matrix3<f64> {
    const AXES: [usize; 3] = [1, 2, 0];
    Matrix3::from_fn(|row, col| m[(AXES[row], AXES[col])])
}

/// Heading, pitch and roll that make the rotation of eq. 1 without a follow-up angle, given on the core's axes.
fn attitude_of(a: &Matrix3<f64>) -> [f64; 3] {
    [a[(0, 2)].atan2(a[(0, 0)]), a[(0, 1)].clamp(-1.0, 1.0).asin(), (-a[(2, 1)]).atan2(a[(1, 1)])]
}

/// Rotation of eq. 1 on the core's axes of heading, pitch and roll: RX(γ) RZ(θ) RY'(φ).
fn eq_1([heading, pitch, roll]: [f64; 3]) -> Matrix3<f64> {
    let ((sp, cp), (st, ct), (sg, cg)) = (heading.sin_cos(), pitch.sin_cos(), roll.sin_cos());
    let by_roll = Matrix3::new(1.0, 0.0, 0.0, 0.0, cg, sg, 0.0, -sg, cg);
    let by_pitch = Matrix3::new(ct, st, 0.0, -st, ct, 0.0, 0.0, 0.0, 1.0);
    let by_heading = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    by_roll * by_pitch * by_heading
}

/// The turn (heading, pitch, roll) of what is turned by the angles φ, ω, κ, degrees, against a platform that is itself
/// turned by `boresight_rad` against its mount: one boresight for both, which is all that a configuration has to hold of a
/// head.
#[must_use]
pub fn turned(rotation_deg: [f64; 3], boresight_rad: [f64; 3]) -> [f64; 3] {
    let head_from_platform = rotation(rotation_deg.map(f64::to_radians)).transpose();
    attitude_of(&(on_core_axes(&head_from_platform) * eq_1(boresight_rad)))
}

/// A vector on the platform's axes (right, forward, up) as one on its mount's (forward, right, down), of a platform that is
/// turned by `boresight_rad` against that.
#[must_use]
pub fn from_platform([right, forward, up]: [f64; 3], boresight_rad: [f64; 3]) -> [f64; 3] {
    let [forward, up, right]: [f64; 3] = (eq_1(boresight_rad).transpose() * Vector3::new(forward, up, right)).into();
    [forward, right, -up]
}

/// Where head `head` is and where it looks when the virtual camera is at `station`.
#[must_use]
pub fn station_of(station: &Station, head: &Head) -> Station {
    let axes = station.axes();
    let [right_m, forward_m, up_m] = head.d_m;
    let [east, north, up] =
        std::array::from_fn(|i| right_m * axes.right[i] + forward_m * axes.forward[i] - up_m * axes.down[i]);
    Station {
        east_m: station.east_m + east,
        north_m: station.north_m + north,
        up_m: station.up_m + up,
        boresight_rad: turned(head.rotation_deg, station.boresight_rad),
        ..*station
    }
}

/// A head as the virtual camera sees it.
#[derive(Clone, Debug)]
pub struct View {
    /// The head as the core's camera.
    pub camera: Camera,
    interior: RenderCamera,
    /// Its ray from the virtual one's, on (right, forward, up).
    head_from_virtual: Matrix3<f64>,
    /// Its optical axis on the platform's axes.
    axis: Vector3<f64>,
}

/// The virtual camera and its heads.
#[derive(Clone, Debug)]
pub struct Rig {
    /// Columns and rows of the virtual image.
    pub size: (usize, usize),
    /// Tangent per virtual pixel, across and along.
    pub tangent_per_px: [f64; 2],
    /// The heads.
    pub views: Vec<View>,
}

/// A rectangle of the virtual image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First column and row.
    pub corner: (usize, usize),
    /// Columns and rows.
    pub size: (usize, usize),
}

impl Rig {
    /// The heads of a camera file, which map a plane `height_m` below the virtual projection centre, or what is far away.
    ///
    /// # Errors
    /// One sentence for a file without heads and for a head that single precision cannot hold.
    pub fn new(file: &CameraFile, height_m: Option<f64>) -> Result<Self, InputError> {
        if file.heads.is_empty() {
            return Err(InputError::new("the camera has no heads"));
        }
        let view = |(index, head): (usize, &Head)| {
            let own = head.camera();
            let camera = core_camera(&own).map_err(|error| InputError::new(format!("head {}: {error}", index + 1)))?;
            let platform_from_head = rotation(head.rotation_deg.map(f64::to_radians));
            let shift = Vector3::from(head.d_m) * height_m.map_or(0.0, |height_m| 1.0 / height_m);
            // v − d/H for v = (X, Y, −1).
            let parallax = Matrix3::identity() + shift * Vector3::z().transpose();
            Ok(View {
                camera,
                interior: render_camera(&own),
                head_from_virtual: platform_from_head.transpose() * parallax,
                axis: platform_from_head * Vector3::new(0.0, 0.0, -1.0),
            })
        };
        let views = file.heads.iter().enumerate().map(view).collect::<Result<_, _>>()?;
        let size = (file.cols as usize, file.rows as usize);
        Ok(Rig { size, tangent_per_px: render_camera(file).tangent_per_px(), views })
    }

    /// The virtual ray (right, forward, up) of a pixel, −1 along the last.
    fn ray(&self, col: f64, row: f64) -> Vector3<f64> {
        let (cols, rows) = (self.size.0 as f64, self.size.1 as f64);
        let [across, along] = self.tangent_per_px;
        Vector3::new((col - 0.5 * (cols - 1.0)) * across, (0.5 * (rows - 1.0) - row) * along, -1.0)
    }

    /// Frame (col, row) of the virtual pixel (`col`, `row`) in head `head`; `None` behind it. Exact, but for the lens not
    /// tested for folding back.
    #[must_use]
    pub fn frame_position(&self, head: usize, col: f64, row: f64) -> Option<(f64, f64)> {
        let view = &self.views[head];
        let u = view.head_from_virtual * self.ray(col, row);
        (u.z < 0.0).then(|| view.interior.pixel([-u.x / u.z, -u.y / u.z]))
    }

    /// How far inside head `head`'s frame the virtual pixel lies, in its pixels from the border; negative outside.
    #[must_use]
    pub fn inside_px(&self, head: usize, col: f64, row: f64) -> f64 {
        let camera = &self.views[head].camera;
        let (last_col, last_row) = (f64::from(camera.cols()) - 1.0, f64::from(camera.rows()) - 1.0);
        match self.frame_position(head, col, row) {
            Some((x, y)) => x.min(last_col - x).min(y).min(last_row - y),
            None => f64::NEG_INFINITY,
        }
    }

    /// Cosine of the angle between the ray of a virtual pixel and the axis of head `head`, times a factor that is the same
    /// for all heads.
    #[must_use]
    pub fn nearness(&self, head: usize, col: f64, row: f64) -> f64 {
        self.views[head].axis.dot(&self.ray(col, row))
    }

    /// Pixels of head `head` that a virtual pixel spans where both look along the head's axis: what decides how its frame is
    /// averaged.
    #[must_use]
    pub fn ratio(&self, head: usize) -> f32 {
        let [across, along] = self.tangent_per_px;
        let (k_h, k_v) = self.views[head].camera.tangent_per_px();
        (across / f64::from(k_h)).min(along / f64::from(k_v)) as f32
    }

    /// Eq. 3 for head `head` and a piece of the virtual image, as the rectifier wants it, with the height and the
    /// resolution that go with it.
    ///
    /// The map is brought to the middle of the piece in f64 and only then rounded to f32, so that it is as good at the far
    /// corner of an image of 15,400 columns as in its middle: an f32 holds a pixel number of 4,096 to 2.4e-4, and what is
    /// rounded is the head's.
    #[must_use]
    pub fn homography(&self, head: usize, tile: &Tile) -> (Homography, (f32, f32)) {
        let view = &self.views[head];
        let middle = |corner: usize, size: usize| corner as f64 + 0.5 * (size as f64 - 1.0);
        let origin = self.ray(middle(tile.corner.0, tile.size.0), middle(tile.corner.1, tile.size.1));
        let [across, along] = self.tangent_per_px;
        // The rectifier's ray is (m k, n k, −1) from the tile's middle, with one k for both axes.
        let from_tile = Matrix3::new(1.0, 0.0, -origin.x, 0.0, along / across, -origin.y, 0.0, 0.0, 1.0);
        let a = on_core_axes(&(view.head_from_virtual * from_tile)).map(|entry| entry as f32);
        (Homography::full(&a, &view.camera), (1.0, across as f32))
    }
}
