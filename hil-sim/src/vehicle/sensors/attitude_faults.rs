//! What an attitude sensor does wrong, put on its good samples.

use super::reading::{Reading, Sample};
use crate::scenario::{AttitudeFaults, Seconds};

/// Passes the samples of one flight.
#[derive(Debug)]
pub(super) struct FaultyAttitude {
    faults: AttitudeFaults,
    /// What the sensor said before it hung.
    last: Option<Reading>,
}

impl FaultyAttitude {
    pub(super) fn new(faults: AttitudeFaults) -> Self {
        FaultyAttitude { faults, last: None }
    }

    /// The sample as it is sent; `None` where the sensor is silent.
    pub(super) fn pass(&mut self, mut sample: Sample) -> Option<Sample> {
        let at_us = sample.sampled_at_us;
        let begun_us = |interval: Option<Seconds>| {
            let [from_us, to_us] = interval?.map(|at_s| (1e6 * at_s).round() as u64);
            (from_us..to_us).contains(&at_us).then_some(from_us)
        };
        if begun_us(self.faults.gap_s).is_some() {
            return None;
        }
        match self.last {
            Some(last) if begun_us(self.faults.stuck_s).is_some() => sample.reading = last,
            _ => self.last = Some(sample.reading),
        }
        if let Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, .. } = &mut sample.reading
            && begun_us(self.faults.nan_s).is_some()
        {
            (*heading_true_rad, *pitch_rad, *roll_rad) = (f64::NAN, f64::NAN, f64::NAN);
        }
        if let Some(from_us) = begun_us(self.faults.backwards_s) {
            sample.sampled_at_us = (2 * from_us).saturating_sub(at_us);
        }
        Some(sample)
    }
}
