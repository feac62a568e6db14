//! Height above the ground's base.

use crate::noise::uniform;
use rand_chacha::ChaCha12Rng;
use std::f64::consts::TAU;

/// Fastest climb and sink, metres a second.
const CLIMB_MAX_M_S: f64 = 2.5;
/// Fastest angular speed of the swing, radians a second, where the range of heights is small.
const SWING_MAX_RAD_S: f64 = 0.2;
/// How sharp the turning points are: 1 is a triangle, whose heights are uniform. Here the distribution is within 0.02
/// of uniform and the vertical acceleration below 4 m/s².
const SHARPNESS: f64 = 0.995;

/// A rounded triangle in time: uniform heights at a bounded rate, so that even a short flight visits them all. (A
/// random function as slow as this would spend a whole flight in one half of the range.)
#[derive(Debug)]
pub struct Climb {
    middle_m: f64,
    /// Metres a radian of the rounded triangle, which swings by ±asin([`SHARPNESS`]).
    per_rad_m: f64,
    swing_rad_s: f64,
    phase_rad: f64,
}

impl Climb {
    /// Between `low_m` and `high_m`.
    pub fn new(mut rng: ChaCha12Rng, [low_m, high_m]: [f64; 2]) -> Self {
        let per_rad_m = 0.5 * (high_m - low_m) / SHARPNESS.asin();
        // A range of nothing divides to infinity, and the swing is limited.
        let swing_rad_s = (CLIMB_MAX_M_S / (per_rad_m * SHARPNESS)).min(SWING_MAX_RAD_S);
        Climb { middle_m: 0.5 * (low_m + high_m), per_rad_m, swing_rad_s, phase_rad: TAU * uniform(&mut rng) }
    }

    /// Height in metres and its derivative.
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let (sin, cos) = (self.phase_rad + self.swing_rad_s * t_s).sin_cos();
        let level = SHARPNESS * sin;
        let slope = SHARPNESS * cos * self.swing_rad_s / (1.0 - level * level).sqrt();
        (self.middle_m + self.per_rad_m * level.asin(), self.per_rad_m * slope)
    }
}
