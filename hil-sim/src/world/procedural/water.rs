//! Lakes: dark water with waves. The picture of the land has the waves of one instant, which the reference keeps; frames show
//! their own.

use super::{CENTRE_EAST_M, CENTRE_NORTH_M, streams};
use crate::noise::pixels::stream;
use crate::world::swell::{Patches, Swell};
use rand_chacha::ChaCha8Rng;

/// Width of a lake, and of the land between two where they share it, metres. Chosen: a frame of the default scene is as wide, so
/// that most frames have a shore.
const LAKE_M: f64 = 150.0;
/// Width of the water's edge, metres.
const EDGE_M: f64 = 1.5;
/// Grey of water, and the waves' standard deviation. Chosen: as dark as the painted river, and waves as strong as the grain of a
/// field, so that a matcher that took them for ground would be misled.
const WATER: f64 = 52.0;
const WAVES: f64 = 9.0;
/// Lengths of the waves that show at a few metres a pixel, metres: glitter in streaks and cat's paws. Chosen.
const WAVES_M: [f64; 2] = [6.0, 60.0];

/// Where the water is.
#[derive(Clone, Debug)]
pub(in crate::world) struct Lakes {
    patches: Patches,
}

/// Waves of one instant.
pub(in crate::world) fn wavy(rng: &mut ChaCha8Rng) -> Swell {
    Swell::new(rng, WAVES_M)
}

impl Lakes {
    /// Lakes over so much of the land of a seed.
    pub(in crate::world) fn new(seed: u64, water_fraction: f64) -> Self {
        Lakes { patches: Patches::new(&mut stream(seed, streams::LAKES), LAKE_M, water_fraction, EDGE_M) }
    }

    /// Whether a local point is on dry land.
    pub(super) fn is_dry(&self, at: [f64; 2]) -> bool {
        self.patches.cover(at) == 0.0
    }

    /// Water with these waves over a grey of the land at a local point.
    pub(super) fn over_local(&self, land: f64, at: [f64; 2], waves: &Swell) -> f64 {
        match self.patches.cover(at) {
            0.0 => land,
            share => land + share * (WATER + WAVES * waves.at(at) - land),
        }
    }

    /// As it is, at a point of the grid.
    pub(in crate::world) fn over(&self, land: f64, [east_m, north_m]: [f64; 2], waves: &Swell) -> f64 {
        self.over_local(land, [east_m - CENTRE_EAST_M, north_m - CENTRE_NORTH_M], waves)
    }
}

/// Paints the lakes into the finished picture, with the waves of the instant that it keeps.
pub(super) fn fill(lakes: &Lakes, seed: u64, albedo: &mut [f32]) {
    use super::{SIDE, local_m};
    use rayon::prelude::*;
    let waves = wavy(&mut stream(seed, streams::WAVES));
    albedo.par_chunks_mut(SIDE).enumerate().for_each(|(row, line)| {
        for (col, value) in line.iter_mut().enumerate() {
            *value = lakes.over_local(f64::from(*value), [local_m(col), -local_m(row)], &waves) as f32;
        }
    });
}
