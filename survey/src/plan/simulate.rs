//! Simulated noise of a block, and what the intersection makes of it (paper 004, section 2, steps 3 to 6).
//!
//! Each photo has one error of its position and its attitude, for all points that it sees; each ray has image noise of its
//! own. The ray is projected through the camera as it really is and read as if it were where the plan has it.

use super::intersect::{Sigmas, intersection};
use super::lines::Strip;
use super::sight::Ray;
use nalgebra::{Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The noise of all photos, and a generator for that of the rays.
#[derive(Debug)]
pub struct Simulation {
    sigmas: Sigmas,
    /// At the start of its streams.
    rays: ChaCha8Rng,
    /// Number of each strip's first photo.
    first: Vec<usize>,
    /// Position errors (along, across, up), and how the camera really is turned.
    photos: Vec<(Vector3<f64>, Rotation3<f64>)>,
}

impl Simulation {
    /// Noise for the photos of `strips`, photo by photo in their order; each round has its own.
    #[must_use]
    pub fn new(strips: &[Strip], sigmas: &Sigmas, seed: u64, round: u64) -> Self {
        let mut rng = generator(seed, round);
        let mut first = Vec::with_capacity(strips.len());
        let mut photos = Vec::new();
        for strip in strips {
            first.push(photos.len());
            for _ in &strip.along_m {
                let draws: [f64; 6] = normals(&mut rng);
                let position = Vector3::from_column_slice(&draws[..3]) * sigmas.position_m;
                let attitude = Vector3::from_column_slice(&draws[3..]) * sigmas.attitude_rad;
                photos.push((position, Rotation3::new(attitude)));
            }
        }
        Simulation { sigmas: *sigmas, rays: generator(seed, round), first, photos }
    }

    /// How far off the point of these rays comes out: along, across, up. `point` gives its rays noise of their own.
    #[must_use]
    pub fn intersected(&self, rays: &[Ray], point: u64) -> Option<[f64; 3]> {
        let mut rng = self.rays.clone();
        // Stream 0 is the photos'.
        rng.set_stream(point + 1);
        let measured: Vec<[f64; 2]> = rays
            .iter()
            .map(|ray| {
                let (position, attitude) = &self.photos[self.first[ray.strip] + ray.photo];
                let [a, b] = ray.tangent;
                let sight = Vector3::new(a, b, -1.0) * ray.depth_m - position;
                let seen = attitude.inverse() * sight;
                let noise: [f64; 2] = normals(&mut rng);
                [0, 1].map(|axis| seen[axis] / -seen[2] + self.sigmas.image[axis] * noise[axis])
            })
            .collect();
        intersection(rays, &measured, &self.sigmas)
    }
}

/// One generator a round, each with a stream for its photos and one a point.
fn generator(seed: u64, round: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&round.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// Standard normal numbers, two at a time (Box and Muller, 1958).
fn normals<const N: usize>(rng: &mut ChaCha8Rng) -> [f64; N] {
    // Uniform in (0, 1]: its logarithm is finite.
    let mut uniform = || ((rng.next_u64() >> 11) + 1) as f64 * (1.0 / (1_u64 << 53) as f64);
    let mut numbers = [0.0; N];
    for pair in numbers.chunks_mut(2) {
        let radius = (-2.0 * uniform().ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * uniform()).sin_cos();
        for (number, value) in pair.iter_mut().zip([radius * cos, radius * sin]) {
            *number = value;
        }
    }
    numbers
}
