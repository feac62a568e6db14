//! Strength of smoothing: the order of the penalty and α for each lag, from the sensor's noise and the vehicle's
//! motion.
//!
//! An estimate is a weighted sum Σ x L of the window's samples. White noise of variance σ² has variance σ² Σ x² in it,
//! and a motion of amplitude A and angular frequency ω has the mean square error A²/2 |Σ x e^{jωt} − e^{jωt₀}|² over
//! its phase. The minimum of their sum is searched for, once, before the flight. The best α at the window's edge is
//! orders of magnitude below that in its middle: α = 100, best for a whole flight of paper 001's positions, is off by
//! 0.56 m at its newest sample, α = 1 by 0.10 m.

use super::band::{Band, Column, Factors, WINDOW};
use super::penalty::{ALPHA_MAX, Order, Penalty, row};
use crate::math;
use core::f32::consts::TAU;

/// Lags distinguished: from the newest sample to the middle of the window.
pub const LAGS: usize = WINDOW / 2 + 1;
/// Leads ahead of the newest sample that are distinguished, intervals.
pub const AHEAD: [f32; 4] = [0.5, 1.0, 1.5, 2.0];
/// Positions of the instant between two samples that are averaged over.
const FRACTIONS: [f32; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];
/// The smallest α, the ratio of one to the next (the fourth root of ten), and how many: up to 10⁴.
const ALPHAS: (f32, f32, usize) = (0.01, 1.778_279_4, 25);

/// A motion to be preserved, in the unit of the channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wave {
    /// Amplitude.
    pub amplitude: f32,
    /// Period, seconds.
    pub period_s: f32,
}

/// A sensor's noise and signal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoiseModel {
    /// Nominal sampling interval, microseconds.
    pub interval_us: u32,
    /// Sigma of the samples' white noise, in the unit of the channel.
    pub white: f32,
    /// The motions; amplitude 0 for none.
    pub waves: [Wave; 2],
}

/// Why a model was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ModelError {
    /// The interval is zero or longer than ten seconds.
    Interval,
    /// The noise is negative or not a number.
    White,
    /// An amplitude is negative or not a number, or a period shorter than two intervals.
    Wave,
}

impl NoiseModel {
    /// # Errors
    /// [`ModelError`].
    pub fn check(&self) -> Result<(), ModelError> {
        if !(1..=10_000_000).contains(&self.interval_us) {
            return Err(ModelError::Interval);
        }
        if !(self.white >= 0.0 && self.white < f32::INFINITY) {
            return Err(ModelError::White);
        }
        let shortest_s = 2e-6 * self.interval_us as f32;
        let sound = |wave: &Wave| {
            let flat = wave.amplitude == 0.0;
            let waves = wave.amplitude > 0.0 && wave.amplitude < f32::INFINITY && wave.period_s >= shortest_s;
            flat || (waves && wave.period_s < f32::INFINITY)
        };
        if self.waves.iter().all(sound) { Ok(()) } else { Err(ModelError::Wave) }
    }

    /// Root mean square acceleration of the motions, channel units per second squared.
    pub fn acceleration(&self) -> f32 {
        let mean_square = |wave: &Wave| {
            let frequency = if wave.amplitude > 0.0 { TAU / wave.period_s } else { 0.0 };
            let peak = wave.amplitude * frequency * frequency;
            0.5 * peak * peak
        };
        math::sqrt(self.waves.iter().map(mean_square).sum())
    }

    /// Angular frequency of a wave in radians an interval; 0 without one.
    fn step_rad(&self, wave: &Wave) -> f32 {
        if wave.amplitude > 0.0 { TAU * 1e-6 * self.interval_us as f32 / wave.period_s } else { 0.0 }
    }
}

/// Smoothing at one lag.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Choice {
    /// Order of the differences.
    pub order: Order,
    /// Dimensionless, for the nominal interval.
    pub alpha: f32,
    /// Expected error by the motion, root mean square, in the unit of the channel.
    pub bias: f32,
    /// Expected error of the rate by the motion, root mean square, per interval.
    pub rate_bias: f32,
}

/// Smoothing at each lag, and for predictions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choices {
    by_lag: [Choice; LAGS],
    ahead: [Choice; AHEAD.len()],
}

