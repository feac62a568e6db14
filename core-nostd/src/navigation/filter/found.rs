//! A match as the filter takes it, and what the filter does not know beforehand.

use crate::math::{beside, hypot, sin_cos, squared};
use crate::tile::Local;
use nalgebra::{Matrix2, Vector2};

/// One sigma of what the filter does not know when it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Of the velocity, each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Of pitch and roll, each, radians.
    pub tilt_rad: f32,
    /// Beside that of what of them comes and goes, while the autopilot's estimator swings, radians.
    pub swings_rad: f32,
}

impl Unknown {
    /// Of pitch and roll, each, all in all, radians.
    pub(super) fn sigma_rad(&self) -> f32 {
        beside(self.tilt_rad, self.swings_rad)
    }
}

/// A match, as far as it concerns the filter.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Where it puts the nadir.
    pub nadir: Local,
    /// Covariance of that without the tilt's error, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Variance of each axis beside it by which it counts less, since the matches before it are off alike.
    pub alike_m2: f32,
    /// One sigma of a tilt that comes and goes, radians.
    pub transient_rad: f32,
    /// What pitch and roll were taken to be off when its frame was rectified, radians.
    pub less_tilt_rad: [f32; 2],
    /// Height above ground, metres.
    pub height_m: f32,
    /// Heading, clockwise from grid north, radians.
    pub heading_rad: f32,
}

impl Found {
    /// As if pitch and roll had been taken to be so much off, radians, when its frame was rectified.
    pub(super) fn with_tilt(self, tilt_rad: [f32; 2]) -> Self {
        let aside = moved_by_tilt(&self) * (Vector2::from(self.less_tilt_rad) - Vector2::from(tilt_rad));
        Found { less_tilt_rad: tilt_rad, ..self.moved(aside.into()) }
    }

    /// With so much more covariance.
    pub(super) fn less_certain(self, by: Matrix2<f32>) -> Self {
        Found { covariance: self.covariance + by, ..self }
    }

    /// As if it had been found so much later on the way.
    pub(super) fn moved(self, way_m: [f32; 2]) -> Self {
        Found { nadir: self.nadir.moved(way_m), ..self }
    }
}

/// Covariance of a match without the tilt that lasts.
pub(super) fn white(found: &Found, transient_rad: f32) -> Matrix2<f32> {
    let moved = moved_by_tilt(found);
    found.covariance + moved * moved.transpose() * squared(hypot(found.transient_rad, transient_rad))
}

/// How an error of pitch and roll moves the nadir that is found, (east, north) metres for each radian: nose up too far by so much, it
/// is found as far behind; right wing down too far, to the right.
pub(super) fn moved_by_tilt(found: &Found) -> Matrix2<f32> {
    let (sin, cos) = sin_cos(found.heading_rad);
    Matrix2::new(-sin, cos, -cos, -sin) * found.height_m
}
