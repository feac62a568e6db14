//! The tilt that the perspective of pictures shows while the attitude is in doubt.
//!
//! A single picture shows it to about a degree, and only its own: an attitude that swings passes its right value now and
//! then. So the tilts of consecutive pictures are averaged, for as long as they agree. Once their mean agrees with the
//! tilt before the doubt, it is the attitude that is right again: the filter restarts with it.

use super::Filter;
use super::innovation_test::TRANSIENT_MAX_RAD;
use super::jumps::PERIOD_US;
use super::measurement::{Measurement, PriorSigmas, tilt_jacobian};
use super::{HIDDEN_M_PER_S, TRANSIENT_GATE};
use crate::math::{combined_sigma, sqrt, squared};
use crate::navigation::reckoning::{JUMP_ONSET_US, Moment, displacement_m};
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Consecutive pictures count as so many independent ones at most. Measured over 8 flights of 290 frames, four a second
/// (patches of 24 and 35 pixels): their errors are correlated by 0.6, 0.4, 0.1 and nothing after 0.25, 0.5, 1 and 2 s.
const INDEPENDENT: f32 = 1.5;
/// Longest interval between two of them, microseconds. Chosen: beyond, an attitude may have swung there and back.
const GAP_US: i32 = 1_000_000;

/// The tilt that a picture shows, beyond the one that its frame was corrected for.
#[derive(Clone, Copy, Debug)]
pub struct ShownTilt {
    /// Displacement of the nadir by it, towards east and north, per metre of height: radians.
    pub along: Vector2<f32>,
    /// Its covariance, square radians.
    pub covariance: Matrix2<f32>,
}

/// A picture's tilt, and where its match is.
#[derive(Clone, Copy, Debug)]
struct Picture {
    moment: Moment,
    /// Nadir as if the frame had been corrected for the tilt before the doubt.
    nadir: Local,
    /// Variance of that without the tilt, each axis, square metres.
    nadir_variance: f32,
    /// Pitch and roll, radians, and the larger variance of either, square radians.
    rad: Vector2<f32>,
    variance: f32,
}

/// Mean of the tilts that consecutive pictures show.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeanTilt {
    since: Micros,
    /// The newest picture's moment.
    moment: Moment,
    /// A match of at most [`GAP_US`] ago, propagated to that moment: its instant, nadir, and variance as of a picture.
    from_at: Micros,
    from: Local,
    from_variance: f32,
    /// Pitch and roll, radians, and the larger variance of either, square radians.
    rad: Vector2<f32>,
    variance: f32,
    /// The least variance of one picture.
    single: f32,
}

impl MeanTilt {
    fn new(picture: Picture) -> Self {
        let Picture { moment, nadir, nadir_variance, rad, variance } = picture;
        let (since, from_at) = (moment.at, moment.at);
        MeanTilt { since, moment, from_at, from: nadir, from_variance: nadir_variance, rad, variance, single: variance }
    }

    /// Propagated to another picture; `None` after too long a gap.
    fn propagated(self, picture: &Picture) -> Option<Self> {
        if !(0..GAP_US).contains(&picture.moment.at.since(self.moment.at)) {
            return None;
        }
        let from = self.from.moved(displacement_m(self.moment, picture.moment));
        Some(MeanTilt { moment: picture.moment, from, ..self })
    }

    /// Whether a picture's match lies where the velocity leads: a tilt that swings moves it.
    fn is_steady(&self, picture: &Picture, sigma_m_per_s: f32) -> bool {
        let drift_m = sigma_m_per_s * picture.moment.at.since(self.from_at) as f32 * 1e-6;
        let variance = self.from_variance + picture.nadir_variance + squared(drift_m);
        squared(picture.nadir.off_m(self.from)) <= TRANSIENT_GATE * variance
    }

    /// With another picture's: their weighted mean, or that picture's alone if they disagree.
    fn with(self, picture: Picture) -> Self {
        let Picture { moment, nadir, nadir_variance, rad, variance } = picture;
        let off = rad - self.rad;
        if off.norm_squared() > TRANSIENT_GATE * (self.variance + variance) {
            return MeanTilt::new(picture);
        }
        let gain = self.variance / (self.variance + variance);
        let single = self.single.min(variance);
        let mean = self.variance * (1.0 - gain);
        let is_old = moment.at.since(self.from_at) >= GAP_US;
        let (from_at, from, from_variance) =
            if is_old { (moment.at, nadir, nadir_variance) } else { (self.from_at, self.from, self.from_variance) };
        MeanTilt {
            from_at,
            from,
            from_variance,
            rad: self.rad + off * gain,
            variance: mean.max(single / INDEPENDENT),
            single,
            ..self
        }
    }

