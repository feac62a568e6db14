//! The capture timer against the autopilot's clock: offset and rate with their uncertainty.
//!
//! A Kalman filter of two states. The offset is what the autopilot's clock shows beyond a whole number of microseconds
//! at the epoch, the newest tick that it was compared at; the rate is how many microseconds more than ticks it gains in
//! a second, in parts per million. Both stay small, so that single precision holds them; the tick and the instant of
//! the epoch are integers. Between epochs t = t1 + (c − c1)(1 + rate), eq. of paper 000's section 2.5 with the rate by
//! all pulses instead of the last two.
//!
//! *Process*: the crystal's rate is a random walk with a variance of q a second, so that over s seconds the covariance
//! grows by q (s³/3, s²/2, s). *Pulses* are whole seconds with their jitter and the timer's rounding. *TIMESYNC*
//! determines which second a pulse is; only without pulses, or so long after the last that it is more accurate, it
//! disciplines the clock by itself: exchanges weigh the less the longer they took beyond the quickest, and the quickest
//! may be off by its whole round trip's asymmetry, which no averaging reduces.
//!
//! An answer is given between request and receipt, whatever the asymmetry. A clock by TIMESYNC that puts it outside is
//! off by at least that excess: its variance grows by that, so that it follows a clock that has made a step, as that of
//! an autopilot's simulator does. If exchange after exchange contradicts the pulses, these are not the autopilot's
//! whole seconds (a receiver's own, or the wrong edge of theirs): until the two agree again, the clock's variance is
//! infinite.

mod epoch;

use super::ROUNDING;
use super::association::rounding_correlation;
use super::settings::ClockSettings;
use crate::math;
use crate::units::{Micros, Ticks};
use epoch::{Epoch, NO_PULSE};

/// Ticks a second.
const SECOND: u32 = 1_000_000;
/// Tolerance of a pulse interval against one second for two pulses to count against the clock: 500 ppm.
const PULSE_TOLERANCE_TICKS: u32 = 500;
/// Gate of a pulse, sigmas: of normal errors one in two million is beyond.
const GATE_SIGMAS: f32 = 5.0;
/// Pulses in a row, a second apart, that outvote a clock disciplined by pulses, and one by TIMESYNC. Chosen: two are
/// the fewest that have an interval, four let the clock follow a step within four seconds.
const OUTVOTE_PULSES: u8 = 4;
const OUTVOTE_TIMESYNC: u8 = 2;
/// Difference of TIMESYNC from the clock above which the autopilot has rebooted: half a second, beyond which a pulse
/// would be given the wrong second.
const REBOOT_US: i32 = 500_000;
/// Consecutive exchanges contradicting the clock, beyond their round trip, after which it is not used. Chosen: one or
/// two may be latencies of the link.
const CONTRADICTIONS_MAX: u8 = 3;
/// Longest round trip of an exchange that is used. Chosen: links answer within some ten milliseconds.
const ROUND_TRIP_MAX_US: i32 = 1_000_000;
/// Scatter of an exchange as quick as the quickest, microseconds. Chosen: of the order of a byte at 115,200
/// baud, 87 us.
const EXCHANGE_SIGMA_US: f32 = 50.0;
/// Age above which the epoch is moved forwards: half a minute, far below the 36 minutes of half the timer's range.
const EPOCH_AGE_MAX_TICKS: i32 = 30_000_000;
/// Pulses younger than this discipline the clock, and TIMESYNC only determines their second. Chosen: ten missing
/// pulses.
const PULSES_LIVE_TICKS: u32 = 10 * SECOND;

/// The clock at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    at: Micros,
    fraction_us: f32,
    /// Variance, us².
    pub variance: f32,
}

impl Reading {
    /// The instant `later_us` after the tick, to the nearest microsecond.
    pub fn rounded(&self, later_us: f32) -> Option<Micros> {
        self.at.0.checked_add_signed(math::round(self.fraction_us + later_us) as i64).map(Micros)
    }
}

/// State of the clock, for telemetry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockState {
    /// Whether pulses discipline it; TIMESYNC otherwise.
    pub by_pulses: bool,
    /// Microseconds more than ticks in a second.
    pub rate_ppm: f32,
    /// One sigma of the rate.
    pub rate_sigma_ppm: f32,
    /// Seconds since the newest pulse; `u32::MAX` without one.
    pub free_wheeling_s: u32,
}

/// The clock.
#[derive(Debug)]
pub struct Clock {
    settings: ClockSettings,
    epoch: Option<Epoch>,
    /// The newest refused pulse, and how many before it were a second apart.
    rejected: Option<(Ticks, u8)>,
    /// The shortest recent round trip, microseconds.
    shortest_us: u32,
    /// Exchanges in a row that contradict the pulses.
    contradictions: u8,
    pulses_ignored: u32,
    epochs: u32,
}

