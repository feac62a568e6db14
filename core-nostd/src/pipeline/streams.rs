//! The stamped streams: checked on entry, kept in ring buffers.

use crate::pose::position::PositionState;
use crate::pose::{Backwards, Channels, History};
use crate::tile::Geographic;
use crate::tilt::Attitude;
use crate::units::{Metres, Micros, Radians};

/// Position and velocity of the navigation that the fixes are to correct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionSample {
    /// Position.
    pub position: Geographic,
    /// Velocity to true north, m/s.
    pub north_m_per_s: f32,
    /// Velocity to true east, m/s.
    pub east_m_per_s: f32,
    /// Altitude above the datum of the tile's elevation model, by the autopilot, metres; `None` if unknown.
    pub altitude_m: Option<f32>,
    /// Altitude of the take-off point likewise, metres; `None` if unknown.
    pub home_m: Option<f32>,
    /// Velocity upwards, m/s.
    pub climb_m_per_s: f32,
}

impl PositionSample {
    /// At rest, with unknown altitude.
    pub fn standing(position: Geographic) -> Self {
        PositionSample {
            position,
            north_m_per_s: 0.0,
            east_m_per_s: 0.0,
            altitude_m: None,
            home_m: None,
            climb_m_per_s: 0.0,
        }
    }
}

/// The two instants of a sample, with their sigmas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instants {
    /// Its stamp.
    pub sampled_at: Micros,
    /// Sigma of the stamp by the resolution of its message, microseconds.
    pub stamp_sigma_us: f32,
    /// Its arrival at the board; `None` while the board's clock is not related to the stamps' clock yet.
    pub arrival: Option<Arrival>,
}

impl Instants {
    /// The stamp, if it is neither later than the arrival nor more than `age_us` before it.
    ///
    /// # Errors
    /// [`SampleError::Future`], [`SampleError::Backwards`].
    pub(super) fn recent(&self, age_us: i32) -> Result<Micros, SampleError> {
        let late_us = self.arrival.map_or(0, |arrival| arrival.at.since(self.sampled_at));
        if late_us < -FUTURE_US {
            return Err(SampleError::Future);
        }
        if late_us > age_us { Err(SampleError::Backwards) } else { Ok(self.sampled_at) }
    }
}

/// Arrival of a sample at the board, on the stamps' clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// The instant.
    pub at: Micros,
    /// Sigma of the relation between the clocks, microseconds.
    pub sigma_us: f32,
}

impl From<Micros> for Instants {
    fn from(sampled_at: Micros) -> Self {
        Instants { sampled_at, stamp_sigma_us: 0.0, arrival: None }
    }
}

/// Why a sample was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SampleError {
    /// Its stamp is not after the newest one's.
    Backwards,
    /// An impossible value, or a stamp from before the clock's start.
    Invalid,
    /// Its stamp is too long after its arrival.
    Future,
}

impl From<Backwards> for SampleError {
    fn from(_: Backwards) -> Self {
        SampleError::Backwards
    }
}

/// Limit of the slant range, metres: the largest value of a DISTANCE_SENSOR message is an error code.
const SLANT_MAX_M: f32 = 655.0;
/// A sample stamped later than its arrival by more than this is refused, microseconds. Chosen between 40 ms, by which a
/// receiver that reads its clock once for many bytes was seen to be late, and 90 ms, where a few bad messages would
/// already cost a frame.
const FUTURE_US: i32 = 50_000;
/// A sample stamped later than its arrival by more than this and [`AHEAD_SIGMAS`] of the clocks' relation is taken, but
/// dropped for the next sample: otherwise a few such messages would have all others refused until the clock has reached
/// them. The millisecond that messages round to, and one for an autopilot that stamps at the end of its loop.
const AHEAD_US: f32 = 2_000.0;
/// Gate in sigmas: of normal errors one in two million is beyond.
const AHEAD_SIGMAS: f32 = 5.0;
/// Consecutive samples with stamps before the newest after which the sender's clock counts as restarted and the history
/// is dropped. Chosen between 2, since a link may deliver a few samples late, and 40, the longest ring: each one
/// refused is time without a pose. 20 are a tenth of a second of attitudes at 200 Hz, four seconds of positions at 5
/// Hz.
const BACKWARDS_MAX: u8 = 20;

/// Samples of one sensor, its calibrated latency, and the delay of its newest sample.
#[derive(Debug)]
pub struct Stream<T, const C: usize, const N: usize> {
    history: History<T, C, N>,
    /// Latency of the values against their stamps: the sensor's own filters.
    latency_us: u32,
    delay_us: u32,
    stamp_sigma_us: f32,
    backwards: u8,
}

impl<T: Channels<C>, const C: usize, const N: usize> Stream<T, C, N> {
    const fn new(latency_us: u32) -> Self {
        Stream { history: History::new(), latency_us, delay_us: 0, stamp_sigma_us: 0.0, backwards: 0 }
    }

