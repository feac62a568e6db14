//! What a scenario's timed faults make of the sensors' good samples. Nothing here draws a random number, so that what is not
//! faulty stays as it is without the fault.

mod held;
#[cfg(test)]
mod tests;

use super::reading::{Reading, Sample};
use crate::scenario::{Fault, FaultList, What};
use crate::vehicle::servo::wrapped;
use held::Held;

/// Passes the samples of one flight.
#[derive(Debug)]
pub(super) struct Faulty {
    faults: FaultList,
    /// True heading less grid heading: offsets to the east are on the grid, velocities towards true north and east.
    convergence_rad: f64,
    place: Held<[f64; 3]>,
    velocity: Held<[f64; 3]>,
    slant: Held<Option<f64>>,
    /// Heading, pitch, roll.
    angles: [Held<f64>; 3],
    attitude_velocity: Held<[f64; 3]>,
    stale: Option<(u64, [f64; 3])>,
    follow_up: Held<f64>,
}

impl Faulty {
    /// Before the first sample.
    pub(super) fn new(faults: FaultList, convergence_rad: f64) -> Self {
        Faulty {
            faults,
            convergence_rad,
            place: Held::default(),
            velocity: Held::default(),
            slant: Held::default(),
            angles: Default::default(),
            attitude_velocity: Held::default(),
            stale: None,
            follow_up: Held::default(),
        }
    }

    /// How much older than they should be the attitudes are that are stamped with `at_us`.
    pub(super) fn attitude_delay_us(&self, at_us: u64) -> u64 {
        (1e3 * self.faults.sum(What::AttitudeDelayed, at_us)).round() as u64
    }

    /// How much later than its whole second the pulse of `at_us` comes: its phase, and that of a clock which began anew in the
    /// midst of a second.
    pub(super) fn pulse_late_us(&self, at_us: u64) -> u64 {
        let phase_us = (1e3 * self.faults.sum(What::ClockPhase, at_us)).round() as u64;
        let boots = self.faults.of(What::ClockReboot).map(Fault::to_us).filter(|boot_us| *boot_us <= at_us);
        phase_us + boots.max().unwrap_or(0) % 1_000_000
    }

    /// The sample as it is sent; `None` where the sensor is silent.
    pub(super) fn pass(&mut self, sample: Sample) -> Option<Sample> {
        let at_us = sample.sampled_at_us;
        let is = |what| self.faults.is(what, at_us);
        let off = match sample.reading {
            Reading::Pps { .. } => is(What::ClockReboot),
            Reading::Attitude { .. } => is(What::AttitudeOff),
            Reading::FollowUp { .. } => is(What::EncoderOff),
            Reading::Range { .. } => is(What::RangeOff),
            Reading::Position { .. } => is(What::PositionOff),
        };
        if off {
            return None;
        }
        let reading = match sample.reading {
            Reading::Pps { second } => Reading::Pps { second },
            Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s } => {
                self.attitude(at_us, [heading_true_rad, pitch_rad, roll_rad], velocity_ned_m_s)
            }
            Reading::FollowUp { follow_up_rad } => self.follow_up(at_us, follow_up_rad),
            Reading::Range { slant_m } => self.range(at_us, slant_m),
            Reading::Position { east_m, north_m, up_m, velocity_ned_m_s } => {
                self.position(at_us, [east_m, north_m, up_m], velocity_ned_m_s)
            }
        };
        Some(Sample { reading, ..sample })
    }

    fn attitude(&mut self, at_us: u64, angles: [f64; 3], velocity_ned_m_s: [f64; 3]) -> Reading {
        let is = |what| self.faults.is(what, at_us);
        let all = is(What::AttitudeStuck);
        let stuck = [What::HeadingStuck, What::AttitudeStuckPitch, What::AttitudeStuckRoll].map(|what| all || is(what));
        let mut angles: [f64; 3] = std::array::from_fn(|axis| self.angles[axis].pass(stuck[axis], angles[axis]));
        let velocity_ned_m_s = self.attitude_velocity.pass(all, velocity_ned_m_s);
        self.stale = match (self.faults.at(What::AttitudeStale, at_us).next(), self.stale) {
            (None, _) => None,
            (Some(fault), Some((since_us, old))) if at_us < since_us + (1e3 * fault.value) as u64 => {
                angles = old;
                Some((since_us, old))
            }
            (Some(_), _) => Some((at_us, angles)),
        };
        let [heading, pitch, roll] = angles;
        let tilt = |angle: f64| {
            let bias_rad = self.faults.sum(What::AttitudeBias, at_us).to_radians();
            angle * self.faults.product(What::AttitudeScale, at_us) + bias_rad
        };
        Reading::Attitude {
            heading_true_rad: self.turned(What::HeadingBias, at_us, heading),
            pitch_rad: tilt(pitch),
            roll_rad: tilt(roll),
            velocity_ned_m_s: self.dragged(at_us, velocity_ned_m_s),
        }
    }

    fn follow_up(&mut self, at_us: u64, follow_up_rad: f64) -> Reading {
        let follow_up_rad = self.follow_up.pass(self.faults.is(What::EncoderStuck, at_us), follow_up_rad);
        Reading::FollowUp { follow_up_rad: self.turned(What::EncoderBias, at_us, follow_up_rad) }
    }

    fn range(&mut self, at_us: u64, slant_m: Option<f64>) -> Reading {
        let faults = &self.faults;
        let slant_m = self.slant.pass(faults.is(What::RangeStuck, at_us), slant_m);
        let off = |slant_m| slant_m * faults.product(What::RangeScale, at_us) + faults.sum(What::RangeBias, at_us);
        let stepped = |slant_m: f64| {
            faults
                .at(What::RangeSteps, at_us)
                .fold(slant_m, |slant_m, fault| (slant_m / fault.value).round() * fault.value)
        };
        Reading::Range { slant_m: slant_m.map(off).map(stepped) }
    }

    fn position(&mut self, at_us: u64, place: [f64; 3], velocity_ned_m_s: [f64; 3]) -> Reading {
        let faults = &self.faults;
        let stuck = faults.is(What::PositionStuck, at_us);
        let [east, north, up] = self.place.pass(stuck || faults.is(What::PositionStuckPosition, at_us), place);
        let velocity_ned_m_s = self.velocity.pass(stuck, velocity_ned_m_s);
        let drag = faults.at(What::PositionDrag, at_us);
        let dragged_m: f64 = drag.map(|fault| 1e-6 * (at_us - fault.from_us()) as f64 * fault.value).sum();
        Reading::Position {
            east_m: east + faults.sum(What::PositionJump, at_us) + dragged_m,
            north_m: north,
            up_m: up * faults.product(What::BaroScale, at_us) + faults.sum(What::BaroBias, at_us),
            velocity_ned_m_s: self.dragged(at_us, velocity_ned_m_s),
        }
    }

    /// A velocity with what the navigation believes beside the truth: grid east, turned to true north and east.
    fn dragged(&self, at_us: u64, [north, east, down]: [f64; 3]) -> [f64; 3] {
        let [drag, wrong] = [What::PositionDrag, What::PositionWrongVelocity].map(|what| self.faults.sum(what, at_us));
        let (sin, cos) = self.convergence_rad.sin_cos();
        [north - (drag + wrong) * sin, east + (drag + wrong) * cos, down]
    }

    /// An angle with its bias, degrees; without one it is not touched.
    fn turned(&self, what: What, at_us: u64, angle_rad: f64) -> f64 {
        if self.faults.is(what, at_us) {
            wrapped(angle_rad + self.faults.sum(what, at_us).to_radians())
        } else {
            angle_rad
        }
    }
}
