//! Stamped samples and their values between stamps.
//!
//! One ring per stream. A value exists only between two samples that are close enough: never before the first, never
//! after the last (the next sample is waited for), never across a gap. Angles go the short way round.

use crate::tilt::Attitude;
use crate::units::{Micros, Radians};
use heapless::Deque;

/// Why a stream has no value at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PoseError {
    /// The newest sample is still older than the instant: wait for the next.
    NotYet,
    /// The instant is older than what the ring remembers, or nothing was ever received.
    TooOld,
    /// The two samples around the instant are too far apart.
    Gap,
}

/// A sample that was not taken: its stamp is not after the newest one's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Backwards;

/// What can stand between two samples.
pub trait Between: Copy {
    /// The value at the fraction `u` (0 to 1) from `a` to `b`.
    fn between(a: Self, b: Self, u: f32) -> Self;
}

impl Between for f32 {
    fn between(a: f32, b: f32, u: f32) -> f32 {
        a + (b - a) * u
    }
}

impl Between for Radians {
    fn between(a: Radians, b: Radians, u: f32) -> Radians {
        Radians(a.0 + Radians(b.0 - a.0).wrapped().0 * u).wrapped()
    }
}

impl Between for Attitude {
    /// Linear in each angle. At 200 Hz a 5°, 1 Hz roll is met to 6e-4°, 0.005 px; slerp is no better there.
    fn between(a: Attitude, b: Attitude, u: f32) -> Attitude {
        Attitude {
            heading: Radians::between(a.heading, b.heading, u),
            pitch: Radians::between(a.pitch, b.pitch, u),
            roll: Radians::between(a.roll, b.roll, u),
        }
    }
}

/// A value between two samples and where it stands between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolated<T> {
    /// The value.
    pub value: T,
    /// The fraction from the older sample to the newer.
    pub u: f32,
}

impl<T> Interpolated<T> {
    /// Standard deviation of the value for white sample noise of one sigma: √((1−u)² + u²), between 0.71 and 1.
    pub fn noise_factor(&self) -> f32 {
        crate::math::sqrt((1.0 - self.u) * (1.0 - self.u) + self.u * self.u)
    }
}

/// The newest `N` samples of a stream, oldest first.
#[derive(Debug)]
pub struct History<T, const N: usize> {
    samples: Deque<(Micros, T), N>,
}

impl<T: Between, const N: usize> History<T, N> {
    /// Empty.
    pub const fn new() -> Self {
        History { samples: Deque::new() }
    }

    /// Takes a sample; the oldest one makes room.
    ///
    /// # Errors
    /// [`Backwards`] when its stamp is not after the newest one's; nothing changes then.
    pub fn push(&mut self, sampled_at: Micros, value: T) -> Result<(), Backwards> {
        if self.samples.back().is_some_and(|(newest, _)| *newest >= sampled_at) {
            return Err(Backwards);
        }
        if self.samples.is_full() {
            self.samples.pop_front();
        }
        // There is room now: the push cannot fail.
        let _ = self.samples.push_back((sampled_at, value));
        Ok(())
    }

    /// The newest sample.
    pub fn newest(&self) -> Option<(Micros, T)> {
        self.samples.back().copied()
    }

    /// The value at `at`, from samples no more than `gap_us` apart.
    ///
    /// # Errors
    /// [`PoseError`].
    pub fn at(&self, at: Micros, gap_us: u32) -> Result<Interpolated<T>, PoseError> {
        let (newest, _) = self.newest().ok_or(PoseError::NotYet)?;
        if newest < at {
            return Err(PoseError::NotYet);
        }
        let mut after: Option<(Micros, T)> = None;
        for &(stamp, value) in self.samples.iter().rev() {
            if stamp <= at {
                let Some((next_stamp, next)) = after else { return Ok(Interpolated { value, u: 0.0 }) };
                let apart = next_stamp.since(stamp);
                if apart as u32 > gap_us {
                    return Err(PoseError::Gap);
                }
                let u = at.since(stamp) as f32 / apart as f32;
                return Ok(Interpolated { value: T::between(value, next, u), u });
            }
            after = Some((stamp, value));
        }
        Err(PoseError::TooOld)
    }
}

impl<T: Between, const N: usize> Default for History<T, N> {
    fn default() -> Self {
        History::new()
    }
}
