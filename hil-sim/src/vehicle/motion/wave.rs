//! Smooth random functions of time.

use crate::noise::uniform;
use rand_chacha::ChaCha12Rng;
use std::f64::consts::TAU;

/// Sinusoids in a wave. Their sum's kurtosis is 3 − 1.5/N: 2.94, close enough to normal.
const PARTS: u32 = 24;

/// A stationary Gaussian function of time with unit variance, infinitely smooth: equally strong sinusoids of random
/// phase, one in each of [`PARTS`] equal bands of frequency.
#[derive(Debug)]
pub struct Wave {
    /// Angular frequency in radians a second, and phase.
    parts: Vec<(f64, f64)>,
}

impl Wave {
    /// Frequencies between `low_hz` and `high_hz`.
    pub fn new(mut rng: ChaCha12Rng, low_hz: f64, high_hz: f64) -> Self {
        let band_hz = (high_hz - low_hz) / f64::from(PARTS);
        let part = |band| {
            let frequency_hz = low_hz + band_hz * (f64::from(band) + uniform(&mut rng));
            (TAU * frequency_hz, TAU * uniform(&mut rng))
        };
        Wave { parts: (0..PARTS).map(part).collect() }
    }

    /// The function itself: normal, unit variance.
    pub fn normal(&self, t_s: f64) -> f64 {
        let sum: f64 = self.parts.iter().map(|(frequency, phase)| (frequency * t_s + phase).cos()).sum();
        sum * (2.0 / f64::from(PARTS)).sqrt()
    }

    /// Its derivative, a second.
    pub fn normal_rate(&self, t_s: f64) -> f64 {
        let part = |(frequency, phase): &(f64, f64)| -frequency * (frequency * t_s + phase).sin();
        self.parts.iter().map(part).sum::<f64>() * (2.0 / f64::from(PARTS)).sqrt()
    }

    /// Mapped by the normal distribution: uniform within (−1, 1), as smooth.
    pub fn uniform(&self, t_s: f64) -> f64 {
        erf(self.normal(t_s) * std::f64::consts::FRAC_1_SQRT_2)
    }
}

/// Error function, to 1.5e-7 (Abramowitz and Stegun 7.1.26): 1.5e-6° of tilt at ±10°.
fn erf(x: f64) -> f64 {
    const A: [f64; 5] = [0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429];
    let t = 1.0 / (1.0 + 0.3275911 * x.abs());
    let polynomial = A.iter().rev().fold(0.0, |sum, a| (sum + a) * t);
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_function_has_its_tabled_values() {
        for (x, table) in [(0.0, 0.0), (0.5, 0.5204998778), (-1.0, -0.8427007929), (2.0, 0.9953222650)] {
            assert!((erf(x) - table).abs() < 1.6e-7, "erf({x}) = {}", erf(x));
        }
    }
}
