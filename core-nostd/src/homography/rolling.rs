//! Rolling shutter: each row of the frame is exposed at its own instant, so it has a pose and a homography of its own.
//!
//! [`Bands`] holds the homography at a few instants spread evenly over the readout, all of them seen from one picture:
//! the undistorted one of mid-exposure of the middle row. Between two instants their coefficients are blended. With a
//! rate of ω and an angular acceleration of α, and the instants τ apart, blending is off by (ω² + α) τ²/8: at 20°/s,
//! 100°/s² and 2.5 ms by 1.5e-6 rad, less than 1e-3 px.
//!
//! The row at which a ground point is seen decides the instant at which it is seen, so it is found by a
//! fixed-point iteration. g(r), the row at which the instant of row r shows the point, is a contraction: |g'| =
//! (velocity of its image along the columns) x (readout/rows) = q, and [`Bands::new`] refuses q above [`MOTION_MAX`] =
//! 1/16, where one step takes fifteen sixteenths off the error. Started in the middle row, which is at most half a
//! frame off, `STEPS` = 4 leave rows/2/16⁴: 0.004 px of 512 rows in the worst case, 2e-5 px at 20°/s and 40 m/s at 150
//! m (q = 0.016). Above q = 1 the picture would outrun the readout, and a point could be seen twice.
//!
//! Instants before the first row and after the last are extrapolated, so that positions off the frame, which stretches
//! of the rectifier reach for, stay smooth.

use super::{FrameFromPatch, Homography};
use crate::arch::opaque;
use crate::camera::Camera;
use heapless::Vec;

/// Most instants of a readout.
pub const BANDS_MAX: usize = 9;
/// Largest velocity along the columns, rows a row: of a frame of 512 rows read in 20 ms, 1,600 px/s.
pub const MOTION_MAX: f32 = 1.0 / 16.0;
/// Evaluations of the fixed point.
const STEPS: usize = 4;
/// Readouts before the first and after the last row to which the pose is extrapolated.
const BEYOND: f32 = 4.0;

/// Why there is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BandsError {
    /// Fewer than two instants or more than [`BANDS_MAX`].
    Count,
    /// A homography or a displacement with a coefficient that is no finite number.
    NotFinite,
    /// No height above ground, or one that halves or doubles during the readout.
    Height,
    /// The picture moves faster than [`MOTION_MAX`] along the columns, or sees no ground.
    TooFast,
}

/// How far the vehicle is at one instant from where it is at mid-exposure of the middle row, metres on the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Displacement {
    /// To grid east.
    pub east_m: f32,
    /// To grid north.
    pub north_m: f32,
    /// Change of the height above ground.
    pub up_m: f32,
}

/// Pose at one instant of the readout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The homography of the attitude and follow-up angle at that instant, as for a whole frame.
    pub homography: Homography,
    /// Where the vehicle is.
    pub displacement: Displacement,
}

/// The homographies of a readout, 36 bytes an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// From mid-exposure's undistorted picture to the frame, first row to last.
    homographies: Vec<Homography, BANDS_MAX>,
}

/// When instant `index` of `count` is, microseconds after mid-exposure of the middle row, of a readout that takes
/// `readout_us` from the first row's mid-exposure to the last one's. 0 for fewer than two instants.
pub fn offset_us(index: usize, count: usize, readout_us: u32) -> i32 {
    let last = count.clamp(1, BANDS_MAX) as i64 - 1;
    if last == 0 {
        return 0;
    }
    let twice = (2 * (index.min(BANDS_MAX) as i64).min(last) - last) * readout_us as i64;
    // To the nearest, halves up.
    (twice + last).div_euclid(2 * last).min(i32::MAX as i64) as i32
}

impl Homography {
    /// This homography for the picture taken from another position: `self` maps the undistorted picture taken `moved` away,
    /// the result the one taken here, `height_m` above the same level ground.
    ///
    /// A ground point at tangents t from here is at (t H − moved)/(H + up) from there; in pixels m H/(H + up) −
    /// east/((H + up) kH), and n likewise, which is put into the three linear functions.
    pub(crate) fn displaced(&self, camera: &Camera, height_m: f32, moved: Displacement) -> Self {
        let (k_h, k_v) = camera.tangent_per_px();
        let there = height_m + moved.up_m;
        let scale = height_m / there;
        let (m, n) = (moved.east_m / (there * k_h), moved.north_m / (there * k_v));
        Homography { rows: self.rows.map(|c| [c[0] * scale, c[1] * scale, c[2] - c[0] * m - c[1] * n]) }
    }
}

