//! A stream's value at an instant: the fit over the window around it, or linear interpolation between two samples.

use super::band::WINDOW;
use super::fit::{Fitted, Samples};
use super::history::{Channels, History, Interpolated};
use super::noise::{Choice, Choices, NoiseModel};
use super::penalty::Order;
use super::{Method, PoseError};
use crate::math::{hypot, squared};
use crate::units::Micros;

/// Smoothing of a stream of `C` channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoother<const C: usize> {
    interval_us: u32,
    /// White noise of a sample, each channel, one sigma.
    sigmas: [f32; C],
    /// Root mean square acceleration of the motion, channel units per second squared.
    acceleration: f32,
    choices: Choices,
}

/// A stream's value at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T, const C: usize> {
    /// The value.
    pub value: T,
    /// Rate of each channel, per second.
    pub rate: [f32; C],
    /// Sigma of each channel: residual noise of the samples, and the motion's error by smoothing.
    pub sigma: [f32; C],
    /// Sigma of each rate, per second, likewise.
    pub rate_sigma: [f32; C],
    /// Method.
    pub method: Method,
}

/// What to do while fewer later samples than wanted have arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// Wait for so many samples later than the instant, at least one.
    For(u8),
    /// Use as many as there are, at least one.
    No,
}

impl<const C: usize> Smoother<C> {
    /// For a sensor of `model`, whose own noise determines α; `sigmas` are those of the channels.
    pub fn new(model: &NoiseModel, sigmas: [f32; C]) -> Self {
        let choices = Choices::of(model, &[Order::Second, Order::Third]);
        Smoother { interval_us: model.interval_us, sigmas, acceleration: model.acceleration(), choices }
    }

    /// The value of `history` at `at`.
    ///
    /// The window ends half its length after the instant, or with the newest sample, and begins its length before; no
    /// two neighbours in it are further than `gap_us` apart. With fewer than five samples, or without noise to smooth,
    /// the value is interpolated linearly between the two samples around it.
    ///
    /// # Errors
    /// [`PoseError`].
    pub fn at<T: Channels<C>, const N: usize>(
        &self,
        history: &History<T, C, N>,
        at: Micros,
        gap_us: u32,
        wait: Wait,
    ) -> Result<Estimate<T, C>, PoseError> {
        let later = history.later_than(at);
        // A sample at the very instant has a value, but no rate.
        let wanted = if let Wait::For(wanted) = wait { wanted.max(1) } else { 1 };
        if later < wanted as usize {
            return Err(PoseError::NotYet);
        }
        // Between the two samples around it; also tests whether there are any.
        let linear = history.at(at, gap_us)?;
        if self.sigmas.iter().all(|sigma| *sigma == 0.0) {
            return Ok(self.linear(&linear));
        }
        let reference = linear.value;
        let mut samples = Samples::new();
        let lag = self.window(history, at, reference, (gap_us, later), &mut samples);
        let count = samples.times().len();
        let is_frozen =
            |(channel, sigma): (usize, &f32)| *sigma > 0.0 && samples.is_constant(channel, CHANNEL_FROZEN, ROUNDED);
        if samples.repeats(FROZEN) || self.sigmas.iter().enumerate().any(is_frozen) {
            return Err(PoseError::Frozen);
        }
        let choice = self.choices.at(lag);
        let Ok(fitted) = samples.fit(choice.order, choice.alpha, self.sigmas) else {
            return Ok(self.linear(&linear));
        };
        Ok(self.estimate(reference, &fitted, &choice, Method::fitted(&choice, lag, count, &fitted)))
    }

    fn estimate<T: Channels<C>>(
        &self,
        reference: T,
        fitted: &Fitted<C>,
        choice: &Choice,
        method: Method,
    ) -> Estimate<T, C> {
        let per_s = 1e6 / self.interval_us as f32;
        // Noise above the configured one is taken over.
        let scale = fitted.scale.max(1.0);
        Estimate {
            value: reference.moved(fitted.value),
            rate: fitted.rate.map(|rate| rate * per_s),
            sigma: self.sigmas.map(|sigma| hypot(sigma * scale * fitted.gain, choice.bias)),
            rate_sigma: self.sigmas.map(|sigma| hypot(sigma * scale * fitted.rate_gain, choice.rate_bias) * per_s),
            method,
        }
    }

    fn linear<T: Channels<C>>(&self, between: &Interpolated<T, C>) -> Estimate<T, C> {
        let factor = between.noise_factor();
        // A curve of acceleration a is off the straight line by u (1 − u) a t²/2, and its slope by up to a t/2.
        let apart_s = between.apart_us as f32 * 1e-6;
        let bend = 0.5 * between.u * (1.0 - between.u) * self.acceleration * squared(apart_s);
        let turn = 0.5 * self.acceleration * apart_s;
        let noise = core::f32::consts::SQRT_2 / apart_s;
        Estimate {
            value: between.value,
            rate: between.rate,
            sigma: self.sigmas.map(|sigma| hypot(sigma * factor, bend)),
            rate_sigma: self.sigmas.map(|sigma| hypot(sigma * noise, turn)),
            method: Method::Linear,
        }
    }

    /// Fills in the samples around `at`; returns the lag: whole samples between the instant's own interval and the
    /// window's nearer end.
    fn window<T: Channels<C>, const N: usize>(
        &self,
        history: &History<T, C, N>,
        at: Micros,
        reference: T,
        (gap_us, later): (u32, usize),
        samples: &mut Samples<C>,
    ) -> usize {
        let after = later.min(WINDOW / 2);
        let earlier = history.samples().len() - later;
        let before = earlier.min(WINDOW - after);
        let (mut counts, mut newest) = ([0usize; 2], None::<Micros>);
        let per_us = 1.0 / self.interval_us as f32;
        for (stamp, value) in history.samples().skip(earlier - before).take(before + after) {
            // The interval without a gap that contains the instant.
            if newest.is_some_and(|newest| stamp.since(newest) as u32 > gap_us) {
                if stamp > at {
                    break;
                }
                samples.clear();
                counts = [0; 2];
            }
            newest = Some(stamp);
            counts[usize::from(stamp > at)] += 1;
            // Finite, in order and no more than fit: the push cannot fail.
            let _ = samples.push(stamp.since(at) as f32 * per_us, value.difference_from(reference), 1.0);
        }
        counts[0].min(counts[1]).saturating_sub(1)
    }
}

/// Bit-identical consecutive samples after which the sensor counts as frozen: its values are old, though its stamps are
/// fresh. Fewer come from a sensor whose messages are sent more often than its filter is updated, and have an age of no
/// more than two intervals.
const FROZEN: usize = 5;
/// Number for one noisy channel alone, within [`ROUNDED`]. Chosen between an estimator's single-precision angles,
/// which never repeat, and the window's 21; in logs that round angles to 0.01 degrees 0.1 to 1.4 % of the samples do,
/// mostly at rest.
const CHANNEL_FROZEN: usize = 8;
/// Rounding of a constant angle computed from a quaternion in single precision, radians: each component is off by up to
/// 3e-8, and the heading by 1.2e-7 more.
const ROUNDED: f32 = 1e-6;
