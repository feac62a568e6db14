//! Where things are: the river, the main road, the villages, the parcels, and how straight lines are bent.

use super::fractal::fractal;
use super::parcels::{Parcel, Parcels, Spot, Village};
use super::streams;
use crate::noise::pixels::{stream, uniform};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// A winding line: one coordinate as a sum of waves of the other.
#[derive(Debug)]
pub(super) struct Winding {
    base: f64,
    /// Amplitude, wavelength (metres) and phase.
    waves: [[f64; 3]; 3],
}

impl Winding {
    /// Across coordinate and slope at `s`.
    pub(super) fn at(&self, s: f64) -> (f64, f64) {
        self.waves.iter().fold((self.base, 0.0), |(value, slope), [amplitude, wavelength, phase]| {
            let (sin, cos) = (s * TAU / wavelength + phase).sin_cos();
            (value + amplitude * sin, slope + amplitude * TAU / wavelength * cos)
        })
    }

    /// Its place at one coordinate along, for many points across.
    fn crossing(&self, s: f64, half_m: f64) -> Crossing {
        let (middle, slope) = self.at(s);
        Crossing { middle, obliquity: 1.0 / (1.0 + slope * slope).sqrt(), half_m }
    }
}

/// Where a winding line crosses one row or column of the land.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    middle: f64,
    obliquity: f64,
    half_m: f64,
}

impl Crossing {
    /// Signed distance from the middle, metres, to first order in the bend.
    pub(super) fn offset(&self, across: f64) -> f64 {
        (across - self.middle) * self.obliquity
    }

    /// Distance outside the border, metres; negative inside.
    pub(super) fn beyond(&self, across: f64) -> f64 {
        self.offset(across).abs() - self.half_m
    }
}

/// Smooth random values on a coarse raster over the land.
#[derive(Debug)]
struct Coarse {
    values: Vec<f32>,
    cells: usize,
    cell_m: f64,
}

impl Coarse {
    /// A long swell of about +-1: three waves of 500 to 1500 m in random directions.
    fn swell(rng: &mut ChaCha8Rng) -> Self {
        let (cells, cell_m) = (128, 20.0);
        let waves: [[f64; 3]; 3] = std::array::from_fn(|i| {
            let (sin, cos) = uniform(rng, 0.0, TAU).sin_cos();
            let number = TAU / (1500.0 / (1 + i) as f64 * uniform(rng, 0.9, 1.1));
            [number * cos, number * sin, uniform(rng, 0.0, TAU)]
        });
        let at = |i: usize| (i as f64 - cells as f64 / 2.0) * cell_m;
        let value = |k: usize| -> f64 {
            let [x, y] = [at(k % cells), at(k / cells)];
            waves.iter().enumerate().map(|(i, w)| (w[0] * x + w[1] * y + w[2]).sin() / (1 + i) as f64).sum()
        };
        Coarse { values: (0..cells * cells).map(|k| value(k) as f32).collect(), cells, cell_m }
    }

    /// Cell and part of it passed at a coordinate; the border value holds beyond the raster.
    fn place(&self, at: f64) -> (usize, f64) {
        let cell = (at / self.cell_m + self.cells as f64 / 2.0).clamp(0.0, self.cells as f64 - 1.001);
        (cell as usize, cell - (cell as usize) as f64)
    }

    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let ((col, u), (row, v)) = (self.place(x), self.place(y));
        let across = |row: usize| {
            let pair = &self.values[row * self.cells + col..][..2];
            f64::from(pair[0]) * (1.0 - u) + f64::from(pair[1]) * u
        };
        across(row) * (1.0 - v) + across(row + 1) * v
    }

    /// As above along a row of the land, at less cost.
    fn along_row(&self, y: f64) -> impl Fn(f64) -> f64 + '_ {
        let (row, v) = self.place(y);
        let lines = self.values[row * self.cells..][..2 * self.cells].split_at(self.cells);
        let mixed: Vec<f64> =
            lines.0.iter().zip(lines.1).map(|(&a, &b)| f64::from(a) * (1.0 - v) + f64::from(b) * v).collect();
        move |x| {
            let (col, u) = self.place(x);
            mixed[col] * (1.0 - u) + mixed[col + 1] * u
        }
    }
}

#[derive(Debug)]
pub(super) struct Layout {
    river: Winding,
    road: Winding,
    pub(super) villages: Vec<Village>,
    parcels: Parcels,
    bend: [Coarse; 2],
    soil: Coarse,
}

/// Half the width of the main road's asphalt.
const ROAD_HALF_M: f64 = 3.6;
/// How far the swell moves borders and lanes.
const BEND_M: f64 = 22.0;

