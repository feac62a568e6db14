//! What becomes of an estimate by a match, and what there would be without that.

use super::estimate::{Estimate, Innovation};
use super::found::{Found, Unknown};
use super::{Filter, JUMP, KNOWN_M_PER_S, TRANSIENT};
use crate::math::{sqrt, squared};
use crate::navigation::reckoning::JUMP_ONSET_US;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Beyond this, once in ten, the next match shows it as well.
const AGAIN: f32 = 4.6;
/// Largest tilt that comes and goes, radians: beyond, something has jumped. Chosen: that of an attitude 0.3 s late of a vehicle that
/// rocks by 20 degrees a second.
pub(super) const TRANSIENT_MAX_RAD: f32 = 0.1;

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
    /// It was expected, but for a tilt of so many radians that comes and goes: the estimate with it, by this innovation.
    Expected { estimate: Estimate, innovation: Innovation, more_rad: f32 },
    /// It is so far off that something has jumped.
    Jumped(Vector2<f32>),
}

impl Filter {
    /// What becomes of an estimate by a match; a tilt that comes and goes is as large from now on. `plain`: the match's innovation as if none
    /// were known, so that one that lasts is seen in each match.
    pub(super) fn judged(
        &mut self,
        at: Micros,
        estimate: &Estimate,
        (found, plain): (&Found, &Innovation),
        unknown: &Unknown,
    ) -> Judged {
        let swings = plain.squares > TRANSIENT && plain.beyond_rad > self.transient_rad;
        let was_calm = self.transient_rad <= unknown.tilt_rad;
        if swings && !(0..JUMP_ONSET_US).contains(&at.since(self.swung_at)) {
            (self.swung_at, self.swung_rad) = (at, self.transient_rad);
        }
        // What has swung lately may swing on, as far as it has. What the next match shows as well may have come to last, where it cannot be the
        // velocity.
        let is_more = self.swung_rad <= unknown.tilt_rad.max(0.5 * plain.beyond_rad);
        let is_velocity_known = estimate.velocity().iter().all(|(_, variance)| *variance <= squared(KNOWN_M_PER_S));
        let is_again = plain.squares > AGAIN && (1..JUMP_ONSET_US).contains(&at.since(self.swung_at));
        let may_last = is_velocity_known && is_more && is_again;
        if swings && was_calm && self.jumps.likely_back(at, estimate, found, unknown).is_some() {
            return Judged::Jumped(plain.off);
        }
        let innovation = estimate.innovation(found, self.white(found));
        if innovation.squares > JUMP || swings && plain.beyond_rad > TRANSIENT_MAX_RAD {
            return Judged::Jumped(innovation.off);
        }
        if !swings && !may_last {
            return self.expected(estimate, found, innovation, 0.0);
        }
        let doubted = if may_last { estimate.doubted(self.transient_rad, found) } else { *estimate };
        let mut more_rad = 0.0;
        if swings {
            more_rad = sqrt(squared(plain.beyond_rad) - squared(self.transient_rad));
            self.transient_rad = plain.beyond_rad;
        }
        self.expected(&doubted, found, doubted.innovation(found, self.white(found)), more_rad)
    }

    /// The estimate with a match that was expected, by the innovation by which it counts.
    fn expected(&self, estimate: &Estimate, found: &Found, innovation: Innovation, more_rad: f32) -> Judged {
        let innovation = self.counting(estimate, found, innovation);
        Judged::Expected { estimate: estimate.with(&innovation), innovation, more_rad }
    }
}
