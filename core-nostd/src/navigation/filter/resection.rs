//! Resection while the attitude is in doubt: position and tilt by matches and by the perspective of their pictures.
//!
//! A match jumps if the attitude does, and if it is wrong itself or was before. The perspective of its picture tells them apart: corrected
//! for the tilt that this shows, the match lies where the position before leads, or it does not. So a second estimate takes both, the match
//! as it is and the position by resection, and only its tilt is unknown again after a jump.

use super::estimate::Estimate;
use super::measurement::{Measurement, PriorSigmas};
use super::{STEP_MAX_US, TRANSIENT_GATE};
use crate::math::{sqrt, squared};
use crate::navigation::reckoning::{JUMP_ONSET_US, Moment};
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Pictures within so long count as one, microseconds. Measured over 8 flights of 290 frames, four a second (patches of 24 and 35 pixels):
/// their errors are correlated by 0.6, 0.4, 0.1 and nothing after 0.25, 0.5, 1 and 2 s; twice the integral of that.
const INDEPENDENT_US: f32 = 0.9e6;
/// Longest interval between two pictures after which the tilt is known, microseconds. Chosen: beyond it an attitude may have swung there and
/// back.
pub(super) const GAP_US: i32 = 1_000_000;
/// Sigma of the tilt after a jump, each axis, radians. Chosen: half of the largest jump that is one of the tilt.
const JUMPED_RAD: f32 = 0.15;
/// Sigmas of tilt and velocity whose driving noise the estimate has, radians and m/s: with their time constants 0.3 degrees and 0.15 m/s in
/// a second. Chosen: as much as those of an autopilot wander.
const WANDERING_RAD: f32 = 0.037;
const WANDERING_M_PER_S: f32 = 0.3;
/// Change of the tilt that matches within the gate may hide, one sigma, radians in a second, as long after a jump as that takes; it falls
/// with the inverse of the time since. Chosen: three degrees. Without it slow swings of an attitude 0.3 s late passed for velocity, and the
/// position was off by four of its sigmas.
const SWING_RAD: f32 = 0.05;
/// Pictures in a row that contradict the estimate's position until it restarts. Chosen: one in forty does by chance.
const CONTRADICTIONS: u8 = 3;

/// A match corrected for the tilt that its picture shows.
#[derive(Clone, Copy, Debug)]
pub struct Resected {
    /// Displacement of the nadir by the correction, towards east and north, metres.
    pub by_m: Vector2<f32>,
    /// Covariance of the corrected nadir, square metres.
    pub covariance: Matrix2<f32>,
    /// Variance that pictures of the same ground have in common besides, each axis, square metres.
    pub common_variance: f32,
}

impl Resected {
    pub(super) fn is_valid(&self) -> bool {
        let is_finite = self.by_m.iter().chain(&self.covariance).all(|number| number.is_finite());
        let variances = [self.covariance[(0, 0)], self.covariance[(1, 1)]];
        is_finite && variances.into_iter().all(|variance| variance > 0.0) && self.common_variance >= 0.0
    }
}

/// The second estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resection {
    pub(super) moment: Moment,
    pub(super) estimate: Estimate,
    /// When a picture was taken last.
    pub(super) pictured_at: Micros,
    /// Since when the tilt has not jumped.
    pub(super) since: Micros,
    /// Time from the match before to the newest one, seconds.
    step_s: f32,
    /// Whether it jumped with the newest match.
    pub(super) has_jumped: bool,
    /// Pictures in a row that contradict the position.
    contradictions: u8,
    /// Variance of the tilt that pictures have in common, square radians.
    common_variance: f32,
}

impl Resection {
    /// Begins with a match and an unknown tilt.
    pub(super) fn begin(moment: Moment, measurement: &Measurement, prior: &PriorSigmas) -> Self {
        let unknown = PriorSigmas { tilt_rad: JUMPED_RAD, ..*prior };
        let estimate = Estimate::from_match(measurement, measurement.covariance, &unknown);
        // No picture before it has its error.
        let pictured_at = Micros(moment.at.0.saturating_sub(INDEPENDENT_US as u64));
        Resection { pictured_at, ..Resection::new(moment, estimate) }
    }

