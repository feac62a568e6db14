//! The state at mid-exposure: pose, height, predicted position, and their sigmas.

use crate::budget::PATCH_MAX_PX;
use crate::camera::Camera;
use crate::homography::rolling::{Band, Bands, BandsError, Displacement, offset_us};
use crate::homography::{Homography, Placement};
use crate::math;
use crate::motion::{Moving, Rates, Velocity};
use crate::mount::Mount;
use crate::navigation::heights::Height;
use crate::navigation::reckoning::Moment;
use crate::pose::Method;
use crate::tile::Local;
use crate::tilt::{Attitude, equivalent_tilt, follow_up_command};
use crate::units::{Micros, Radians};
use heapless::Vec;

/// The camera's position by the navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Grid metres from the tile's centre.
    pub local: Local,
    /// Velocity towards grid east and north, m/s.
    pub velocity_m_per_s: [f32; 2],
    /// Sigma of each axis, metres.
    pub sigma_m: f32,
}

/// The state at mid-exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Situation {
    /// The instant.
    pub mid_exposure_at: Micros,
    /// Attitude, heading from grid north.
    pub attitude: Attitude,
    /// Follow-up angle used.
    pub follow_up: Radians,
    /// Whether the follow-up angle is the exact one for this attitude.
    pub followed: bool,
    /// How the camera is mounted.
    pub mount: Mount,
    /// Rates of both.
    pub rates: Rates,
    /// Sigma of pitch's and roll's rates, each, radians a second.
    pub sigma_rate_rad_s: f32,
    /// Height above ground, metres: above the plane of the slope, at the nadir.
    pub height_m: f32,
    /// Rise of the ground under the footprint to the east and to the north, metres a metre; zeros without an elevation
    /// model.
    pub slope: [f32; 2],
    /// RMS of the heights about that plane, metres.
    pub relief_m: f32,
    /// Predicted position.
    pub prediction: Prediction,
    /// The camera relative to the point that positions refer to, grid east and north, metres.
    pub camera_offset_m: [f32; 2],
    /// Sigma of pitch and roll, each.
    pub sigma_tilt_rad: f32,
    /// Its drifting part, common to instants seconds apart.
    pub sigma_tilt_drift_rad: f32,
    /// Sigma of the heading, including the follow-up angle's.
    pub sigma_heading_rad: f32,
    /// Sigma of the height.
    pub sigma_height_m: f32,
    /// Heading and height are one candidate of several, none of which has been matched yet.
    pub is_candidate: bool,
    /// Sigma of mid-exposure, seconds.
    pub sigma_stamp_s: f32,
    /// Method of the attitude.
    pub attitude_method: Method,
    /// Method of the position.
    pub position_method: Method,
}

/// Instants of a rolling shutter's readout at which the pose is computed: 5 ms apart for 20 ms, between which the error
/// of blending is less than 0.01 px of the frame.
const BANDS: usize = 5;
/// Smallest patch side, pixels: smaller patches are not distinctive.
const PATCH_MIN_PX: f32 = 7.0;

impl Situation {
    /// White noise of the heading, one sigma, without the drifting error of this variance, radians.
    pub(super) fn white_heading_rad(&self, drifting: f32) -> f32 {
        math::sqrt((math::squared(self.sigma_heading_rad) - drifting).max(0.0))
    }

    /// With exact attitude, follow-up angle, height and mount, at rest over the tile's centre.
    pub fn exact(mid_exposure_at: Micros, attitude: Attitude, follow_up: (Radians, bool), height_m: f32) -> Self {
        let local = Local::default();
        Situation {
            mid_exposure_at,
            attitude,
            follow_up: follow_up.0,
            followed: follow_up.1,
            mount: Mount::default(),
            rates: Rates::default(),
            sigma_rate_rad_s: 0.0,
            height_m,
            slope: [0.0; 2],
            relief_m: 0.0,
            prediction: Prediction { local, velocity_m_per_s: [0.0; 2], sigma_m: 0.0 },
            camera_offset_m: [0.0; 2],
            sigma_tilt_rad: 0.0,
            sigma_tilt_drift_rad: 0.0,
            sigma_heading_rad: 0.0,
            sigma_height_m: 0.0,
            is_candidate: false,
            sigma_stamp_s: 0.0,
            attitude_method: Method::Linear,
            position_method: Method::Propagated,
        }
    }

