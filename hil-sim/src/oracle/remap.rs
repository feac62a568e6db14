//! The patch that a frame must give: the map of eq. 3 with three sampling kernels, cell by cell.

use super::projection::{Camera, Projection, frame_from_ground, pixel_from_frame};
use super::rotation::Matrix3;

/// Samples a cell and axis of [`Kernel::Area4x4`].
const AREA_SAMPLES: usize = 4;

/// A grey image, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    cols: usize,
    rows: usize,
    values: Vec<f64>,
}

/// The cells of a patch on level ground, centred on the nadir: row 0 north, columns east.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Columns of the patch.
    pub cols: usize,
    /// Rows of the patch.
    pub rows: usize,
    /// Side of a cell on the ground, in metres.
    pub resolution_m: f64,
    /// Vertical height of the camera above the ground, in metres.
    pub height_m: f64,
}

/// How a cell takes its value from the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kernel {
    /// The pixel at floor(x + 0.5) under the cell's centre.
    Nearest,
    /// Between the four pixels around the cell's centre.
    Bilinear,
    /// Mean of 4 x 4 bilinear samples at (i + 0.5) / 4 - 0.5 of the cell.
    Area4x4,
}

impl Image {
    /// An image of `cols * rows` values. `None` when their number does not fit.
    pub fn new(cols: usize, rows: usize, values: Vec<f64>) -> Option<Self> {
        (cols.checked_mul(rows) == Some(values.len())).then_some(Self { cols, rows, values })
    }

    /// Columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The value of a pixel, `None` outside.
    pub fn get(&self, col: usize, row: usize) -> Option<f64> {
        if col >= self.cols { None } else { self.values.get(row * self.cols + col).copied() }
    }

    /// The sample at a position between pixel centres, `None` outside the outermost centres [0, cols - 1] and
    /// [0, rows - 1]; the same limits hold for the nearest pixel, as a patch without a mask must not depend on them.
    fn sample(&self, col: f64, row: f64, nearest: bool) -> Option<f64> {
        let inside = |x: f64, count: usize| x >= 0.0 && x <= count as f64 - 1.0;
        if !inside(col, self.cols) || !inside(row, self.rows) {
            return None;
        }
        if nearest {
            return self.get((col + 0.5).floor() as usize, (row + 0.5).floor() as usize);
        }
        let (c0, r0) = (col.floor() as usize, row.floor() as usize);
        let (c1, r1) = ((c0 + 1).min(self.cols - 1), (r0 + 1).min(self.rows - 1));
        let (u, v) = (col - c0 as f64, row - r0 as f64);
        let top = (1.0 - u) * self.get(c0, r0)? + u * self.get(c1, r0)?;
        let bottom = (1.0 - u) * self.get(c0, r1)? + u * self.get(c1, r1)?;
        Some((1.0 - v) * top + v * bottom)
    }
}

/// Where a point of the patch lies in the frame. `col` and `row` may be fractions: +-0.5 gives a cell's borders.
pub fn frame_from_patch(a: &Matrix3, camera: &Camera, grid: &Grid, col: f64, row: f64) -> Projection {
    let tangent_per_cell = grid.resolution_m / grid.height_m;
    let east = (col - (grid.cols as f64 - 1.0) / 2.0) * tangent_per_cell;
    let north = ((grid.rows as f64 - 1.0) / 2.0 - row) * tangent_per_cell;
    let (k_h, k_v) = camera.tangent_per_px();
    frame_from_ground(a, camera, east / k_h, north / k_v)
}

/// The patch, row by row; `None` where a sample falls outside the frame or behind the camera.
pub fn remap(image: &Image, a: &Matrix3, camera: &Camera, grid: &Grid, kernel: Kernel) -> Vec<Option<f64>> {
    let sample = |col: f64, row: f64| {
        let p = frame_from_patch(a, camera, grid, col, row);
        let (frame_col, frame_row) = pixel_from_frame(camera, p.m, p.n);
        if p.in_front { image.sample(frame_col, frame_row, kernel == Kernel::Nearest) } else { None }
    };
    let mut patch = Vec::new();
    for row in 0..grid.rows {
        for col in 0..grid.cols {
            let (col, row) = (col as f64, row as f64);
            patch.push(match kernel {
                Kernel::Nearest | Kernel::Bilinear => sample(col, row),
                Kernel::Area4x4 => mean_of_samples(|du, dv| sample(col + du, row + dv)),
            });
        }
    }
    patch
}

fn mean_of_samples(sample: impl Fn(f64, f64) -> Option<f64>) -> Option<f64> {
    let offset = |i: usize| (i as f64 + 0.5) / AREA_SAMPLES as f64 - 0.5;
    let mut sum = 0.0;
    for i in 0..AREA_SAMPLES {
        for j in 0..AREA_SAMPLES {
            sum += sample(offset(j), offset(i))?;
        }
    }
    Some(sum / (AREA_SAMPLES * AREA_SAMPLES) as f64)
}
