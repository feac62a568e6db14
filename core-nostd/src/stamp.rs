//! From shutter edges to the instant of mid-exposure on the autopilot's clock (paper 000, section 2.5 of its
//! corrected form).
//!
//! A capture timer latches the shutter's opening and closing, the pulse-per-second edges and the arrival of a frame's
//! first row, all with the same free-running 32-bit 1 MHz counter. [`edges`] keeps the shutter's edges without their
//! bounces, `association` finds those that belong to a frame, [`clock`] relates the counter to the autopilot's clock, and
//! [`Stamper`] makes a [`Stamp`] of the three.
//!
//! Every latch is the count completed at its instant, so it comes half a tick early in the mean. Pulses, edges and
//! arrivals do so alike, and only differences between them matter.

pub mod settings;
pub mod edges;
mod association;
pub mod clock;

use crate::math;
use crate::units::{Micros, Ticks};
pub use association::Association;
pub use clock::{Clock, ClockState};
pub use edges::{Edge, EdgeError, Edges};
pub use settings::{
    ClockSettings, ExposureLimits, KnownExposure, Polarity, SettingsError, ShutterSettings, StampSettings, Wired,
};

/// Longest possible exposure, microseconds; a longer one is a lost edge.
pub const EXPOSURE_MAX_US: i32 = 500_000;
/// Variance of a value that is rounded to whole units: of a latch in ticks, of a stamp in microseconds.
pub(crate) const ROUNDING: f32 = 1.0 / 12.0;

/// Both edges of one exposure on the capture timer.
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

/// Source of a stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum StampSource {
    /// Opening and closing edge.
    BothEdges = 0,
    /// One of them, and the known exposure.
    OneEdge = 1,
    /// The frame's arrival less its calibrated latency, and the known exposure.
    Arrival = 2,
}

impl StampSource {
    /// The source with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        [StampSource::BothEdges, StampSource::OneEdge, StampSource::Arrival].get(code as usize).copied()
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            StampSource::BothEdges => "both_edges",
            StampSource::OneEdge => "one_edge",
            StampSource::Arrival => "arrival",
        }
    }
}

/// When a frame was exposed, on the autopilot's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamp {
    /// The shutter opened.
    pub open: Micros,
    /// The shutter closed.
    pub close: Micros,
    /// The middle of the exposure: the instant that the picture belongs to.
    pub mid: Micros,
    /// One sigma of `mid`: edges or arrival, exposure, the clock at that instant, rounding.
    pub sigma_us: f32,
    /// What it was made of.
    pub source: StampSource,
}

/// Why a frame gets no stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StampError {
    /// Nothing relates the timer to the autopilot's clock yet.
    NoClock,
    /// The clock has run free for too long, or pulses and time exchanges contradict each other: its sigma is beyond the
    /// settings' limit.
    UncertainClock,
    /// Opening and closing edge are further apart than any exposure is long, or in the wrong order.
    BadExposure,
    /// The edges contradict each other, the known exposure or the frame's arrival.
    Contradiction,
    /// Not both edges are there, and no exposure is known that could stand for the other.
    NoExposure,
    /// The frame did not arrive after the one before.
    Backwards,
}

/// How often the stamps' input was not as it should be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StampCounters {
    /// Edges that were bounces or stray short pulses.
    pub edges_bounced: u32,
    /// Edges that were latched twice or ran backwards.
    pub edges_bad: u32,
    /// Edges that a frame should have had and had not.
    pub edges_missing: u32,
    /// Pulses off by more than the clock's gate.
    pub pulses_ignored: u32,
    /// Times that the clock was restarted at a new epoch.
    pub clock_epochs: u32,
}

/// Edges, pulses and time exchanges in, stamps out.
#[derive(Debug)]
pub struct Stamper {
    shutter: ShutterSettings,
    sigma_max_us: f32,
    edges: Edges,
    /// The capture timer on the autopilot's clock.
    pub clock: Clock,
    counters: StampCounters,
}

impl Stamper {
    /// Before the first edge. The settings have been checked by [`StampSettings::check`].
    pub fn new(settings: &StampSettings) -> Self {
        Stamper {
            shutter: settings.shutter,
            sigma_max_us: settings.clock.sigma_max_us,
            edges: Edges::new(),
            clock: Clock::new(settings.clock),
            counters: StampCounters::default(),
        }
    }

    /// An edge of the shutter's line. What is not taken is counted.
    ///
    /// # Errors
    /// [`EdgeError`] if the edge was refused.
    pub fn on_edge(&mut self, edge: Edge) -> Result<(), EdgeError> {
        let taken = self.edges.push(edge, &self.shutter);
        let counter = match taken {
            Ok(()) => return taken,
            Err(EdgeError::Bounce) => &mut self.counters.edges_bounced,
            Err(EdgeError::Backwards | EdgeError::Repeated) => &mut self.counters.edges_bad,
        };
        *counter = counter.wrapping_add(1);
        taken
    }

    /// Sets the exposure of the next frame, for a camera with commanded exposures.
    pub fn expect_exposure(&mut self, us: u32) {
        if let Some(known) = &mut self.shutter.exposure {
            known.us = us;
        }
    }

    /// To be called at least every ten minutes: drops edges so old that a wrap of the timer would make them look new,
    /// and moves the clock's epoch forwards.
    pub fn keep(&mut self, now: Ticks) {
        self.edges.forget(now);
        self.clock.keep(now);
    }

    /// The stamp of the frame whose first row arrived at `arrival`. Frames must come in their order; edges up to those
    /// of a frame belong to none that follows.
    ///
    /// # Errors
    /// [`StampError`].
    pub fn frame(&mut self, arrival: Ticks) -> Result<Stamp, StampError> {
        let found = self.edges.associate(arrival, &self.shutter)?;
        let missing = self.shutter.wired.count().saturating_sub(found.edges());
        self.counters.edges_missing = self.counters.edges_missing.wrapping_add(missing.into());
        let exposure = found.exposure(&self.shutter)?;
        let mid = exposure.mid().ok_or(StampError::BadExposure)?;
        let reading = self.clock.read(mid).ok_or(StampError::NoClock)?;
        // An odd length's middle lies half a tick later than the whole one.
        let half = if exposure.close.since(exposure.open) & 1 == 1 { 0.5 } else { 0.0 };
        let sigma_us = math::sqrt(found.variance(&self.shutter) + reading.variance + ROUNDING);
        // Written so that a NaN is refused, too.
        if sigma_us.is_nan() || sigma_us > self.sigma_max_us {
            return Err(StampError::UncertainClock);
        }
        let instant = |tick| self.clock.instant(tick).map(|(at, _)| at).ok_or(StampError::NoClock);
        Ok(Stamp {
            open: instant(exposure.open)?,
            close: instant(exposure.close)?,
            mid: reading.rounded(half).ok_or(StampError::NoClock)?,
            sigma_us,
            source: found.source(),
        })
    }

    /// What was counted so far.
    pub fn counters(&self) -> StampCounters {
        let (pulses_ignored, clock_epochs) = self.clock.counted();
        StampCounters { pulses_ignored, clock_epochs, ..self.counters }
    }
}
