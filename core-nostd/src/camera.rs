//! The camera: what its file says, checked once.
//!
//! A frame camera of `cols` x `rows` pixels with full fields of view `fov_h` (across, columns) and `fov_v` (along,
//! rows), the principal point off the centre by (`m0`, `n0`), and optional Brown-Conrady distortion. The paper's
//! "instantaneous field of view" is the full field: with the per-pixel one its eq. 2 to 4 are wrong by a factor M.

use crate::math;
use crate::units::Radians;

/// Why a camera was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CameraError {
    /// No columns or rows, or more than 8192.
    Size,
    /// A field of view not between 0 and 180 degrees, or not a number.
    FieldOfView,
    /// An offset or a distortion coefficient that is not a finite number.
    NotFinite,
}

/// Brown-Conrady coefficients in OpenCV's convention: normalised coordinates with x to the right and y *downwards*
/// (backwards on the ground), ideal to distorted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Distortion {
    /// Radial, r².
    pub k1: f32,
    /// Radial, r⁴.
    pub k2: f32,
    /// Radial, r⁶.
    pub k3: f32,
    /// Tangential, first.
    pub p1: f32,
    /// Tangential, second.
    pub p2: f32,
}

/// A checked camera. Build it with [`Camera::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Camera {
    cols: u16,
    rows: u16,
    /// Tangent per pixel across: kH = tan(V_H/2)/(cols/2), the inverse of the focal length in pixels.
    k_h: f32,
    /// Tangent per pixel along: kV = tan(V_V/2)/(rows/2).
    k_v: f32,
    offset_m_px: f32,
    offset_n_px: f32,
    distortion: Option<Distortion>,
    /// Square of the radius, in tangents, at which the radial distortion folds back; infinite where it never does.
    fold_r2: f32,
}

/// Share by which the sides of square pixels may differ: fields of view in hundredths of a degree are off by up to 2e-4, and a
/// sensor whose pixels are not square by more than this.
pub const SQUARE_MAX: f32 = 1e-3;
/// Largest square of a tangent that is searched for a fold: 80 degrees off the axis.
const FOLD_R2_MAX: f32 = 32.0;
/// Step of that search: 0.2 % of the radius at 45 degrees off the axis. Chosen.
const FOLD_STEP: f32 = 1.0 / 256.0;

impl Distortion {
    /// Where the slope of the distorted radius, 1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶, first reaches zero.
    fn fold_r2(&self) -> f32 {
        let mut r2 = 0.0;
        while r2 < FOLD_R2_MAX {
            if 1.0 + r2 * (3.0 * self.k1 + r2 * (5.0 * self.k2 + r2 * 7.0 * self.k3)) <= 0.0 {
                return r2 - FOLD_STEP;
            }
            r2 += FOLD_STEP;
        }
        f32::INFINITY
    }
}

impl Camera {
    /// Checks and prepares a camera. `offset_m_px`, `offset_n_px`: principal point relative to the frame's centre,
    /// right and forward positive, added after the distortion.
    ///
    /// # Errors
    /// [`CameraError`] names the first thing that cannot be a camera.
    pub fn new(
        (cols, rows): (u16, u16),
        (fov_h, fov_v): (Radians, Radians),
        (offset_m_px, offset_n_px): (f32, f32),
        distortion: Option<Distortion>,
    ) -> Result<Self, CameraError> {
        if cols == 0 || rows == 0 || cols > 8192 || rows > 8192 {
            return Err(CameraError::Size);
        }
        let possible = |fov: Radians| fov.0 > 0.0 && fov.0 < core::f32::consts::PI;
        if !possible(fov_h) || !possible(fov_v) {
            return Err(CameraError::FieldOfView);
        }
        let d = distortion.unwrap_or(Distortion { k1: 0.0, k2: 0.0, k3: 0.0, p1: 0.0, p2: 0.0 });
        if ![offset_m_px, offset_n_px, d.k1, d.k2, d.k3, d.p1, d.p2].iter().all(|v| v.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        let k_h = math::tan(0.5 * fov_h.0) / (0.5 * cols as f32);
        let k_v = math::tan(0.5 * fov_v.0) / (0.5 * rows as f32);
        let distortion = distortion.filter(|d| [d.k1, d.k2, d.k3, d.p1, d.p2].iter().any(|&v| v != 0.0));
        let fold_r2 = distortion.map_or(f32::INFINITY, |d| d.fold_r2());
        Ok(Camera { cols, rows, k_h, k_v, offset_m_px, offset_n_px, distortion, fold_r2 })
    }

    /// Frame width, pixels.
    pub fn cols(&self) -> u16 {
        self.cols
    }

    /// Frame height, pixels.
    pub fn rows(&self) -> u16 {
        self.rows
    }

    /// Principal point off the frame's centre, pixels (right, forward).
    pub fn offset_px(&self) -> (f32, f32) {
        (self.offset_m_px, self.offset_n_px)
    }

    /// Tangent per pixel (across, along).
    pub fn tangent_per_px(&self) -> (f32, f32) {
        (self.k_h, self.k_v)
    }

    /// Whether both fields of view are the same per pixel to rounding, 1e-6, which eq. 7 demands.
    pub fn is_isotropic(&self) -> bool {
        (self.k_h - self.k_v).abs() <= 1e-6 * self.k_h
    }

    /// Whether pixels are square as far as a data sheet says, to [`SQUARE_MAX`].
    pub fn has_square_pixels(&self) -> bool {
        (self.k_h - self.k_v).abs() <= SQUARE_MAX * self.k_h
    }

    /// Frame position of an ideal image point: the point (`m`, `n`) as a lens without distortion would show it,
    /// centred pixels, gets distortion and then the offset. Eq. 3's `+ m0`, `+ n0`.
    pub fn distorted(&self, m: f32, n: f32) -> (f32, f32) {
        let (m, n) = match &self.distortion {
            None => (m, n),
            Some(d) => {
                let (x, y) = (m * self.k_h, -n * self.k_v);
                let r2 = x * x + y * y;
                let radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
                let xd = x * radial + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x);
                let yd = y * radial + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y;
                (xd / self.k_h, -yd / self.k_v)
            }
        };
        (m + self.offset_m_px, n + self.offset_n_px)
    }

    /// Whether the ideal point (`m`, `n`) lies within the radius where the radial distortion folds back. Beyond it,
    /// points far outside the field of view land inside the frame, a second time where the model opens out again; they
    /// must not be sampled there.
    pub(crate) fn is_invertible_at(&self, m: f32, n: f32) -> bool {
        let (x, y) = (m * self.k_h, n * self.k_v);
        x * x + y * y < self.fold_r2
    }

    /// Whether the camera has any distortion.
    pub fn is_distorted(&self) -> bool {
        self.distortion.is_some()
    }

    /// Size of the rectified patch by eq. 4, W = 2 H tan(V_H/2)/R and H tan(V_V/2) likewise, before rounding down.
    /// The paper prints the two fields of view exchanged; the width belongs to the one across.
    pub fn patch_size(&self, height_m: f32, resolution_m: f32) -> (f32, f32) {
        let per_px = height_m / resolution_m;
        (self.k_h * self.cols as f32 * per_px, self.k_v * self.rows as f32 * per_px)
    }

    /// Frame pixels that one output pixel spans at nadir: (R/H)/k, the smaller of the two axes. Below 1 the output is
    /// finer than the frame.
    pub fn ratio(&self, height_m: f32, resolution_m: f32) -> f32 {
        resolution_m / (height_m * self.k_h.max(self.k_v))
    }
}
