//! The filter's past: each match once, when the velocities around its instant are there.

use super::estimate::Estimate;
use super::found::{Unknown, white};
use super::judged::Judged;
use super::{Filter, JERK_M_PER_S3};
use crate::math::squared;
use crate::navigation::reckoning::displacement_m;
use crate::units::Micros;
use nalgebra::Matrix2;

impl Filter {
    /// The match that has waited longest, moved to the newest reported velocity by what is known of the way.
    pub(super) fn settle_oldest(&mut self, unknown: &Unknown) {
        let Some((at, found)) = self.waiting.pop_front() else { return };
        let Some(settled) = self.settled else { return };
        let (apart_s, [east, north]) = (self.reported.at.since(at) as f32 * 1e-6, settled.velocity());
        // Beyond the newest velocity its jerk is not known, and within it not all of its error.
        let late_m = JERK_M_PER_S3 / 6.0 * squared(apart_s.min(0.0)) * apart_s;
        let variance = |(_, variance): (f32, f32)| squared(apart_s) * variance + squared(late_m);
        let found = found
            .moved(displacement_m(self.reckoned(at), self.reported))
            .moved([-east.0 * apart_s, -north.0 * apart_s])
            .less_certain(Matrix2::new(variance(east), 0.0, 0.0, variance(north)));
        let plain = settled.innovation(&found, white(&found, 0.0));
        let begun = match self.judged(at, &settled, (&found, &plain), unknown) {
            Judged::Expected { estimate, innovation, .. } => {
                self.satellites.matched(&found, self.counted(&found));
                self.misalignment.matched(&found, &innovation, self.is_as_mounted());
                self.settled = Some(estimate);
                return;
            }
            Judged::Jumped(off) => {
                // When the match before it was is not kept.
                let jumped = (at, Micros(0), off);
                let begun = self.jumps.jumped(jumped, (settled.tilt_rad(), Some(settled)), &found, unknown);
                let unknown = Unknown { tilt_rad: begun.sigma_rad, ..*unknown };
                Estimate::begun(&begun.found, self.white(&begun.found), &unknown)
            }
        };
        self.satellites.begun(&begun);
        self.misalignment.begun(&found);
        self.settled = Some(begun);
    }

    /// Whether no jump has changed the tilt, or has been taken back.
    fn is_as_mounted(&self) -> bool {
        self.jumps.usual_rad() == Some(self.misalignment.usual_rad())
    }

    /// A misalignment that matches have told is in the estimate from now on.
    pub(super) fn find_misalignment(&mut self) {
        let is_as_mounted = self.is_as_mounted();
        let Some(settled) = self.settled.as_mut().filter(|_| is_as_mounted) else { return };
        let was_found = self.misalignment.is_found();
        if self.misalignment.find(settled) {
            self.jumps.goes_back_to(self.misalignment.usual_rad());
            if !was_found {
                // Satellites have told the map's offset with the tilt of before.
                self.satellites.forget_offset();
            }
        }
    }
}
