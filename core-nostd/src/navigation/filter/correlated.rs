//! Matches with correlated errors: over a map of another year their weight is reduced.

use super::Filter;
use super::estimate::{Estimate, Innovation};
use super::measurement::Measurement;
use nalgebra::Matrix2;

/// Correlation time of the match errors over a map of another year, seconds. Measured over 28 flights between eight
/// years: the errors of two matches are correlated by 0.5 and 0.67 after 1.5 s (patches of 35 and 64 pixels), 0.15 and
/// 0.38 after 6 s, 0.1 and 0.24 after 10 s.
const CORRELATION_S: f32 = 4.0;

impl Filter {
    /// Covariance with which a match enters the estimate.
    pub(super) fn inflated_covariance(&self, measurement: &Measurement) -> Matrix2<f32> {
        self.white(measurement) + Matrix2::identity() * measurement.inflation_m2
    }

    /// Variance to add to each axis of a match of the newest frame, square metres, given the variance that is common to
    /// neighbours: all matches within twice the correlation time then weigh as much as one.
    pub fn inflation_m2(&self, map_variance_m2: f32) -> f32 {
        let apart_s = self.moment.at.since(self.matched_at).max(1) as f32 * 1e-6;
        ((2.0 * CORRELATION_S / apart_s).max(1.0) - 1.0) * map_variance_m2
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
