//! Interruptions: velocities that stop, are frozen, or go back with their clock. The estimate of position and velocity ends; what is known or
//! doubted of the attitude does not, since whatever interrupts the velocities, the camera leans as before.

use super::Filter;
use super::innovation_test::TRANSIENT_MAX_RAD;
use super::jumps::Jumps;
use super::measurement::PriorSigmas;
use super::misalignment::Misalignment;
use crate::navigation::reckoning::Moment;
use crate::units::Micros;

impl Filter {
    /// The reported data may be invalid: restarts with the next velocity.
    pub fn forget(&mut self) {
        self.reset(self.reported);
    }

    /// Resets all but the newest velocity, the map's offset by satellites, and what is known or doubted of the attitude.
    pub(super) fn reset(&mut self, moment: Moment) {
        match &self.settled {
            Some(settled) if settled.is_valid() => {
                self.kept_tilt = Some((settled.tilt_rad(), settled.tilt_sigma_rad()));
            }
            // What was learnt with it is worth nothing.
            Some(_) => {
                (self.jumps, self.misalignment) = (Jumps::new(), Misalignment::new());
                self.kept_tilt = Some(([0.0; 2], TRANSIENT_MAX_RAD));
            }
            None => {}
        }
        self.jumps.interrupted(moment.at);
        // Field by field: a new filter would need its size on the stack as well.
        (self.acceleration, self.moment, self.matched_at) = ([0.0; 2], moment, Micros(0));
        (self.settled, self.newest, self.prediction) = (None, None, None);
        self.pending.clear();
        (self.satellite_tilt_rad, self.tried_rad, self.swing_at) = (None, None, moment.at);
        self.resections.interrupted();
        self.satellites.stop();
    }

    /// The prior of the first match: the tilt may be as uncertain as before a reset.
    pub(super) fn start_prior(&self, prior: &PriorSigmas) -> PriorSigmas {
        let kept_rad = self.kept_tilt.map_or(0.0, |(_, sigma_rad)| sigma_rad);
        PriorSigmas { tilt_rad: prior.tilt_rad.max(kept_rad), ..*prior }
    }
}
