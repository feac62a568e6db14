//! The receiver of satellite navigation: what its faults make of a good measurement, and what it has told of them when.

use crate::scenario::{FaultList, What};
use crate::vehicle::autopilot::Received;
use crate::vehicle::inertial::estimator::Measurement;

/// From a position's instant to when the receiver's message is handed over: what ArduPilot has of u-blox receivers from the M8 on
/// (AP_GPS_UBLOX::get_lag).
const HANDED_OVER_US: u64 = 120_000;
/// A position that is older than this is none any more. Chosen: five of five a second.
const OLD_US: u64 = 1_000_000;

/// The receiver.
#[derive(Clone, Debug)]
pub(super) struct Receiver {
    faults: FaultList,
    sigma_m: f64,
    /// Instant, and north and east, of each position that it had.
    places: Vec<(u64, [f64; 2])>,
}

impl Receiver {
    pub(super) fn new(faults: FaultList, sigma_m: f64) -> Self {
        Receiver { faults, sigma_m, places: Vec::new() }
    }

    /// A measurement as the receiver has it; nothing where it has none.
    pub(super) fn pass(&mut self, at_us: u64, measurement: Measurement) -> Option<Measurement> {
        let Measurement::Gnss { place_m: [north, east], mut velocity_m_s } = measurement else {
            return Some(measurement);
        };
        if self.faults.is(What::GnssOff, at_us) {
            return None;
        }
        let drag = self.faults.at(What::GnssDrag, at_us);
        let dragged_m: f64 = drag.map(|fault| 1e-6 * (at_us - fault.from_us()) as f64 * fault.value).sum();
        let place_m = [north, east + self.faults.sum(What::GnssJump, at_us) + dragged_m];
        velocity_m_s.y += self.faults.sum(What::GnssDrag, at_us);
        self.places.push((at_us, place_m));
        Some(Measurement::Gnss { place_m, velocity_m_s })
    }

    /// The newest position that it has handed over by an instant.
    pub(super) fn received(&self, t_us: u64) -> Option<Received> {
        let newest = self.places.iter().rev().find(|(at_us, _)| at_us + HANDED_OVER_US <= t_us);
        let (at_us, [north_m, east_m]) = *newest?;
        let age_us = t_us - at_us - HANDED_OVER_US;
        (age_us <= OLD_US).then_some(Received { age_us, east_m, north_m, sigma_m: self.sigma_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn received(faults: &str, at_us: u64) -> (Option<Measurement>, Receiver) {
        let faults: FaultList = faults.split(' ').map(|fault| fault.parse().expect("a fault")).collect();
        let mut receiver = Receiver::new(faults, 2.0);
        let good = Measurement::Gnss { place_m: [10.0, 20.0], velocity_m_s: Vector3::new(1.0, 2.0, 3.0) };
        (receiver.pass(at_us, good), receiver)
    }

    #[test]
    fn what_is_forged_reaches_filter_and_message_alike() {
        let (measured, receiver) = received("gnss.jump=30@5.. gnss.drag=-0.5@4..", 8_000_000);
        let velocity_m_s = Vector3::new(1.0, 1.5, 3.0);
        assert_eq!(measured, Some(Measurement::Gnss { place_m: [10.0, 48.0], velocity_m_s }));
        let told = receiver.received(8_130_000).expect("it is handed over");
        assert_eq!((told.age_us, told.east_m, told.north_m, told.sigma_m), (10_000, 48.0, 10.0, 2.0));
        assert_eq!((receiver.received(8_119_999), receiver.received(9_120_001)), (None, None));
    }

    #[test]
    fn a_receiver_that_is_off_has_nothing() {
        let (measured, receiver) = received("gnss.off@5..9", 8_000_000);
        assert_eq!((measured, receiver.received(8_500_000)), (None, None));
        assert!(received("gnss.off@5..9", 9_000_000).0.is_some());
    }
}
