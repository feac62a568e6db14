//! Waves on lakes: each frame shows others.

use crate::noise::pixels::stream;
use crate::world::procedural::{Lakes, wavy};
use crate::world::swell::Swell;

/// First stream of the seed, one a frame.
const STREAM: u64 = 0x71 << 32;

#[derive(Clone, Debug)]
pub(super) struct Waves {
    seed: u64,
    lakes: Lakes,
}

/// The waves of a frame.
#[derive(Clone, Debug)]
pub(super) struct Now<'w> {
    lakes: &'w Lakes,
    swell: Swell,
}

impl Waves {
    pub(super) fn new(seed: u64, water_fraction: f64) -> Self {
        Waves { seed, lakes: Lakes::new(seed, water_fraction) }
    }

    pub(super) fn at(&self, frame: u64) -> Now<'_> {
        Now { lakes: &self.lakes, swell: wavy(&mut stream(self.seed, STREAM + frame)) }
    }
}

impl Now<'_> {
    /// The waves that the picture of the ground has are replaced.
    pub(super) fn pass(&self, origin: [f64; 3], directions: &[[f64; 3]], along: &[f64], seen: &mut [f64]) {
        // A ray to the horizon meets nothing.
        let rays = directions.iter().zip(along).zip(seen).filter(|((_, along), _)| along.is_finite());
        for ((direction, along), seen) in rays {
            let at = [0, 1].map(|axis| origin[axis] + along * direction[axis]);
            *seen = self.lakes.over(*seen, at, &self.swell);
        }
    }
}
