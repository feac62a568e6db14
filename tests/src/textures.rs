//! Textures that are known between their pixels: sums of waves, each integrated over a pixel in closed form.

use super::seeded::Random;
use plumbline_core::image::Run;
use std::f64::consts::TAU;

/// Ground with a grey level everywhere: 128 plus waves in all directions.
#[derive(Debug)]
pub struct Ground {
    /// Waves a pixel across and down, phase in turns, height.
    waves: Vec<[f64; 4]>,
}

/// A grey picture and its size (cols, rows).
#[derive(Debug, Clone)]
pub struct Picture {
    /// Row by row from the top.
    pub pixels: Vec<u8>,
    /// (cols, rows).
    pub size: (u16, u16),
}

/// How a picture lies on the ground: its centre, and how it is turned (clockwise, image axes) and stretched there.
#[derive(Debug, Clone, Copy, Default)]
pub struct Placement {
    /// The picture's centre on the ground.
    pub centre: (f64, f64),
    /// Clockwise.
    pub turn_rad: f64,
    /// Ground pixels a picture's pixel spans, minus 1.
    pub scale: f64,
}

impl Ground {
    /// Wavelengths from `shortest_px` to 40 pixels, as many in each octave and all of one height, which is what ground looks
    /// like; about `deviation` grey levels in all.
    pub fn new(seed: u64, deviation: f64, shortest_px: f64) -> Self {
        let mut random = Random::new(seed);
        let mut wave = || {
            let (length, direction) = (shortest_px * (40.0 / shortest_px).powf(random.uniform()), random.uniform());
            let (s, c) = (TAU * direction).sin_cos();
            [c / length, s / length, random.uniform(), 1.0]
        };
        let mut waves: Vec<[f64; 4]> = (0..80).map(|_| wave()).collect();
        let power = waves.iter().map(|w| 0.5 * w[3] * w[3]).sum::<f64>();
        for wave in &mut waves {
            wave[3] *= deviation / power.sqrt();
        }
        Ground { waves }
    }

    /// The exact greys of a picture of `size` at `placement`: means over its pixels. A wave over a square falls off as
    /// sinc(u) sinc(v); along a row of pixels its phase grows evenly, so each value follows from the one before.
    pub fn exact(&self, size: (u16, u16), placement: Placement) -> Vec<f64> {
        let half = |count: u16| 0.5 * (f64::from(count) - 1.0);
        let (s, c) = placement.turn_rad.sin_cos();
        let stretch = 1.0 + placement.scale;
        let mut greys = vec![128.0; usize::from(size.0) * usize::from(size.1)];
        for &[u, v, phase, height] in &self.waves {
            let height = height * sinc(u * stretch) * sinc(v * stretch);
            // Turns a pixel along a row and down a column.
            let (right, down) = (stretch * (u * c + v * s), stretch * (v * c - u * s));
            let (step_s, step_c) = (TAU * right).sin_cos();
            let corner =
                phase + u * placement.centre.0 + v * placement.centre.1 - right * half(size.0) - down * half(size.1);
            for (row, line) in greys.chunks_exact_mut(size.0.into()).enumerate() {
                let (mut sin, mut cos) = (TAU * (corner + down * row as f64)).sin_cos();
                for grey in line {
                    *grey += height * sin;
                    (sin, cos) = (sin * step_c + cos * step_s, cos * step_c - sin * step_s);
                }
            }
        }
        greys
    }

    /// The exact grey of a pixel, upright and of the ground's scale, around a point of the ground.
    pub fn at(&self, (x, y): (f64, f64)) -> f64 {
        let wave =
            |&[u, v, phase, height]: &[f64; 4]| height * sinc(u) * sinc(v) * (TAU * (phase + u * x + v * y)).sin();
        128.0 + self.waves.iter().map(wave).sum::<f64>()
    }

    /// The picture that a camera takes of it: noise of `noise` grey levels, rounded.
    pub fn picture(&self, size: (u16, u16), placement: Placement, noise: f64, random: &mut Random) -> Picture {
        let seen = self.exact(size, placement).into_iter().map(|grey| grey + noise * random.normal());
        Picture { pixels: seen.map(|grey| grey.round().clamp(0.0, 255.0) as u8).collect(), size }
    }
}

/// Mean of a wave of so many turns a pixel over a pixel, over its value in the middle.
fn sinc(turns: f64) -> f64 {
    if turns == 0.0 { 1.0 } else { (0.5 * TAU * turns).sin() / (0.5 * TAU * turns) }
}

/// The whole picture valid.
pub fn all_valid((cols, rows): (u16, u16)) -> Vec<Run> {
    (0..rows).map(|row| Run { row, start: 0, end: cols }).collect()
}

/// A footprint as a tilted camera leaves it: a slanting quadrilateral.
pub fn footprint((cols, rows): (u16, u16)) -> Vec<Run> {
    (0..rows).map(|row| Run { row, start: row / 5, end: cols - (rows - row) / 4 }).collect()
}