impl Choices {
    /// The best for `model` among `orders`; some thousand solutions of a window, a few milliseconds of a Cortex-M7.
    pub fn of(model: &NoiseModel, orders: &[Order]) -> Self {
        let newest = (WINDOW - 1) as f32;
        let lags = core::array::from_fn(|lag| FRACTIONS.map(|fraction| newest - lag as f32 - fraction));
        let leads = AHEAD.map(|ahead| [newest + ahead]);
        Choices { by_lag: best(model, orders, &lags), ahead: best(model, orders, &leads) }
    }

    /// At `lag` whole samples behind the newest; beyond, that of the window's middle.
    pub fn at(&self, lag: usize) -> Choice {
        let [.., middle] = self.by_lag;
        self.by_lag.get(lag).copied().unwrap_or(middle)
    }

    /// At a lead of `intervals` ahead of the newest sample; `None` beyond the last of [`AHEAD`].
    pub fn ahead(&self, intervals: f32) -> Option<Choice> {
        AHEAD.iter().position(|ahead| intervals <= *ahead).and_then(|i| self.ahead.get(i).copied())
    }
}

/// The choice with the smallest mean square error for each group of instants in a full window, in intervals from its
/// oldest sample.
fn best<const G: usize, const N: usize>(model: &NoiseModel, orders: &[Order], groups: &[[f32; N]; G]) -> [Choice; G] {
    let waves = model.waves.map(|wave| Phasors::new(&wave, model.step_rad(&wave)));
    let times: [f32; WINDOW] = core::array::from_fn(|i| i as f32);
    let none = Choice { order: Order::Second, alpha: ALPHAS.0, bias: 0.0, rate_bias: 0.0 };
    let mut best = [(f32::INFINITY, none); G];
    for order in orders {
        let mut alpha = ALPHAS.0;
        for _ in 0..ALPHAS.2 {
            let mut band = Band::diagonal(&[1.0; WINDOW]);
            Penalty::new(&times, *order, alpha).add_to(&mut band);
            let mut factors = Factors::NONE;
            if !band.factor_into(&mut factors) {
                break;
            }
            for (group, best) in groups.iter().zip(&mut best) {
                let (mut noise, mut bias, mut rate_bias) = (0.0, 0.0, 0.0);
                for at in group {
                    let (value, rate) = row(&times, *at, *order);
                    let x = factors.solve(&value);
                    noise += x.iter().map(|w| w * w).sum::<f32>();
                    bias += waves.iter().map(|wave| wave.error(&x, *at)).sum::<f32>();
                    let x = factors.solve(&rate);
                    rate_bias += waves.iter().map(|wave| wave.rate_error(&x, *at)).sum::<f32>();
                }
                let count = N as f32;
                let (noise, bias) = (model.white * model.white * noise / count, bias / count);
                if noise + bias < best.0 {
                    let (bias, rate_bias, order) = (math::sqrt(bias), math::sqrt(rate_bias / count), *order);
                    *best = (noise + bias * bias, Choice { order, alpha, bias, rate_bias });
                }
            }
            // Rounding must not bring the last beyond the largest α of a fit.
            alpha = (alpha * ALPHAS.1).min(ALPHA_MAX);
        }
    }
    best.map(|(_, choice)| choice)
}

/// A wave at each sample of a window, as a complex number.
struct Phasors {
    /// A²/2.
    power: f32,
    step_rad: f32,
    samples: [(f32, f32); WINDOW],
}

impl Phasors {
    fn new(wave: &Wave, step_rad: f32) -> Self {
        let samples = core::array::from_fn(|i| math::sin_cos(step_rad * i as f32));
        Phasors { power: 0.5 * wave.amplitude * wave.amplitude, step_rad, samples }
    }

    /// Mean square error of the sum with the weights `x`, for the value at `at`.
    fn error(&self, x: &Column, at: f32) -> f32 {
        let (sin, cos) = math::sin_cos(self.step_rad * at);
        self.squared_error(x, (sin, cos))
    }

    /// Error of the rate of a wave, per interval.
    fn rate_error(&self, x: &Column, at: f32) -> f32 {
        let (sin, cos) = math::sin_cos(self.step_rad * at);
        self.squared_error(x, (self.step_rad * cos, -self.step_rad * sin))
    }

    /// A²/2 |Σ x e^{jωt} − `target`|², numbers as (imaginary, real) parts.
    fn squared_error(&self, x: &Column, target: (f32, f32)) -> f32 {
        let sum = |(s, c): (f32, f32), (x, wave): (&f32, &(f32, f32))| (s + x * wave.0, c + x * wave.1);
        let (s, c) = x.iter().zip(&self.samples).fold((-target.0, -target.1), sum);
        self.power * (s * s + c * c)
    }
}
