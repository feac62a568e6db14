//! What belongs to the instant of a frame's exposure, beside the frame's report, which fills its message.

use plumbline_core::stamp::{ClockState, Stamp, StampCounters, StampSource};
use serde::{Deserialize, Serialize};

/// What is known of the instant of a frame's exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstantReport {
    /// Number of the frame.
    pub sequence: u32,
    /// Its stamp; the frame's report says why there is none.
    pub stamp: Option<StampTold>,
}

impl InstantReport {
    /// Nothing known yet.
    pub fn new(sequence: u32) -> Self {
        InstantReport { sequence, stamp: None }
    }
}

/// A stamp as it is told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StampTold {
    /// Mid-exposure on the autopilot's clock, microseconds.
    pub mid_us: u64,
    /// From the opening to the middle, and from there to the closing.
    pub halves_us: (u32, u32),
    /// One sigma of the middle.
    pub sigma_us: f32,
    /// [`StampSource`] by its code.
    pub source: u8,
    /// Whether pulses discipline the clock; TIMESYNC otherwise.
    pub by_pulses: bool,
    /// Microseconds that the autopilot's clock gains on the capture timer in a second, and one sigma of it.
    pub rate_ppm: (f32, f32),
    /// Seconds since the newest pulse; `u32::MAX` where there was none.
    pub free_wheeling_s: u32,
}

impl StampTold {
    /// A stamp, and the clock when the frame arrived.
    pub fn new(stamp: &Stamp, clock: &ClockState) -> Self {
        StampTold {
            mid_us: stamp.mid.0,
            halves_us: (stamp.mid.since(stamp.open).max(0) as u32, stamp.close.since(stamp.mid).max(0) as u32),
            sigma_us: stamp.sigma_us,
            source: stamp.source as u8,
            by_pulses: clock.by_pulses,
            rate_ppm: (clock.rate_ppm, clock.rate_sigma_ppm),
            free_wheeling_s: clock.free_wheeling_s,
        }
    }

    /// What it was made of.
    pub fn source(&self) -> Option<StampSource> {
        StampSource::from_code(self.source)
    }
}

/// What was wrong with edges and pulses, since start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StampHealth {
    /// Edges that were bounces or stray short pulses.
    pub edges_bounced: u32,
    /// Edges latched twice or backwards.
    pub edges_bad: u32,
    /// Edges that a frame should have had and had not.
    pub edges_missing: u32,
    /// Pulses off by more than the clock's gate.
    pub pulses_ignored: u32,
    /// Times that the clock was tied anew; the first is its start.
    pub ties: u32,
    /// Seconds since the newest pulse; `u32::MAX` where there was none.
    pub free_wheeling_s: u32,
}

impl StampHealth {
    /// Counters, and the clock now.
    pub fn new(counters: StampCounters, clock: &ClockState) -> Self {
        StampHealth {
            edges_bounced: counters.edges_bounced,
            edges_bad: counters.edges_bad,
            edges_missing: counters.edges_missing,
            pulses_ignored: counters.pulses_ignored,
            ties: counters.ties,
            free_wheeling_s: clock.free_wheeling_s,
        }
    }
}
