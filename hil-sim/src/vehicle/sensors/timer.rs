//! The board's capture timer: free-running, 1 MHz, 32 bits, on a quartz of its own.

use crate::noise::{normal, stream};
use crate::scenario::Scenario;

/// The rate's walk takes a step this often, microseconds.
const STEP_US: u64 = 100_000;

/// Maps the autopilot's clock to the timer's count.
#[derive(Debug, Clone, PartialEq)]
pub struct TimerModel {
    /// Count at the autopilot's time 0.
    pub start_ticks: u32,
    /// How much faster than the autopilot's clock it runs at time 0, parts per million.
    pub drift_ppm: f64,
    /// The walk: ticks gained by it and the rate reached, parts per million, at each step; the last rate stays.
    walk: Vec<(f64, f64)>,
}

impl TimerModel {
    /// A timer whose rate stays.
    #[must_use]
    pub fn steady(start_ticks: u32, drift_ppm: f64) -> Self {
        TimerModel { start_ticks, drift_ppm, walk: Vec::new() }
    }

    /// The scenario's timer. Its rate does a random walk: its variance grows by the square of `timer.rate_walk_ppm` in
    /// a second.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let (timer, rate_walk_ppm) = (&scenario.world.timer, scenario.vehicle.timer.rate_walk_ppm);
        let mut rng = stream(scenario.run.seed, "timer.walk");
        let step_s = STEP_US as f64 * 1e-6;
        let steps = scenario.run.duration_us() / STEP_US + 1;
        let (mut gained, mut rate_ppm) = (0.0, 0.0);
        let walk = (0..steps).map(|_| {
            let here = (gained, rate_ppm);
            gained += rate_ppm * step_s;
            rate_ppm += rate_walk_ppm * step_s.sqrt() * normal(&mut rng);
            here
        });
        let walk = if rate_walk_ppm > 0.0 { walk.collect() } else { Vec::new() };
        TimerModel { walk, ..TimerModel::steady(timer.start_ticks, timer.drift_ppm) }
    }

    /// What a capture at `t_us` latches: the ticks completed since time 0 on top of the start, wrapping.
    #[must_use]
    pub fn ticks(&self, t_us: u64) -> u32 {
        self.latch(t_us as f64)
    }

    /// As [`TimerModel::ticks`], between whole microseconds.
    #[must_use]
    pub fn latch(&self, t_us: f64) -> u32 {
        // What is gained is small enough for f64 over any flight; the count itself stays in integers.
        let whole_us = t_us.floor();
        let gained = (t_us - whole_us + t_us * self.drift_ppm * 1e-6 + self.walked(t_us)).floor() as i64;
        self.start_ticks.wrapping_add((whole_us as i64).wrapping_add(gained) as u32)
    }

    fn walked(&self, t_us: f64) -> f64 {
        let step = ((t_us.max(0.0) as u64 / STEP_US) as usize).min(self.walk.len().saturating_sub(1));
        self.walk
            .get(step)
            .map_or(0.0, |(gained, rate_ppm)| gained + rate_ppm * (t_us - step as f64 * STEP_US as f64) * 1e-6)
    }
}
