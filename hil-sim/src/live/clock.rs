//! The autopilot's clock at instants of our own: a line through the quickest TIMESYNC exchanges of the last seconds.
//!
//! A simulated autopilot's clock does not run as ours: it stands still while the simulator is paused or short of processor, runs
//! at the simulator's speed, and goes in steps, since the simulator computes some milliseconds at once and then sleeps. An
//! exchange says what it showed between request and answer; the quickest ones were answered as it woke, at the beginning of a
//! step. The line through them is smooth, as a board's timer has to be. An autopilot may take off what its serial line would
//! have taken (some milliseconds at 57,600 baud), though there is none: the stamps of its messages say so, since its clock shows
//! a stamp when that arrives, and the line is moved up to their lower quartile: they lie anywhere in a step, exchanges at its
//! beginning. Where no stamps arrive any more the relation waits for them.

use std::collections::VecDeque;

/// How far back the line looks, seconds. Chosen: 16 exchanges of 2 ms scatter tie it to half a millisecond, and a speed that
/// changes is followed within a few seconds.
const WINDOW_S: f64 = 4.0;
/// Of each so many seconds the quickest exchange counts, of about five.
const BIN_S: f64 = 0.25;
/// Bins that a rate takes; with fewer it stays as it was.
const RATE_BINS: usize = 5;
/// An exchange off the line by its round trip and this much says that the clock has stood still or jumped, microseconds.
/// Chosen: above the steps of a simulator, 5 ms at single speed, and not by much: what is taken for scatter stays in the line for
/// seconds.
const JUMP_US: f64 = 8_000.0;
/// Likewise of a stamp ahead of the relation, in which it is a step ahead at most.
const STAMP_JUMP_US: f64 = 12_000.0;
/// Exchanges that take so many times the median are left out.
const SLOW: f64 = 2.0;
/// Stamps that a quartile takes.
const STAMPS_MIN: usize = 20;
/// Exchanges off the line by more than so many times the others' scatter are left out.
const GATE: f64 = 4.0;

/// A TIMESYNC exchange; seconds of our clock.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Exchange {
    middle_s: f64,
    trip_s: f64,
    theirs_us: f64,
}

/// `at_us` at `at_s`, `rate` microseconds a microsecond from there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    at_s: f64,
    at_us: f64,
    rate: f64,
}

impl Line {
    fn at(&self, wall_s: f64) -> f64 {
        self.at_us + (wall_s - self.at_s) * 1e6 * self.rate
    }
}

/// How good the relation was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockErrors {
    /// Root mean square distance of the quickest exchanges from the line, microseconds.
    pub scatter_us: f64,
    /// Mean of half the quickest exchanges' round trips, microseconds: what an asymmetry can hide.
    pub half_trip_us: f64,
    /// Exchanges.
    pub exchanges: u64,
    /// How much stamps are ahead of exchanges, microseconds.
    pub ahead_us: f64,
    /// How often the clock was found to have stood still or jumped.
    pub jumps: u32,
    /// Microseconds of the autopilot's clock a microsecond of ours.
    pub rate: f64,
}

/// The relation.
#[derive(Debug)]
pub struct Clock {
    exchanges: VecDeque<Exchange>,
    /// Stamps of the last seconds, microseconds, and when they arrived.
    stamps: VecDeque<(f64, f64)>,
    line: Option<Line>,
    /// Whether its rate is from exchanges; before that nothing is a jump.
    has_rate: bool,
    /// What stamps are ahead of the exchanges.
    ahead_us: f64,
    /// The newest stamp, microseconds.
    newest_us: f64,
    hold_us: f64,
    squares: (f64, u64),
    half_trips_us: (f64, u64),
    count: u64,
    jumps: u32,
}

