//! The board's capture timer: free-running, 1 MHz, 32 bits, on a quartz of its own.

use crate::scenario::Scenario;

/// Maps the autopilot's clock to the timer's count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimerModel {
    /// Count at the autopilot's time 0.
    pub start_ticks: u32,
    /// How much faster than the autopilot's clock it runs, parts per million.
    pub drift_ppm: f64,
}

impl TimerModel {
    /// The scenario's timer.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        TimerModel { start_ticks: scenario.timer.start_ticks, drift_ppm: scenario.timer.drift_ppm }
    }

    /// What a capture at `t_us` latches: the ticks completed since time 0 on top of the start, wrapping.
    #[must_use]
    pub fn ticks(&self, t_us: u64) -> u32 {
        // The drift alone is small enough for f64 over any flight; the count itself stays in integers.
        let drift_ticks = (t_us as f64 * self.drift_ppm * 1e-6).floor() as i64;
        self.start_ticks.wrapping_add(t_us.wrapping_add_signed(drift_ticks) as u32)
    }
}
