//! The navigation's position, propagated to an instant.
//!
//! Positions come five times a second, with latency. Waiting for the one after the exposure would cost half a second,
//! so the newest are propagated: with the measured velocity, or by the fit over the last positions, whichever has the
//! smaller expected error.

use super::band::WINDOW;
use super::fit::Samples;
use super::history::{Channels, History};
use super::noise::{Choices, NoiseModel};
use super::penalty::Order;
use super::{Method, PoseError};
use crate::math::{hypot, sqrt, squared};
use crate::units::Micros;

/// A position on the grid, metres from the tile's centre, and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionState {
    /// Grid east.
    pub east_m: f32,
    /// Grid north.
    pub north_m: f32,
    /// Velocity to grid east.
    pub east_m_per_s: f32,
    /// Velocity to grid north.
    pub north_m_per_s: f32,
}

impl Channels<4> for PositionState {
    fn difference_from(self, reference: PositionState) -> [f32; 4] {
        [
            self.east_m - reference.east_m,
            self.north_m - reference.north_m,
            self.east_m_per_s - reference.east_m_per_s,
            self.north_m_per_s - reference.north_m_per_s,
        ]
    }

    fn moved(self, [east, north, east_rate, north_rate]: [f32; 4]) -> PositionState {
        PositionState {
            east_m: self.east_m + east,
            north_m: self.north_m + north,
            east_m_per_s: self.east_m_per_s + east_rate,
            north_m_per_s: self.north_m_per_s + north_rate,
        }
    }
}

/// Sigmas of positions and velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionSigmas {
    /// Drift of a position, metres: what the fixes are to correct. No smoothing reduces it.
    pub drift_m: f32,
    /// Each velocity, m/s.
    pub velocity_m_per_s: f32,
}

/// Propagates positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predictor {
    model: NoiseModel,
    sigmas: PositionSigmas,
    choices: Choices,
}

/// Distance flown with bit-identical positions after which the sensor counts as frozen, metres. Chosen.
const FROZEN_M: f32 = 1.0;

/// A predicted position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Position and velocity.
    pub state: PositionState,
    /// Sigma of east and north, each, metres, the drift included.
    pub sigma_m: f32,
    /// Method.
    pub method: Method,
}

impl Predictor {
    /// For positions of `model`, whose white noise and motion are in metres.
    pub fn new(model: &NoiseModel, sigmas: PositionSigmas) -> Self {
        Predictor { model: *model, sigmas, choices: Choices::of(model, &[Order::Second, Order::Third]) }
    }

    /// The position at `at`, no further than `age_us` from the newest sample.
    ///
    /// # Errors
    /// [`PoseError::TooOld`] without a sample so near, [`PoseError::Frozen`] if the vehicle moves and its position does
    /// not.
    pub fn at<const N: usize>(
        &self,
        history: &History<PositionState, 4, N>,
        at: Micros,
        age_us: u32,
    ) -> Result<Predicted, PoseError> {
        let (newest, propagated) = self.newest(history, at, age_us)?;
        match self.fitted(history, at, newest) {
            Some(fitted) if fitted.sigma_m < propagated.sigma_m => Ok(fitted),
            _ => Ok(propagated),
        }
    }

    /// The propagated position without the fit, a second copy of which would take 4 KB of a board's flash; it smooths
    /// white noise only, the smaller part of a navigation's error.
    ///
    /// # Errors
    /// Those of [`Predictor::at`].
    pub(crate) fn propagated_to<const N: usize>(
        &self,
        history: &History<PositionState, 4, N>,
        at: Micros,
        age_us: u32,
    ) -> Result<Predicted, PoseError> {
        self.newest(history, at, age_us).map(|(_, propagated)| propagated)
    }

