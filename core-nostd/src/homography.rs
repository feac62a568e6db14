//! The projective map between the undistorted picture and the frame: eq. 3 in full, eq. 7 for a camera that follows,
//! eq. 6 for the way back.
//!
//! The undistorted picture is what the same camera would take without tilt: pixel (`m`, `n`), right and north of its
//! centre. The frame is what it did take: (`m'`, `n'`), right and forward. A resampler needs the map in this
//! direction, from its output to its input.
//!
//! Corrected against the paper: a minus stands before the fraction of eq. 3 and 7 (the printed one is the image behind
//! the lens, turned by 180°), and eq. 7's second numerator begins with `n a11`, not `m a11`, which would be degenerate.

use crate::camera::Camera;
use crate::tilt::EquivalentTilt;
use crate::{frames, math};
use nalgebra::Matrix3;

/// The smallest denominator that counts as in front of the camera. den is the depth of the ground point along the
/// optical axis in heights; 0.02 is 89° off the axis, where the picture of the ground has no use left.
pub const DEN_MIN: f32 = 0.02;

/// Coefficients of numerators and denominator, each linear in (m, n, 1). Ideal pixels, before distortion and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    m: [f32; 3],
    n: [f32; 3],
    den: [f32; 3],
}

impl Homography {
    /// Eq. 3, any fields of view and any follow-up angle: `a` is [`crate::tilt::camera_from_local`].
    ///
    /// den = a22 − m kH a23 − n kV a21, m' = (m a33 + n (kV/kH) a31 − a32/kH)/den,
    /// n' = (m (kH/kV) a13 + n a11 − a12/kV)/den.
    pub fn full(a: &Matrix3<f32>, camera: &Camera) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        let [a11, a12, a13] = [a[(0, 0)], a[(0, 1)], a[(0, 2)]];
        let [a21, a22, a23] = [a[(1, 0)], a[(1, 1)], a[(1, 2)]];
        let [a31, a32, a33] = [a[(2, 0)], a[(2, 1)], a[(2, 2)]];
        Homography {
            m: [a33, k_v / k_h * a31, -a32 / k_h],
            n: [k_h / k_v * a13, a11, -a12 / k_v],
            den: [-k_h * a23, -k_v * a21, a22],
        }
    }

    /// Eq. 7, for a camera that follows exactly and has one field of view per pixel (`k`, the larger axis' where they
    /// differ: check [`Camera::is_isotropic`] first).
    ///
    /// den = cγ cθ − m k sγ + n k cγ sθ, m' = (m cγ + n sγ sθ + sγ cθ/k)/den, n' = (n cθ − sθ/k)/den.
    pub fn simplified(tilt: EquivalentTilt, camera: &Camera) -> Self {
        let (k, _) = camera.tangent_per_px();
        let (st, ct) = math::sin_cos(tilt.pitch.0);
        let (sg, cg) = math::sin_cos(tilt.roll.0);
        Homography { m: [cg, sg * st, sg * ct / k], n: [0.0, ct, -st / k], den: [-k * sg, k * cg * st, cg * ct] }
    }

    /// The way back, frame to undistorted picture: eq. 3 with A transposed (eq. 6).
    pub fn inverse(a: &Matrix3<f32>, camera: &Camera) -> Self {
        Homography::full(&a.transpose(), camera)
    }

    /// Image of (`m`, `n`) in ideal pixels, `None` behind the camera or so near the horizon that it does not matter.
    pub fn ideal(&self, m: f32, n: f32) -> Option<(f32, f32)> {
        let dot = |c: &[f32; 3]| c[0] * m + c[1] * n + c[2];
        let den = dot(&self.den);
        if den.is_nan() || den < DEN_MIN {
            return None;
        }
        let reciprocal = 1.0 / den;
        Some((dot(&self.m) * reciprocal, dot(&self.n) * reciprocal))
    }

    /// Denominator at (`m`, `n`): positive in front of the camera.
    pub fn denominator(&self, m: f32, n: f32) -> f32 {
        self.den[0] * m + self.den[1] * n + self.den[2]
    }
}

/// Where a pixel of a patch lies in the frame: homography, distortion and the two centrings in one.
#[derive(Clone, Copy, Debug)]
pub struct FrameFromPatch<'a> {
    homography: Homography,
    camera: &'a Camera,
    /// Undistorted pixels per patch pixel, across and along.
    scale: (f32, f32),
    size: (u16, u16),
}

impl<'a> FrameFromPatch<'a> {
    /// `height_m` above ground, `resolution_m` a patch pixel, `size` of the patch (cols, rows), which is centred on
    /// the nadir and north-up.
    pub fn new(
        homography: Homography,
        camera: &'a Camera,
        (height_m, resolution_m): (f32, f32),
        size: (u16, u16),
    ) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        let tangent = resolution_m / height_m;
        FrameFromPatch { homography, camera, scale: (tangent / k_h, tangent / k_v), size }
    }

    /// Patch size, (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Whether the lens bends the map beyond a homography.
    pub fn is_distorted(&self) -> bool {
        self.camera.is_distorted()
    }

    /// Frame (col, row) of patch (col, row), fractions allowed; `None` beyond the horizon guard and where the lens
    /// model folds back.
    // Called from few places, a few times a row: not worth its size at each of them.
    #[inline(never)]
    pub fn frame_position(&self, col: f32, row: f32) -> Option<(f32, f32)> {
        let (m, n) = frames::centred(col, row, self.size.0, self.size.1);
        let (m, n) = self.homography.ideal(m * self.scale.0, n * self.scale.1)?;
        if !self.camera.is_invertible_at(m, n) {
            return None;
        }
        let (m, n) = self.camera.distorted(m, n);
        Some(frames::pixel(m, n, self.camera.cols(), self.camera.rows()))
    }
}
