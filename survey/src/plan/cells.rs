//! The area cut into cells, and what the photos know of each: how many see it, how well it is determined.

use super::area::Area;
use super::intersect::{Sigmas, covariance};
use super::sight::{Photos, Ray};
use super::simulate::Simulation;
use super::terrain::Terrain;
use crate::dem::Dem;
use rayon::prelude::*;

/// Cells across the shorter side of the area, at least.
const SIDE_MIN: f64 = 20.0;
/// Cells inside an area, at least, as long as the raster around it stays below so many.
const INSIDE_MIN: usize = 50;
const THIN_MAX: usize = 1 << 20;

/// A raster of square cells over the area, row 0 the southern one.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Columns, eastward.
    pub cols: usize,
    /// Rows, northward.
    pub rows: usize,
    /// Centre of the first column.
    pub west_m: f64,
    /// Centre of the first row.
    pub south_m: f64,
    /// Side of a cell.
    pub step_m: f64,
    /// Those whose centres lie inside the area, where the height is known.
    pub inside: Vec<Cell>,
}

/// A cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Eastward.
    pub col: usize,
    /// Northward.
    pub row: usize,
    /// Height of its centre.
    pub height_m: f64,
    /// Slope from which on a ray from there meets no terrain.
    clear_slope: f64,
}

/// What the photos know of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Photos that see its centre.
    pub photos: u32,
    /// Most of them in one strip.
    pub in_strip: u32,
    /// Horizontal standard deviation, both coordinates together, and that of the height; `None` where it is not determined.
    pub sd_m: Option<[f64; 2]>,
}

/// Root mean squares over the cells that are determined, and how many are not covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Horizontal and height, from the covariance.
    pub rms_m: [f64; 2],
    /// Largest ones of a cell.
    pub worst_m: [f64; 2],
    /// Cells that fewer than two photos of one strip see.
    pub gaps: usize,
}

impl Cells {
    /// Cells over `area` (x, y): as fine as the elevation model, but no more than about `most`, and not coarser than a
    /// twentieth of the area's shorter side; finer where a thin area slips between them.
    #[must_use]
    pub fn new(terrain: &Terrain<'_>, area: &Area, most: usize) -> Self {
        let dem = terrain.dem();
        let [x0, y0, x1, y1] = area.bounds();
        let (shorter_m, longer_m) = ((x1 - x0).min(y1 - y0), (x1 - x0).max(y1 - y0));
        let coarsest_m = (shorter_m * longer_m / most as f64).sqrt().max(longer_m / most as f64);
        let mut step_m = dem.step_m[0].min(dem.step_m[1]).min(shorter_m / SIDE_MIN).max(coarsest_m);
        let mut cells = Self::laid(dem, area, step_m);
        while cells.inside.len() < INSIDE_MIN && cells.cols * cells.rows < THIN_MAX {
            step_m *= 0.5;
            cells = Self::laid(dem, area, step_m);
        }
        let mut inside = std::mem::take(&mut cells.inside);
        inside.par_iter_mut().for_each(|cell| {
            cell.clear_slope = terrain.clear_slope(cells.centre(cell.col, cell.row), cell.height_m);
        });
        Cells { inside, ..cells }
    }

    fn laid(dem: &Dem, area: &Area, step_m: f64) -> Self {
        let [x0, y0, x1, y1] = area.bounds();
        let count = |from: f64, to: f64| ((to - from) / step_m).ceil().max(1.0) as usize;
        let (cols, rows) = (count(x0, x1), count(y0, y1));
        // What is left over lies half on each side.
        let first = |from: f64, to: f64, count: usize| 0.5 * (from + to - (count - 1) as f64 * step_m);
        let (west_m, south_m) = (first(x0, x1, cols), first(y0, y1, rows));
        let mut cells = Cells { cols, rows, west_m, south_m, step_m, inside: Vec::new() };
        for row in 0..rows {
            let middle_m = cells.centre(0, row)[1];
            for [from_m, to_m] in area.ranges([middle_m, middle_m]) {
                let col = |at_m: f64| ((at_m - west_m) / step_m).clamp(0.0, cols as f64);
                for col in col(from_m).ceil() as usize..(col(to_m).floor() as usize + 1).min(cols) {
                    let [x, y] = cells.centre(col, row);
                    if let Some(height_m) = dem.height(x, y) {
                        cells.inside.push(Cell { col, row, height_m, clear_slope: 0.0 });
                    }
                }
            }
        }
        cells
    }

