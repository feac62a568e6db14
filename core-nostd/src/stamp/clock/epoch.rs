//! State of the clock's filter at its epoch: propagation to another tick, and update by a comparison.

use crate::math;
use crate::units::{Micros, Ticks};

/// Age without any pulse.
pub(super) const NO_PULSE: u32 = u32::MAX;

/// The state and the tick that it refers to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Epoch {
    pub(super) tick: Ticks,
    /// The instant in whole microseconds, and the fraction beyond.
    pub(super) at: Micros,
    pub(super) offset_us: f32,
    pub(super) rate_ppm: f32,
    /// Variances of offset (us²) and rate (ppm²), and their covariance (us ppm).
    pub(super) offset_variance: f32,
    pub(super) covariance: f32,
    pub(super) rate_variance: f32,
    /// Variance of TIMESYNC's asymmetry, 0 while pulses discipline.
    pub(super) bias_variance: f32,
    /// Ticks since the newest accepted pulse, or [`NO_PULSE`] without one for an hour.
    pub(super) pulse_age: u32,
}

impl Epoch {
    /// The state propagated, forwards or backwards, to `tick`.
    pub(super) fn propagated(&self, tick: Ticks, walk_ppm: f32) -> Option<Epoch> {
        let ticks = tick.since(self.tick);
        let s = ticks as f32 * 1e-6;
        let noise = walk_ppm * walk_ppm * s.abs();
        let offset_us = self.offset_us + self.rate_ppm * s;
        let propagated = Epoch {
            tick,
            at: Micros(self.at.0.checked_add_signed(ticks as i64)?),
            offset_us,
            offset_variance: self.offset_variance
                + s * (2.0 * self.covariance + s * self.rate_variance)
                + noise * s * s / 3.0,
            covariance: self.covariance + s * self.rate_variance + 0.5 * noise * s,
            rate_variance: self.rate_variance + noise,
            pulse_age: if self.pulse_age == NO_PULSE { NO_PULSE } else { self.pulse_age.saturating_add_signed(ticks) },
            ..*self
        };
        propagated.normalised()
    }

    /// Whole microseconds of the offset moved into the instant.
    pub(super) fn normalised(self) -> Option<Epoch> {
        let whole = math::round(self.offset_us);
        let at = Micros(self.at.0.checked_add_signed(whole as i64)?);
        Some(Epoch { at, offset_us: self.offset_us - whole, ..self })
    }

    /// Innovation of `instant`, microseconds.
    pub(super) fn innovation_us(&self, instant: Micros) -> f32 {
        instant.since(self.at) as f32 - self.offset_us
    }

    /// With the variance of an error of at least `off_us` added, if that is positive.
    pub(super) fn widened(self, off_us: f32) -> Epoch {
        let off_us = off_us.max(0.0);
        Epoch { offset_variance: self.offset_variance + off_us * off_us, ..self }
    }

    /// Updated by a comparison with this innovation and variance.
    pub(super) fn updated(self, innovation_us: f32, variance: f32) -> Epoch {
        let sum = self.offset_variance + variance;
        let left = variance / sum;
        Epoch {
            offset_us: self.offset_us + self.offset_variance / sum * innovation_us,
            rate_ppm: self.rate_ppm + self.covariance / sum * innovation_us,
            offset_variance: self.offset_variance * left,
            covariance: self.covariance * left,
            rate_variance: (self.rate_variance - self.covariance * self.covariance / sum).max(0.0),
            ..self
        }
    }
}