    fn push(&mut self, at: Instants, value: T) -> Result<(), SampleError> {
        let sampled_at = at.sampled_at.0.checked_sub(self.latency_us as u64).map(Micros).ok_or(SampleError::Invalid)?;
        if let Some(arrival) = at.arrival {
            if at.sampled_at.since(arrival.at) > FUTURE_US {
                return Err(SampleError::Future);
            }
            let allowed_us = AHEAD_US + AHEAD_SIGMAS * arrival.sigma_us;
            let is_ahead = |newest: Micros| newest.since(arrival.at) as f32 + self.latency_us as f32 > allowed_us;
            while self.history.newest().is_some_and(|(newest, _)| newest >= sampled_at && is_ahead(newest)) {
                self.history.drop_newest();
            }
        }
        if self.history.push(sampled_at, value).is_err() {
            self.backwards = self.backwards.saturating_add(1);
            if self.backwards < BACKWARDS_MAX {
                return Err(SampleError::Backwards);
            }
            self.history = History::new();
            self.history.push(sampled_at, value)?;
        }
        self.backwards = 0;
        self.delay_us = at.arrival.map_or(0, |arrival| arrival.at.since(sampled_at).max(0) as u32);
        self.stamp_sigma_us = at.stamp_sigma_us;
        Ok(())
    }

    fn clear(&mut self) {
        *self = Stream::new(self.latency_us);
    }

    /// The samples, at the instants of their values.
    pub fn history(&self) -> &History<T, C, N> {
        &self.history
    }

    /// Sigma of the newest stamp by the resolution of its message, seconds.
    pub(super) fn stamp_sigma_s(&self) -> f32 {
        self.stamp_sigma_us * 1e-6
    }

    /// Delay from the newest value's instant to its arrival, microseconds; 0 while the clocks are not related yet.
    pub fn delay_us(&self) -> u32 {
        self.delay_us
    }
}

/// Latency of the values against their stamps, microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Latencies {
    /// Attitude.
    pub attitude_us: u32,
    /// Follow-up angle.
    pub follow_up_us: u32,
    /// Slant range.
    pub range_us: u32,
    /// Position.
    pub position_us: u32,
}

/// The newest samples of every stream. The ring of attitudes holds a window of the fit and what arrives during a
/// readout; that of positions eleven samples.
#[derive(Debug)]
pub struct Streams {
    /// Attitude, heading already relative to grid north.
    pub attitude: Stream<Attitude, 3, 40>,
    /// Follow-up angle.
    pub follow_up: Stream<Radians, 1, 16>,
    /// Slant range, metres.
    pub slant: Stream<f32, 1, 16>,
    /// Position and velocity on the grid.
    pub position: Stream<PositionState, 4, 11>,
}

impl Streams {
    /// Empty.
    pub const fn new(latencies: Latencies) -> Self {
        Streams {
            attitude: Stream::new(latencies.attitude_us),
            follow_up: Stream::new(latencies.follow_up_us),
            slant: Stream::new(latencies.range_us),
            position: Stream::new(latencies.position_us),
        }
    }

    /// Drops all samples: the clock of their stamps has restarted.
    pub fn clear(&mut self) {
        self.attitude.clear();
        self.follow_up.clear();
        self.slant.clear();
        self.position.clear();
    }

    /// Delay of the newest sample of attitude, follow-up angle, range and position, microseconds.
    pub fn delays_us(&self) -> [u32; 4] {
        [self.attitude.delay_us(), self.follow_up.delay_us(), self.slant.delay_us(), self.position.delay_us()]
    }

    /// Takes an attitude whose heading is relative to grid north.
    ///
    /// # Errors
    /// [`SampleError`]; the stream is unchanged then.
    pub fn attitude(&mut self, at: impl Into<Instants>, attitude: Attitude) -> Result<(), SampleError> {
        if ![attitude.heading.0, attitude.pitch.0, attitude.roll.0].iter().all(|angle| angle.is_finite()) {
            return Err(SampleError::Invalid);
        }
        self.attitude.push(at.into(), attitude)
    }

    /// Takes a follow-up angle.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn follow_up(&mut self, at: impl Into<Instants>, follow_up: Radians) -> Result<(), SampleError> {
        if !follow_up.0.is_finite() {
            return Err(SampleError::Invalid);
        }
        self.follow_up.push(at.into(), follow_up)
    }

    /// Takes a slant range.
    ///
    /// # Errors
    /// [`SampleError`]; 0 and anything beyond 655 m are codes, not ranges.
    pub fn slant(&mut self, at: impl Into<Instants>, slant: Metres) -> Result<(), SampleError> {
        if !(slant.0 > 0.0 && slant.0 < SLANT_MAX_M) {
            return Err(SampleError::Invalid);
        }
        self.slant.push(at.into(), slant.0)
    }

    /// Takes a position on the grid.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn position(&mut self, at: impl Into<Instants>, state: PositionState) -> Result<(), SampleError> {
        if !state.difference_from(PositionState::default()).iter().all(|v| v.is_finite()) {
            return Err(SampleError::Invalid);
        }
        self.position.push(at.into(), state)
    }
}

#[cfg(test)]
mod tests {
    use super::{Arrival, Instants, SampleError};
    use crate::units::Micros;

    #[test]
    fn a_stamp_of_another_clock_is_not_recent() {
        let arrival = Some(Arrival { at: Micros(10_000_000), sigma_us: 0.0 });
        let recent = |us| Instants { sampled_at: Micros(us), stamp_sigma_us: 0.0, arrival }.recent(2_000_000);
        assert_eq!((recent(10_050_000), recent(8_000_000)), (Ok(Micros(10_050_000)), Ok(Micros(8_000_000))));
        assert_eq!((recent(10_050_001), recent(7_999_999)), (Err(SampleError::Future), Err(SampleError::Backwards)));
        // Microseconds since 1970.
        assert_eq!((recent(1_790_000_000_000_000), recent(0)), (Err(SampleError::Future), Err(SampleError::Backwards)));
        assert_eq!(Instants::from(Micros(5)).recent(0), Ok(Micros(5)));
    }
}