    /// Place of a cell's centre.
    #[must_use]
    pub fn centre(&self, col: usize, row: usize) -> [f64; 2] {
        [self.west_m + col as f64 * self.step_m, self.south_m + row as f64 * self.step_m]
    }

    /// What photos know of each cell inside, in the order of [`Self::inside`].
    #[must_use]
    pub fn known(&self, photos: &Photos<'_>, sigmas: &Sigmas) -> Vec<Known> {
        let of = |rays: &mut Vec<Ray>, cell: &Cell| {
            self.rays(photos, cell, rays);
            Known::of(rays, sigmas)
        };
        self.inside.par_iter().map_init(Vec::new, of).collect()
    }

    /// Root mean square of the errors of all cells' intersections, horizontal and height, with noise drawn `rounds` times;
    /// `None` where no cell is determined.
    #[must_use]
    pub fn simulated(&self, photos: &Photos<'_>, sigmas: &Sigmas, seed: u64, rounds: u64) -> Option<[f64; 2]> {
        let simulations: Vec<Simulation> =
            (0..rounds).map(|round| Simulation::new(photos.strips(), sigmas, seed, round)).collect();
        let of = |rays: &mut Vec<Ray>, (index, cell): (usize, &Cell)| {
            self.rays(photos, cell, rays);
            let off = simulations.iter().filter_map(|simulation| simulation.intersected(rays, index as u64));
            off.fold([0.0; 3], |sum, [along, across, up]| {
                [sum[0] + 1.0, sum[1] + along * along + across * across, sum[2] + up * up]
            })
        };
        let squares: Vec<[f64; 3]> = self.inside.par_iter().enumerate().map_init(Vec::new, of).collect();
        // Summed in order, so that the same seed gives the same bits on any number of cores.
        let sum = squares.iter().fold([0.0; 3], |sum, cell| std::array::from_fn(|k| sum[k] + cell[k]));
        (sum[0] > 0.0).then(|| [(sum[1] / sum[0]).sqrt(), (sum[2] / sum[0]).sqrt()])
    }

    fn rays(&self, photos: &Photos<'_>, cell: &Cell, rays: &mut Vec<Ray>) {
        photos.rays(self.centre(cell.col, cell.row), cell.height_m, cell.clear_slope, rays);
    }
}

impl Known {
    /// By the rays of all photos that see the cell, strip by strip.
    #[must_use]
    pub fn of(rays: &[Ray], sigmas: &Sigmas) -> Self {
        Known {
            photos: rays.len() as u32,
            in_strip: rays.chunk_by(|a, b| a.strip == b.strip).map(<[Ray]>::len).max().unwrap_or(0) as u32,
            sd_m: covariance(rays, sigmas).map(|c| [(c[(0, 0)] + c[(1, 1)]).sqrt(), c[(2, 2)].sqrt()]),
        }
    }

    /// Whether fewer than two photos of one strip see the cell.
    #[must_use]
    pub fn is_gap(&self) -> bool {
        self.in_strip < 2
    }
}

impl Summary {
    /// Of all cells; `None` where not one is determined.
    #[must_use]
    pub fn new(known: &[Known]) -> Option<Self> {
        let gaps = known.iter().filter(|cell| cell.is_gap()).count();
        let determined: Vec<[f64; 2]> = known.iter().filter_map(|cell| cell.sd_m).collect();
        if determined.is_empty() {
            return None;
        }
        let rms = |axis: usize| {
            (determined.iter().map(|sd| sd[axis] * sd[axis]).sum::<f64>() / determined.len() as f64).sqrt()
        };
        let most = |axis: usize| determined.iter().map(|sd| sd[axis]).fold(0.0, f64::max);
        Some(Summary { rms_m: [rms(0), rms(1)], worst_m: [most(0), most(1)], gaps })
    }
}
