//! Everything that holds at the instant of mid-exposure: pose, height, predicted position, and what they are worth.

use super::{FollowUpMode, Pipeline, Refusal, Settings};
use crate::budget::PATCH_MAX_PX;
use crate::camera::Camera;
use crate::homography::Homography;
use crate::math;
use crate::pose::PoseError;
use crate::tile::Local;
use crate::tilt::{Attitude, camera_from_local, equivalent_tilt, follow_up_command};
use crate::units::{Micros, Radians};

/// Where the navigation believes to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Grid metres from the tile's centre.
    pub local: Local,
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
    /// Whether eq. 7 serves: the follow-up angle is the exact one.
    pub followed: bool,
    /// Height above ground, metres.
    pub height_m: f32,
    /// Predicted position.
    pub prediction: Prediction,
    /// Sigma of pitch and roll, each.
    pub sigma_tilt_rad: f32,
    /// Sigma of heading, the follow-up angle's included where it enters.
    pub sigma_heading_rad: f32,
    /// Sigma of the height.
    pub sigma_height_m: f32,
}

/// Smallest a22 that is worked with: 60° between optical axis and plumb line.
const COS_TILT_MIN: f32 = 0.5;
/// Smallest patch side, pixels: less is no template.
const PATCH_MIN_PX: f32 = 7.0;

impl Pipeline<'_> {
    /// Interpolates every stream to mid-exposure. `Ok(None)`: a stream's next sample has not arrived yet; try again
    /// when it has, as long as patience lasts.
    ///
    /// # Errors
    /// The [`Refusal`] that waiting cannot mend.
    pub fn situate(&self, mid_exposure_at: Micros) -> Result<Option<Situation>, Refusal> {
        let settings = self.settings();
        let attitude = match self.streams.attitude.at(mid_exposure_at, settings.gap_us) {
            Err(PoseError::NotYet) => return Ok(None),
            other => other.map_err(|e| if e == PoseError::Gap { Refusal::AttitudeGap } else { Refusal::NoAttitude })?,
        };
        let slant = match self.streams.slant.at(mid_exposure_at, settings.range_gap_us) {
            Err(PoseError::NotYet) => return Ok(None),
            other => other.map_err(|_| Refusal::NoRange)?,
        };
        if !attitude.value.looks_down() || attitude.value.cos_tilt() < COS_TILT_MIN {
            return Err(Refusal::Tilt);
        }
        let (follow_up, followed) = match settings.follow_up {
            FollowUpMode::Followed => (follow_up_command(attitude.value), true),
            FollowUpMode::Fixed => (Radians(0.0), false),
            FollowUpMode::Measured => match self.streams.follow_up.at(mid_exposure_at, settings.gap_us) {
                Err(PoseError::NotYet) => return Ok(None),
                other => (other.map_err(|_| Refusal::NoFollowUp)?.value, false),
            },
        };
        let cos_tilt = attitude.value.cos_tilt();
        let height_m = slant.value * cos_tilt;
        let sigma_tilt_rad = sigma_tilt(settings, attitude.noise_factor());
        let sigma_range_m = settings.sigmas.range_m * slant.noise_factor();
        // H = s cos t: a tilt error changes the height by s sin t.
        let sigma_lean_m = slant.value * math::sqrt((1.0 - cos_tilt * cos_tilt).max(0.0)) * sigma_tilt_rad;
        Ok(Some(Situation {
            mid_exposure_at,
            attitude: attitude.value,
            follow_up,
            followed,
            height_m,
            prediction: self.predict(mid_exposure_at)?,
            sigma_tilt_rad,
            sigma_heading_rad: hypot(settings.sigmas.heading_rad, settings.sigmas.follow_up_rad),
            sigma_height_m: hypot(sigma_range_m, sigma_lean_m),
        }))
    }

    /// Which stream a frame waited for in vain.
    pub fn missing_at(&self, mid_exposure_at: Micros) -> Refusal {
        let settings = self.settings();
        let missing = |error: Option<PoseError>| error == Some(PoseError::NotYet);
        if missing(self.streams.attitude.at(mid_exposure_at, settings.gap_us).err()) {
            Refusal::NoAttitude
        } else if missing(self.streams.slant.at(mid_exposure_at, settings.range_gap_us).err()) {
            Refusal::NoRange
        } else {
            Refusal::NoFollowUp
        }
    }

    /// The newest position carried on with its velocity.
    fn predict(&self, at: Micros) -> Result<Prediction, Refusal> {
        let newest = self.streams.position.ok_or(Refusal::NoPosition)?;
        let age_us = at.since(newest.sampled_at);
        if age_us.unsigned_abs() > self.settings().position_age_us {
            return Err(Refusal::NoPosition);
        }
        let georeference = self.tile().georeference();
        let local = georeference.local(newest.position).ok_or(Refusal::OutsideReference)?;
        let seconds = age_us as f32 * 1e-6;
        // True north and east turned into the grid's: grid heading = true heading − convergence.
        let (s, c) = math::sin_cos(georeference.convergence.0);
        let (north, east) = (newest.north_m_per_s * seconds, newest.east_m_per_s * seconds);
        let local =
            Local { east_m: local.east_m + east * c - north * s, north_m: local.north_m + north * c + east * s };
        Ok(Prediction { local })
    }
}

impl Situation {
    /// The map for this situation: eq. 7 where the camera follows, eq. 3 otherwise.
    pub fn homography(&self, camera: &Camera) -> Homography {
        if self.followed {
            Homography::simplified(equivalent_tilt(self.attitude, self.follow_up), camera)
        } else {
            Homography::full(&camera_from_local(self.attitude, self.follow_up), camera)
        }
    }

    /// Patch size by eq. 4, rounded down, at most the build's; `None` when too small to be a template or the height
    /// is no height.
    pub fn patch_size(&self, camera: &Camera, resolution_m: f32) -> Option<(u16, u16)> {
        let (cols, rows) = camera.patch_size(self.height_m, resolution_m);
        let side = |px: f32| px.min(PATCH_MAX_PX as f32) as u16;
        (cols >= PATCH_MIN_PX && rows >= PATCH_MIN_PX).then(|| (side(cols), side(rows)))
    }
}

/// White noise is averaged by the interpolation, drift is not.
fn sigma_tilt(settings: &Settings, noise_factor: f32) -> f32 {
    hypot(settings.sigmas.tilt_white_rad * noise_factor, settings.sigmas.tilt_drift_rad)
}

fn hypot(a: f32, b: f32) -> f32 {
    math::sqrt(a * a + b * b)
}
