//! Clouds: an opaque layer with gaps at one height, which drifts. Lying nearer to the camera than the ground, they pass by faster.

use crate::noise::pixels::stream;
use crate::scenario;
use crate::world::swell::Patches;

/// Stream of the seed.
const STREAM: u64 = 0x70;
/// Width of a cloud's border, in its own widths. Chosen.
const BORDER: f64 = 0.1;

#[derive(Clone, Debug)]
pub(super) struct Clouds {
    patches: Patches,
    height_m: f64,
    wind_m_s: [f64; 2],
    grey: f64,
}

/// The layer at an instant.
#[derive(Clone, Debug)]
pub(super) struct Now<'w> {
    clouds: &'w Clouds,
    up_m: f64,
    drifted_m: [f64; 2],
}

impl Clouds {
    pub(super) fn new(seed: u64, weather: &scenario::Weather) -> Self {
        let size_m = weather.cloud_size_m;
        Clouds {
            patches: Patches::new(&mut stream(seed, STREAM), size_m, weather.cloud_fraction, BORDER * size_m),
            height_m: weather.cloud_height_m,
            wind_m_s: weather.cloud_wind_m_s,
            grey: weather.cloud_dn,
        }
    }

    pub(super) fn at(&self, at_s: f64, ground_m: f64) -> Now<'_> {
        Now { clouds: self, up_m: ground_m + self.height_m, drifted_m: self.wind_m_s.map(|rate| rate * at_s) }
    }
}

impl Now<'_> {
    /// Covers what is seen through the layer from above.
    pub(super) fn pass(&self, origin: [f64; 3], directions: &[[f64; 3]], seen: &mut [f64]) {
        let above_m = origin[2] - self.up_m;
        if above_m <= 0.0 {
            return;
        }
        for (direction, seen) in directions.iter().zip(seen) {
            if direction[2] >= 0.0 {
                continue;
            }
            let along = -above_m / direction[2];
            let at = std::array::from_fn(|axis| origin[axis] + along * direction[axis] - self.drifted_m[axis]);
            *seen += self.clouds.patches.cover(at) * (self.clouds.grey - *seen);
        }
    }
}
