//! What is decided before a flight.

use crate::budget::REACQUIRE_PX;
use crate::camera::Camera;
use crate::matching::judge::AcceptRule;

/// How the camera follows, and which model rectifies it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FollowUpMode {
    /// The servo follows exactly: eq. 7 with the equivalent pitch and roll.
    Followed,
    /// The servo lags and its encoder is read: eq. 3 with the follow-up angle interpolated to mid-exposure.
    Measured,
    /// The camera is fixed to the body: eq. 3 with β = 0.
    Fixed,
}

/// One sigma of each source, as its data sheet or calibration says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sigmas {
    /// Pitch and roll, the part that is new in every sample, radians.
    pub tilt_white_rad: f32,
    /// Pitch and roll, the part that drifts slowly and no interpolation reduces, radians.
    pub tilt_drift_rad: f32,
    /// Heading, radians.
    pub heading_rad: f32,
    /// Follow-up angle, radians.
    pub follow_up_rad: f32,
    /// Slant range, metres.
    pub range_m: f32,
}

/// Why settings were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsError {
    /// The search radius is zero or larger than this build holds.
    Search,
    /// A sigma is negative or not a number.
    Sigma,
    /// Eq. 7 was asked for with unequal fields of view per pixel.
    NotIsotropic,
    /// The frame memory is too small for a search.
    FrameMemory,
}

/// Settings of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The camera.
    pub camera: Camera,
    /// How it follows.
    pub follow_up: FollowUpMode,
    /// What the sources are worth.
    pub sigmas: Sigmas,
    /// Largest distance of two attitude or follow-up samples to interpolate between, microseconds.
    pub gap_us: u32,
    /// Largest distance of two ranges to interpolate between, microseconds.
    pub range_gap_us: u32,
    /// Oldest position to predict from, microseconds.
    pub position_age_us: u32,
    /// How long a frame waits for its pose, microseconds after mid-exposure.
    pub patience_us: u32,
    /// Search radius, pixels of the reference. Beyond [`SEARCH_MAX_PX`](crate::budget::SEARCH_MAX_PX) every frame is searched
    /// from coarse to fine, at some times the cost.
    pub search_px: u16,
    /// When a match becomes a fix.
    pub accept: AcceptRule,
}

impl Settings {
    /// # Errors
    /// [`SettingsError`].
    pub fn check(&self) -> Result<(), SettingsError> {
        if !(1..=REACQUIRE_PX).contains(&(self.search_px as usize)) {
            return Err(SettingsError::Search);
        }
        let s = &self.sigmas;
        let sound = |sigma: &f32| sigma.is_finite() && *sigma >= 0.0;
        if ![s.tilt_white_rad, s.tilt_drift_rad, s.heading_rad, s.follow_up_rad, s.range_m].iter().all(sound) {
            return Err(SettingsError::Sigma);
        }
        if self.follow_up == FollowUpMode::Followed && !self.camera.is_isotropic() {
            return Err(SettingsError::NotIsotropic);
        }
        Ok(())
    }
}
