//! From the stamped streams to the situation at mid-exposure.

use super::{FollowUpMode, Pipeline, Prediction, Situation};
use crate::budget::PATCH_MAX_PX;
use crate::math::{combined_sigma, hypot, sqrt, squared};
use crate::motion::Rates;
use crate::navigation::candidates::{Candidate, candidates};
use crate::navigation::filter::PriorSigmas;
use crate::navigation::heights::Height;
use crate::pose::position::PositionState;
use crate::pose::{Estimate, Interpolated, Method, PoseError, Wait};
use crate::tile::Local;
use crate::tilt::{Attitude, follow_up_command};
use crate::units::{Micros, Radians};

/// Why there is no situation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SituateError {
    /// No attitude at mid-exposure.
    Attitude(PoseError),
    /// No follow-up angle.
    FollowUp(PoseError),
    /// No slant range.
    Range(PoseError),
    /// No position to predict from.
    Position(PoseError),
    /// The optical axis is too near the horizon, or the attitude is not a number.
    Tilt,
    /// The newest position lies where the tile's georeference does not reach.
    OffTheMap,
}

/// A follow-up angle, its rate per second and its sigma.
struct FollowUp {
    angle: Radians,
    rate: f32,
    sigma_rad: f32,
}

/// Sigmas of pitch and roll, each, and of the heading, radians.
struct Uncertainty {
    tilt_rad: f32,
    /// The tilt's drifting part.
    tilt_drift_rad: f32,
    /// White noise of heading and follow-up angle.
    heading_rad: f32,
    /// The heading's drifting part, without an estimate of it.
    heading_drift_rad: f32,
}

/// Standard gravity (ISO 80000-3).
const G_M_PER_S2: f32 = 9.806_65;
/// Time within which an estimator removes an error of its velocity, seconds: ArduPlane 4.8, off by 5 m/s after 40 s
/// without fixes, was then off by up to 5.9 degrees.
const VELOCITY_REMOVED_S: f32 = 15.0;
/// Heading error of a level compass per radian of tilt: the tangent of the inclination of the Earth's magnetic field.
/// Chosen: that of 63 degrees, as in middle latitudes; it is less towards the equator and more towards the poles.
const HEADING_PER_TILT: f32 = 2.0;
/// Smallest a22 allowed: 70° between optical axis and plumb line, where a field of view of 60° begins at 40°. Chosen.
pub(super) const COS_TILT_MIN: f32 = 0.34;

/// Swing of the autopilot's pitch and roll while its estimator changes from satellites to fixes: sigma as a multiple of
/// the configured drift. Measured over 36 flights that were kept by their fixes (consumer inertial sensors, two fixes a
/// second): 0.20 degrees RMS, and after the loss of satellites 0.26, 0.32, 0.36, 0.37, 0.33, 0.29 and 0.28 every two
/// seconds.
const SWING_FACTOR: f32 = 1.5;
/// Largest sigma of that swing, radians: half a degree. Chosen: a larger drift than in these flights may be a camera's
/// that leans, which does not swing.
const SWING_MAX_RAD: f32 = 0.009;

/// Sigmas of the heading beyond which a rotation may be the encoder's. Chosen: a normal error is beyond once in 400. From one sigma on an attitude
/// that was off by a degree from the beginning was found later or not at all.
const ENCODER_SIGMAS: f32 = 3.0;

/// Least number of the candidate, which counts the frames without a match, from which on every other frame is corrected
/// for the tilt before the learnt one. Chosen: two are missed by chance.
const CANDIDATE_MIN: u8 = 3;

/// The result of a stream; `Ok(None)` if it is not yet there and may be waited for.
fn awaited<T>(result: Result<T, PoseError>, wait: Wait) -> Result<Option<T>, PoseError> {
    match result {
        Err(PoseError::NotYet) if wait != Wait::No => Ok(None),
        result => result.map(Some),
    }
}

