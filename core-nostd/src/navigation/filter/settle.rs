//! The settled estimate: takes each match once, when the velocities around its instant are known.

use super::estimate::Estimate;
use super::innovation_test::Outcome;
use super::measurement::{PriorSigmas, white};
use super::{Filter, JERK_M_PER_S3};
use crate::math::squared;
use crate::navigation::reckoning::displacement_m;
use crate::units::Micros;
use nalgebra::Matrix2;

impl Filter {
    /// Updates by the match that has waited longest, moved to the instant of the newest reported velocity.
    pub(super) fn settle_oldest(&mut self, prior: &PriorSigmas) {
        let Some((at, measurement)) = self.pending.pop_front() else { return };
        let Some(settled) = self.settled else { return };
        let (apart_s, [east, north]) = (self.reported.at.since(at) as f32 * 1e-6, settled.velocity());
        // Extrapolation beyond the newest velocity has the jerk's error; the displacement has the velocity error's.
        let late_m = JERK_M_PER_S3 / 6.0 * squared(apart_s.min(0.0)) * apart_s;
        let variance = |(_, variance): (f32, f32)| squared(apart_s) * variance + squared(late_m);
        let measurement = measurement
            .moved(displacement_m(self.extrapolated(at), self.reported))
            .moved([-east.0 * apart_s, -north.0 * apart_s])
            .with_covariance(Matrix2::new(variance(east), 0.0, 0.0, variance(north)));
        let plain = settled.innovation(&measurement, white(&measurement, 0.0));
        let restarted = match self.test_innovation(at, &settled, (&measurement, &plain), prior) {
            Outcome::Consistent { estimate, innovation, .. } => {
                self.satellites.matched(&measurement, self.inflated_covariance(&measurement));
                self.misalignment.matched(&measurement, &innovation, self.is_as_mounted());
                self.settled = Some(estimate);
                return;
            }
            Outcome::Outlier(off) => {
                // The instant of the match before is not kept.
                let jumped = (at, Micros(0), off);
                let restart = self.jumps.jumped(jumped, (settled.tilt_rad(), Some(settled)), &measurement, prior);
                let prior = PriorSigmas { tilt_rad: restart.sigma_rad, ..*prior };
                self.transient_rad = self.transient_rad.max(restart.swing_rad);
                Estimate::from_match(&restart.measurement, self.white(&restart.measurement), &prior)
            }
        };
        self.satellites.restart(&restarted);
        self.misalignment.restart(&measurement);
        self.settled = Some(restarted);
    }

    /// Whether the tilt is as mounted: no jump has changed it, or it was reversed.
    fn is_as_mounted(&self) -> bool {
        self.jumps.mean_rad() == Some(self.misalignment.mean_rad())
    }

    /// Moves a detected misalignment into the estimate.
    pub(super) fn detect_misalignment(&mut self) {
        let is_as_mounted = self.is_as_mounted();
        let Some(settled) = self.settled.as_mut().filter(|_| is_as_mounted) else { return };
        let was_detected = self.misalignment.is_detected();
        if self.misalignment.detect(settled) {
            self.jumps.set_mean(self.misalignment.mean_rad());
            if !was_detected {
                // The offset was estimated with the tilt before.
                self.satellites.reset_offset();
            }
        }
    }
}
