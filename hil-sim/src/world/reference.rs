//! Reference tiles: what an older orthophoto of the same land looks like, at the resolution the matching works in.
//!
//! A cell is the area mean of the ground seen from straight above. Then come the ways in which an old picture differs from
//! today's frame: another gamma, gain and offset, noise of its own, and areas that have changed since: fields ploughed,
//! buildings new.

mod changes;

use crate::noise::pixels::{add_noise, to_grey};
use crate::world::Ground;
use changes::Changes;
use rayon::prelude::*;

/// How the reference differs from the ground. `grey = 255 (albedo / 255)^gamma gain + offset + noise`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radiometry {
    /// Exponent on the relative grey value; 1 leaves it.
    pub gamma: f64,
    /// Factor on the grey value.
    pub gain: f64,
    /// Grey value added.
    pub offset: f64,
    /// Standard deviation of the noise of a cell, grey values.
    pub noise_dn: f64,
    /// Share of the area, 0 to 1, that shows something else, in blobs of 15 to 60 m.
    pub changed_fraction: f64,
    /// Seed of noise and changes.
    pub seed: u64,
}

impl Radiometry {
    /// No difference at all.
    pub const SAME: Radiometry =
        Radiometry { gamma: 1.0, gain: 1.0, offset: 0.0, noise_dn: 0.0, changed_fraction: 0.0, seed: 0 };
}

/// Stream number of the noise; no block on a map in metres has it.
const NOISE_STREAM: u64 = 1 << 63;

/// A reference tile, row 0 north, `cols` x `rows` cells of `resolution_m`; the first cell's CENTRE lies at (`west_m`,
/// `north_m`). Each cell is the mean of k x k albedo samples, k so that a sample is no wider than an albedo pixel (3 to 16).
/// Cells that are not wholly on known ground are 0: ask [`Ground::bounds`] before.
pub fn reference_tile(
    ground: &Ground,
    west_m: f64,
    north_m: f64,
    cols: usize,
    rows: usize,
    resolution_m: f64,
    radiometry: &Radiometry,
) -> Vec<u8> {
    reference_tile_counted(ground, west_m, north_m, cols, rows, resolution_m, radiometry).0
}

/// As [`reference_tile`], and how many cells are not wholly on known ground.
pub fn reference_tile_counted(
    ground: &Ground,
    west_m: f64,
    north_m: f64,
    cols: usize,
    rows: usize,
    resolution_m: f64,
    radiometry: &Radiometry,
) -> (Vec<u8>, usize) {
    let mut tile = vec![0u8; cols * rows];
    if tile.is_empty() {
        return (tile, 0);
    }
    let per_side = (resolution_m / ground.albedo_grid().step_m).ceil().clamp(3.0, 16.0) as usize;
    let part = |i: usize| ((i as f64 + 0.5) / per_side as f64 - 0.5) * resolution_m;
    let south_m = north_m - rows as f64 * resolution_m;
    let east_m = west_m + cols as f64 * resolution_m;
    let changes = Changes::over(ground, [west_m, east_m], [south_m, north_m], resolution_m, radiometry);
    let unknown = tile.par_chunks_mut(cols).enumerate().map(|(row, line)| {
        let mut values = vec![0.0; cols];
        for (col, value) in values.iter_mut().enumerate() {
            let (east, north) = (west_m + col as f64 * resolution_m, north_m - row as f64 * resolution_m);
            let samples = (0..per_side * per_side)
                .map(|k| changes.albedo(ground, east + part(k % per_side), north - part(k / per_side)));
            let mean = samples.sum::<Option<f64>>().map(|sum| sum / (per_side * per_side) as f64);
            *value = mean.map_or(f64::NAN, |mean| {
                255.0 * (mean / 255.0).powf(radiometry.gamma) * radiometry.gain + radiometry.offset
            });
        }
        add_noise(&mut values, radiometry.noise_dn, radiometry.seed, NOISE_STREAM, row);
        let unknown = values.iter().filter(|value| value.is_nan()).count();
        for (cell, value) in line.iter_mut().zip(values) {
            *cell = if value.is_nan() { 0 } else { to_grey(value) };
        }
        unknown
    });
    let unknown = unknown.sum();
    (tile, unknown)
}

#[cfg(test)]
mod tests;
