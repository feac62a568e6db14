//! The projective map between the undistorted picture and the frame: eq. 3 in full, eq. 7 for a camera that follows,
//! eq. 6 for the inverse.
//!
//! The undistorted picture is what the same camera would take without tilt: pixel (`m`, `n`), right and north of its
//! centre. The frame is what it did take: (`m'`, `n'`), right and forward. A resampler needs the map in this
//! direction, from its output to its input.
//!
//! Corrected against the paper: a minus stands before the fraction of eq. 3 and 7 (the printed one is the image behind
//! the lens, turned by 180°), and eq. 7's second numerator begins with `n a11`, not `m a11`, which would be degenerate.

pub mod rolling;

use crate::camera::Camera;
use crate::tilt::EquivalentTilt;
use crate::{frames, math};
use nalgebra::Matrix3;
use rolling::Bands;

/// The smallest denominator that counts as in front of the camera. den is the depth of the ground point along the
/// optical axis in heights; 0.02 is 89° off the axis, where the picture of the ground has no use left.
pub(crate) const DEN_MIN: f32 = 0.02;

/// Coefficients of numerators and denominator, each linear in (m, n, 1). Ideal pixels, before distortion and offset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Homography {
    /// Numerator across, numerator along, denominator.
    rows: [[f32; 3]; 3],
}

impl Homography {
    /// Eq. 3, any fields of view and any follow-up angle: `a` is [`crate::tilt::camera_from_local`].
    ///
    /// den = a22 − m kH a23 − n kV a21, m' = (m a33 + n (kV/kH) a31 − a32/kH)/den,
    /// n' = (m (kH/kV) a13 + n a11 − a12/kV)/den.
    ///
    /// Nothing here asks `a` to be a rotation: any matrix maps the rays (n kV, −1, m kH) of one picture to those of another.
    /// So does that of a head of a combined camera (paper 002), whose undistorted picture is a piece of the virtual image.
    pub fn full(a: &Matrix3<f32>, camera: &Camera) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        let [a11, a12, a13] = [a[(0, 0)], a[(0, 1)], a[(0, 2)]];
        let [a21, a22, a23] = [a[(1, 0)], a[(1, 1)], a[(1, 2)]];
        let [a31, a32, a33] = [a[(2, 0)], a[(2, 1)], a[(2, 2)]];
        let m = [a33, k_v / k_h * a31, -a32 / k_h];
        let n = [k_h / k_v * a13, a11, -a12 / k_v];
        Homography { rows: [m, n, [-k_h * a23, -k_v * a21, a22]] }
    }

    /// Eq. 7, for a camera that follows exactly and has one field of view per pixel (`k`, the larger axis' where they
    /// differ: check [`Camera::is_isotropic`] first).
    ///
    /// den = cγ cθ − m k sγ + n k cγ sθ, m' = (m cγ + n sγ sθ + sγ cθ/k)/den, n' = (n cθ − sθ/k)/den.
    pub fn simplified(tilt: EquivalentTilt, camera: &Camera) -> Self {
        let (k, _) = camera.tangent_per_px();
        let (st, ct) = math::sin_cos(tilt.pitch.0);
        let (sg, cg) = math::sin_cos(tilt.roll.0);
        let den = [-k * sg, k * cg * st, cg * ct];
        Homography { rows: [[cg, sg * st, sg * ct / k], [0.0, ct, -st / k], den] }
    }

    /// This map of level ground for ground that rises by `slope` to the east and to the north.
    ///
    /// Of a ground point X east and Y north of the nadir the ray is (Y, z, X) in (north, up, east), and eq. 3 puts z = −H there.
    /// On the plane through the nadir with slopes a and b, H below the camera, z = a X + b Y − H. The picture stays the one whose
    /// pixel (m, n) is that of X = m kH H, Y = n kV H, as a map has it, so in heights the ray is (n kV, a m kH + b n kV − 1, m kH):
    /// still linear in (m, n, 1). The up component's share is what stands, with a minus, in the third column c, so the first one gains
    /// −a kH c and the second one −b kV c, in numerators and denominator alike, of eq. 3 as of eq. 7. A pixel costs what it did.
    #[must_use]
    #[inline(never)]
    pub fn over_slope(self, camera: &Camera, [a, b]: [f32; 2]) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        Homography { rows: self.rows.map(|[m, n, c]| [m - a * k_h * c, n - b * k_v * c, c]) }
    }

    /// The inverse map, frame to undistorted picture: eq. 3 with A transposed (eq. 6).
    pub fn inverse(a: &Matrix3<f32>, camera: &Camera) -> Self {
        Homography::full(&a.transpose(), camera)
    }

    /// Image of (`m`, `n`) in ideal pixels, `None` behind the camera or so near the horizon that it does not matter.
    pub fn ideal(&self, m: f32, n: f32) -> Option<(f32, f32)> {
        let dot = |c: &[f32; 3]| c[0] * m + c[1] * n + c[2];
        let [across, along, den] = &self.rows;
        let den = dot(den);
        // False for a NaN as well.
        (den >= DEN_MIN).then(|| {
            let reciprocal = 1.0 / den;
            (dot(across) * reciprocal, dot(along) * reciprocal)
        })
    }

    /// Undistorted pixel of the ideal frame position (`m`, `n`): the inverse of [`Homography::ideal`], by Cramer's
    /// rule. `None` where that sees no ground.
    fn undo(&self, m: f32, n: f32) -> Option<(f32, f32)> {
        // m den = m-numerator and n den = n-numerator, linear in the undistorted pixel.
        let [across, along, den] = &self.rows;
        let row = |c: &[f32; 3], at: f32| [c[0] - at * den[0], c[1] - at * den[1], c[2] - at * den[2]];
        let ([a, b, c], [d, e, f]) = (row(across, m), row(along, n));
        let reciprocal = 1.0 / (a * e - b * d);
        let (m, n) = ((b * f - c * e) * reciprocal, (c * d - a * f) * reciprocal);
        (self.denominator(m, n) >= DEN_MIN).then_some((m, n))
    }

    /// Denominator at (`m`, `n`): positive in front of the camera.
    pub fn denominator(&self, m: f32, n: f32) -> f32 {
        let [_, _, den] = self.rows;
        den[0] * m + den[1] * n + den[2]
    }
}

