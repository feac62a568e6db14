//! Random numbers that a seed and a name decide.
//!
//! Each source of noise draws from a ChaCha stream of its own, named after it. So a sensor that is switched on or off,
//! or samples faster, changes no other sensor's noise.

pub mod pixels;

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// The generator of the source `name` in a flight with `seed`.
#[must_use]
pub fn stream(seed: u64, name: &str) -> ChaCha12Rng {
    // FNV-1a, 64 bits: it only has to tell a few names apart, and must be the same for ever.
    let hash = name
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&hash.to_le_bytes());
    ChaCha12Rng::from_seed(key)
}

/// Uniform in [0, 1), 53 bits.
pub fn uniform(rng: &mut ChaCha12Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Standard normal, by Box and Muller.
pub fn normal(rng: &mut ChaCha12Rng) -> f64 {
    let radius = (-2.0 * (1.0 - uniform(rng)).ln()).sqrt();
    radius * (TAU * uniform(rng)).cos()
}

/// Noise that is new in every sample.
#[derive(Debug, Clone)]
pub struct White {
    sigma: f64,
    rng: ChaCha12Rng,
}

impl White {
    /// One sigma, in the unit of what it is added to.
    #[must_use]
    pub fn new(sigma: f64, seed: u64, name: &str) -> Self {
        White { sigma, rng: stream(seed, name) }
    }

    /// The next sample's noise.
    pub fn draw(&mut self) -> f64 {
        self.sigma * normal(&mut self.rng)
    }
}

/// First-order Gauss-Markov noise: stationary, standard deviation σ, autocorrelation e^(−Δt/τ).
///
/// Discretised exactly for any step: x' = x e^(−Δt/τ) + σ √(1 − e^(−2Δt/τ)) n, started from the stationary law.
#[derive(Debug, Clone)]
pub struct GaussMarkov {
    sigma: f64,
    time_constant_us: f64,
    /// The newest instant and its value in sigmas.
    newest: Option<(u64, f64)>,
    rng: ChaCha12Rng,
}

impl GaussMarkov {
    /// One sigma in the unit of what it is added to; the time constant in seconds, above 0.
    #[must_use]
    pub fn new(sigma: f64, time_constant_s: f64, seed: u64, name: &str) -> Self {
        GaussMarkov { sigma, time_constant_us: time_constant_s * 1e6, newest: None, rng: stream(seed, name) }
    }

    /// The noise at `t_us`, not before the instant asked for last.
    pub fn at(&mut self, t_us: u64) -> f64 {
        let value = match self.newest {
            None => normal(&mut self.rng),
            Some((before_us, value)) => {
                let kept = (-(t_us.saturating_sub(before_us) as f64) / self.time_constant_us).exp();
                value * kept + (1.0 - kept * kept).sqrt() * normal(&mut self.rng)
            }
        };
        self.newest = Some((t_us, value));
        self.sigma * value
    }
}