    /// Whether a tilt is the one shown.
    fn is(&self, rad: &Vector2<f32>, gate: f32) -> bool {
        (self.rad - rad).norm_squared() <= gate * self.variance
    }
}

/// What pictures show of the tilt while the attitude is in doubt, and for some time after.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownTilts {
    mean: Option<MeanTilt>,
    /// When they showed that the attitude was right again.
    right_at: Option<Micros>,
}

impl ShownTilts {
    pub(super) const fn new() -> Self {
        ShownTilts { mean: None, right_at: None }
    }
}

impl Filter {
    /// Whether the attitude was in doubt a moment ago: what swings would be off again within that time.
    pub fn was_in_doubt(&self) -> bool {
        self.shown.right_at.is_some_and(|at| (0..PERIOD_US).contains(&self.moment.at.since(at)))
    }

    /// The attitude is not in doubt.
    pub fn attitude_is_known(&mut self) {
        self.shown = ShownTilts::new();
    }

    /// Takes the tilt that the newest frame's picture shows, after its match, while the attitude is in doubt or was a
    /// moment ago. `is_in_doubt`: which of them. `known_rad`: sigma of a tilt with which frames have fixes.
    pub fn attitude_shown(
        &mut self,
        shown: &ShownTilt,
        (is_in_doubt, known_rad): (bool, f32),
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) {
        let jacobian = tilt_jacobian(measurement) / measurement.height_m;
        let rad = Vector2::from(measurement.corrected_tilt_rad) + jacobian.transpose() * shown.along;
        let variance = shown.covariance.diagonal().max();
        // A NaN is no variance.
        let is_valid = variance > 0.0 && rad.iter().all(|rad| rad.is_finite());
        if !is_valid {
            return;
        }
        let nadir = measurement.with_tilt(self.jumps.before_rad()).nadir;
        let nadir_variance = measurement.covariance.diagonal().max();
        let picture = Picture { moment: self.moment, nadir, nadir_variance, rad, variance };
        let sigma_m_per_s = prior.velocity_m_per_s.min(HIDDEN_M_PER_S);
        let propagated = self.shown.mean.and_then(|mean| mean.propagated(&picture));
        let steady = propagated.filter(|mean| mean.is_steady(&picture, sigma_m_per_s));
        let mean = steady.map_or(MeanTilt::new(picture), |mean| mean.with(picture));
        self.shown.mean = Some(mean);
        if is_in_doubt {
            // An attitude is fitted over its samples for as long.
            if self.moment.at.since(mean.since) >= JUMP_ONSET_US {
                self.restart_as_shown(&mean, known_rad, measurement, prior);
            }
            return;
        }
        let right_rad = Vector2::from(self.matched_tilt_rad());
        if propagated.is_some() && steady.is_none() {
            self.transient_rad = TRANSIENT_MAX_RAD;
            return;
        }
        let off_rad = if mean.is(&right_rad, TRANSIENT_GATE) { 0.0 } else { (mean.rad - right_rad).norm() };
        self.transient_rad = self.transient_rad.max(off_rad).max(sqrt(mean.variance));
    }

    /// Restarts from a match with the tilt before the doubt, if that is the one that pictures show; otherwise with the
    /// shown one, if the estimated one is not: the next frames are corrected for it.
    fn restart_as_shown(&mut self, mean: &MeanTilt, known_rad: f32, measurement: &Measurement, prior: &PriorSigmas) {
        let sigma_rad = sqrt(mean.variance);
        let right = self.jumps.means().find(|right| mean.is(right, TRANSIENT_GATE));
        if let Some(right_rad) = right.filter(|_| sigma_rad <= known_rad) {
            self.jumps.end(right_rad.into());
            (self.transient_rad, self.before_swing_rad) = (sigma_rad, sigma_rad);
            self.shown.right_at = Some(mean.moment.at);
            self.start(&measurement.with_tilt(right_rad.into()), prior);
        } else if right.is_none() && !mean.is(&self.matched_tilt_rad().into(), TRANSIENT_GATE) {
            let prior = PriorSigmas { tilt_rad: combined_sigma(prior.tilt_rad, sigma_rad), ..*prior };
            self.start(&measurement.with_tilt(mean.rad.into()), &prior);
        }
    }
}
