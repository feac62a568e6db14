//! Land that repeats: parcels that are copies of one, or stripes that look alike all along.

use super::{SIDE, STEP_M};
use crate::scenario::Land;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Width of the track along two sides of a parcel, metres, and its grey: those of a painted track.
const TRACK_M: f64 = 3.4;
const TRACK: f64 = 182.0;
/// Greys of the two halves of a parcel or of a period of stripes: those of a dark crop and of a bright one.
const HALVES: [f64; 2] = [100.0, 148.0];
/// Spacing and contrast of the rows, and the contrast of the grain: those of row crops.
const ROWS_M: f64 = 2.0;
const ROWS: f64 = 8.0;
const GRAIN: f64 = 11.0;

/// Lays the pattern over the land's own greys.
pub(super) fn lay(land: &Land, albedo: &mut [f32], grain: &[f32]) {
    if !land.has_pattern() {
        return;
    }
    albedo.par_chunks_mut(SIDE).enumerate().for_each(|(row, line)| {
        let y = row as f64 * STEP_M;
        for (col, value) in line.iter_mut().enumerate() {
            let x = col as f64 * STEP_M;
            let own = f64::from(*value);
            let copied = if land.parcel_m > 0.0 {
                parcel([x, y].map(|at| at.rem_euclid(land.parcel_m)), land.parcel_m, grain)
            } else {
                stripe(x.rem_euclid(land.stripe_m), land.stripe_m, grain)
            };
            *value = (own + land.repeats * (copied - own)) as f32;
        }
    });
}

/// The grain of the land's first metres, for every copy.
fn grain_at(grain: &[f32], [x, y]: [f64; 2]) -> f64 {
    f64::from(grain[(y / STEP_M) as usize * SIDE + (x / STEP_M) as usize])
}

/// Grey at a place in a parcel: a track on two sides, then two crops with their rows.
fn parcel([x, y]: [f64; 2], side_m: f64, grain: &[f32]) -> f64 {
    let grain = grain_at(grain, [x, y]);
    if x < TRACK_M || y < TRACK_M {
        return TRACK + 0.8 * GRAIN * grain;
    }
    HALVES[usize::from(x > 0.5 * side_m)] + ROWS * (TAU * y / ROWS_M).sin() + GRAIN * grain
}

/// Grey so far across a period of stripes.
fn stripe(x: f64, period_m: f64, grain: &[f32]) -> f64 {
    HALVES[usize::from(x > 0.5 * period_m)] + ROWS * (TAU * x / ROWS_M).sin() + GRAIN * grain_at(grain, [x, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pattern over black land.
    fn laid(land: Land) -> Vec<f32> {
        let grain: Vec<f32> = (0..SIDE * SIDE).map(|i| (i * 7919 % 1009) as f32 / 504.0 - 1.0).collect();
        let mut albedo = vec![0.0; SIDE * SIDE];
        lay(&land, &mut albedo, &grain);
        albedo
    }

    #[test]
    fn parcels_are_copies_and_stripes_are_alike_along() {
        let none = laid(Land::default());
        assert!(none.iter().all(|grey| *grey == 0.0));
        let parcels = laid(Land { parcel_m: 40.0, ..Land::default() });
        let (period, at) = (80, |col: usize, row: usize| row * SIDE + col);
        for (col, row) in [(3, 3), (30, 71), (1234, 2201)] {
            assert_eq!(parcels[at(col, row)], parcels[at(col + period, row)]);
            assert_eq!(parcels[at(col, row)], parcels[at(col, row + 5 * period)]);
        }
        let apart = |a: usize, b: usize| (parcels[a] - parcels[b]).abs() > 10.0;
        assert!((0..period).filter(|&i| apart(at(i, 40), at(i + period / 2, 40))).count() > period / 2);
        let stripes = laid(Land { stripe_m: 30.0, ..Land::default() });
        for col in 0..200 {
            assert_eq!(stripes[at(col, 7)], stripes[at(col, 3001)]);
            assert_eq!(stripes[at(col, 7)], stripes[at(col + 60, 7)]);
        }
        let mean = |from: usize| stripes[from..from + 30].iter().sum::<f32>() / 30.0;
        assert!((mean(31) - mean(0) - 48.0).abs() < 12.0, "{} {}", mean(0), mean(31));
        let mixed = laid(Land { parcel_m: 40.0, repeats: 0.25, ..Land::default() });
        assert!(mixed.iter().zip(&parcels).all(|(part, whole)| (part - 0.25 * whole).abs() < 1e-4));
    }
}
