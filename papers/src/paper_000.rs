//! Paper 000: Table 2 and figure 3 (image motion of 300 seed points), figures 4 and 5 (forward intersection against the
//! instant taken for the exposure's), by the oracle.
//!
//! [`seeds`] is the image motion, [`intersection`] the Monte Carlo, [`figures`] the pictures. What the paper does not
//! state, format and lattice above all, is named where it is assumed.

pub mod figures;
pub mod intersection;
pub mod seeds;

use super::Row;
use super::text::{lines, rows_into};
use intersection::Sweep;
use plumbline_sim::oracle::motion::{Exterior, Photo};
use serde::Serialize;

/// Pixel, mm.
const PIXEL_MM: f64 = 9e-3;
const FOCAL_MM: f64 = 120.0;
const ANGLES_DEG: f64 = 0.5;
const RATES_DEG_S: f64 = 0.3;
const EXPOSURE_MS: f64 = 5.0;
const HEIGHT_M: f64 = 2000.0;
const SPEED_KM_H: f64 = 110.0;

/// Table 1 of the paper, the shutter opening at `y_m` along the flight.
fn photo(y_m: f64) -> Photo {
    Photo {
        opening: Exterior { station_m: [0.0, y_m, HEIGHT_M], angles_rad: [ANGLES_DEG.to_radians(); 3] },
        rates_rad_s: [RATES_DEG_S.to_radians(); 3],
        speed_m_s: SPEED_KM_H / 3.6,
        focal: FOCAL_MM,
    }
}

/// Decimals of its numbers: image motion is small.
pub const DECIMALS: usize = 6;

/// Paper 000 by our own code.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seed of the ground points.
    pub seed: u64,
    /// Ground points of figures 4 and 5.
    pub points: usize,
    /// The rows, table by table.
    pub rows: Vec<Row>,
    /// Figures 4 and 5.
    pub sweep: Vec<Sweep>,
}

impl Reproduction {
    /// Everything.
    pub fn new() -> Self {
        let sweep = intersection::sweep();
        let mut rows = seeds::rows();
        rows.extend(intersection::rows());
        Reproduction { paper: "000", seed: super::SEED, points: intersection::POINTS, rows, sweep }
    }

    /// What it is reproduced by.
    pub fn head(&self) -> String {
        format!(
            "Paper {}: Table 2 by 300 seed points, figures 4 and 5 by {} ground points of seed {} and {} stamps.",
            self.paper,
            self.points,
            self.seed,
            self.sweep.len()
        )
    }

    /// The whole as text that ends with a line break.
    pub fn text(&self) -> String {
        let mut text = lines(&[self.head()]);
        rows_into(&mut text, &self.rows, DECIMALS);
        text
    }
}

impl Default for Reproduction {
    fn default() -> Self {
        Reproduction::new()
    }
}
