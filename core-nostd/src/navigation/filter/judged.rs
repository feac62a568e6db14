//! What becomes of an estimate by a match, and what there would be without that.

use super::estimate::Estimate;
use nalgebra::{Matrix2, Vector2};

/// What there would be without the newest match.
#[derive(Clone, Copy, Debug)]
pub(super) struct Without {
    /// How far east and north of the estimate, metres.
    pub(super) off_m: Vector2<f32>,
    /// By how much the covariance would be larger, square metres.
    pub(super) larger: Matrix2<f32>,
}

impl Without {
    pub(super) fn new(expected: &Estimate, matched: &Estimate) -> Self {
        let ((was, large), (is, small)) = (expected.position(), matched.position());
        Without { off_m: Vector2::new(was.east_m - is.east_m, was.north_m - is.north_m), larger: large - small }
    }
}

/// What becomes of an estimate by a match.
#[allow(clippy::large_enum_variant, reason = "no heap to put the large one on, and one at a time is made")]
pub(super) enum Judged {
    /// It was expected, but for a tilt of so many radians that comes and goes.
    Expected(Estimate, f32),
    /// It is so far off that something has jumped.
    Jumped(Vector2<f32>),
}
