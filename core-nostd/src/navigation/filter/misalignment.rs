//! Misalignment: a constant error of pitch and roll larger than the attitude's configured sigma.
//!
//! The filter would attribute the displacement of its matches to wander and velocity error, and its innovations would
//! have the same sign turn after turn. A constant bias enters them linearly, ν = S b + white noise, and S follows from
//! the filter's gains (the separate bias of Friedland, "Treatment of bias in recursive filtering", IEEE Trans.
//! Automatic Control 14, 1969): b and its covariance are those of a filter with two more states. Whether there is a
//! bias is decided by the likelihood ratio of the innovations with and without it (Willsky and Jones, IEEE Trans.
//! Automatic Control 21, 1976).

use super::estimate::{Estimate, Innovation, STATES, TILT, WANDER, propagate_columns};
use super::measurement::{Measurement, tilt_jacobian};
use crate::math::{exp, ln, sqrt, squared};
use nalgebra::{ArrayStorage, Matrix2, SMatrix, Vector2};

/// Prior sigma of a misalignment, each axis, radians. Chosen: one degree, as of a camera mounted by eye and an
/// accelerometer levelled on a table.
const SIGMA_RAD: f32 = 0.0175;
/// Prior probability of a misalignment. Chosen: one vehicle in ten.
const PRIOR_PROBABILITY: f32 = 0.1;
/// Probability above which it is moved into the estimate: it is more likely than not.
const DETECTED: f32 = 0.5;

/// Estimate of the misalignment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Misalignment {
    /// Sensitivity of the estimate's error, true less estimated, to the misalignment's pitch and roll, per radian.
    pub(super) sensitivity: SMatrix<f32, STATES, 2>,
    /// Sums over innovations: Sᵀ W⁻¹ S and Sᵀ W⁻¹ ν, W their covariance.
    information: Matrix2<f32>,
    score: Vector2<f32>,
    /// Probability of a misalignment.
    probability: f32,
    /// Misalignment that the estimate contains, pitch and roll, once detected: the mean of the tilt's Gauss-Markov
    /// process. The sums are of the remainder.
    detected_rad: Option<[f32; 2]>,
}

impl Misalignment {
    /// The prior.
    pub(super) const fn new() -> Self {
        Misalignment {
            sensitivity: SMatrix::from_array_storage(ArrayStorage([[0.0; STATES]; 2])),
            information: Matrix2::new(0.0, 0.0, 0.0, 0.0),
            score: Vector2::new(0.0, 0.0),
            probability: PRIOR_PROBABILITY,
            detected_rad: None,
        }
    }

    /// The estimate restarts from a match: its position has the whole displacement. A detected misalignment keeps its
    /// covariance.
    pub(super) fn restart(&mut self, measurement: &Measurement) {
        let known = if self.is_detected() { *self } else { Misalignment::new() };
        let mut sensitivity = SMatrix::<f32, STATES, 2>::zeros();
        sensitivity.fixed_view_mut::<2, 2>(0, 0).copy_from(&-tilt_jacobian(measurement));
        *self = Misalignment { sensitivity, ..known };
    }

    /// Propagates the sensitivity with the estimate's states ([`Estimate::propagate`]).
    pub(super) fn propagate(&mut self, seconds: f32, forgets_tilt: bool) {
        propagate_columns(&mut self.sensitivity, seconds, forgets_tilt);
    }

    /// The estimate was updated by a match with this innovation. `is_informative`: no jump has changed the tilt.
    pub(super) fn matched(&mut self, measurement: &Measurement, innovation: &Innovation, is_informative: bool) {
        let tilted = tilt_jacobian(measurement);
        let own = |states: usize| self.sensitivity.fixed_view::<2, 2>(states, 0);
        let jacobian = own(0) + tilted * own(TILT) + own(WANDER) * measurement.height_m + tilted;
        self.sensitivity -= innovation.cross_covariance * (innovation.inverse * jacobian);
        if is_informative {
            let weighed = jacobian.transpose() * innovation.inverse;
            self.information += weighed * jacobian;
            self.score += weighed * innovation.off;
            self.probability = self.posterior();
        }
    }

    /// The misalignment given there is one: pitch and roll, radians, and covariance. Not stored: it would not fit the
    /// flight computer's memory.
    fn estimate(&self) -> (Vector2<f32>, Matrix2<f32>) {
        let covariance = self.precision().try_inverse().unwrap_or_default();
        (covariance * self.score, covariance)
    }

    /// Inverse of that covariance.
    fn precision(&self) -> Matrix2<f32> {
        self.information + Matrix2::identity() / squared(SIGMA_RAD)
    }

    /// Posterior probability: normal innovations are more likely by e^(bᵀ y / 2) √det(P / σ²), y the score and P the
    /// covariance of b.
    fn posterior(&self) -> f32 {
        let (remainder_rad, covariance) = self.estimate();
        // Of the whole misalignment: what the estimate contains, and the remainder.
        let rad = Vector2::from(self.mean_rad()) + remainder_rad;
        let score = self.score + self.precision() * Vector2::from(self.mean_rad());
        let spread = ln((covariance / squared(SIGMA_RAD)).determinant().max(f32::MIN_POSITIVE));
        let log_ratio = 0.5 * (score.dot(&rad) + spread);
        1.0 / (1.0 + (1.0 - PRIOR_PROBABILITY) / PRIOR_PROBABILITY * exp(-log_ratio))
    }

