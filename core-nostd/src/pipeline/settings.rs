//! Settings of a flight.

use crate::budget::REACQUIRE_PX;
use crate::camera::Camera;
use crate::matching::AcceptRule;
use crate::mount::Mount;
use crate::pipeline::streams::Latencies;
use crate::pose::noise::{LAGS, NoiseModel, Wave};
use crate::pose::position::{PositionSigmas, Predictor};
use crate::pose::{Smoother, Wait};
use crate::units::Radians;

/// How the follow-up angle is obtained, and which model rectifies with it.
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

/// Sigmas of each source, by data sheet or calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sigmas {
    /// Pitch and roll, white noise of each sample, radians.
    pub tilt_white_rad: f32,
    /// Pitch and roll, slow drift that no interpolation reduces, radians.
    pub tilt_drift_rad: f32,
    /// Heading, white noise of each sample, radians.
    pub heading_white_rad: f32,
    /// Heading, drift, radians.
    pub heading_drift_rad: f32,
    /// Follow-up angle, radians.
    pub follow_up_rad: f32,
    /// Slant range, metres.
    pub range_m: f32,
    /// Position, each axis, white noise of each sample, metres.
    pub position_white_m: f32,
    /// Position, drift, metres: what the fixes are to correct.
    pub position_drift_m: f32,
    /// Velocity, each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Velocity with which the attitude's estimator compensates the centripetal acceleration of a turn, m/s; 0 for an
    /// attitude that needs none.
    pub turn_velocity_m_per_s: f32,
    /// Bias of the altitude against the elevation model, metres.
    pub altitude_m: f32,
    /// Scale error of the altitude.
    pub altitude_scale: f32,
}

/// Sampling and signal of a stream, by which, with the sigmas, its smoothing is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Nominal sampling interval, microseconds.
    pub interval_us: u32,
    /// Motions to be preserved: radians or metres; amplitude 0 for none.
    pub waves: [Wave; 2],
}

/// [`Motion`] of each stream that is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motions {
    /// Pitch and roll; the heading is smoothed as they are.
    pub attitude: Motion,
    /// East and north.
    pub position: Motion,
}

impl Default for Motions {
    /// A usual vehicle and its sensors: attitude at 200 Hz, positions at 5 Hz; turns of 10° in 4 s and a shake of 0.3°
    /// in 0.7 s; a weave of 30 m in 20 s.
    fn default() -> Self {
        let wave = |degrees, period_s| Wave { amplitude: Radians::from_degrees(degrees).0, period_s };
        let weave = Wave { amplitude: 30.0, period_s: 20.0 };
        Motions {
            attitude: Motion { interval_us: 5_000, waves: [wave(10.0, 4.0), wave(0.3, 0.7)] },
            position: Motion { interval_us: 200_000, waves: [weave, Wave::default()] },
        }
    }
}

/// The fits by the settings, computed once.
#[derive(Debug)]
pub(super) struct Smoothers {
    pub(super) attitude: Smoother<3>,
    pub(super) position: Predictor,
}

/// Why settings were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsError {
    /// The search radius is zero or larger than this build supports.
    Search,
    /// A sigma is negative or not a number.
    Sigma,
    /// A camera that follows has unequal fields of view per pixel.
    PixelsNotSquare,
    /// The frame memory is too small for a search.
    FrameMemory,
    /// A stream's interval or motion is impossible.
    Motion,
    /// A lever arm or a boresight is not finite, or the camera leans too far from its mount's axis.
    Mount,
    /// A readout longer than a second.
    Readout,
    /// A gap, an age, a patience or a latency is longer than a minute.
    Limit,
    /// The lag is longer than a window.
    Lag,
}