/// A patch: how large it is, and where it lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Placement {
    /// Columns and rows.
    pub size: (u16, u16),
    /// From the nadir to its centre, pixels to the east and north.
    pub aside: (i16, i16),
}

/// Where a pixel of a patch lies in the frame: homography, distortion and the two centrings in one.
#[derive(Clone, Copy, Debug)]
pub struct FrameFromPatch<'a> {
    pose: Pose<'a>,
    camera: &'a Camera,
    /// Undistorted pixels per patch pixel, across and along.
    scale: (f32, f32),
    size: (u16, u16),
    /// From the nadir to the patch's centre, patch pixels to the east and north.
    aside: (f32, f32),
}

/// When the rows of the frame were exposed.
#[derive(Clone, Copy, Debug)]
enum Pose<'a> {
    /// All at once.
    Global(Homography),
    /// One after the other: the poses, and the function that computes a position. Through a pointer, so that an image
    /// without a rolling shutter does not carry it.
    Rolling(&'a Bands, Position),
}

/// Frame (col, row) of patch (col, row).
type Position = fn(&Bands, &FrameFromPatch<'_>, f32, f32) -> Option<(f32, f32)>;

impl<'a> FrameFromPatch<'a> {
    /// `height_m` above ground, `resolution_m` a patch pixel, `size` of the patch (cols, rows), which is centred on
    /// the nadir, unless it lies [`aside`](FrameFromPatch::aside), and north-up.
    pub fn new(
        homography: Homography,
        camera: &'a Camera,
        (height_m, resolution_m): (f32, f32),
        size: (u16, u16),
    ) -> Self {
        FrameFromPatch::of(Pose::Global(homography), camera, (height_m, resolution_m), size)
    }

    /// [`FrameFromPatch::new`] for a rolling shutter: `bands` hold the pose of each row. The patch is that of mid-exposure
    /// of the middle row, at which the vehicle is `height_m` above ground, the height given to [`Bands::new`].
    pub fn rolling(
        bands: &'a Bands,
        camera: &'a Camera,
        (height_m, resolution_m): (f32, f32),
        size: (u16, u16),
    ) -> Self {
        FrameFromPatch::of(Pose::Rolling(bands, Bands::position), camera, (height_m, resolution_m), size)
    }

    fn of(pose: Pose<'a>, camera: &'a Camera, (height_m, resolution_m): (f32, f32), size: (u16, u16)) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        let tangent = resolution_m / height_m;
        FrameFromPatch { pose, camera, scale: (tangent / k_h, tangent / k_v), size, aside: (0.0, 0.0) }
    }

    /// This map for a patch whose centre lies so many pixels to the east and north of the nadir.
    #[must_use]
    pub fn aside(self, (east, north): (i16, i16)) -> Self {
        FrameFromPatch { aside: (east as f32, north as f32), ..self }
    }

    /// Position of patch (`col`, `row`) from the nadir, patch pixels to the east and north.
    fn off_nadir(&self, col: f32, row: f32) -> (f32, f32) {
        let (m, n) = frames::centred(col, row, self.size.0, self.size.1);
        (m + self.aside.0, n + self.aside.1)
    }

    /// Patch size, (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Whether lens distortion or a rolling shutter makes the map more than a homography.
    pub fn is_nonlinear(&self) -> bool {
        self.camera.is_distorted() || matches!(self.pose, Pose::Rolling(..))
    }

    /// Frame (col, row) of patch (col, row), fractions allowed; `None` beyond the horizon guard and where the lens
    /// model folds back.
    // Called from few places, a few times a row: not worth its size at each of them.
    #[inline(never)]
    pub fn frame_position(&self, col: f32, row: f32) -> Option<(f32, f32)> {
        let homography = match &self.pose {
            Pose::Global(homography) => homography,
            Pose::Rolling(bands, position) => return position(bands, self, col, row),
        };
        let (m, n) = self.off_nadir(col, row);
        let (m, n) = homography.ideal(m * self.scale.0, n * self.scale.1)?;
        if !self.camera.is_invertible_at(m, n) {
            return None;
        }
        let (m, n) = self.camera.distorted(m, n);
        Some(frames::pixel(m, n, self.camera.cols(), self.camera.rows()))
    }

    /// Frame position with one pose for all rows.
    fn at_once(&self, homography: Homography) -> Self {
        FrameFromPatch { pose: Pose::Global(homography), ..*self }
    }

    /// The map along row `row`, where it is a homography and nothing else; `None` with lens distortion or a
    /// rolling shutter.
    pub(crate) fn along_row(&self, row: f32) -> Option<AlongRow> {
        let Pose::Global(homography) = &self.pose else { return None };
        if self.camera.is_distorted() {
            return None;
        }
        let (m, n) = self.off_nadir(0.0, row);
        let (m, n, across) = (m * self.scale.0, n * self.scale.1, self.scale.0);
        let linear = |c: &[f32; 3]| Linear { first: c[0] * m + c[1] * n + c[2], growth: c[0] * across };
        let [right, ahead, depth] = &homography.rows;
        let (right, ahead, depth) = (linear(right), linear(ahead), linear(depth));
        let (m, n) = self.camera.distorted(0.0, 0.0);
        let (col, row) = frames::pixel(m, n, self.camera.cols(), self.camera.rows());
        Some(AlongRow { depth, col: depth.times(col).plus(right), row: depth.times(row).plus(ahead.times(-1.0)) })
    }
}