    /// The height for rectification.
    pub(super) fn height(&self) -> Height {
        Height { metres: self.height_m, sigma_m: self.sigma_height_m }
    }

    /// Instant and reported velocity.
    pub(super) fn moment(&self) -> Moment {
        Moment { at: self.mid_exposure_at, velocity_m_per_s: self.prediction.velocity_m_per_s }
    }

    /// The homography: eq. 7 where the camera follows, is aligned and has square pixels, eq. 3 otherwise; onto the
    /// sloping plane if there is a slope.
    pub fn homography(&self, camera: &Camera) -> Homography {
        let level = self.over_level_ground(camera);
        if self.slope == [0.0; 2] { level } else { level.over_slope(camera, self.slope) }
    }

    fn over_level_ground(&self, camera: &Camera) -> Homography {
        if self.followed && self.mount.is_aligned() && camera.is_isotropic() {
            Homography::simplified(equivalent_tilt(self.attitude, self.follow_up), camera)
        } else {
            Homography::full(&self.mount.camera_from_local(self.attitude, self.follow_up), camera)
        }
    }

    /// Intersection with the sloping plane of a ray that meets level ground at `(east, north)` heights; `None` if it
    /// does not descend to the plane.
    ///
    /// The ray is s (east, north, −1) heights, the plane lies at a s east + b s north − 1: s = 1 / (1 + a east + b
    /// north).
    fn on_slope(&self, (east, north): (f32, f32)) -> Option<(f32, f32)> {
        let [a, b] = self.slope;
        let falls = 1.0 + a * east + b * north;
        // A ray that reaches fifty times as far counts as the horizon.
        (falls > 0.02).then(|| (east / falls, north / falls))
    }

    /// Extent of the frame's corners from the nadir, (east, north), heights; larger than any patch beyond the horizon.
    /// The lens distortion, some pixels of the frame at a corner, is ignored.
    fn reach(&self, camera: &Camera) -> (f32, f32) {
        let a = self.mount.camera_from_local(self.attitude, self.follow_up);
        let undistorted_from_frame = Homography::inverse(&a, camera);
        let (m, n) = (0.5 * camera.cols() as f32, 0.5 * camera.rows() as f32);
        let (k_h, k_v) = camera.tangent_per_px();
        let corners = [(m, n), (m, -n), (-m, n), (-m, -n)].map(|(m, n)| {
            let corner = undistorted_from_frame.ideal(m, n);
            let corner = corner.and_then(|(m, n)| self.on_slope((m * k_h, n * k_v)));
            corner.map_or((f32::MAX, f32::MAX), |(east, north)| (east.abs(), north.abs()))
        });
        corners
            .iter()
            .fold((0.0, 0.0), |(across, along): (f32, f32), corner| (across.max(corner.0), along.max(corner.1)))
    }

    /// This situation `after_us` after mid-exposure: angles propagated with their rates. Over the readout of a rolling
    /// shutter, ±10 ms, the error is half of an angular acceleration of 100°/s² times 10 ms squared, 0.005°.
    fn after(&self, after_us: i32) -> Self {
        let seconds = after_us as f32 * 1e-6;
        let propagated = |angle: Radians, rate: f32| Radians(angle.0 + rate * seconds);
        let attitude = Attitude {
            heading: propagated(self.attitude.heading, self.rates.heading),
            pitch: propagated(self.attitude.pitch, self.rates.pitch),
            roll: propagated(self.attitude.roll, self.rates.roll),
        };
        let follow_up =
            if self.followed { follow_up_command(attitude) } else { propagated(self.follow_up, self.rates.follow_up) };
        Situation { attitude, follow_up, ..*self }
    }

