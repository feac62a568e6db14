//! Eq. 2, 3 and 6 of paper 003 by the bare ray, with the lens distortion that the paper leaves out.

use super::rotation::{Matrix3, apply, transpose};

/// Newton steps after which an inversion of the distortion counts as failed; a mild lens needs 3 to 5.
const DISTORTION_STEPS: usize = 50;
/// Largest last step of that inversion, in tangents: 1e-11 px for a focal length of 1000 px.
const DISTORTION_STEP: f64 = 1e-14;

/// Brown-Conrady coefficients in OpenCV's convention: from ideal to distorted, on x = right, y = DOWN the image, both
/// tangents. All zero = no distortion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// Radial, of r^2.
    pub k1: f64,
    /// Radial, of r^4.
    pub k2: f64,
    /// Radial, of r^6.
    pub k3: f64,
    /// Tangential, mostly along y.
    pub p1: f64,
    /// Tangential, mostly along x.
    pub p2: f64,
}

/// What eq. 2 needs of a camera. The fields of view are FULL angles of the frame: the paper says "instantaneous", but
/// its equations hold for the full angle only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Columns of the frame.
    pub cols: usize,
    /// Rows of the frame.
    pub rows: usize,
    /// Full field of view across, over the columns, in radians.
    pub fov_h_rad: f64,
    /// Full field of view along, over the rows, in radians.
    pub fov_v_rad: f64,
    /// The paper's m0, added after the distortion, in pixels to the right.
    pub offset_m_px: f64,
    /// The paper's n0, added after the distortion, in pixels forward.
    pub offset_n_px: f64,
    /// Lens distortion.
    pub distortion: Distortion,
}

impl Camera {
    /// Tangents per pixel (kH, kV): across and along. 1/k is the focal length in pixels.
    pub fn tangent_per_px(&self) -> (f64, f64) {
        let half_cols = self.cols as f64 / 2.0;
        let half_rows = self.rows as f64 / 2.0;
        ((self.fov_h_rad / 2.0).tan() / half_cols, (self.fov_v_rad / 2.0).tan() / half_rows)
    }
}

/// A point that was projected, in pixels from the centre of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// To the right.
    pub m: f64,
    /// Forward.
    pub n: f64,
    /// Whether the ray meets the target plane ahead of the lens. If not, `m` and `n` belong to the ray's other end,
    /// or are not finite.
    pub in_front: bool,
}

/// Eq. 3: undistorted pixel (m, n) of the level, north-up image -> frame pixel (m', n').
///
/// Not by the paper's algebra but by its proof: the ray (n kV, -1, m kH) in (north, up, east), turned by A, is cut
/// with the image plane one unit below the lens.
pub fn frame_from_ground(a: &Matrix3, camera: &Camera, m: f64, n: f64) -> Projection {
    let (k_h, k_v) = camera.tangent_per_px();
    let [forward, up, right] = apply(a, [n * k_v, -1.0, m * k_h]);
    frame_from_tangents(camera, right / -up, forward / -up, up < 0.0)
}

/// Eq. 6: frame pixel (m', n') -> undistorted pixel (m, n), the inverse of [`frame_from_ground`].
///
/// A is orthogonal, so the way back is its transpose. `None` where the distortion cannot be undone (outside the range
/// in which the lens polynomial is one to one).
pub fn ground_from_frame(a: &Matrix3, camera: &Camera, m_frame: f64, n_frame: f64) -> Option<Projection> {
    let (k_h, k_v) = camera.tangent_per_px();
    let x = (m_frame - camera.offset_m_px) * k_h;
    let y = -(n_frame - camera.offset_n_px) * k_v;
    let (x, y) = camera.distortion.undo(x, y)?;
    let [north, up, east] = apply(&transpose(a), [-y, -1.0, x]);
    Some(Projection { m: east / -up / k_h, n: north / -up / k_v, in_front: up < 0.0 })
}

/// Frame pixel counted from the centre (m', n') -> (column, row), integers at pixel centres, row 0 forward.
pub fn pixel_from_frame(camera: &Camera, m_frame: f64, n_frame: f64) -> (f64, f64) {
    (m_frame + (camera.cols as f64 - 1.0) / 2.0, (camera.rows as f64 - 1.0) / 2.0 - n_frame)
}

/// The lens and the offsets: ideal tangents (right, forward) -> frame pixel.
pub(super) fn frame_from_tangents(camera: &Camera, right: f64, forward: f64, in_front: bool) -> Projection {
    let (k_h, k_v) = camera.tangent_per_px();
    let (x, y) = camera.distortion.apply(right, -forward);
    Projection { m: x / k_h + camera.offset_m_px, n: -y / k_v + camera.offset_n_px, in_front }
}

impl Distortion {
    /// Ideal -> distorted. Exactly the identity when all coefficients are zero.
    pub(super) fn apply(&self, x: f64, y: f64) -> (f64, f64) {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let x_d = x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x);
        let y_d = y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y;
        (x_d, y_d)
    }

    /// Distorted -> ideal by Newton's method, started at the distorted point.
    fn undo(&self, x_d: f64, y_d: f64) -> Option<(f64, f64)> {
        if *self == Self::default() {
            return Some((x_d, y_d));
        }
        let (mut x, mut y) = (x_d, y_d);
        for _ in 0..DISTORTION_STEPS {
            let (x_now, y_now) = self.apply(x, y);
            let [[j11, j12], [j21, j22]] = self.jacobian(x, y);
            let determinant = j11 * j22 - j12 * j21;
            if determinant <= 0.0 {
                return None;
            }
            let (dx, dy) = (x_d - x_now, y_d - y_now);
            let step_x = (j22 * dx - j12 * dy) / determinant;
            let step_y = (j11 * dy - j21 * dx) / determinant;
            x += step_x;
            y += step_y;
            if step_x.abs().max(step_y.abs()) < DISTORTION_STEP {
                return Some((x, y));
            }
        }
        None
    }

    /// Derivatives of [`Distortion::apply`] by x (first column) and y (second).
    fn jacobian(&self, x: f64, y: f64) -> [[f64; 2]; 2] {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let radial_by_r2 = self.k1 + r2 * (2.0 * self.k2 + 3.0 * r2 * self.k3);
        let mixed = 2.0 * x * y * radial_by_r2 + 2.0 * self.p1 * x + 2.0 * self.p2 * y;
        [
            [radial + 2.0 * x * x * radial_by_r2 + 2.0 * self.p1 * y + 6.0 * self.p2 * x, mixed],
            [mixed, radial + 2.0 * y * y * radial_by_r2 + 6.0 * self.p1 * y + 2.0 * self.p2 * x],
        ]
    }
}