/// A linear function of the column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear {
    first: f32,
    growth: f32,
}

impl Linear {
    /// Its value at `col`.
    pub(crate) fn at(self, col: f32) -> f32 {
        self.first + col * self.growth
    }

    pub(crate) fn times(self, factor: f32) -> Self {
        Linear { first: self.first * factor, growth: self.growth * factor }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Linear { first: self.first + other.first, growth: self.growth + other.growth }
    }

    /// `from`..`to` without the columns at which it is negative.
    #[inline(never)]
    pub(crate) fn narrow(self, (from, to): (f32, f32)) -> (f32, f32) {
        let (is_from, is_to) = (self.at(from) >= 0.0, self.at(to) >= 0.0);
        if is_from && is_to {
            return (from, to);
        }
        let root = -self.first / self.growth;
        match (is_from, is_to) {
            (true, _) => (from, to.min(root)),
            (_, true) => (from.max(root), to),
            _ => (f32::INFINITY, f32::NEG_INFINITY),
        }
    }
}

/// Frame positions along a row of a patch: quotients of linear functions of the column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlongRow {
    /// Denominator.
    depth: Linear,
    /// Frame column times depth.
    col: Linear,
    /// Frame row times depth.
    row: Linear,
}

impl AlongRow {
    /// Frame (col, row) at patch column `col`; `None` beyond the horizon guard.
    pub(crate) fn position(&self, col: f32) -> Option<(f32, f32)> {
        let depth = self.depth.at(col);
        // False for a NaN as well.
        (depth >= DEN_MIN).then(|| {
            let reciprocal = 1.0 / depth;
            (self.col.at(col) * reciprocal, self.row.at(col) * reciprocal)
        })
    }

    /// First and last column, fractions, whose positions lie in the frame of `size` (cols, rows) with `margin_px` to
    /// spare, within 0 to `last`; the first above the last where there is none.
    ///
    /// The borders of the frame are straight lines in the patch as well.
    #[inline(never)]
    pub(crate) fn inside(&self, size: (u16, u16), margin_px: f32, last: f32) -> (f32, f32) {
        let guard = Linear { first: self.depth.first - DEN_MIN, growth: self.depth.growth };
        let mut columns = guard.narrow((0.0, last));
        for (axis, count) in [(self.col, size.0), (self.row, size.1)] {
            columns = axis.plus(self.depth.times(-margin_px)).narrow(columns);
            let end = self.depth.times(count as f32 - 1.0 - margin_px);
            columns = end.plus(axis.times(-1.0)).narrow(columns);
        }
        columns
    }
}
