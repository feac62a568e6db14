//! The autopilot's clock, and what fails of it: what TIMESYNC says, and a boot after which it begins at 0.

use crate::noise::{stream, uniform};
use crate::scenario::{Fault, FaultList, What};
use crate::vehicle::sensors::Sample;
use rand_chacha::ChaCha12Rng;

/// Runs with the simulator's time; it is what it reads that fails.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    faults: FaultList,
    /// The simulator's time at which it began.
    zero_us: u64,
    jitter: ChaCha12Rng,
}

impl Clock {
    /// At power-on.
    pub(super) fn new(faults: FaultList, seed: u64) -> Self {
        Clock { faults, zero_us: 0, jitter: stream(seed, "fault.clock.jitter") }
    }

    /// Whether the autopilot has no power.
    pub(super) fn is_off(&self, at_us: u64) -> bool {
        self.faults.is(What::ClockReboot, at_us)
    }

    /// Whether the autopilot has booted since this was asked last; the clock begins anew then.
    pub(super) fn has_booted(&mut self, at_us: u64) -> bool {
        let boots = self.faults.of(What::ClockReboot).map(Fault::to_us).filter(|boot_us| *boot_us <= at_us);
        let zero_us = boots.max().unwrap_or(0);
        zero_us > std::mem::replace(&mut self.zero_us, zero_us)
    }

    /// What it reads at an instant.
    pub(super) fn reads(&self, at_us: u64) -> u64 {
        at_us.saturating_sub(self.zero_us)
    }

    /// A sample with the instants of this clock; `None` of one that was taken before it began.
    pub(super) fn stamped(&self, sample: &Sample) -> Option<Sample> {
        let [sampled_at_us, arrived_at_us] =
            [sample.sampled_at_us, sample.arrived_at_us].map(|at_us| at_us.checked_sub(self.zero_us));
        Some(Sample { sampled_at_us: sampled_at_us?, arrived_at_us: arrived_at_us?, ..*sample })
    }

    /// What TIMESYNC says that it reads.
    pub(super) fn told_us(&self, at_us: u64) -> i64 {
        self.reads(at_us) as i64 + (1e3 * self.faults.sum(What::ClockOffset, at_us)).round() as i64
    }

    /// How much longer an answer of TIMESYNC takes on its way back.
    pub(super) fn late_us(&mut self, at_us: u64) -> u64 {
        let jitter = &mut self.jitter;
        let waits: f64 = self.faults.at(What::ClockJitter, at_us).map(|fault| fault.value * uniform(jitter)).sum();
        (1e3 * (waits + self.faults.sum(What::ClockAsymmetry, at_us))).round() as u64
    }
}