impl Bands {
    /// `bands`: the pose at [`offset_us`] of each instant, in their order, first row first. `height_m` above ground at
    /// mid-exposure of the middle row.
    ///
    /// Poses should come from one smooth fit: between instants that noise has set apart the map bends, and the
    /// rectifier's stretches follow a parabola.
    ///
    /// # Errors
    /// [`BandsError`].
    pub fn new(bands: &[Band], camera: &Camera, height_m: f32) -> Result<Self, BandsError> {
        if bands.len() < 2 {
            return Err(BandsError::Count);
        }
        let mut homographies = Vec::new();
        for band in bands {
            let up_m = band.displacement.up_m;
            // False for a NaN as well.
            if !(height_m > 0.0 && height_m.is_finite() && up_m > -0.5 * height_m && up_m < height_m) {
                return Err(BandsError::Height);
            }
            let seen = band.homography.displaced(camera, height_m, band.displacement);
            if !seen.rows.as_flattened().iter().all(|coefficient| coefficient.is_finite()) {
                return Err(BandsError::NotFinite);
            }
            homographies.push(seen).map_err(|_| BandsError::Count)?;
        }
        let bands = Bands { homographies };
        if bands.fastest(camera) <= MOTION_MAX { Ok(bands) } else { Err(BandsError::TooFast) }
    }

    /// Largest velocity along the columns, rows a row, of what is seen at the corners, sides and centre of the frame
    /// from one instant to the next; infinite where no ground is seen. Points that are over the horizon are left out.
    /// So is the lens's distortion, for whose local scale of 1 + 3 k1 r² the limit has a margin.
    fn fastest(&self, camera: &Camera) -> f32 {
        let rows_apart = (camera.rows() as f32 - 1.0).max(1.0) / (self.homographies.len() as f32 - 1.0).max(1.0);
        let half = (0.5 * camera.cols() as f32, 0.5 * camera.rows() as f32);
        let (mut most, mut is_seen) = (0.0f32, false);
        for pair in self.homographies.windows(2) {
            let [now, next] = pair else { continue };
            for point in 0..9u8 {
                let (m, n) = ((point % 3) as f32 - 1.0, (point / 3) as f32 - 1.0);
                let (m, n) = (m * half.0, n * half.1);
                let Some((_, later)) = now.undo(m, n).and_then(|(m, n)| next.ideal(m, n)) else { continue };
                is_seen = true;
                let moved = (later - n).abs();
                // A NaN must not be lost.
                most = if moved <= most { most } else { moved };
            }
        }
        if is_seen { most / rows_apart } else { f32::INFINITY }
    }

    /// The homography `late` readouts after the first row's instant.
    #[inline(never)]
    fn at(&self, late: f32) -> Option<Homography> {
        let intervals = self.homographies.len().checked_sub(1)?;
        let at = late.clamp(-BEYOND, 1.0 + BEYOND) * intervals as f32;
        // A cast saturates, at 0 for what lies below.
        let first = (at as usize).min(intervals.saturating_sub(1));
        let [now, next] = self.homographies.get(first..)?.first_chunk()?;
        let share = at - first as f32;
        let mut blend = *now;
        let mut pairs = blend.rows.as_flattened_mut().iter_mut().zip(next.rows.as_flattened());
        let mut left = 9;
        while left > 0 {
            if let Some((now, next)) = pairs.next() {
                *now += share * (next - *now);
            }
            left = opaque(left - 1);
        }
        Some(blend)
    }

    /// Frame (col, row) of patch (`col`, `row`) in the instant of its own row: each instant is a global shutter's map.
    pub(super) fn position(&self, map: &FrameFromPatch<'_>, col: f32, row: f32) -> Option<(f32, f32)> {
        let last = (map.camera.rows() as f32 - 1.0).max(1.0);
        let (per_row, mut seen) = (1.0 / last, (0.0, 0.5 * last));
        let mut left = STEPS;
        while left > 0 {
            seen = map.at_once(self.at(seen.1 * per_row)?).frame_position(col, row)?;
            left = opaque(left - 1);
        }
        Some(seen)
    }
}
