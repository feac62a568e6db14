//! The paper's simulation: a sine of at most 10 m/s about the designed height, measured at 5 Hz; and an attitude.

use plumbline_survey::smooth::{Alpha, Epochs, Fit, Options, Order, SmoothError, smooth};
use std::f64::consts::TAU;

/// Largest amount of an error of position, metres: the paper's figure and its formulas' text have 25 cm.
pub const NOISE_M: f64 = 0.25;
/// Height of the flight, metres.
const HEIGHT_M: f64 = 500.0;
/// Largest speed of the deviation, m/s.
const SPEED_M_S: f64 = 10.0;
/// Phase of the sine; the paper gives none.
const PHASE: f64 = 0.7;
/// How long, seconds; positions and attitudes a second.
const LENGTH_S: f64 = 60.0;
const POSITIONS_HZ: f64 = 5.0;
const ATTITUDES_HZ: f64 = 50.0;
/// Largest amount of an error of attitude, degrees.
const NOISE_DEG: f64 = 0.05;

/// Samples of a known curve.
#[derive(Clone, Copy, Debug)]
pub struct Simulation {
    truth: fn(f64, f64) -> f64,
    period_s: f64,
    rate_hz: f64,
    noise: f64,
    seed: u64,
}

/// Z of the projection centre, metres, with a deviation of the period.
#[must_use]
pub fn position(period_s: f64, seed: u64) -> Simulation {
    let truth = |t_s: f64, period_s: f64| {
        let w = TAU / period_s;
        HEIGHT_M + SPEED_M_S / w * (PHASE + w * t_s).sin()
    };
    Simulation { truth, period_s, rate_hz: POSITIONS_HZ, noise: NOISE_M, seed }
}

/// An angle, degrees: 3 degrees in 6 s, 0.3 degrees in 0.7 s, a drift of 0.002 degrees a second.
#[must_use]
pub fn attitude(seed: u64) -> Simulation {
    let truth = |t_s: f64, _: f64| 3.0 * (TAU / 6.0 * t_s).sin() + 0.3 * (TAU / 0.7 * t_s).sin() + 0.002 * t_s;
    Simulation { truth, period_s: 0.0, rate_hz: ATTITUDES_HZ, noise: NOISE_DEG, seed }
}

impl Simulation {
    /// The curve without noise.
    #[must_use]
    pub fn truth(&self, t_s: f64) -> f64 {
        (self.truth)(t_s, self.period_s)
    }

    /// When it is measured, seconds.
    #[must_use]
    pub fn instants(&self) -> Vec<f64> {
        let intervals = (LENGTH_S * self.rate_hz).round() as u32;
        (0..=intervals).map(|i| f64::from(i) / self.rate_hz).collect()
    }

    /// What is measured: noise evenly within its bounds, by splitmix64.
    #[must_use]
    pub fn observed(&self) -> Vec<f64> {
        let mut state = self.seed;
        let noise = |state: &mut u64| self.noise * (2.0 * uniform(state) - 1.0);
        self.instants().into_iter().map(|t_s| self.truth(t_s) + noise(&mut state)).collect()
    }

    /// The fit of order 2 or 3.
    ///
    /// # Errors
    /// As [`smooth`]: an alpha that is none.
    pub fn fitted(&self, order: usize, alpha: Alpha) -> Result<Fit, SmoothError> {
        let order = if order == 2 { Order::Second } else { Order::Third };
        let observed = self.observed();
        smooth(&Epochs::new(self.instants())?, &observed, &vec![1.0; observed.len()], &Options::new(order, alpha))
    }
}

/// The next of splitmix64, 53 bits in [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