    /// Covariance of pitch and roll by the misalignment beyond the configured sigma, square radians. Before it is
    /// detected, the square of its estimate weighted by the increase of its probability, so that the configured sigma
    /// holds without evidence against it; afterwards that of the remainder, and the square of what the estimate contains
    /// weighted by the probability that there is none: of 400 flights of three minutes two had one without a cause.
    fn covariance(&self) -> Matrix2<f32> {
        if !self.is_detected() && self.probability <= PRIOR_PROBABILITY {
            return Matrix2::zeros();
        }
        let (rad, covariance) = self.estimate();
        if let Some(detected_rad) = self.detected_rad.map(Vector2::from) {
            return covariance + detected_rad * detected_rad.transpose() * (1.0 - self.probability);
        }
        let more = ((self.probability - PRIOR_PROBABILITY) / (1.0 - PRIOR_PROBABILITY)).max(0.0);
        rad * rad.transpose() * more
    }

    /// The larger sigma of that, radians.
    pub(super) fn sigma_rad(&self) -> f32 {
        sqrt(self.covariance().diagonal().max().max(0.0))
    }

    /// Contribution to the covariance of the estimate's position, square metres.
    pub(super) fn position_covariance(&self) -> Matrix2<f32> {
        let sensitivity = self.sensitivity.fixed_view::<2, 2>(0, 0);
        sensitivity * self.covariance() * sensitivity.transpose()
    }

    /// Whether the estimate contains it.
    pub(super) fn is_detected(&self) -> bool {
        self.detected_rad.is_some()
    }

    /// Mean to which the tilt decays, pitch and roll, radians. After a resolved jump the jumps have another mean, and
    /// the misalignment is estimated no further.
    pub(super) fn mean_rad(&self) -> [f32; 2] {
        self.detected_rad.unwrap_or_default()
    }

    /// Moves the misalignment and what has been learnt of it since into the estimate, if it is more likely than not;
    /// returns whether it has.
    pub(super) fn detect(&mut self, estimate: &mut Estimate) -> bool {
        // A NaN is not likely.
        let is_likely = self.is_detected() || self.probability > DETECTED;
        if !is_likely {
            return false;
        }
        let (rad, _) = self.estimate();
        let mut sensitivity = self.sensitivity;
        sensitivity[(TILT, 0)] += 1.0;
        sensitivity[(TILT + 1, 1)] += 1.0;
        estimate.state += sensitivity * rad;
        // The remainder is zero, with the same covariance.
        self.score = Vector2::zeros();
        let [pitch, roll] = self.mean_rad();
        self.detected_rad = Some([pitch + rad[0], roll + rad[1]]);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::{DETECTED, Misalignment, PRIOR_PROBABILITY};
    use crate::math::squared;
    use crate::navigation::filter::estimate::Estimate;
    use crate::navigation::filter::{Measurement, PriorSigmas};
    use crate::tile::Local;
    use nalgebra::{Matrix2, Vector2};

    const PRIOR: PriorSigmas = PriorSigmas { velocity_m_per_s: 0.5, tilt_rad: 0.0035, extra_wander_rad: 0.0 };

    /// What innovations say that show `rad` of pitch to a sigma of 0.005 radians.
    fn shown(rad: f32) -> Misalignment {
        let information = Matrix2::identity() / squared(0.005);
        let mut shown =
            Misalignment { information, score: information * Vector2::new(rad, 0.0), ..Misalignment::new() };
        shown.probability = shown.posterior();
        shown
    }

    fn estimate() -> Estimate {
        let measurement = Measurement::level(Local::default(), 1.0);
        Estimate::from_match(&measurement, Matrix2::identity(), &PRIOR)
    }

    /// Moved into the estimate it is as probable as before, and its sigma contains that there is none.
    #[test]
    fn a_doubtful_one_leaves_its_doubt() {
        let mut doubtful = shown(0.018);
        let probability = doubtful.probability;
        assert!((DETECTED..0.8).contains(&probability), "{probability}");
        assert!(doubtful.detect(&mut estimate()));
        assert!((doubtful.posterior() - probability).abs() < 1e-3, "{} {probability}", doubtful.posterior());
        let [contained_rad, _] = doubtful.mean_rad();
        let least_rad = contained_rad * (1.0 - probability).sqrt();
        assert!((least_rad..1.3 * least_rad).contains(&doubtful.sigma_rad()), "{} {least_rad}", doubtful.sigma_rad());
        // Innovations that show none afterwards take it back.
        let around = Matrix2::identity() / squared(0.003);
        doubtful.information += around;
        doubtful.score -= around * Vector2::from(doubtful.mean_rad());
        doubtful.probability = doubtful.posterior();
        assert!(doubtful.probability < PRIOR_PROBABILITY, "{}", doubtful.probability);
        // One that is sure has the sigma of its remainder.
        let mut sure = shown(0.03);
        assert!(sure.detect(&mut estimate()) && sure.sigma_rad() < 0.0052, "{} {}", sure.probability, sure.sigma_rad());
    }
}
