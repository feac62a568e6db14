//! The filter's measurement, and its prior sigmas.

use crate::math::{combined_sigma, hypot, sin_cos, squared};
use crate::tile::Local;
use nalgebra::{Matrix2, Vector2};

/// Prior sigmas of the filter's states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorSigmas {
    /// Velocity, each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Pitch and roll, each, radians.
    pub tilt_rad: f32,
    /// Additional wander of pitch and roll while the autopilot's estimator converges, radians.
    pub extra_wander_rad: f32,
}

impl PriorSigmas {
    /// Total of pitch and roll, each, radians.
    pub(super) fn sigma_rad(&self) -> f32 {
        combined_sigma(self.tilt_rad, self.extra_wander_rad)
    }
}

/// A match as the filter's measurement.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// Measured nadir.
    pub nadir: Local,
    /// Its covariance without the tilt's error, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Part of that, on each axis, by a map of another year; 0 over one that seems to be of the same year.
    pub map_variance_m2: f32,
    /// Variance to add to each axis since its error is correlated with those of earlier matches, square metres.
    pub inflation_m2: f32,
    /// Sigma of a transient tilt, radians.
    pub transient_rad: f32,
    /// Error of pitch and roll that its frame was corrected for in rectification, radians.
    pub corrected_tilt_rad: [f32; 2],
    /// Height above ground, metres.
    pub height_m: f32,
    /// Heading, clockwise from grid north, radians.
    pub heading_rad: f32,
}

impl Measurement {
    /// Of a level frame 120 m up, heading north, with this variance on each axis, square metres.
    #[cfg(test)]
    pub(super) fn level(nadir: Local, variance: f32) -> Self {
        Measurement {
            nadir,
            covariance: Matrix2::identity() * variance,
            map_variance_m2: 0.0,
            inflation_m2: 0.0,
            transient_rad: 0.0,
            corrected_tilt_rad: [0.0; 2],
            height_m: 120.0,
            heading_rad: 0.0,
        }
    }

    /// As if its frame had been corrected for this error of pitch and roll, radians.
    pub(super) fn with_tilt(self, tilt_rad: [f32; 2]) -> Self {
        let aside = tilt_jacobian(&self) * (Vector2::from(self.corrected_tilt_rad) - Vector2::from(tilt_rad));
        Measurement { corrected_tilt_rad: tilt_rad, ..self.moved(aside.into()) }
    }

    /// With covariance added.
    pub(super) fn with_covariance(self, by: Matrix2<f32>) -> Self {
        Measurement { covariance: self.covariance + by, ..self }
    }

    /// Moved by a displacement (east, north), metres.
    pub(super) fn moved(self, way_m: [f32; 2]) -> Self {
        Measurement { nadir: self.nadir.moved(way_m), ..self }
    }
}

/// Covariance of a match without the constant tilt.
pub(super) fn white(measurement: &Measurement, transient_rad: f32) -> Matrix2<f32> {
    let jacobian = tilt_jacobian(measurement);
    measurement.covariance + jacobian * jacobian.transpose() * squared(hypot(measurement.transient_rad, transient_rad))
}

/// Jacobian of the measured nadir to the error of pitch and roll, (east, north) metres a radian: with a reported nose
/// too high the nadir is found too far behind, with a reported right wing too low too far to the right.
pub(super) fn tilt_jacobian(measurement: &Measurement) -> Matrix2<f32> {
    let (sin, cos) = sin_cos(measurement.heading_rad);
    Matrix2::new(-sin, cos, -cos, -sin) * measurement.height_m
}
