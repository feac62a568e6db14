//! The truth as it comes: SIM_STATE, which bears no time, and the instant of each.
//!
//! All messages of one rate are sent by one loop of the autopilot, in an order of their own: an attitude stamped in milliseconds,
//! the true state, then a stamp in microseconds. Where both stamps are of one millisecond the true state is of that instant, and
//! nothing is open. Where no stamp follows at once it lies between two attitudes, at the place at which it arrives between them.
//!
//! The attitudes could be fitted to each other instead, but an estimated attitude is older than its stamp: the fit ([`ShiftFit`])
//! tells both together. With the instants known it tells how much older, which is the delay of the autopilot's filters, and what
//! a board has to be configured with.

use super::messages::SimState;
use super::shift::{Fitted, ShiftFit, Turn};
use crate::vehicle::motion::{Recorded, TrueState, recorded};
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use std::collections::VecDeque;

/// Stamps in milliseconds are cut off.
const MILLISECOND_US: f64 = 1000.0;
/// They lie this much too early on average, microseconds.
pub const STAMP_CUT_US: f64 = 0.5 * MILLISECOND_US;
/// Attitudes on each side of a true one that its rate of turning is taken over: at 100 Hz 40 ms, so that the stamps' milliseconds
/// do not matter.
const ASIDE: usize = 2;
/// Attitudes after which the shift is settled anew: some four times a second.
const SETTLE_EVERY: u32 = 25;
/// Arrivals that the order's fraction is the middle of.
const ARRIVALS_MAX: usize = 201;

/// Whose place it is, on which grid.
#[derive(Clone, Debug)]
pub struct Place {
    /// The ground's reference system.
    pub crs: Crs,
    /// Home's height above mean sea level: that of the flat ground.
    pub home_alt_m: f64,
}

impl Place {
    /// The vehicle in a state: its antenna's place on the grid, above home.
    ///
    /// # Errors
    /// A place that the grid does not have.
    pub fn state(&self, sim: &SimState) -> Result<TrueState, InputError> {
        let [lat, lon] = sim.place_e7.unwrap_or_default().map(|e7| f64::from(e7) * 1e-7);
        let (east_m, north_m) = self.crs.from_wgs84(lat, lon)?;
        let convergence_rad = self.crs.convergence_rad(east_m, north_m)?;
        let [heading_true, pitch_rad, roll_rad] = angles(sim.attitude);
        let [north, east, down] = sim.velocity_ned_m_s;
        let (sin, cos) = convergence_rad.sin_cos();
        Ok(TrueState {
            east_m,
            north_m,
            up_m: sim.alt_m - self.home_alt_m,
            heading_rad: crate::vehicle::servo::wrapped(heading_true - convergence_rad),
            pitch_rad,
            roll_rad,
            follow_up_rad: 0.0,
            // Grid north lies clockwise of true north by the convergence.
            velocity_enu_m_s: [east * cos - north * sin, north * cos + east * sin, -down],
        })
    }
}

/// Heading from true north, pitch, roll.
fn angles([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
        (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin(),
        (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
    ]
}

/// An attitude with a time, and when it came.
#[derive(Clone, Copy, Debug)]
struct Timed {
    stamp_us: f64,
    arrived_s: f64,
    attitude: [f64; 4],
}

/// A true state that waits for the attitudes after it.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// Counts the attitude before it.
    before: u64,
    arrived_s: f64,
    attitude: [f64; 4],
}

/// A true state between two stamps, microseconds.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The millisecond of the attitude before it.
    before_us: f64,
    /// The stamp behind it, infinite until it comes.
    after_us: f64,
    state: TrueState,
}

impl Sample {
    /// Whether its instant is the stamp behind it: that is of the same millisecond.
    fn is_pinned(&self) -> bool {
        self.after_us - self.before_us < MILLISECOND_US
    }

    fn instant_us(&self, shift_us: f64) -> f64 {
        if self.is_pinned() { self.after_us } else { self.before_us + shift_us }
    }
}