impl Layout {
    pub(super) fn new(seed: u64) -> Self {
        let mut rng = stream(seed, streams::LAYOUT);
        let mut phase = || uniform(&mut rng, 0.0, TAU);
        let river =
            Winding { base: -140.0, waves: [[170.0, 1500.0, phase()], [55.0, 520.0, phase()], [13.0, 190.0, phase()]] };
        let road =
            Winding { base: 60.0, waves: [[120.0, 2300.0, phase()], [45.0, 900.0, phase()], [10.0, 420.0, phase()]] };
        // Villages sit on the main road, away from the river, the last a hamlet off the road.
        let mut villages = Vec::new();
        for [along, radius] in [[-620.0, 130.0], [480.0, 210.0]] {
            let mut x = along + uniform(&mut rng, -80.0, 80.0);
            let y = road.at(x).0 + uniform(&mut rng, -30.0, 30.0);
            let gap = river.crossing(y, 0.0).offset(x);
            let clearance = radius + 60.0;
            if gap.abs() < clearance {
                x += (clearance - gap.abs()).copysign(along);
            }
            villages.push(([x, road.at(x).0], radius));
        }
        villages.push(([uniform(&mut rng, 200.0, 700.0), uniform(&mut rng, -720.0, -560.0)], 85.0));
        villages.push(([uniform(&mut rng, -720.0, -500.0), uniform(&mut rng, 560.0, 720.0)], 75.0));
        let parcels = Parcels::new(&villages, &mut rng);
        let bend = [(); 2].map(|()| Coarse::swell(&mut rng));
        let soil = Coarse { values: fractal(seed, streams::SOIL, 512, 6), cells: 512, cell_m: 4.0 };
        Layout { river, road, villages, parcels, bend, soil }
    }

    /// The river where it crosses the row at `y`; across is x.
    pub(super) fn river_at(&self, y: f64) -> Crossing {
        self.river.crossing(y, 13.0 + 4.0 * (y / 83.0).sin() + 2.0 * (y / 31.0).sin())
    }

    /// The asphalt of the main road where it crosses the column at `x`; across is y.
    pub(super) fn road_at(&self, x: f64) -> Crossing {
        self.road.crossing(x, ROAD_HALF_M)
    }

    /// Point and direction of the main road at `x`.
    pub(super) fn road_through(&self, x: f64) -> ([f64; 2], [f64; 2]) {
        let (y, slope) = self.road.at(x);
        let length = 1f64.hypot(slope);
        ([x, y], [1.0 / length, slope / length])
    }

    /// Distance from the water's edge and from the asphalt's, metres; negative on them.
    pub(super) fn beyond_river_and_road(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.river_at(y).beyond(x), self.road_at(x).beyond(y)]
    }

    /// Tone of the soil about its mean, standard deviation about 1.
    pub(super) fn soil(&self, at: [f64; 2]) -> f64 {
        self.soil.at(at)
    }

    /// From the land to the straight world the parcels were cut in.
    pub(super) fn straightened(&self, at: [f64; 2]) -> [f64; 2] {
        [at[0] + BEND_M * self.bend[0].at(at), at[1] + BEND_M * self.bend[1].at(at)]
    }

    /// Along the row at `y`: the straightened point and the tone of the soil at each x.
    pub(super) fn along_row(&self, y: f64) -> impl Fn(f64) -> ([f64; 2], f64) + '_ {
        let [bend_x, bend_y] = self.bend.each_ref().map(|bend| bend.along_row(y));
        let soil = self.soil.along_row(y);
        move |x| ([x + BEND_M * bend_x(x), y + BEND_M * bend_y(x)], soil(x))
    }

    /// The inverse of `straightened`, by iteration: the bends are gentle.
    pub(super) fn bent(&self, straight: [f64; 2]) -> [f64; 2] {
        let mut at = straight;
        for _ in 0..6 {
            let image = self.straightened(at);
            at = [at[0] + straight[0] - image[0], at[1] + straight[1] - image[1]];
        }
        at
    }

    /// Parcel and nearest border of a point on the land.
    pub(super) fn spot(&self, at: [f64; 2]) -> Spot<'_> {
        self.parcels.locate(self.straightened(at))
    }

    /// The parcels, in straightened coordinates.
    pub(super) fn parcels(&self) -> &Parcels {
        &self.parcels
    }

    /// Each parcel, to look otherwise.
    pub(super) fn parcels_mut(&mut self) -> &mut [Parcel] {
        self.parcels.all_mut()
    }
}
