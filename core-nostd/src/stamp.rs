//! From shutter edges to the instant of mid-exposure on the autopilot's clock (paper 000, section 2.5 of its
//! corrected form).
//!
//! A capture timer latches the shutter's opening and closing and the pulse-per-second edges, all with the same
//! free-running 32-bit 1 MHz counter. The pulses tie that counter to the autopilot's seconds.

use crate::units::{Micros, Ticks};

/// Longest exposure that is believed; a longer one is a lost edge.
pub const EXPOSURE_MAX_US: i32 = 500_000;
/// How far a pulse interval may be off one second: 500 ppm, ten times a poor crystal.
const PULSE_TOLERANCE_TICKS: u32 = 500;

/// Both edges of one exposure, as the capture timer latched them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Exposure {
    /// Shutter opens.
    pub open: Ticks,
    /// Shutter closes.
    pub close: Ticks,
}

impl Exposure {
    /// Mid-exposure on the timer: open + (close − open)/2 with a wrapping difference. (open + close)/2 would be half
    /// the timer's range off across a wrap. `None` when the closing edge is not after the opening one or too late to
    /// belong to it.
    pub fn mid(self) -> Option<Ticks> {
        let length = self.close.since(self.open);
        if !(0..=EXPOSURE_MAX_US).contains(&length) {
            return None;
        }
        Some(Ticks(self.open.0.wrapping_add(length as u32 / 2)))
    }
}

/// Ties the capture timer to the autopilot's clock by pulses per second, labelled by a coarse offset.
///
/// The offset comes from TIMESYNC and is good to the link's latency; it only has to say *which* second a pulse is.
/// Between pulses t = s1 + (c − c1)/(c1 − c0). Without pulses the coarse offset alone is used.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    /// The coarse tie: this tick was about this instant.
    coarse: Option<(Ticks, Micros)>,
    /// The two newest pulses: older, newer with its second.
    pulse: Option<Ticks>,
    fine: Option<Fine>,
}

#[derive(Clone, Copy, Debug)]
struct Fine {
    last: Ticks,
    second: u64,
    /// Ticks in the autopilot's second.
    ticks_per_second: u32,
}

/// How long pulses may have ceased before the coarse offset takes over: ten minutes at 20 ppm are 12 ms.
const FREE_WHEELING_MAX_TICKS: i32 = 600_000_000;
/// A coarse offset further from the pulses than this says that the autopilot has booted anew.
const CONTRADICTION_US: i32 = 500_000;

impl Fine {
    fn is_contradicted(&self, tick: Ticks, theirs: Micros) -> bool {
        let old = tick.since(self.last).unsigned_abs() > FREE_WHEELING_MAX_TICKS as u32;
        let ours = pulse_instant(tick, self.last, self.second, self.ticks_per_second);
        old || ours.is_none_or(|ours| ours.since(theirs).unsigned_abs() > CONTRADICTION_US as u32)
    }
}

impl Clock {
    /// A TIMESYNC exchange: tick `sent`, the autopilot's answer `theirs`, tick `received`. Symmetric delay assumed.
    pub fn on_timesync(&mut self, sent: Ticks, theirs: Micros, received: Ticks) {
        let round_trip = received.since(sent);
        if !(0..1_000_000).contains(&round_trip) {
            return;
        }
        let middle = Ticks(sent.0.wrapping_add(round_trip as u32 / 2));
        if self.fine.is_some_and(|fine| fine.is_contradicted(middle, theirs)) {
            (self.fine, self.pulse) = (None, None);
        }
        self.coarse = Some((middle, theirs));
    }

    /// A pulse: an edge at `tick`, at a whole second of the autopilot. Ignored until a coarse offset exists; an edge
    /// that is not one second after the one before starts the pair anew, so a glitch costs a second, not a wrong rate.
    pub fn on_pulse(&mut self, tick: Ticks) {
        let Some(near) = self.instant(tick) else { return };
        let second = (near.0 + 500_000) / 1_000_000;
        if let Some(before) = self.pulse {
            let interval = tick.0.wrapping_sub(before.0);
            if interval.abs_diff(1_000_000) <= PULSE_TOLERANCE_TICKS {
                self.fine = Some(Fine { last: tick, second, ticks_per_second: interval });
            }
        }
        self.pulse = Some(tick);
    }

    /// The autopilot's instant at `tick`, for ticks within half an hour of the newest tie. `None` before any tie, and
    /// for instants before the autopilot booted.
    pub fn instant(&self, tick: Ticks) -> Option<Micros> {
        match (self.fine, self.coarse) {
            (Some(fine), _) => pulse_instant(tick, fine.last, fine.second, fine.ticks_per_second),
            (None, Some((at, theirs))) => theirs.0.checked_add_signed(tick.since(at) as i64).map(Micros),
            (None, None) => None,
        }
    }
}

/// t = s1 + (c − c1)/(c1 − c0) in whole microseconds, rounded to nearest.
pub fn pulse_instant(tick: Ticks, last: Ticks, second: u64, ticks_per_second: u32) -> Option<Micros> {
    if ticks_per_second == 0 {
        return None;
    }
    let per_second = ticks_per_second as i64;
    let scaled = tick.since(last) as i64 * 1_000_000;
    let since = (2 * scaled + per_second).div_euclid(2 * per_second);
    second.checked_mul(1_000_000)?.checked_add_signed(since).map(Micros)
}