/// Settings of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The camera.
    pub camera: Camera,
    /// How the follow-up angle is obtained.
    pub follow_up: FollowUpMode,
    /// Mount of the camera.
    pub mount: Mount,
    /// Sigmas of the sources.
    pub sigmas: Sigmas,
    /// Sampling and motion of the fitted streams.
    pub motions: Motions,
    /// Latencies of the streams.
    pub latencies: Latencies,
    /// Rolling shutter: from the first row's mid-exposure to the last one's, microseconds; 0 for a global one.
    pub readout_us: u32,
    /// Number of samples by which the pose lags behind the newest: 2 give most of the benefit of smoothing.
    pub lag: u8,
    /// Largest gap between two attitude or follow-up samples to interpolate over, microseconds.
    pub gap_us: u32,
    /// Largest gap between two ranges to interpolate over, microseconds.
    pub range_gap_us: u32,
    /// Oldest position to predict from, microseconds.
    pub position_age_us: u32,
    /// How long a frame waits for its pose, microseconds after mid-exposure.
    pub patience_us: u32,
    /// Search radius, pixels of the reference. Beyond [`SEARCH_MAX_PX`](crate::budget::SEARCH_MAX_PX) every frame is
    /// searched coarse to fine, at several times the cost.
    pub search_px: u16,
    /// Acceptance test of a match.
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
        let angles = [s.tilt_white_rad, s.tilt_drift_rad, s.heading_white_rad, s.heading_drift_rad, s.follow_up_rad];
        let lengths = [s.range_m, s.position_white_m, s.position_drift_m, s.altitude_m, s.altitude_scale];
        let velocities = [s.velocity_m_per_s, s.turn_velocity_m_per_s];
        if !angles.iter().chain(&lengths).chain(&velocities).all(sound) {
            return Err(SettingsError::Sigma);
        }
        if !self.models().iter().all(|model| model.check().is_ok()) {
            return Err(SettingsError::Motion);
        }
        let (arm, turn) = (&self.mount.lever_arm, &self.mount.boresight);
        let is_within = |angle: Radians, most: f32| angle.0.abs() <= most;
        let is_mount = [arm.forward_m, arm.right_m, arm.down_m].iter().all(|length| length.is_finite())
            && is_within(turn.heading, TURN_MAX_RAD)
            && is_within(turn.pitch, LEAN_MAX_RAD)
            && is_within(turn.roll, LEAN_MAX_RAD);
        if !is_mount {
            return Err(SettingsError::Mount);
        }
        let Latencies { attitude_us, follow_up_us, range_us, position_us } = self.latencies;
        let limits = [self.gap_us, self.range_gap_us, self.position_age_us, self.patience_us];
        if ![attitude_us, follow_up_us, range_us, position_us].iter().chain(&limits).all(|us| *us <= LIMIT_MAX_US) {
            return Err(SettingsError::Limit);
        }
        if self.readout_us > READOUT_MAX_US {
            return Err(SettingsError::Readout);
        }
        if self.lag as usize >= LAGS {
            return Err(SettingsError::Lag);
        }
        if self.follow_up == FollowUpMode::Followed && !self.camera.has_square_pixels() {
            return Err(SettingsError::PixelsNotSquare);
        }
        Ok(())
    }

    /// Samples that the pose waits for: the end of the instant's own interval, and the lag.
    pub fn wait(&self) -> Wait {
        Wait::For(self.lag + 1)
    }

    /// Noise and motion of attitude and position.
    fn models(&self) -> [NoiseModel; 2] {
        let Motions { attitude, position } = self.motions;
        let model = |motion: Motion, white| NoiseModel { interval_us: motion.interval_us, white, waves: motion.waves };
        [model(attitude, self.sigmas.tilt_white_rad), model(position, self.sigmas.position_white_m)]
    }

    pub(super) fn smoothers(&self) -> Smoothers {
        let [attitude, position] = self.models();
        let s = &self.sigmas;
        let sigmas = PositionSigmas { drift_m: s.position_drift_m, velocity_m_per_s: s.velocity_m_per_s };
        Smoothers {
            attitude: Smoother::new(&attitude, [s.heading_white_rad, s.tilt_white_rad, s.tilt_white_rad]),
            position: Predictor::new(&position, sigmas),
        }
    }
}

/// Longest gap, age, patience and latency: a minute.
const LIMIT_MAX_US: u32 = 60_000_000;
/// Longest readout of a rolling shutter.
const READOUT_MAX_US: u32 = 1_000_000;
/// Largest pitch and roll of a camera in its mount: a head of a combined camera leans by 20 to 30 degrees; with 46 and
/// the vehicle's own tilt the horizon is near.
const LEAN_MAX_RAD: f32 = 0.8;
/// Any rotation about the axis: a head may stand on its side.
const TURN_MAX_RAD: f32 = core::f32::consts::PI;
