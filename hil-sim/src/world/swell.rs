//! Smooth random values over the plane, and where they are lowest: the shapes of clouds, lakes and waves.

use crate::noise::pixels::{uniform, unit};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Plane waves that a value is the sum of. Chosen: enough that the values are normal within a few percent, few enough to ask for
/// them ray by ray.
const WAVES: usize = 16;
/// Points a side, and their distance in longest waves, over which the share of the plane is counted. Chosen: a share is off by
/// a percent or two of the plane.
const COUNTED: usize = 96;
const APART: f64 = 0.37;

/// A sum of plane waves of random directions, mean 0, standard deviation 1.
#[derive(Clone, Debug)]
pub(super) struct Swell {
    /// Wave number along both axes (radians a metre), and phase.
    waves: [[f64; 3]; WAVES],
    longest_m: f64,
}

impl Swell {
    /// Wave lengths between `shortest_m` and `longest_m`, as many in each octave.
    pub(super) fn new(rng: &mut ChaCha8Rng, [shortest_m, longest_m]: [f64; 2]) -> Self {
        let waves = std::array::from_fn(|_| {
            let (sin, cos) = uniform(rng, 0.0, TAU).sin_cos();
            let number = TAU / (shortest_m * (longest_m / shortest_m).powf(unit(rng)));
            [number * cos, number * sin, uniform(rng, 0.0, TAU)]
        });
        Swell { waves, longest_m }
    }

    /// The value at a point in metres.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let sum: f64 =
            self.waves.iter().map(|[along_x, along_y, phase]| (along_x * x + along_y * y + phase).sin()).sum();
        // The variance of a sine is a half.
        sum * (2.0 / WAVES as f64).sqrt()
    }
}

/// Patches of the plane: where smooth random values are among the lowest.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    swell: Swell,
    below: f64,
    /// Change of the value over the soft border.
    border: f64,
}

impl Patches {
    /// Patches about `size_m` wide, as their gaps where the share is a half, that cover `share` of the plane; their borders fade
    /// over some `border_m`.
    pub(super) fn new(rng: &mut ChaCha8Rng, size_m: f64, share: f64, border_m: f64) -> Self {
        // A wave is a patch and a gap long.
        let swell = Swell::new(rng, [1.4 * size_m, 2.8 * size_m]);
        let place = |i: usize| (i as f64 - COUNTED as f64 / 2.0) * APART * swell.longest_m;
        let mut values: Vec<f64> =
            (0..COUNTED * COUNTED).map(|i| swell.at([place(i % COUNTED), place(i / COUNTED)])).collect();
        values.sort_by(f64::total_cmp);
        let below = match (share * values.len() as f64) as usize {
            0 => f64::NEG_INFINITY,
            count => values.get(count).copied().unwrap_or(f64::INFINITY),
        };
        // The root mean square slope of the middle wave along one axis.
        Patches { swell, below, border: border_m * TAU / (2.0 * size_m) / std::f64::consts::SQRT_2 }
    }

    /// How much of a patch is at a point: 0 outside, 1 inside.
    pub(super) fn cover(&self, at: [f64; 2]) -> f64 {
        ((self.below - self.swell.at(at)) / self.border + 0.5).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::pixels::stream;

    #[test]
    fn values_are_of_unit_size_and_patches_cover_their_share() {
        let swell = Swell::new(&mut stream(3, 1), [20.0, 60.0]);
        let points: Vec<[f64; 2]> =
            (0..40_000).map(|i| [f64::from(i % 200) * 17.3, f64::from(i / 200) * 13.9]).collect();
        let mean = |of: &dyn Fn([f64; 2]) -> f64| points.iter().map(|at| of(*at)).sum::<f64>() / points.len() as f64;
        let (middle, square) = (mean(&|at| swell.at(at)), mean(&|at| swell.at(at).powi(2)));
        // 40,000 points over some 3000 waves: standard errors of about 0.02 and 0.03.
        assert!(middle.abs() < 0.08 && (square - 1.0).abs() < 0.12, "{middle} {square}");
        for share in [0.0, 0.3, 0.6, 1.0] {
            let patches = Patches::new(&mut stream(3, 2), 30.0, share, 2.0);
            let covered = mean(&|at| patches.cover(at));
            assert!((covered - share).abs() < 0.02, "{covered} of {share}");
        }
    }
}
