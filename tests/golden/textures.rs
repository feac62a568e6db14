//! Textures that are known between their pixels: sums of waves, each integrated over a pixel in closed form.

use super::seeded::Random;
use plumbline_core::rectify::Run;
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
    pub pixels: Vec<u8>,
    pub size: (u16, u16),
}

/// How a picture lies on the ground: its centre, and how it is turned (clockwise, image axes) and stretched there.
#[derive(Debug, Clone, Copy, Default)]
pub struct Placement {
    pub centre: (f64, f64),
    pub turn_rad: f64,
    pub scale: f64,
}

impl Ground {
    /// Wavelengths from `shortest_px` to 40 pixels, as many in each octave and all of one height, which is what ground looks like;
    /// about `deviation` grey levels in all.
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

    /// Mean grey level of a pixel of side `side` about (x, y); a wave over a square falls off as sinc(u) sinc(v).
    fn grey(&self, x: f64, y: f64, side: f64) -> f64 {
        let sinc = |t: f64| if t == 0.0 { 1.0 } else { (0.5 * TAU * t).sin() / (0.5 * TAU * t) };
        let wave = |&[u, v, phase, height]: &[f64; 4]| {
            height * sinc(u * side) * sinc(v * side) * (TAU * (u * x + v * y + phase)).sin()
        };
        128.0 + self.waves.iter().map(wave).sum::<f64>()
    }

    /// The exact greys of a picture of `size` at `placement`.
    pub fn exact(&self, size: (u16, u16), placement: Placement) -> Vec<f64> {
        let half = |count: u16| 0.5 * (f64::from(count) - 1.0);
        let (s, c) = placement.turn_rad.sin_cos();
        let stretch = 1.0 + placement.scale;
        let at = |i: usize| {
            let (cols, i) = (usize::from(size.0), i);
            let (x, y) = ((i % cols) as f64 - half(size.0), (i / cols) as f64 - half(size.1));
            let (x, y) = (stretch * (c * x - s * y), stretch * (s * x + c * y));
            self.grey(placement.centre.0 + x, placement.centre.1 + y, stretch)
        };
        (0..usize::from(size.0) * usize::from(size.1)).map(at).collect()
    }

    /// The same as a camera shows it: noise of `noise` grey levels, rounded.
    pub fn picture(&self, size: (u16, u16), placement: Placement, noise: f64, random: &mut Random) -> Picture {
        let seen = self.exact(size, placement).into_iter().map(|grey| grey + noise * random.normal());
        Picture { pixels: seen.map(|grey| grey.round().clamp(0.0, 255.0) as u8).collect(), size }
    }
}

/// The whole picture valid.
pub fn all_valid((cols, rows): (u16, u16)) -> Vec<Run> {
    (0..rows).map(|row| Run { row, start: 0, end: cols }).collect()
}

/// A footprint as a tilted camera leaves it: a slanting quadrilateral.
pub fn footprint((cols, rows): (u16, u16)) -> Vec<Run> {
    (0..rows).map(|row| Run { row, start: row / 5, end: cols - (rows - row) / 4 }).collect()
}