impl Clock {
    /// Without an epoch yet.
    pub const fn new(settings: ClockSettings) -> Self {
        Clock {
            settings,
            epoch: None,
            rejected: None,
            shortest_us: u32::MAX,
            contradictions: 0,
            pulses_ignored: 0,
            epochs: 0,
        }
    }

    fn pulse_variance(&self) -> f32 {
        self.settings.pulse_sigma_us * self.settings.pulse_sigma_us + ROUNDING
    }

    /// The state at `tick`.
    fn propagated(&self, tick: Ticks) -> Option<Epoch> {
        self.epoch?.propagated(tick, self.settings.rate_walk_ppm)
    }

    /// A TIMESYNC exchange: tick `sent`, the autopilot's answer `theirs`, tick `received`. Symmetric delay assumed.
    pub fn on_timesync(&mut self, sent: Ticks, theirs: Micros, received: Ticks) {
        let round_trip = received.since(sent);
        if !(0..ROUND_TRIP_MAX_US).contains(&round_trip) {
            return;
        }
        let round_trip = round_trip as u32;
        let middle = Ticks(sent.0.wrapping_add(round_trip / 2));
        // The shortest grows by a sixty-fourth an exchange, so that a link may become slower.
        self.shortest_us = self.shortest_us.saturating_add(self.shortest_us / 64).saturating_add(1).min(round_trip);
        let slow_us = 0.5 * (round_trip - self.shortest_us) as f32;
        let variance = EXCHANGE_SIGMA_US * EXCHANGE_SIGMA_US + slow_us * slow_us;
        let (floor_us, shortest_us) = (self.settings.timesync_sigma_us, self.shortest_us as f32);
        // Uniform within plus and minus half the round trip.
        let bias_variance = floor_us * floor_us + shortest_us * shortest_us * ROUNDING;

        let restarted = Epoch {
            tick: middle,
            at: theirs,
            offset_us: 0.0,
            rate_ppm: 0.0,
            offset_variance: variance,
            covariance: 0.0,
            rate_variance: self.settings.rate_sigma_ppm * self.settings.rate_sigma_ppm,
            bias_variance,
            pulse_age: NO_PULSE,
        };
        let Some(state) = self.propagated(middle) else {
            self.restart(restarted);
            return;
        };
        // The crystals are the same after a reboot: their rate is kept.
        let restarted = Epoch { rate_ppm: state.rate_ppm, rate_variance: state.rate_variance, ..restarted };
        if theirs.since(state.at).unsigned_abs() > REBOOT_US as u32 {
            self.restart(restarted);
            return;
        }
        if state.bias_variance == 0.0 {
            self.compare(state.innovation_us(theirs).abs(), round_trip, state.offset_variance);
        }
        if state.pulse_age < PULSES_LIVE_TICKS {
            return;
        }
        let is_more_accurate =
            state.bias_variance == 0.0 && state.offset_variance < bias_variance && !self.is_contradicted();
        if is_more_accurate {
            self.epoch = Some(state);
        } else if state.bias_variance == 0.0 {
            self.contradictions = 0;
            self.epoch = Some(Epoch { pulse_age: state.pulse_age, ..restarted });
        } else {
            let innovation_us = state.innovation_us(theirs);
            let state = state.widened(innovation_us.abs() - 0.5 * round_trip as f32);
            let updated = state.updated(innovation_us, variance);
            self.epoch = Epoch { bias_variance, ..updated }.normalised();
        }
    }

    /// Compares an exchange of `round_trip` ticks that is `off_us` from the clock by pulses. One much slower than the
    /// quickest proves little when it agrees.
    fn compare(&mut self, off_us: f32, round_trip: u32, offset_variance: f32) {
        if off_us > 0.5 * round_trip as f32 + self.exchange_gate_us(offset_variance) {
            self.contradictions = self.contradictions.saturating_add(1);
        } else if round_trip / 2 <= self.shortest_us {
            self.contradictions = 0;
        }
    }

    /// Gate of an exchange beyond half its round trip.
    fn exchange_gate_us(&self, variance: f32) -> f32 {
        let floor_us = self.settings.timesync_sigma_us;
        1.0 + GATE_SIGMAS * math::sqrt(floor_us * floor_us + EXCHANGE_SIGMA_US * EXCHANGE_SIGMA_US + variance)
    }

    fn is_contradicted(&self) -> bool {
        self.contradictions >= CONTRADICTIONS_MAX
    }

    fn restart(&mut self, epoch: Epoch) {
        (self.epoch, self.rejected, self.contradictions) = (Some(epoch), None, 0);
        self.epochs = self.epochs.wrapping_add(1);
    }