    /// The homographies of a rolling shutter that reads all rows in `readout_us`, at [`BANDS`] instants, each with its
    /// own attitude, follow-up angle and position.
    pub(super) fn bands(&self, camera: &Camera, readout_us: u32) -> Result<Bands, BandsError> {
        let mut bands = Vec::<Band, BANDS>::new();
        for index in 0..BANDS {
            let after_us = offset_us(index, BANDS, readout_us);
            let seconds = after_us as f32 * 1e-6;
            let [east, north] = self.prediction.velocity_m_per_s;
            let (east_m, north_m) = (east * seconds, north * seconds);
            // In level flight the plane is nearer where the ground rises.
            let [rises_east, rises_north] = self.slope;
            let up_m = if self.slope == [0.0; 2] { 0.0 } else { -(rises_east * east_m + rises_north * north_m) };
            let displacement = Displacement { east_m, north_m, up_m };
            let homography = self.after(after_us).homography(camera);
            bands.push(Band { homography, displacement }).map_err(|_| BandsError::Count)?;
        }
        Bands::new(&bands, camera, self.height_m)
    }

    /// The motion for the image-motion model. Level flight is assumed: the climb is not measured.
    pub fn moving(&self) -> Moving {
        let [east, north] = self.prediction.velocity_m_per_s;
        Moving {
            attitude: self.attitude,
            follow_up: self.follow_up,
            rates: self.rates,
            velocity: Velocity { north, up: 0.0, east },
            height_m: self.height_m,
        }
    }

    /// Size and position of the patch, the size rounded down and limited to the build's; `None` if it is too small to
    /// be a template or the height is invalid.
    ///
    /// If the frame shows the nadir the patch is centred on it with the size of eq. 4; for a camera mounted obliquely,
    /// whose footprint hardly lies in a patch of that size, with the size that contains the footprint. If the frame
    /// does not show the nadir, as in a steep turn, the patch has the largest size and begins at the near edge of the
    /// footprint: there each of the frame's pixels sees the least ground.
    pub fn placement(&self, camera: &Camera, resolution_m: f32) -> Option<Placement> {
        let (cols, rows) = if self.mount.looks_aside() {
            let (across, along) = self.reach(camera);
            let per_px = 2.0 * self.height_m / resolution_m;
            (across * per_px, along * per_px)
        } else {
            camera.patch_size(self.height_m, resolution_m)
        };
        if !(cols >= PATCH_MIN_PX && rows >= PATCH_MIN_PX) {
            return None;
        }
        let side = |px: f32| px.min(PATCH_MAX_PX as f32) as u16;
        let Some((east, north)) = self.near_edge(camera) else {
            return Some(Placement { size: (side(cols), side(rows)), aside: (0, 0) });
        };
        let near = math::hypot(east, north);
        let whole_px = near * self.height_m / resolution_m + 0.5 * PATCH_MAX_PX as f32;
        let pixels = |part: f32| math::round(part / near * whole_px) as i16;
        Some(Placement { size: (PATCH_MAX_PX as u16, PATCH_MAX_PX as u16), aside: (pixels(east), pixels(north)) })
    }

    /// Near edge of the footprint, (east, north) of the nadir, heights; `None` if the frame shows the nadir, or no
    /// ground. The lens distortion is ignored, as in [`Situation::reach`].
    fn near_edge(&self, camera: &Camera) -> Option<(f32, f32)> {
        let a = self.mount.camera_from_local(self.attitude, self.follow_up);
        let (m, n) = Homography::full(&a, camera).ideal(0.0, 0.0)?;
        let (half_m, half_n) = (0.5 * camera.cols() as f32, 0.5 * camera.rows() as f32);
        if m.abs() <= half_m && n.abs() <= half_n {
            return None;
        }
        let (k_h, k_v) = camera.tangent_per_px();
        let (m, n) = Homography::inverse(&a, camera).ideal(m.clamp(-half_m, half_m), n.clamp(-half_n, half_n))?;
        self.on_slope((m * k_h, n * k_v))
    }
}