impl Pipeline<'_> {
    /// The situation at mid-exposure, an instant with its sigma in microseconds. `Ok(None)`: a stream's next samples
    /// have not arrived yet. Try again when they have, within the configured patience; then with [`Wait::No`], which
    /// never returns `Ok(None)`.
    ///
    /// # Errors
    /// [`SituateError`] if waiting does not help.
    // Inlined, its working memory would lie on the stack below that of a match; so would those of the other stages.
    #[inline(never)]
    pub fn situate(
        &mut self,
        (mid_exposure_at, sigma_us): (Micros, f32),
        wait: Wait,
    ) -> Result<Option<Situation>, SituateError> {
        let Some(attitude) = self.attitude_at(mid_exposure_at, wait)? else { return Ok(None) };
        let [offset_north_m, _, offset_east_m] = self.settings.mount.camera_offset(attitude.value);
        let camera_offset_m = [offset_east_m, offset_north_m];
        let (prediction, position_method) = self.predict(mid_exposure_at, camera_offset_m)?;
        let slant = self.slant_at(mid_exposure_at, prediction.local, wait);
        let Some(slant) = awaited(slant, wait).map_err(SituateError::Range)? else { return Ok(None) };
        let follow_up = awaited(self.follow_up(mid_exposure_at, &attitude), wait);
        let Some(follow_up) = follow_up.map_err(SituateError::FollowUp)? else { return Ok(None) };
        let sigma_s = sigma_us * 1e-6;
        let prior_sigmas = self.prior_sigmas();
        self.navigation.filter.propagate(mid_exposure_at, &prior_sigmas);
        let number = self.navigation.candidate;
        // Over a map of another year a frame is evidence for the surface although it is not matched alone.
        let is_lost = self.navigation.surface.map_year.is_own() && number >= CANDIDATE_MIN && number % 2 == 1;
        self.navigation.filter.try_other_tilt(is_lost, &prior_sigmas);
        let sigmas = self.uncertainty(&attitude, &follow_up, sigma_s);
        let range = slant.map(|slant| self.range(&slant, attitude.value, prediction.local, sigmas.tilt_rad));
        let azimuth = self.navigation.azimuth.at(mid_exposure_at, attitude.value.heading, sigmas.heading_drift_rad);
        let height = self.height(mid_exposure_at, range, &prediction);
        let height = height.ok_or(SituateError::Range(PoseError::TooOld))?;
        self.navigation.azimuth = azimuth;
        let [pitch_off, roll_off] = self.navigation.filter.tilt_rad();
        let settings = &self.settings;
        let heading_rad = hypot(sqrt(azimuth.variance()), sigmas.heading_rad);
        let ([turn, scale], is_candidate) = self.candidate(height, heading_rad);
        let used = attitude.value.corrected_by([azimuth.off_rad() - turn.off, pitch_off, roll_off]);
        let height_m = height.metres * (1.0 + scale.off);
        let ([heading, pitch, roll], [_, pitch_sigma, roll_sigma]) = (attitude.rate, attitude.rate_sigma);
        Ok(Some(Situation {
            mid_exposure_at,
            attitude: used,
            follow_up: follow_up.angle,
            followed: settings.follow_up == FollowUpMode::Followed && used == attitude.value,
            mount: settings.mount,
            rates: Rates { heading, pitch, roll, follow_up: follow_up.rate },
            sigma_rate_rad_s: pitch_sigma.max(roll_sigma),
            height_m,
            slope: self.navigation.plane.map_or([0.0; 2], |plane| plane.slope),
            relief_m: self.navigation.plane.map_or(0.0, |plane| plane.relief_m),
            prediction,
            camera_offset_m,
            sigma_tilt_rad: sigmas.tilt_rad,
            sigma_tilt_drift_rad: sigmas.tilt_drift_rad,
            sigma_heading_rad: turn.sigma,
            sigma_height_m: scale.sigma * height_m,
            is_candidate,
            sigma_stamp_s: sigma_s,
            attitude_method: attitude.method,
            position_method,
        }))
    }

    /// The attitude at an instant, of a camera that sees the ground below; `Ok(None)` while its next samples have not
    /// arrived.
    fn attitude_at(&self, at: Micros, wait: Wait) -> Result<Option<Estimate<Attitude, 3>>, SituateError> {
        let history = self.streams.attitude.history();
        let attitude = self.smoothers.attitude.at(history, at, self.settings.gap_us, wait);
        // A frame that waits for a follow-up angle in vain may wait until the attitudes around it are gone.
        if let Err(PoseError::TooOld) = attitude
            && let Err(error) = self.measured_follow_up(at)
        {
            return Err(SituateError::FollowUp(error));
        }
        let Some(attitude) = awaited(attitude, wait).map_err(SituateError::Attitude)? else { return Ok(None) };
        let sees = attitude.value.looks_down() && attitude.value.cos_tilt() >= COS_TILT_MIN;
        if sees { Ok(Some(attitude)) } else { Err(SituateError::Tilt) }
    }

    /// Sigmas of attitude and heading at an instant with sigma `sigma_s`, which counts by the rates. The fit averages
    /// white noise, not drift.
    ///
    /// The heading error of a compass that is levelled by an attitude is [`HEADING_PER_TILT`] times the tilt's error.
    fn uncertainty(&self, attitude: &Estimate<Attitude, 3>, follow_up: &FollowUp, sigma_s: f32) -> Uncertainty {
        let sigmas = &self.settings().sigmas;
        let [heading, pitch, roll] = attitude.rate;
        // The attitude's own stamps contribute as the instant does. They are rounded independently, so a fit averages
        // some of that, depending on its weights; none is assumed.
        let apart_s = hypot(sigma_s, self.streams.attitude.stamp_sigma_s());
        let late = |sigma: f32, rate: f32| hypot(sigma, rate * apart_s);
        let tilt = late(attitude.sigma[1], pitch).max(late(attitude.sigma[2], roll));
        let by_velocity = self.tilt_by_velocity(heading);
        let left_rad = combined_sigma(self.navigation.filter.tilt_sigma_rad(&self.prior_sigmas()), by_velocity);
        let heading_drift = combined_sigma(sigmas.heading_drift_rad, self.added_sigmas.heading_rad);
        let heading_drift_rad = combined_sigma(heading_drift, HEADING_PER_TILT * by_velocity);
        // The estimated error of pitch and roll may be the mount's, and the rotation of matches the encoder's. Both lean with the vehicle, and
        // displace the nadir by their product with the lean.
        let [pitch_off, roll_off] = self.navigation.filter.tilt_rad();
        let aboard_rad = combined_sigma(hypot(pitch_off, roll_off), self.encoder_off_rad(heading_drift_rad));
        let lean = hypot(attitude.value.pitch.0, attitude.value.roll.0);
        let tilt_drift_rad = combined_sigma(left_rad, aboard_rad * lean);
        let heading_sigma = late(attitude.sigma[0], heading - follow_up.rate);
        let tilt_rad = hypot(tilt, tilt_drift_rad);
        let heading_rad = hypot(heading_sigma, follow_up.sigma_rad);
        Uncertainty { tilt_rad, tilt_drift_rad, heading_rad, heading_drift_rad }
    }

    /// What the rotation of matches shows beyond the heading's errors, radians, if there is an encoder: it may be the encoder's error. A camera
    /// turned about its axis sees the nadir off by that angle times the lean, and a wrong heading does not move it; the picture is the same.
    fn encoder_off_rad(&self, heading_sigma_rad: f32) -> f32 {
        let is_measured = self.settings.follow_up == FollowUpMode::Measured;
        let beyond = squared(self.navigation.azimuth.off_rad()) - squared(ENCODER_SIGMAS * heading_sigma_rad);
        if is_measured { sqrt(beyond.max(0.0)) } else { 0.0 }
    }

    /// Prior sigmas of the filter's states.
    pub(super) fn prior_sigmas(&self) -> PriorSigmas {
        let sigmas = &self.settings.sigmas;
        let velocity_m_per_s = hypot(sigmas.velocity_m_per_s, self.navigation.velocity.m_per_s());
        PriorSigmas {
            velocity_m_per_s: combined_sigma(velocity_m_per_s, self.added_sigmas.velocity_m_per_s),
            tilt_rad: sigmas.tilt_drift_rad,
            extra_wander_rad: if self.navigation.is_changing {
                (SWING_FACTOR * sigmas.tilt_drift_rad).min(SWING_MAX_RAD)
            } else {
                0.0
            },
        }
    }

    /// Height by a slant range: H = s cos t over level ground, with an error of s sin t per radian of tilt.
    fn range(&self, slant: &Interpolated<f32, 1>, attitude: Attitude, nadir: Local, tilt_rad: f32) -> Height {
        let cos_tilt = attitude.cos_tilt();
        let range_m = self.settings.sigmas.range_m * slant.noise_factor();
        let lean_m = slant.value * sqrt((1.0 - cos_tilt * cos_tilt).max(0.0)) * tilt_rad;
        let sigma_m = hypot(range_m, lean_m);
        let Some(plane) = self.navigation.plane else {
            return Height { metres: slant.value * cos_tilt, sigma_m };
        };
        // On a slope the beam lands higher or lower, by the slope times s cos t per radian.
        let climb_m = slant.value * cos_tilt * hypot(plane.slope[0], plane.slope[1]) * tilt_rad;
        Height {
            metres: self.height_above(&plane, slant.value, attitude, nadir),
            sigma_m: combined_sigma(sigma_m, climb_m),
        }
    }

    /// Rotation and scale that this frame is rectified with, and whether they are one of several candidates.
    fn candidate(&self, height: Height, heading_rad: f32) -> ([Candidate; 2], bool) {
        let (cols, rows) = self.settings.camera.patch_size(height.metres, self.tile.ground_resolution().0);
        let half_px = 0.5 * cols.max(rows).min(PATCH_MAX_PX as f32);
        candidates(self.navigation.candidate, heading_rad, height.sigma_m / height.metres, half_px)
    }

    /// Sigma of the tilt by the error of the velocity that the autopilot's attitude is computed with.
    ///
    /// In a turn at ω its centripetal acceleration is subtracted: a velocity error v is an acceleration error ω v
    /// across, so a tilt of ω v / g. An estimator that observes an error v removes it by tilting, within a time T: v /
    /// (g T).
    fn tilt_by_velocity(&self, turn_rad_per_s: f32) -> f32 {
        let sigma_m_per_s = self.settings().sigmas.turn_velocity_m_per_s;
        if sigma_m_per_s <= 0.0 {
            return 0.0;
        }
        let seen_m_per_s = self.navigation.velocity.m_per_s();
        let turning = turn_rad_per_s.abs() * hypot(sigma_m_per_s, seen_m_per_s);
        hypot(turning, seen_m_per_s / VELOCITY_REMOVED_S) / G_M_PER_S2
    }

    /// The follow-up angle at an instant.
    ///
    /// # Errors
    /// [`PoseError`].
    fn follow_up(&self, at: Micros, attitude: &Estimate<Attitude, 3>) -> Result<FollowUp, PoseError> {
        let sigma_rad = self.settings.sigmas.follow_up_rad;
        Ok(match (self.measured_follow_up(at)?, self.settings.follow_up) {
            (Some(found), _) => {
                FollowUp { angle: found.value, rate: found.rate[0], sigma_rad: sigma_rad * found.noise_factor() }
            }
            (None, FollowUpMode::Fixed) => FollowUp { angle: Radians(0.0), rate: 0.0, sigma_rad: 0.0 },
            // A servo that follows exactly turns with the heading, but for terms of the tilt's square.
            (None, _) => FollowUp { angle: follow_up_command(attitude.value), rate: attitude.rate[0], sigma_rad },
        })
    }

    /// The measured angle; `Ok(None)` if none is measured.
    fn measured_follow_up(&self, at: Micros) -> Result<Option<Interpolated<Radians, 1>>, PoseError> {
        if self.settings.follow_up != FollowUpMode::Measured {
            return Ok(None);
        }
        // Linear: its noise rotates the patch about the nadir, which matching estimates, and moves the fix by that times the lean only.
        self.streams.follow_up.history().at(at, self.settings.gap_us).map(Some)
    }

    /// Position and velocity of the camera near the newest samples: the newest position propagated with its velocity,
    /// and the lever arm by the newest attitude. `None` without them.
    pub fn camera_at(&self, at: Micros) -> Option<PositionState> {
        if self.is_off_the_map {
            return None;
        }
        let (_, attitude) = self.streams.attitude.history().newest()?;
        let [north_m, _, east_m] = self.settings().mount.camera_offset(attitude);
        let (history, age_us) = (self.streams.position.history(), self.settings().position_age_us);
        let state = self.smoothers.position.propagated_to(history, at, age_us).ok()?.state;
        Some(PositionState { east_m: state.east_m + east_m, north_m: state.north_m + north_m, ..state })
    }

    /// Predicted position of the camera: the navigation's, propagated, plus the lever arm.
    fn predict(&self, at: Micros, offset_m: [f32; 2]) -> Result<(Prediction, Method), SituateError> {
        if self.is_off_the_map {
            return Err(SituateError::OffTheMap);
        }
        let history = self.streams.position.history();
        let age_us = self.settings().position_age_us;
        let predicted = self.smoothers.position.at(history, at, age_us).map_err(SituateError::Position)?;
        let state = predicted.state;
        let [east_m, north_m] = offset_m;
        let local = Local { east_m: state.east_m + east_m, north_m: state.north_m + north_m };
        let velocity_m_per_s = [state.east_m_per_s, state.north_m_per_s];
        let sigma_m = combined_sigma(predicted.sigma_m, self.added_sigmas.position_m);
        Ok((Prediction { local, velocity_m_per_s, sigma_m }, predicted.method))
    }
}