/// What is known of the true states' instants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// From the millisecond of the attitude before a true state to its instant, microseconds: of those that are not pinned.
    pub us: f64,
    /// The instants' error, at most.
    pub error_us: f64,
    /// Share of true states that have the stamp of their own instant behind them.
    pub pinned: f64,
    /// What the attitudes say: how much older than its stamp the estimated one is, and the true state younger; `None` where
    /// the vehicle has hardly turned.
    pub fitted: Option<Fitted>,
    /// From one attitude to the next, microseconds.
    pub interval_us: f64,
}

impl Shift {
    /// How much older than its stamp the autopilot's estimated attitude is, microseconds, and one sigma, where the instants
    /// are known without it.
    pub fn attitude_delay_us(&self) -> Option<[f64; 2]> {
        let fitted = self.fitted.filter(|_| self.pinned > 0.5)?;
        Some([fitted.shift_us, fitted.sigma_us])
    }
}

/// The truth of a flight.
#[derive(Debug, Default)]
pub struct Truth {
    /// The newest attitudes, and how many came before them.
    attitudes: VecDeque<Timed>,
    passed: u64,
    waiting: VecDeque<Waiting>,
    fit: ShiftFit,
    fractions: VecDeque<f64>,
    intervals_us: VecDeque<f64>,
    samples: Vec<Sample>,
    pinned: u64,
    /// True states without an attitude of their own before them.
    pub unordered: u64,
    /// The shift as it was settled last, and attitudes since.
    settled: Shift,
    since: u32,
}

impl Truth {
    /// An estimated attitude, stamped `time_boot_ms`.
    pub fn attitude(&mut self, time_boot_ms: u32, attitude: [f64; 4], arrived_s: f64) {
        let stamp_us = f64::from(time_boot_ms) * MILLISECOND_US;
        if self.attitudes.back().is_some_and(|last| stamp_us <= last.stamp_us) {
            return;
        }
        if let Some(last) = self.attitudes.back() {
            keep(&mut self.intervals_us, stamp_us - last.stamp_us);
        }
        // Only the millisecond is known.
        self.stamp(stamp_us + MILLISECOND_US);
        self.attitudes.push_back(Timed { stamp_us, arrived_s, attitude });
        while let Some(waiting) = self.waiting.front().copied() {
            let index = (waiting.before - self.passed) as usize;
            if index + ASIDE >= self.attitudes.len() {
                break;
            }
            self.waiting.pop_front();
            self.compare(index, &waiting);
        }
        let needed = self.waiting.front().map_or(self.passed + self.attitudes.len() as u64 - 1, |first| first.before);
        while self.passed + (ASIDE as u64) < needed {
            self.attitudes.pop_front();
            self.passed += 1;
        }
        self.since += 1;
        if self.since >= SETTLE_EVERY {
            self.settle();
        }
    }

    /// A stamp behind a true state.
    pub fn stamp(&mut self, stamp_us: f64) {
        let Some(last) = self.samples.last_mut() else { return };
        // One of another clock is none.
        if last.after_us.is_infinite() && stamp_us >= last.before_us {
            last.after_us = stamp_us;
            self.pinned += u64::from(last.is_pinned());
        }
    }

    /// A true state, `attitude` its [w, x, y, z] and `state` what it is on the grid.
    pub fn state(&mut self, attitude: [f64; 4], state: TrueState, arrived_s: f64) {
        let Some(before) = self.attitudes.back().copied() else { return };
        if self.samples.last().is_some_and(|last| last.before_us >= before.stamp_us) {
            self.unordered += 1;
            return;
        }
        self.samples.push(Sample { before_us: before.stamp_us, after_us: f64::INFINITY, state });
        let before = self.passed + self.attitudes.len() as u64 - 1;
        self.waiting.push_back(Waiting { before, arrived_s, attitude });
    }