    /// Takes a pulse: an edge at `tick`, at a whole second of the autopilot. Ignored until a TIMESYNC has given the
    /// clock its first epoch. One beyond its gate is counted and ignored, unless it and some before it are a second
    /// apart each: then the clock is wrong and is restarted.
    pub fn on_pulse(&mut self, tick: Ticks) {
        let Some(state) = self.propagated(tick) else {
            self.pulses_ignored = self.pulses_ignored.wrapping_add(1);
            return;
        };
        let seconds = (state.at.0.saturating_add(SECOND as u64 / 2)) / SECOND as u64;
        let second = Micros(seconds * SECOND as u64);
        let innovation_us = state.innovation_us(second);
        let offset_variance = state.offset_variance + state.bias_variance;
        let variance = self.pulse_variance();
        let gate_us = if state.bias_variance > 0.0 {
            0.5 * self.shortest_us as f32 + self.exchange_gate_us(state.offset_variance + variance)
        } else {
            1.0 + GATE_SIGMAS * math::sqrt(offset_variance + variance)
        };
        if innovation_us.abs() <= gate_us {
            let state = Epoch { offset_variance, bias_variance: 0.0, pulse_age: 0, ..state };
            self.epoch = state.updated(innovation_us, variance).normalised();
            self.rejected = None;
        } else {
            self.reject_pulse(tick, second, &state);
        }
    }

    /// A pulse outside its gate. A restarted clock has the rate of the last two pulses.
    fn reject_pulse(&mut self, tick: Ticks, second: Micros, state: &Epoch) {
        self.pulses_ignored = self.pulses_ignored.wrapping_add(1);
        let since = |before: Ticks| tick.0.wrapping_sub(before.0);
        let (interval, votes) = match self.rejected {
            Some((before, votes)) if since(before).abs_diff(SECOND) <= PULSE_TOLERANCE_TICKS => {
                (since(before), votes.saturating_add(1))
            }
            _ => (0, 1),
        };
        self.rejected = Some((tick, votes));
        let needed = if state.bias_variance > 0.0 { OUTVOTE_TIMESYNC } else { OUTVOTE_PULSES };
        if votes >= needed && interval > 0 {
            let variance = self.pulse_variance();
            self.restart(Epoch {
                tick,
                at: second,
                offset_us: 0.0,
                rate_ppm: (SECOND as i32 - interval as i32) as f32 / (interval as f32 * 1e-6),
                offset_variance: variance,
                covariance: variance,
                rate_variance: 2.0 * variance,
                bias_variance: 0.0,
                pulse_age: 0,
            });
            // An exchange has to agree first.
            self.contradictions = CONTRADICTIONS_MAX;
        }
    }

    /// Moves an old epoch forwards, so that no tick is ever half the timer's range away from it.
    pub fn keep(&mut self, now: Ticks) {
        if self.epoch.is_some_and(|epoch| now.since(epoch.tick) > EPOCH_AGE_MAX_TICKS) {
            self.epoch = self.propagated(now);
        }
    }

    /// The autopilot's instant at `tick` with its variance, for ticks within half an hour of the epoch. `None` before
    /// the first epoch, and for instants before the autopilot booted.
    ///
    /// Pulses that jitter by less than half a tick are all rounded alike as long as the rates do not change, and no
    /// averaging reduces that. While pulses and exchanges contradict each other the variance is infinite.
    pub fn read(&self, tick: Ticks) -> Option<Reading> {
        let state = self.propagated(tick)?;
        let rounding = ROUNDING * rounding_correlation(self.settings.pulse_sigma_us);
        let variance = state.offset_variance.max(0.0) + state.bias_variance + rounding;
        let variance = if self.is_contradicted() { f32::INFINITY } else { variance };
        Some(Reading { at: state.at, fraction_us: state.offset_us, variance })
    }

    /// The autopilot's instant at `tick`, to the nearest microsecond, and its sigma in microseconds.
    pub fn instant(&self, tick: Ticks) -> Option<(Micros, f32)> {
        let reading = self.read(tick)?;
        Some((reading.rounded(0.0)?, math::sqrt(reading.variance + ROUNDING)))
    }

    /// State of the clock at `now`.
    pub fn state(&self, now: Ticks) -> ClockState {
        self.propagated(now).map_or_else(ClockState::default, |state| ClockState {
            by_pulses: state.bias_variance == 0.0,
            rate_ppm: state.rate_ppm,
            rate_sigma_ppm: math::sqrt(state.rate_variance),
            free_wheeling_s: if state.pulse_age == NO_PULSE { u32::MAX } else { state.pulse_age / SECOND },
        })
    }

    /// Number of pulses ignored, and of restarts of the clock.
    pub fn counted(&self) -> (u32, u32) {
        (self.pulses_ignored, self.epochs)
    }
}
