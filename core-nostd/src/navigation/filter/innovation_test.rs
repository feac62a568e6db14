//! Innovation test of a match, and the prediction without it.

use super::estimate::{Estimate, Innovation};
use super::measurement::{Measurement, PriorSigmas};
use super::{Filter, JUMP_GATE, TRANSIENT_GATE, VELOCITY_KNOWN_M_PER_S};
use crate::math::{sqrt, squared};
use crate::navigation::reckoning::JUMP_ONSET_US;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Gate of a repeated transient: normal errors exceed it once in ten.
const REPEAT_GATE: f32 = 4.6;
/// Largest transient tilt, radians; more is a jump. Chosen: that of an attitude 0.3 s late of a vehicle that rocks by
/// 20 degrees a second.
pub(super) const TRANSIENT_MAX_RAD: f32 = 0.1;

/// The prediction without the newest match, relative to the estimate with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prediction {
    /// Its position less the estimate's, east and north, metres.
    pub(super) off_m: Vector2<f32>,
    /// Its covariance less the estimate's, square metres.
    pub(super) extra_covariance: Matrix2<f32>,
}

impl Prediction {
    pub(super) fn new(expected: &Estimate, matched: &Estimate) -> Self {
        let ((was, large), (is, small)) = (expected.position(), matched.position());
        Prediction { off_m: is.to(was).into(), extra_covariance: large - small }
    }
}

/// Result of the innovation test.
#[allow(clippy::large_enum_variant, reason = "no heap to put the large one on, and one at a time is made")]
pub(super) enum Outcome {
    /// Consistent, with an additional transient tilt in radians: the updated estimate, and the innovation that updated
    /// it.
    Consistent { estimate: Estimate, innovation: Innovation, more_rad: f32 },
    /// An outlier: tilt or position has jumped by this innovation, east and north, metres.
    Outlier(Vector2<f32>),
}

impl Filter {
    /// Tests a match against an estimate; a transient tilt that it shows is kept. `plain`: the match's innovation
    /// without a transient tilt, so that a constant one is seen in each match.
    pub(super) fn test_innovation(
        &mut self,
        at: Micros,
        estimate: &Estimate,
        (measurement, plain): (&Measurement, &Innovation),
        prior: &PriorSigmas,
    ) -> Outcome {
        let swings = plain.nis > TRANSIENT_GATE && plain.excess_tilt_rad > self.transient_rad;
        let was_calm = self.transient_rad <= prior.tilt_rad;
        if swings && !(0..JUMP_ONSET_US).contains(&at.since(self.swing_at)) {
            (self.swing_at, self.before_swing_rad) = (at, self.transient_rad);
        }
        // What has swung lately may swing on with its amplitude. What the next match repeats may be constant, if it
        // cannot be the velocity's error.
        let is_more = self.before_swing_rad <= prior.tilt_rad.max(0.5 * plain.excess_tilt_rad);
        let is_velocity_known =
            estimate.velocity().iter().all(|(_, variance)| *variance <= squared(VELOCITY_KNOWN_M_PER_S));
        let is_repeated = plain.nis > REPEAT_GATE && (1..JUMP_ONSET_US).contains(&at.since(self.swing_at));
        let may_last = is_velocity_known && is_more && is_repeated;
        if swings && was_calm && self.jumps.likely_return(at, estimate, measurement, prior).is_some() {
            return Outcome::Outlier(plain.off);
        }
        let innovation = estimate.innovation(measurement, self.white(measurement));
        if innovation.nis > JUMP_GATE || swings && plain.excess_tilt_rad > TRANSIENT_MAX_RAD {
            return Outcome::Outlier(innovation.off);
        }
        if !swings && !may_last {
            return self.consistent(estimate, measurement, innovation, 0.0);
        }
        let inflated = if may_last { estimate.inflated(self.transient_rad, measurement) } else { *estimate };
        let mut more_rad = 0.0;
        if swings {
            more_rad = sqrt(squared(plain.excess_tilt_rad) - squared(self.transient_rad));
            self.transient_rad = plain.excess_tilt_rad;
        }
        self.consistent(&inflated, measurement, inflated.innovation(measurement, self.white(measurement)), more_rad)
    }

    /// The estimate updated by a consistent match, with its covariance inflated for correlated errors.
    fn consistent(
        &self,
        estimate: &Estimate,
        measurement: &Measurement,
        innovation: Innovation,
        more_rad: f32,
    ) -> Outcome {
        let innovation = self.inflated_innovation(estimate, measurement, innovation);
        Outcome::Consistent { estimate: estimate.updated(&innovation), innovation, more_rad }
    }
}