    pub(super) fn new(moment: Moment, estimate: Estimate) -> Self {
        let at = moment.at;
        Resection {
            moment,
            estimate,
            pictured_at: at,
            since: at,
            step_s: 0.0,
            has_jumped: false,
            contradictions: 0,
            common_variance: 0.0,
        }
    }

    /// Propagated to a moment; `None` after too long a gap.
    pub(super) fn propagated(mut self, moment: Moment, prior: &PriorSigmas) -> Option<Self> {
        let since_us = moment.at.since(self.moment.at);
        if !(0..STEP_MAX_US).contains(&since_us) {
            return None;
        }
        let wandering = PriorSigmas {
            tilt_rad: WANDERING_RAD,
            velocity_m_per_s: prior.velocity_m_per_s.min(WANDERING_M_PER_S),
            ..*prior
        };
        self.estimate.propagate((self.moment, moment), 0.0, None, &wandering);
        (self.moment, self.step_s) = (moment, since_us as f32 * 1e-6);
        if since_us >= GAP_US {
            self.forget_tilt();
        }
        Some(self)
    }

    /// From the newest match on the tilt is unknown.
    fn forget_tilt(&mut self) {
        self.since = self.moment.at;
        self.estimate = self.estimate.with_tilt(self.estimate.tilt_rad(), JUMPED_RAD);
    }

    /// Updated by a match; with an unknown tilt if that has jumped.
    pub(super) fn matched(mut self, measurement: &Measurement) -> Self {
        let white = measurement.covariance;
        self.has_jumped = self.estimate.innovation(measurement, white).nis > TRANSIENT_GATE;
        if self.has_jumped {
            self.forget_tilt();
        } else {
            let onset_us = JUMP_ONSET_US as f32;
            let share = onset_us / (onset_us + self.moment.at.since(self.since) as f32);
            self.estimate = self.estimate.with_tilt_noise(SWING_RAD * share * sqrt(self.step_s));
        }
        let innovation = self.estimate.innovation(measurement, white);
        Resection { estimate: self.estimate.updated(&innovation), ..self }
    }

    /// Updated by the picture of that match; `None` if pictures contradict it.
    pub(super) fn resected(mut self, resected: &Resected, measurement: &Measurement) -> Option<Self> {
        let nadir = measurement.nadir.moved(resected.by_m.into());
        let common = Matrix2::identity() * resected.common_variance;
        let covariance = resected.covariance + common;
        if self.estimate.position_innovation(nadir, covariance).nis > TRANSIENT_GATE {
            self.contradictions += 1;
            return Some(self).filter(|resection| resection.contradictions < CONTRADICTIONS);
        }
        let since_us = self.moment.at.since(core::mem::replace(&mut self.pictured_at, self.moment.at));
        let share = (INDEPENDENT_US / since_us.max(1) as f32).max(1.0);
        let innovation = self.estimate.position_innovation(nadir, resected.covariance * share + common);
        let common_variance = resected.common_variance / squared(measurement.height_m);
        Some(Resection { estimate: self.estimate.updated(&innovation), contradictions: 0, common_variance, ..self })
    }

    /// Position and its covariance, with what pictures have in common, seen from a height in metres.
    pub(super) fn position(&self, height_m: f32) -> (Local, Matrix2<f32>) {
        let (local, covariance) = self.estimate.position();
        (local, covariance + Matrix2::identity() * (self.common_variance * squared(height_m)))
    }

    pub(super) fn tilt_rad(&self) -> Vector2<f32> {
        self.estimate.tilt_rad().into()
    }

    pub(super) fn tilt_variance(&self) -> f32 {
        squared(self.estimate.tilt_sigma_rad()) + self.common_variance
    }

    /// Whether this tilt may be the estimated one, radians.
    pub(super) fn is_near(&self, rad: &Vector2<f32>) -> bool {
        (self.tilt_rad() - rad).norm_squared() <= TRANSIENT_GATE * self.tilt_variance()
    }
}
