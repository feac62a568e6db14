//! The newest samples of a stream, and interpolation between two of them.

use super::PoseError;
use crate::tilt::Attitude;
use crate::units::{Micros, Radians};
use heapless::Deque;

/// A refused sample: its stamp is not after the newest one's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Backwards;

/// A quantity of `C` channels that can be expressed as its difference from another.
///
/// Angles are differenced the short way round, so a window of attitudes is unwrapped about its reference. Heading,
/// pitch and roll serve as channels because nothing is rectified beyond 70° of tilt, far from their singularity at 90°.
pub trait Channels<const C: usize>: Copy + PartialEq {
    /// Difference from `reference`.
    fn difference_from(self, reference: Self) -> [f32; C];
    /// With the difference `by` added.
    fn moved(self, by: [f32; C]) -> Self;
}

impl Channels<1> for f32 {
    fn difference_from(self, reference: f32) -> [f32; 1] {
        [self - reference]
    }

    fn moved(self, [by]: [f32; 1]) -> f32 {
        self + by
    }
}

impl Channels<1> for Radians {
    fn difference_from(self, reference: Radians) -> [f32; 1] {
        [Radians(self.0 - reference.0).wrapped().0]
    }

    fn moved(self, [by]: [f32; 1]) -> Radians {
        Radians(self.0 + by).wrapped()
    }
}

impl Channels<3> for Attitude {
    fn difference_from(self, reference: Attitude) -> [f32; 3] {
        let turn = Radians(self.heading.0 - reference.heading.0).wrapped().0;
        [turn, self.pitch.0 - reference.pitch.0, self.roll.0 - reference.roll.0]
    }

    fn moved(self, [turn, pitch, roll]: [f32; 3]) -> Attitude {
        Attitude {
            heading: Radians(self.heading.0 + turn).wrapped(),
            pitch: Radians(self.pitch.0 + pitch).wrapped(),
            roll: Radians(self.roll.0 + roll).wrapped(),
        }
    }
}

/// A value interpolated between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolated<T, const C: usize> {
    /// The value.
    pub value: T,
    /// The fraction from the older sample to the newer.
    pub u: f32,
    /// Interval of the two samples, microseconds; 0 if the instant is a sample's and no later one is there.
    pub apart_us: u32,
    /// Rate of each channel, per second; 0 if the instant is a sample's and no later one is there.
    pub rate: [f32; C],
}

impl<T, const C: usize> Interpolated<T, C> {
    /// Standard deviation of the value for white sample noise of one sigma: √((1−u)² + u²), between 0.71 and 1.
    pub(crate) fn noise_factor(&self) -> f32 {
        crate::math::sqrt((1.0 - self.u) * (1.0 - self.u) + self.u * self.u)
    }
}

/// The newest `N` samples of a stream, oldest first.
#[derive(Debug)]
pub struct History<T, const C: usize, const N: usize> {
    samples: Deque<(Micros, T), N>,
}

impl<T: Channels<C>, const C: usize, const N: usize> History<T, C, N> {
    /// Empty.
    pub const fn new() -> Self {
        History { samples: Deque::new() }
    }

    /// Takes a sample; if the ring is full, the oldest is dropped.
    ///
    /// # Errors
    /// [`Backwards`] if its stamp is not after the newest one's; nothing changes then.
    pub fn push(&mut self, sampled_at: Micros, value: T) -> Result<(), Backwards> {
        if self.samples.back().is_some_and(|(newest, _)| *newest >= sampled_at) {
            return Err(Backwards);
        }
        if self.samples.is_full() {
            self.samples.pop_front();
        }
        // The ring is not full now: the push cannot fail.
        let _ = self.samples.push_back((sampled_at, value));
        Ok(())
    }

    /// Drops the newest sample.
    pub(crate) fn drop_newest(&mut self) {
        self.samples.pop_back();
    }

    /// The newest sample.
    pub fn newest(&self) -> Option<(Micros, T)> {
        self.samples.back().copied()
    }

    /// The samples, oldest first.
    pub fn samples(&self) -> impl DoubleEndedIterator<Item = (Micros, T)> + ExactSizeIterator + '_ {
        self.samples.iter().copied()
    }

    /// Number of samples later than `at`.
    pub(crate) fn later_than(&self, at: Micros) -> usize {
        self.samples.iter().rev().take_while(|(stamp, _)| *stamp > at).count()
    }

    /// The value at `at` by linear interpolation from the sample before it to the one after, no more than `gap_us` apart.
    ///
    /// # Errors
    /// [`PoseError`].
    // A few times a frame: inlined everywhere it would fill the flight computer's flash.
    #[inline(never)]
    pub fn at(&self, at: Micros, gap_us: u32) -> Result<Interpolated<T, C>, PoseError> {
        let (newest, _) = self.newest().ok_or(PoseError::NotYet)?;
        if newest < at {
            return Err(PoseError::NotYet);
        }
        let mut after: Option<(Micros, T)> = None;
        for &(stamp, value) in self.samples.iter().rev() {
            if stamp <= at {
                let Some((next_stamp, next)) = after else {
                    return Ok(Interpolated { value, u: 0.0, apart_us: 0, rate: [0.0; C] });
                };
                let apart = next_stamp.since(stamp);
                if apart as u32 > gap_us {
                    return Err(PoseError::Gap);
                }
                let u = at.since(stamp) as f32 / apart as f32;
                let difference = next.difference_from(value);
                let per_s = 1e6 / apart as f32;
                return Ok(Interpolated {
                    value: value.moved(difference.map(|w| w * u)),
                    u,
                    apart_us: apart as u32,
                    rate: difference.map(|w| w * per_s),
                });
            }
            after = Some((stamp, value));
        }
        Err(PoseError::TooOld)
    }
}

impl<T: Channels<C>, const C: usize, const N: usize> Default for History<T, C, N> {
    fn default() -> Self {
        History::new()
    }
}
