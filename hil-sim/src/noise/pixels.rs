//! Seeded random streams: ChaCha with eight rounds, whose output is documented and the same on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of its own for each pair: the seed is the key (little endian, zero padded), `stream` the ChaCha stream number.
pub fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut key = [0u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(stream);
    rng
}

/// Uniform in [0, 1) from one 32-bit word.
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / 4_294_967_296.0
}

/// Uniform in [low, high) from one 32-bit word.
pub fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * unit(rng)
}

/// Two independent standard normal numbers from two 32-bit words (Box and Muller, Ann. Math. Stat. 29, 1958).
pub fn normal_pair(rng: &mut ChaCha8Rng) -> [f64; 2] {
    // 1 - u lies in (0, 1], so the logarithm is finite; the largest value that can come out is 6.7.
    let radius = (-2.0 * (1.0 - unit(rng)).ln()).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * unit(rng)).sin_cos();
    [radius * cos, radius * sin]
}

/// Adds normal noise of standard deviation `noise_dn` to a row of grey values. `row` chooses the place in the stream, so
/// rows can be made in any order, by any number of threads. A row takes two words a pair of pixels.
pub fn add_noise(values: &mut [f64], noise_dn: f64, seed: u64, stream_index: u64, row: usize) {
    if noise_dn <= 0.0 {
        return;
    }
    let words = values.len().div_ceil(2) as u128 * 2;
    let mut rng = stream(seed, stream_index);
    rng.set_word_pos(row as u128 * words);
    for pair in values.chunks_mut(2) {
        for (value, normal) in pair.iter_mut().zip(normal_pair(&mut rng)) {
            *value += noise_dn * normal;
        }
    }
}

/// Rounds to the nearest grey value of 8 bit and clamps.
pub fn to_grey(value: f64) -> u8 {
    // Cut off: what is left is the nearest, away from 0 in the middle.
    (value.clamp(0.0, 255.0) + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_zero_and_unit_variance() {
        let mut rng = stream(1, 2);
        let draws: Vec<f64> = (0..50_000).flat_map(|_| normal_pair(&mut rng)).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        // Standard errors for n = 1e5: mean 0.0032, variance 0.0045; four of each are allowed.
        assert!(mean.abs() < 0.013, "mean {mean}");
        assert!((variance - 1.0).abs() < 0.018, "variance {variance}");
    }

    #[test]
    fn streams_and_rows_differ_but_repeat() {
        let row = |stream, row| {
            let mut values = [0.0; 9];
            add_noise(&mut values, 1.0, 7, stream, row);
            values
        };
        assert_eq!(row(3, 5), row(3, 5));
        assert_ne!(row(3, 5), row(3, 6));
        assert_ne!(row(3, 5), row(4, 5));
    }
}