impl Clock {
    /// Nothing is known yet. `hold_us`: how far it goes beyond the newest stamp, a few intervals of the stream.
    pub fn new(hold_us: f64) -> Self {
        let (squares, half_trips_us) = ((0.0, 0), (0.0, 0));
        let (exchanges, stamps) = (VecDeque::new(), VecDeque::new());
        let (line, has_rate, ahead_us, newest_us, count, jumps) = (None, false, 0.0, 0.0, 0, 0);
        Clock { exchanges, stamps, line, has_rate, ahead_us, newest_us, hold_us, squares, half_trips_us, count, jumps }
    }

    /// What the autopilot's clock shows at `wall_s`, microseconds. It may go back a little from one exchange to the next.
    pub fn at(&self, wall_s: f64) -> Option<f64> {
        let line = self.line?;
        let hold_us = self.hold_us * line.rate.max(1.0);
        let at_us = line.at(wall_s) + self.ahead_us;
        Some(if self.newest_us > 0.0 { at_us.min(self.newest_us + hold_us) } else { at_us })
    }

    /// A stamp of its clock has arrived at `wall_s`: it shows at least that.
    pub fn stamped(&mut self, wall_s: f64, stamp_us: f64) {
        self.newest_us = self.newest_us.max(stamp_us);
        if let Some(line) = self.line.as_mut().filter(|_| self.has_rate)
            && stamp_us > line.at(wall_s) + self.ahead_us + STAMP_JUMP_US * line.rate.max(1.0)
        {
            *line = Line { at_s: wall_s, at_us: stamp_us - self.ahead_us, ..*line };
            self.forget();
        }
        self.stamps.push_back((wall_s, stamp_us));
        while self.stamps.front().is_some_and(|(first_s, _)| *first_s < wall_s - WINDOW_S) {
            self.stamps.pop_front();
        }
    }

    /// The clock has jumped: what was before says nothing.
    fn forget(&mut self) {
        self.exchanges.clear();
        self.stamps.clear();
        self.jumps += 1;
    }

    /// A request sent at `sent_s` was answered with `theirs_us`, which arrived at `received_s`.
    pub fn exchanged(&mut self, sent_s: f64, received_s: f64, theirs_us: f64) {
        let (middle_s, trip_s) = (0.5 * (sent_s + received_s), received_s - sent_s);
        if trip_s.is_nan() || trip_s < 0.0 {
            return;
        }
        self.count += 1;
        if let Some(line) = self.line.as_mut().filter(|_| self.has_rate) {
            let tolerance_us = (1e6 * trip_s + JUMP_US) * line.rate.max(1.0);
            if (theirs_us - line.at(middle_s)).abs() > tolerance_us {
                *line = Line { at_s: middle_s, at_us: theirs_us, ..*line };
                self.forget();
            }
        }
        self.exchanges.push_back(Exchange { middle_s, trip_s, theirs_us });
        while self.exchanges.front().is_some_and(|first| first.middle_s < middle_s - WINDOW_S) {
            self.exchanges.pop_front();
        }
        self.fit();
    }

    /// How good it was so far.
    pub fn errors(&self) -> ClockErrors {
        let mean = |(sum, count): (f64, u64)| sum / count.max(1) as f64;
        ClockErrors {
            scatter_us: mean(self.squares).sqrt(),
            half_trip_us: mean(self.half_trips_us),
            exchanges: self.count,
            ahead_us: self.ahead_us,
            jumps: self.jumps,
            rate: self.line.map_or(1.0, |line| line.rate),
        }
    }

