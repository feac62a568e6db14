//! When the camera exposes.

use crate::noise::{White, stream, uniform};
use crate::scenario::{Scenario, WARM_UP_US, vehicle};
use plumbline_core::stamp::EXPOSURE_MAX_US;
use plumbline_firmware::wire::telemetry::ExposureReport;

/// One exposure, microseconds of the autopilot's clock; with a rolling shutter that of the middle row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exposure {
    /// Counts from 0.
    pub frame: u32,
    /// What the camera is set to; the shutter's jitter comes to it.
    pub set_us: u32,
    /// The shutter opens.
    pub open_us: u64,
    /// The shutter closes.
    pub close_us: u64,
    /// The first row reaches the board; with a rolling shutter not before the last row's exposure has ended, so that no
    /// row is handed over before it was taken.
    pub readout_start_us: u64,
}

impl Exposure {
    /// The true middle of the exposure: open + (close − open)/2, rounded down.
    #[must_use]
    pub fn mid_us(&self) -> u64 {
        self.open_us + (self.close_us - self.open_us) / 2
    }

    /// The true middle of the exposure without rounding.
    #[must_use]
    pub fn mid_exact_us(&self) -> f64 {
        self.open_us as f64 + 0.5 * (self.close_us - self.open_us) as f64
    }
}

/// Sigmas beyond which no arrival is early or late: the board's gate takes five.
const ARRIVAL_SIGMAS_MAX: f64 = 4.0;

/// The shutter: makes exposures of openings.
#[derive(Debug)]
pub struct Shutter {
    exposure_us: u32,
    /// Commands that do not hold yet, in the order of their frames.
    commands: Vec<ExposureReport>,
    /// The frame that is exposed next.
    next: u32,
    settings: vehicle::Shutter,
    last_row_us: u64,
    length: White,
    arrival: White,
}

impl Shutter {
    /// The scenario's.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Shutter {
            exposure_us: scenario.vehicle.exposure_us,
            commands: Vec::new(),
            next: 0,
            settings: scenario.vehicle.shutter,
            last_row_us: scenario.vehicle.rolling_shutter_us().div_ceil(2),
            length: White::new(1.0, scenario.run.seed, "shutter.length"),
            arrival: White::new(1.0, scenario.run.seed, "frame.arrival"),
        }
    }

    /// Takes a command of the firmware. A sensor has taken over the settings of the frame that it exposes next, so a command
    /// holds for none before the one behind that.
    pub fn command(&mut self, command: ExposureReport) {
        let us = command.us.clamp(1, EXPOSURE_MAX_US as u32);
        self.commands.push(ExposureReport { from: command.from.max(self.next), us });
    }

    /// The camera has lost its power, and with it what it was told.
    pub fn restart(&mut self, scenario: &Scenario) {
        (self.exposure_us, self.commands) = (scenario.vehicle.exposure_us, Vec::new());
    }

    /// Exposure `frame`, which opens at `open_us`. Its first row arrives the latency after it closed, more or less the
    /// arrival's jitter.
    pub fn expose(&mut self, frame: u32, open_us: u64) -> Exposure {
        let held = self.commands.iter().rposition(|command| command.from <= frame);
        if let Some(newest) = held {
            self.exposure_us = self.commands[newest].us;
            self.commands.drain(..=newest);
        }
        self.next = frame + 1;
        let shutter = &self.settings;
        let length_us =
            (f64::from(self.exposure_us) + shutter.exposure_jitter_us * self.length.draw()).round().max(1.0) as u64;
        let close_us = open_us + length_us;
        let off = self.arrival.draw().clamp(-ARRIVAL_SIGMAS_MAX, ARRIVAL_SIGMAS_MAX);
        let latency_us = f64::from(shutter.arrival_latency_us) + shutter.arrival_jitter_us * off;
        let readout_start_us = close_us + self.last_row_us + latency_us.round().max(1.0) as u64;
        Exposure { frame, set_us: self.exposure_us, open_us, close_us, readout_start_us }
    }
}

/// The exposures of a flight without a plan, all of them as long as the scenario says.
pub fn exposures(scenario: &Scenario) -> impl Iterator<Item = Exposure> + use<> {
    let mut shutter = Shutter::new(scenario);
    openings(scenario).map(move |(frame, open_us)| shutter.expose(frame, open_us))
}

/// When the shutter opens in a flight without a plan, by frame: frame k at the warm-up's end + k intervals + a random part of the
/// jitter.
pub fn openings(scenario: &Scenario) -> impl Iterator<Item = (u32, u64)> + use<> {
    let mut rng = stream(scenario.run.seed, "shutter");
    let interval_us = scenario.run.frame_interval_us();
    let jitter_us = f64::from(scenario.run.frame_jitter_us);
    (0..scenario.run.frames).map(move |frame| {
        let late_us = (jitter_us * uniform(&mut rng)) as u64;
        (frame, WARM_UP_US + u64::from(frame) * interval_us + late_us)
    })
}