    /// The newest sample, and its propagation to `at`.
    fn newest<const N: usize>(
        &self,
        history: &History<PositionState, 4, N>,
        at: Micros,
        age_us: u32,
    ) -> Result<(PositionState, Predicted), PoseError> {
        let (newest_at, newest) = history.newest().ok_or(PoseError::TooOld)?;
        let age = at.since(newest_at);
        if age.unsigned_abs() > age_us {
            return Err(PoseError::TooOld);
        }
        if self.is_frozen(history) {
            return Err(PoseError::Frozen);
        }
        Ok((newest, self.propagated(newest, age as f32 * 1e-6)))
    }

    /// Whether the last positions are bit-identical though the vehicle, by its velocity, has moved further than noise
    /// and the message's resolution of a centimetre can hide.
    pub(crate) fn is_frozen<const N: usize>(&self, history: &History<PositionState, 4, N>) -> bool {
        let mut newest_first = history.samples().rev();
        let Some((newest_at, newest)) = newest_first.next() else { return false };
        let same = |state: &PositionState| (state.east_m, state.north_m) == (newest.east_m, newest.north_m);
        let Some((since, _)) = newest_first.take_while(|(_, state)| same(state)).last() else { return false };
        let seconds = newest_at.since(since) as f32 * 1e-6;
        let speed = hypot(newest.east_m_per_s, newest.north_m_per_s);
        speed * seconds > FROZEN_M + 5.0 * (self.model.white + self.sigmas.velocity_m_per_s * seconds)
    }

    /// The newest sample propagated by its velocity. The unknown accelerations of the motion add to the sigma.
    fn propagated(&self, newest: PositionState, seconds: f32) -> Predicted {
        let state = newest.moved([newest.east_m_per_s * seconds, newest.north_m_per_s * seconds, 0.0, 0.0]);
        let variance = squared(self.sigmas.drift_m)
            + squared(self.model.white)
            + squared(self.sigmas.velocity_m_per_s * seconds)
            + squared(0.5 * self.model.acceleration() * seconds * seconds);
        Predicted { state, sigma_m: sqrt(variance), method: Method::Propagated }
    }

    /// The fit over the last positions, extrapolated; `None` if there are too few, a gap is between them or the instant
    /// is too far ahead.
    fn fitted<const N: usize>(
        &self,
        history: &History<PositionState, 4, N>,
        at: Micros,
        newest: PositionState,
    ) -> Option<Predicted> {
        if self.model.white == 0.0 {
            return None;
        }
        let interval_us = self.model.interval_us;
        let mut samples = Samples::<2>::new();
        let mut before: Option<Micros> = None;
        let mut ahead = 0.0;
        for (stamp, state) in history.samples().skip(history.samples().len().saturating_sub(WINDOW)) {
            if before.is_some_and(|before| stamp.since(before) as u32 > 2 * interval_us) {
                samples.clear();
            }
            before = Some(stamp);
            let time = stamp.since(at) as f32 / interval_us as f32;
            ahead = -time;
            let [east, north, _, _] = state.difference_from(newest);
            samples.push(time, [east, north], 1.0).ok()?;
        }
        let choice = self.choices.ahead(ahead)?;
        let fitted = samples.fit(choice.order, choice.alpha, [self.model.white; 2]).ok()?;
        let per_s = 1e6 / interval_us as f32;
        let [east, north] = fitted.value;
        let white = self.model.white * fitted.scale.max(1.0);
        let rate_sigma = hypot(white * fitted.rate_gain, choice.rate_bias) * per_s;
        let mut state = PositionState { east_m: newest.east_m + east, north_m: newest.north_m + north, ..newest };
        // The measured velocity is kept if it is the better one.
        if rate_sigma < self.sigmas.velocity_m_per_s {
            (state.east_m_per_s, state.north_m_per_s) = (fitted.rate[0] * per_s, fitted.rate[1] * per_s);
        }
        let noise = white * fitted.gain;
        let sigma_m = sqrt(squared(self.sigmas.drift_m) + squared(noise) + squared(choice.bias));
        let count = samples.times().len();
        Some(Predicted { state, sigma_m, method: Method::fitted(&choice, 0, count, &fitted) })
    }
}
