//! 1/f texture: every octave of size carries the same variance.

use crate::noise::pixels::stream;
use rand_chacha::rand_core::Rng;
use rayon::prelude::*;

/// A square of `side` x `side` values with mean 0 and standard deviation about 1, detail from 2^`levels` pixels down to one.
///
/// Starts from a coarse random raster, doubles it with the weights 9 3 3 1 / 16 (which in the limit is a quadratic B-spline,
/// so no edges show) and adds fresh random values of the same size at every doubling. Level k draws from stream
/// `first_stream` + k, each row from its own place in it.
pub(super) fn fractal(seed: u64, first_stream: u64, side: usize, levels: u32) -> Vec<f32> {
    // A uniform number has variance 1/3 of its half width squared; the octaves keep about 1/3 of it after smoothing.
    let half_width = 3.0 / f64::from(levels + 1).sqrt() as f32;
    let mut width = side.div_ceil(1 << levels) + 1;
    let mut values = vec![0f32; width * width];
    add_random(&mut values, width, half_width, seed, first_stream);
    for level in (0..levels).rev() {
        let finer = if level == 0 { side } else { side.div_ceil(1 << level) + 1 };
        values = doubled(&values, width, finer);
        width = finer;
        add_random(&mut values, width, half_width, seed, first_stream + u64::from(levels - level));
    }
    values
}

fn add_random(values: &mut [f32], width: usize, half_width: f32, seed: u64, stream_number: u64) {
    let scale = half_width / 32768.0;
    values.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
        let mut rng = stream(seed, stream_number);
        rng.set_word_pos(row as u128 * width.div_ceil(2) as u128);
        for pair in line.chunks_mut(2) {
            let word = rng.next_u32();
            for (value, half) in pair.iter_mut().zip([word & 0xffff, word >> 16]) {
                *value += (half as f32 - 32767.5) * scale;
            }
        }
    });
}

/// Twice as many pixels (cut to `finer`): each lies a quarter of a coarse pixel off the coarse centre.
fn doubled(coarse: &[f32], width: usize, finer: usize) -> Vec<f32> {
    let neighbours = |index: usize| {
        let near = (index / 2).min(width - 1);
        (near, if index % 2 == 1 { (near + 1).min(width - 1) } else { near.saturating_sub(1) })
    };
    let mut fine = vec![0f32; finer * finer];
    fine.par_chunks_mut(finer).enumerate().for_each(|(row, line)| {
        let (near, far) = neighbours(row);
        let mixed: Vec<f32> =
            (0..width).map(|col| 0.75 * coarse[near * width + col] + 0.25 * coarse[far * width + col]).collect();
        for (col, value) in line.iter_mut().enumerate() {
            let (near, far) = neighbours(col);
            *value = 0.75 * mixed[near] + 0.25 * mixed[far];
        }
    });
    fine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_unit_size_and_every_octave_the_same_share() {
        let side = 1024;
        let values = fractal(5, 100, side, 8);
        assert_eq!(values, fractal(5, 100, side, 8));
        let variance = |step: usize| {
            let sum: f64 = (0..side * (side - step))
                .map(|i| {
                    let at = (i / (side - step)) * side + i % (side - step);
                    f64::from(values[at + step] - values[at]).powi(2)
                })
                .sum();
            sum / (side * (side - step)) as f64
        };
        let total = values.iter().map(|&v| f64::from(v * v)).sum::<f64>() / values.len() as f64;
        println!("standard deviation {:.2}", total.sqrt());
        assert!((0.7..1.4).contains(&total.sqrt()), "{total}");
        // The structure function of 1/f noise grows by the same amount at each doubling.
        let steps: Vec<f64> = [2, 4, 8, 16, 32].map(|s| variance(2 * s) - variance(s)).to_vec();
        println!("increments {steps:.3?}");
        assert!(steps.iter().all(|&s| s > 0.4 * steps[0] && s < 2.5 * steps[0]), "{steps:?}");
    }
}