    fn fit(&mut self) {
        let quickest = self.quickest();
        let before = self.line.map_or(1.0, |line| line.rate);
        let Some(line) = through(&quickest, before) else { return };
        let off = |exchange: &&Exchange| (exchange.theirs_us - line.at(exchange.middle_s)).abs();
        let mut distances: Vec<f64> = quickest.iter().map(|exchange| off(&exchange)).collect();
        distances.sort_by(f64::total_cmp);
        let gate_us = GATE * distances.get(distances.len() / 2).copied().unwrap_or(0.0).max(100.0);
        let kept: Vec<Exchange> = quickest.iter().filter(|exchange| off(exchange) <= gate_us).copied().collect();
        let Some(line) = through(&kept, before) else { return };
        self.line = Some(line);
        self.has_rate |= kept.len() >= RATE_BINS;
        let mut ahead_us: Vec<f64> = self.stamps.iter().map(|(wall_s, stamp)| stamp - line.at(*wall_s)).collect();
        ahead_us.sort_by(f64::total_cmp);
        if ahead_us.len() >= STAMPS_MIN {
            self.ahead_us = ahead_us[ahead_us.len() / 4].max(0.0);
        }
        // The newest bin's quickest is not known before the bin is full.
        for exchange in kept.iter().rev().skip(1).take(usize::from(kept.len() >= RATE_BINS)) {
            let off_us = exchange.theirs_us - line.at(exchange.middle_s);
            self.squares = (self.squares.0 + off_us * off_us, self.squares.1 + 1);
            self.half_trips_us = (self.half_trips_us.0 + 0.5e6 * exchange.trip_s, self.half_trips_us.1 + 1);
        }
    }

    /// The quickest exchange of each bin, without those that are slow beside all: the clock stood still meanwhile.
    fn quickest(&self) -> Vec<Exchange> {
        let mut trips_s: Vec<f64> = self.exchanges.iter().map(|exchange| exchange.trip_s).collect();
        trips_s.sort_by(f64::total_cmp);
        let slow_s = SLOW * trips_s.get(trips_s.len() / 2).copied().unwrap_or(0.0);
        let mut quickest: Vec<Exchange> = Vec::new();
        for exchange in self.exchanges.iter().filter(|exchange| exchange.trip_s <= slow_s) {
            let bin = (exchange.middle_s / BIN_S).floor();
            match quickest.last_mut() {
                Some(last) if (last.middle_s / BIN_S).floor() == bin => {
                    if exchange.trip_s < last.trip_s {
                        *last = *exchange;
                    }
                }
                _ => quickest.push(*exchange),
            }
        }
        quickest
    }
}

