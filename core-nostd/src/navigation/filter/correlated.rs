//! Matches with correlated errors: their weight is reduced. Over a map of another year one that is further off than neighbours can be is a jump.

use super::estimate::{Estimate, Innovation, part_sigmas_rad};
use super::measurement::{Measurement, PriorSigmas};
use super::{Filter, JUMP_GATE, VELOCITY_KNOWN_M_PER_S};
use crate::math::squared;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Correlation time of the match errors over a map of another year, seconds. Measured over 28 flights between eight
/// years: the errors of two matches are correlated by 0.5 and 0.67 after 1.5 s (patches of 35 and 64 pixels), 0.15 and
/// 0.38 after 6 s, 0.1 and 0.24 after 10 s.
const CORRELATION_S: f32 = 4.0;
/// Share of a match's variance, over a map of the same year, that neighbours have in common, and its correlation time, seconds. Measured over
/// 120 flights of three minutes with two matches a second: their errors, 0.69 of the stated variance, are correlated by 0.30, 0.22, 0.15, 0.12
/// and 0.06 after 0.5, 1, 1.5, 2 and 4 s, over poor ground as over rich. The mean over many of them is as uncertain as with these two.
const SAME_YEAR_SHARE: f32 = 0.4;
const SAME_YEAR_CORRELATION_S: f32 = 1.0;
/// Share of the common variance by which matches within [`NEIGHBOURS_US`] differ. Measured over 28 such flights: with a quarter, none of 8,200
/// innovations was beyond 17.5 squared sigmas; of the first matches after the attitude had jumped by 1.5 to 3.5 pixels, in 42 flights, those
/// that followed within that time were beyond 30.
const DIFFERENCE_SHARE: f32 = 0.25;
const NEIGHBOURS_US: i32 = 2_000_000;
/// Share of the wander's variance by which its values within that time differ: they are correlated by 0.95 after 2 s.
const WANDER_SHARE: f32 = 0.1;
/// Largest rate of turn, radians a second, by which an unknown tilt moves a match: that of the fastest turns flown.
const TURN_RAD_S: f32 = 0.35;

impl Filter {
    /// Covariance with which a match enters the estimate.
    pub(super) fn inflated_covariance(&self, measurement: &Measurement) -> Matrix2<f32> {
        self.white(measurement) + Matrix2::identity() * measurement.inflation_m2
    }

    /// Variance to add to each axis of a match of the newest frame, square metres, given its covariance and the part that
    /// a map of another year has in it: all matches within twice the correlation time then weigh as much as one, by what
    /// they have in common.
    pub fn inflation_m2(&self, covariance: &Matrix2<f32>, map_variance_m2: f32) -> f32 {
        let apart_s = self.moment.at.since(self.matched_at).max(1) as f32 * 1e-6;
        let (common_m2, correlation_s) = if map_variance_m2 > 0.0 {
            (map_variance_m2, CORRELATION_S)
        } else {
            (SAME_YEAR_SHARE * 0.5 * covariance.trace(), SAME_YEAR_CORRELATION_S)
        };
        ((2.0 * correlation_s / apart_s).max(1.0) - 1.0) * common_m2
    }

    /// Whether a match of the newest frame over a map of another year, displaced by `off` from the prediction, is further off than errors
    /// allow that it does not have in common with the match before, at `before`. Not while the velocity is unknown.
    pub(super) fn contradicts_neighbour(
        &self,
        before: Micros,
        estimate: &Estimate,
        (measurement, off): (&Measurement, &Vector2<f32>),
        prior: &PriorSigmas,
    ) -> bool {
        let since_us = self.moment.at.since(before);
        if measurement.map_variance_m2 <= 0.0 || !(1..=NEIGHBOURS_US).contains(&since_us) {
            return false;
        }
        let apart_s = since_us as f32 * 1e-6;
        let common_m2 = measurement.map_variance_m2;
        let own_m2 = (0.5 * self.white(measurement).trace() - common_m2).max(0.0);
        let velocity = estimate.velocity().map(|(_, variance)| variance).into_iter().fold(0.0, f32::max);
        if velocity > squared(VELOCITY_KNOWN_M_PER_S) {
            return false;
        }
        let [_, wander_rad] = part_sigmas_rad(prior);
        let tilt = WANDER_SHARE * squared(wander_rad) + squared(TURN_RAD_S * apart_s * estimate.tilt_sigma_rad());
        let differs_m2 =
            DIFFERENCE_SHARE * common_m2 + own_m2 + velocity * squared(apart_s) + tilt * squared(measurement.height_m);
        off.norm_squared() > JUMP_GATE * differs_m2
    }

    /// The innovation of a consistent match with its covariance inflated for correlated errors.
    pub(super) fn inflated_innovation(
        &self,
        estimate: &Estimate,
        measurement: &Measurement,
        innovation: Innovation,
    ) -> Innovation {
        if measurement.inflation_m2 > 0.0 {
            estimate.innovation(measurement, self.inflated_covariance(measurement))
        } else {
            innovation
        }
    }
}
