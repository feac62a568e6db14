//! What has changed on the land since the reference was taken: blobs of 15 to 60 m, fixed to the ground.

use super::Radiometry;
use crate::noise::pixels::{stream, uniform, unit};
use crate::world::Ground;
use std::f64::consts::TAU;

/// Side of the square blocks that each hold their share of changes, metres. Blocks lie on multiples of this number in the
/// ground's coordinates, so tiles that overlap show the same changes.
const BLOCK_M: f64 = 120.0;
const BLOB_M: [f64; 2] = [15.0, 60.0];
/// Everything that changed under a tile: the blobs of every block it touches.
#[derive(Debug)]
pub(super) struct Changes {
    first: [i64; 2],
    across: usize,
    blocks: Vec<Vec<Blob>>,
}

impl Changes {
    pub(super) fn over(
        ground: &Ground,
        east: [f64; 2],
        north: [f64; 2],
        margin_m: f64,
        radiometry: &Radiometry,
    ) -> Self {
        let index = |at: f64| (at / BLOCK_M).floor() as i64;
        let first = [index(east[0] - margin_m), index(north[0] - margin_m)];
        let last = [index(east[1] + margin_m), index(north[1] + margin_m)];
        let across = (last[0] - first[0] + 1) as usize;
        let blocks = (first[1]..=last[1])
            .flat_map(|y| (first[0]..=last[0]).map(move |x| [x, y]))
            .map(|block| blobs(ground, block, radiometry))
            .collect();
        Changes { first, across, blocks }
    }

    /// Albedo as it was when the reference was taken.
    pub(super) fn albedo(&self, ground: &Ground, east_m: f64, north_m: f64) -> Option<f64> {
        let now = ground.albedo(east_m, north_m)?;
        let col = ((east_m / BLOCK_M).floor() as i64 - self.first[0]) as usize;
        let row = ((north_m / BLOCK_M).floor() as i64 - self.first[1]) as usize;
        let blob = self.blocks[row * self.across + col].iter().find(|blob| blob.covers(east_m, north_m));
        Some(blob.map_or(now, |blob| blob.albedo(ground, east_m, north_m)))
    }
}

/// One changed place: a rectangle or an ellipse with another tone and texture.
#[derive(Debug)]
struct Blob {
    centre: [f64; 2],
    half: [f64; 2],
    axis: [f64; 2],
    round: bool,
    tone: f64,
    building: bool,
    row_period_m: f64,
    texture_from: [f64; 2],
}

impl Blob {
    /// Position along and across the blob.
    fn local(&self, east_m: f64, north_m: f64) -> [f64; 2] {
        let [e, n] = [east_m - self.centre[0], north_m - self.centre[1]];
        [e * self.axis[0] + n * self.axis[1], n * self.axis[0] - e * self.axis[1]]
    }

    fn covers(&self, east_m: f64, north_m: f64) -> bool {
        let [u, v] = self.local(east_m, north_m);
        let [u, v] = [u / self.half[0], v / self.half[1]];
        if self.round { u * u + v * v <= 1.0 } else { u.abs() <= 1.0 && v.abs() <= 1.0 }
    }

    /// A building has two roof sides; a field has rows and borrows its irregularities from another place of the ground.
    fn albedo(&self, ground: &Ground, east_m: f64, north_m: f64) -> f64 {
        let [_, across] = self.local(east_m, north_m);
        let texture = if self.building {
            18f64.copysign(across)
        } else {
            let borrowed = ground.albedo(east_m + self.texture_from[0], north_m + self.texture_from[1]);
            let irregular = borrowed.map_or(0.0, |b| (0.3 * (b - 120.0)).clamp(-15.0, 15.0));
            8.0 * (TAU * across / self.row_period_m).sin() + irregular
        };
        (self.tone + texture).clamp(0.0, 255.0)
    }
}

/// The changes of one block. Blobs are drawn until they cover the wished share, counted on a 1 m raster; the last one is
/// shrunk to fit, and one that would be smaller than the smallest blob is kept with the probability that makes the mean right.
fn blobs(ground: &Ground, [x, y]: [i64; 2], radiometry: &Radiometry) -> Vec<Blob> {
    // Block coordinates fit 31 bits each on any map in metres; the pair makes the stream number.
    let mut rng = stream(radiometry.seed, ((x as u32 as u64) << 32) | y as u32 as u64);
    let side = BLOCK_M as usize;
    let mut covered = vec![false; side * side];
    let mut missing = radiometry.changed_fraction.clamp(0.0, 1.0) * BLOCK_M * BLOCK_M;
    let corner = [x as f64 * BLOCK_M, y as f64 * BLOCK_M];
    let mut found = Vec::new();
    for _ in 0..400 {
        if missing < 0.5 {
            break;
        }
        let building = unit(&mut rng) < 0.35;
        let round = !building && unit(&mut rng) < 0.3;
        let mut size = [uniform(&mut rng, BLOB_M[0], BLOB_M[1]), uniform(&mut rng, BLOB_M[0], BLOB_M[1])];
        if building {
            size = [size[0], size[1].min(30.0)];
        }
        let share = if round { TAU / 8.0 } else { 1.0 };
        let too_large = size[0] * size[1] * share / missing;
        if too_large > 1.0 {
            size = size.map(|s| (s / too_large.sqrt()).max(BLOB_M[0]));
            let area = size[0] * size[1] * share;
            if area > missing && unit(&mut rng) >= missing / area {
                break;
            }
        }
        let (sin, cos) = uniform(&mut rng, 0.0, TAU).sin_cos();
        let half = size.map(|s| s / 2.0);
        let reach = [half[0] * cos.abs() + half[1] * sin.abs(), half[0] * sin.abs() + half[1] * cos.abs()];
        let centre = std::array::from_fn(|i| corner[i] + uniform(&mut rng, reach[i], BLOCK_M - reach[i]));
        let now = ground.albedo(centre[0], centre[1]).unwrap_or(128.0);
        let away = uniform(&mut rng, 40.0, 90.0);
        let tone = if now > 128.0 { now - away } else { now + away };
        let (distance, bearing) = (uniform(&mut rng, 150.0, 400.0), uniform(&mut rng, 0.0, TAU));
        let blob = Blob {
            centre,
            half,
            axis: [cos, sin],
            round,
            tone,
            building,
            row_period_m: uniform(&mut rng, 2.0, 6.0),
            texture_from: [distance * bearing.cos(), distance * bearing.sin()],
        };
        for (i, cell) in covered.iter_mut().enumerate() {
            let (east, north) = (corner[0] + (i % side) as f64 + 0.5, corner[1] + (i / side) as f64 + 0.5);
            if !*cell && blob.covers(east, north) {
                *cell = true;
                missing -= 1.0;
            }
        }
        found.push(blob);
    }
    found
}