/// The line through exchanges by least squares; of too few with the rate that it had `before`.
fn through(exchanges: &[Exchange], before: f64) -> Option<Line> {
    let last = exchanges.last()?;
    let count = exchanges.len() as f64;
    let mean_s = exchanges.iter().map(|e| e.middle_s).sum::<f64>() / count;
    let mean_us = exchanges.iter().map(|e| e.theirs_us - last.theirs_us).sum::<f64>() / count + last.theirs_us;
    let (mut square, mut product) = (0.0, 0.0);
    for exchange in exchanges {
        let later_s = exchange.middle_s - mean_s;
        square += later_s * later_s;
        product += later_s * (exchange.theirs_us - mean_us);
    }
    let rate = if exchanges.len() < RATE_BINS || square == 0.0 { before } else { product / square * 1e-6 };
    // No clock runs backwards.
    Some(Line { at_s: mean_s, at_us: mean_us, rate: rate.max(0.0) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{stream, uniform};

    /// Exchanges 20 times a second and stamps 100 times from `from_s` to `to_s` with a clock that goes in steps of 5 ms: the
    /// simulator sleeps through a step and then computes it at once. `shows`: what it would show without steps. Its answers are
    /// `early_us` too early, as by a serial line.
    fn exchange(clock: &mut Clock, [from_s, to_s]: [f64; 2], early_us: f64, shows: impl Fn(f64) -> f64) {
        let mut rng = stream(from_s.to_bits(), "exchanges");
        let (mut sent_s, mut stamped_s) = (from_s, from_s);
        while sent_s < to_s {
            let awake = |at_s: f64| (at_s / 0.005).ceil() * 0.005;
            let mut late_s = || 0.0005 + 0.001 * uniform(&mut rng);
            while stamped_s < sent_s {
                // Computed at the beginning of the step before.
                clock.stamped(awake(stamped_s) - 0.005 + late_s(), shows(stamped_s));
                stamped_s += 0.01033;
            }
            let answered_s = awake(sent_s) + late_s();
            clock.exchanged(sent_s, answered_s, shows(awake(sent_s)) - early_us);
            sent_s += 0.047;
        }
    }

    #[test]
    fn a_clock_in_steps_is_followed_to_a_millisecond_at_any_speed() {
        for rate in [0.5, 1.0, 5.0] {
            let shows = |wall_s: f64| 7e6 + 1e6 * rate * wall_s;
            let mut clock = Clock::new(40_000.0);
            exchange(&mut clock, [0.0, 20.0], 0.0, shows);
            let off_us = clock.at(20.0).unwrap() - shows(20.0);
            // A step's quarter ahead of its beginning.
            assert!((off_us / rate - 500.0).abs() < 1500.0, "{off_us} us at {rate}");
            let errors = clock.errors();
            assert!((errors.rate / rate - 1.0).abs() < 1e-3 && errors.jumps == 0, "{errors:?}");
            assert!(errors.scatter_us < 1500.0 * rate && errors.half_trip_us < 2000.0, "{errors:?}");
        }
    }

    #[test]
    fn what_an_autopilot_takes_off_for_a_serial_line_is_put_back() {
        let shows = |wall_s: f64| 7e6 + 1e6 * wall_s;
        let off_us = |early_us: f64| {
            let mut clock = Clock::new(40_000.0);
            exchange(&mut clock, [0.0, 20.0], early_us, shows);
            clock.at(20.0).unwrap() - shows(20.0)
        };
        assert!((off_us(5000.0) - off_us(0.0)).abs() < 300.0, "{} {}", off_us(5000.0), off_us(0.0));
    }

    #[test]
    fn it_waits_for_a_clock_that_stands_still_and_goes_on_with_it() {
        let mut clock = Clock::new(40_000.0);
        exchange(&mut clock, [0.0, 10.0], 0.0, |wall_s| 1e6 * wall_s);
        // Nothing comes for two seconds.
        let held_us = clock.at(12.0).unwrap();
        assert!((9.95e6..10.05e6).contains(&held_us), "{held_us}");
        let shows = |wall_s: f64| 1e6 * (wall_s - 2.0);
        exchange(&mut clock, [12.0, 12.2], 0.0, shows);
        let off_us = clock.at(12.2).unwrap() - shows(12.2);
        assert!(off_us.abs() < 8000.0, "{off_us}");
        exchange(&mut clock, [12.2, 18.0], 0.0, shows);
        let off_us = clock.at(18.0).unwrap() - shows(18.0);
        assert!(off_us.abs() < 2500.0 && clock.errors().jumps == 1, "{off_us} {:?}", clock.errors());
    }

    /// A simulator short of processor: 30 ms behind for a second, and then back.
    #[test]
    fn a_clock_that_falls_behind_and_catches_up_is_followed_at_once() {
        let shows = |wall_s: f64| 1e6 * (wall_s - if (10.0..11.0).contains(&wall_s) { 0.03 } else { 0.0 });
        let mut clock = Clock::new(80_000.0);
        exchange(&mut clock, [0.0, 10.0], 0.0, shows);
        for (from_s, to_s) in [(10.0, 10.3), (10.3, 10.9), (10.9, 11.3), (11.3, 12.0)] {
            exchange(&mut clock, [from_s, to_s], 0.0, shows);
            let off_us = clock.at(to_s).unwrap() - shows(to_s);
            assert!(off_us.abs() < 3000.0, "{off_us} at {to_s}");
        }
        assert_eq!(clock.errors().jumps, 2);
    }

    #[test]
    fn before_any_exchange_it_shows_nothing() {
        let mut clock = Clock::new(40_000.0);
        assert_eq!(clock.at(1.0), None);
        clock.stamped(1.0, 5e6);
        assert_eq!(clock.at(1.0), None);
        clock.exchanged(2.0, 1.0, 6e6);
        assert_eq!(clock.at(1.0), None);
    }
}