    /// A true attitude beside the estimated one before it.
    fn compare(&mut self, index: usize, waiting: &Waiting) {
        let Some(first) = index.checked_sub(ASIDE).and_then(|first| self.attitudes.get(first)) else { return };
        let (before, next, last) = (&self.attitudes[index], &self.attitudes[index + 1], &self.attitudes[index + ASIDE]);
        let span_s = next.arrived_s - before.arrived_s;
        if span_s > 0.0 {
            keep(&mut self.fractions, ((waiting.arrived_s - before.arrived_s) / span_s).clamp(0.0, 1.0));
        }
        let turned_s = (last.stamp_us - first.stamp_us) * 1e-6;
        let rate_rad_s = turn(first.attitude, last.attitude).map(|rad| rad / turned_s);
        let turn_rad = turn(before.attitude, waiting.attitude);
        self.fit.take(Turn { at_us: before.stamp_us, turn_rad, rate_rad_s });
    }

    /// Settles the shift by all that is known: from now on every instant is by it.
    pub fn settle(&mut self) -> Shift {
        self.since = 0;
        let interval_us = middle(&self.intervals_us).unwrap_or(0.0);
        let pinned = self.pinned as f64 / self.samples.len().max(1) as f64;
        let fitted = self.fit.fitted();
        let shift = Shift { pinned, fitted, interval_us, ..Shift::default() };
        self.settled = if pinned > 0.5 {
            Shift { us: 0.5 * MILLISECOND_US, error_us: 0.5 * MILLISECOND_US, ..shift }
        } else {
            // Where between two attitudes the states arrive, and what their order leaves open.
            let us = 0.5 * MILLISECOND_US + middle(&self.fractions).unwrap_or(0.5) * interval_us;
            Shift { us, error_us: us.max(interval_us + MILLISECOND_US - us), ..shift }
        };
        self.settled
    }

    /// The truth at an instant; `None` while the samples after it have not come, and in gaps.
    pub fn at(&self, at_us: f64) -> Option<TrueState> {
        recorded(&self.around(at_us, at_us), at_us)
    }

    /// The newest instant that is known, microseconds.
    pub fn newest_us(&self) -> Option<f64> {
        self.samples.last().map(|sample| sample.instant_us(self.settled.us))
    }

    /// The newest state.
    pub fn newest(&self) -> Option<&TrueState> {
        self.samples.last().map(|sample| &sample.state)
    }

    /// The samples from `from_us` to `to_us` and one beyond each end.
    pub fn around(&self, from_us: f64, to_us: f64) -> Vec<Recorded> {
        let instant_us = |sample: &Sample| sample.instant_us(self.settled.us);
        let first = self.samples.partition_point(|sample| instant_us(sample) <= from_us).saturating_sub(1);
        let end = (self.samples.partition_point(|sample| instant_us(sample) < to_us) + 1).min(self.samples.len());
        let within = self.samples.get(first..end).unwrap_or_default();
        within.iter().map(|sample| (instant_us(sample), sample.state)).collect()
    }

    /// All samples.
    pub fn all(&self) -> Vec<Recorded> {
        self.around(f64::NEG_INFINITY, f64::INFINITY)
    }
}

fn keep(values: &mut VecDeque<f64>, value: f64) {
    values.push_back(value);
    if values.len() > ARRIVALS_MAX {
        values.pop_front();
    }
}

fn middle(values: &VecDeque<f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// The turn from one attitude to another, about the axes of the first: radians.
fn turn(from: [f64; 4], to: [f64; 4]) -> [f64; 3] {
    let [aw, ax, ay, az] = [from[0], -from[1], -from[2], -from[3]];
    let [bw, bx, by, bz] = to;
    let w = aw * bw - ax * bx - ay * by - az * bz;
    let v = [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ];
    let sin = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    // The shorter of both ways round.
    let angle = 2.0 * sin.atan2(w.abs()) * w.signum();
    if sin > 0.0 { v.map(|x| x / sin * angle) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests;
