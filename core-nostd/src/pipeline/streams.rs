//! The stamped streams: checked at the door, kept in rings.

use crate::pose::{Backwards, History};
use crate::tile::Geographic;
use crate::tilt::Attitude;
use crate::units::{Metres, Micros, Radians};

/// A position with its velocity, of the navigation that is to be corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionSample {
    /// When it held.
    pub sampled_at: Micros,
    /// Where.
    pub position: Geographic,
    /// Velocity to true north, m/s.
    pub north_m_per_s: f32,
    /// Velocity to true east, m/s.
    pub east_m_per_s: f32,
}

/// Range beyond which a slant is not believed, metres: the largest a DISTANCE_SENSOR message can carry is an error
/// code.
const SLANT_MAX_M: f32 = 655.0;

/// The newest samples of every stream. Capacities hold a quarter of a second of 200 Hz attitude and more, 100 Hz follow-up and 50 Hz range.
#[derive(Debug, Default)]
pub struct Streams {
    /// Attitude, heading already relative to grid north.
    pub attitude: History<Attitude, 48>,
    /// Follow-up angle.
    pub follow_up: History<Radians, 32>,
    /// Slant range, metres.
    pub slant: History<f32, 16>,
    /// The newest position.
    pub position: Option<PositionSample>,
}

/// Why a sample was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SampleError {
    /// Its stamp is not after the newest one's.
    Backwards,
    /// A value that no sensor can mean.
    Invalid,
}

impl From<Backwards> for SampleError {
    fn from(_: Backwards) -> Self {
        SampleError::Backwards
    }
}

impl Streams {
    /// Empty.
    pub const fn new() -> Self {
        Streams { attitude: History::new(), follow_up: History::new(), slant: History::new(), position: None }
    }

    /// Takes an attitude whose heading is relative to grid north.
    ///
    /// # Errors
    /// [`SampleError`]; the stream is unchanged then.
    pub fn attitude(&mut self, sampled_at: Micros, attitude: Attitude) -> Result<(), SampleError> {
        if ![attitude.heading.0, attitude.pitch.0, attitude.roll.0].iter().all(|angle| angle.is_finite()) {
            return Err(SampleError::Invalid);
        }
        Ok(self.attitude.push(sampled_at, attitude)?)
    }

    /// Takes a follow-up angle.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn follow_up(&mut self, sampled_at: Micros, follow_up: Radians) -> Result<(), SampleError> {
        if !follow_up.0.is_finite() {
            return Err(SampleError::Invalid);
        }
        Ok(self.follow_up.push(sampled_at, follow_up)?)
    }

    /// Takes a slant range.
    ///
    /// # Errors
    /// [`SampleError`]; 0 and anything beyond 655 m are codes, not ranges.
    pub fn slant(&mut self, sampled_at: Micros, slant: Metres) -> Result<(), SampleError> {
        if !(slant.0 > 0.0 && slant.0 < SLANT_MAX_M) {
            return Err(SampleError::Invalid);
        }
        Ok(self.slant.push(sampled_at, slant.0)?)
    }

    /// Takes a position.
    ///
    /// # Errors
    /// [`SampleError`].
    pub fn position(&mut self, sample: PositionSample) -> Result<(), SampleError> {
        let lat_possible = (-900_000_000..=900_000_000).contains(&sample.position.lat_e7);
        let lon_possible = (-1_800_000_000..=1_800_000_000).contains(&sample.position.lon_e7);
        if !(lat_possible && lon_possible && sample.north_m_per_s.is_finite() && sample.east_m_per_s.is_finite()) {
            return Err(SampleError::Invalid);
        }
        if self.position.is_some_and(|newest| newest.sampled_at >= sample.sampled_at) {
            return Err(SampleError::Backwards);
        }
        self.position = Some(sample);
        Ok(())
    }
}
