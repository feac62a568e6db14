//! A raster with its place on the ground, and the two ways to read between its pixels.

/// A north-up raster of one band. Row 0 is the northern one, columns run east, pixel centres are integers.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Number of columns.
    pub cols: usize,
    /// Number of rows.
    pub rows: usize,
    /// East coordinate of the CENTRES of column 0, metres.
    pub west_m: f64,
    /// North coordinate of the CENTRES of row 0, metres.
    pub north_m: f64,
    /// Distance between pixel centres, metres, the same both ways.
    pub step_m: f64,
    /// Values, row by row; NaN where nothing is known.
    pub data: Vec<f32>,
}

/// A rectangle on the ground, borders included, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest east coordinate.
    pub west_m: f64,
    /// Largest east coordinate.
    pub east_m: f64,
    /// Smallest north coordinate.
    pub south_m: f64,
    /// Largest north coordinate.
    pub north_m: f64,
}

impl Bounds {
    /// Whether the point lies inside or on the border.
    pub fn contains(&self, east_m: f64, north_m: f64) -> bool {
        east_m >= self.west_m && east_m <= self.east_m && north_m >= self.south_m && north_m <= self.north_m
    }

    /// So far to the east and north, metres.
    pub fn moved(&self, [east_m, north_m]: [f64; 2]) -> Self {
        Bounds {
            west_m: self.west_m + east_m,
            east_m: self.east_m + east_m,
            south_m: self.south_m + north_m,
            north_m: self.north_m + north_m,
        }
    }

    /// Larger by `by_m` on all sides.
    pub fn grown(&self, by_m: f64) -> Self {
        Bounds {
            west_m: self.west_m - by_m,
            east_m: self.east_m + by_m,
            south_m: self.south_m - by_m,
            north_m: self.north_m + by_m,
        }
    }

    /// The middle, `[east, north]`.
    pub fn centre(&self) -> [f64; 2] {
        [(self.west_m + self.east_m) / 2.0, (self.south_m + self.north_m) / 2.0]
    }
}

impl Grid {
    /// The rectangle spanned by the outermost pixel CENTRES: between them values can be interpolated, beyond them not.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            west_m: self.west_m,
            east_m: self.west_m + (self.cols - 1) as f64 * self.step_m,
            south_m: self.north_m - (self.rows - 1) as f64 * self.step_m,
            north_m: self.north_m,
        }
    }

    /// Ground to pixel: fractional `(col, row)`.
    pub fn pixel(&self, east_m: f64, north_m: f64) -> (f64, f64) {
        ((east_m - self.west_m) / self.step_m, (self.north_m - north_m) / self.step_m)
    }

    pub(super) fn at(&self, col: usize, row: usize) -> f64 {
        f64::from(self.data[row * self.cols + col])
    }

    /// Whether the fractional pixel lies between the outermost centres.
    pub(super) fn covers(&self, col: f64, row: f64) -> bool {
        let last = |count: usize| f64::from(count as i32 - 1);
        col >= 0.0 && row >= 0.0 && col <= last(self.cols) && row <= last(self.rows)
    }

    /// Bilinear value at a fractional pixel. Outside the raster the nearest border value.
    pub(super) fn bilinear(&self, col: f64, row: f64) -> f64 {
        let (c, u) = cell(col, self.cols);
        let (r, v) = cell(row, self.rows);
        let north = self.at(c, r) * (1.0 - u) + self.at(c + 1, r) * u;
        let south = self.at(c, r + 1) * (1.0 - u) + self.at(c + 1, r + 1) * u;
        north * (1.0 - v) + south * v
    }

    /// Catmull-Rom value at a fractional pixel that the raster covers: passes through the pixels and has a continuous slope,
    /// so a frame that is finer than the raster shows a smooth ground and no facets. Not clamped. Border pixels repeat.
    #[inline]
    pub(super) fn catmull_rom(&self, col: f64, row: f64) -> f64 {
        let (c, u) = cell(col, self.cols);
        let (r, v) = cell(row, self.rows);
        if c >= 1 && c + 2 < self.cols && r >= 1 && r + 2 < self.rows {
            let from = (r - 1) * self.cols + c - 1;
            let lines = &self.data[from..from + 3 * self.cols + 4];
            return weighted(|k| lines[k * self.cols..].first_chunk().copied().unwrap_or_default(), [u, v]);
        }
        let line = |k: usize| {
            let line = (r + k).saturating_sub(1).min(self.rows - 1) * self.cols;
            std::array::from_fn(|k| self.data[line + (c + k).saturating_sub(1).min(self.cols - 1)])
        };
        weighted(line, [u, v])
    }

    /// Four of [`Grid::catmull_rom`] at once, of pixels that the raster covers and away from its borders: `None` where one is
    /// not.
    #[inline]
    pub(super) fn four_catmull_rom(&self, cols: [f64; 4], rows: [f64; 4]) -> Option<[f64; 4]> {
        let (last_col, last_row) = (f64::from(self.cols as i32 - 3), f64::from(self.rows as i32 - 3));
        let is_inside = |all: [f64; 4], last: f64| all.iter().all(|&at| at >= 1.0 && at < last);
        if !is_inside(cols, last_col) || !is_inside(rows, last_row) {
            return None;
        }
        let (c, r) = (cols.map(|at| at as i32), rows.map(|at| at as i32));
        let mut values = [0.0; 4];
        for i in 0..4 {
            let from = (r[i] - 1) as usize * self.cols + (c[i] - 1) as usize;
            let lines = self.data.get(from..from + 3 * self.cols + 4)?;
            let taps =
                |k: usize| lines.get(k * self.cols..).and_then(<[f32]>::first_chunk).copied().unwrap_or_default();
            values[i] = weighted(taps, [cols[i] - f64::from(c[i]), rows[i] - f64::from(r[i])]);
        }
        Some(values)
    }
}

/// The mean of 4 x 4 pixels, line by line, with the weights of a place so far into the cell in their middle.
#[inline(always)]
fn weighted(line: impl Fn(usize) -> [f32; 4], [u, v]: [f64; 2]) -> f64 {
    let (wu, wv) = (catmull_rom_weights(u), catmull_rom_weights(v));
    // Columns first, four at once.
    let mut sums = [0.0; 4];
    for (k, weight) in wv.into_iter().enumerate() {
        for (sum, tap) in sums.iter_mut().zip(line(k)) {
            *sum += f64::from(tap) * weight;
        }
    }
    sums[0] * wu[0] + sums[1] * wu[1] + sums[2] * wu[2] + sums[3] * wu[3]
}

/// The cell (index of its lower pixel) a fractional coordinate lies in and the part of the cell passed, 0 to 1. Clamps.
#[inline]
fn cell(at: f64, count: usize) -> (usize, f64) {
    // 32 bits with a sign are what a processor converts at once; no raster has more columns.
    let last = count as i32 - 1;
    let clamped = at.clamp(0.0, f64::from(last));
    let index = (clamped as i32).min(last - 1);
    (index as usize, clamped - f64::from(index))
}

/// Weights of the pixels -1, 0, 1, 2 at the fraction `t` of the middle interval (Keys 1981, a = -1/2).
fn catmull_rom_weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t + 2.0 * t2 - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// value = f(col, row) on a 12 x 9 grid.
    fn grid(f: impl Fn(f64, f64) -> f64) -> Grid {
        let (cols, rows) = (12, 9);
        let data = (0..cols * rows).map(|i| f((i % cols) as f64, (i / cols) as f64) as f32).collect();
        Grid { cols, rows, west_m: 100.0, north_m: 50.0, step_m: 0.5, data }
    }

    #[test]
    fn both_ways_reproduce_a_plane_exactly() {
        let plane = |c: f64, r: f64| 3.0 + 2.0 * c - 0.5 * r;
        let g = grid(plane);
        for (c, r) in [(3.25, 4.75), (1.0, 1.0), (9.9, 6.9)] {
            assert!((g.bilinear(c, r) - plane(c, r)).abs() < 1e-12);
            assert!((g.catmull_rom(c, r) - plane(c, r)).abs() < 1e-12);
        }
        assert_eq!(g.bilinear(-3.0, 20.0), plane(0.0, 8.0));
    }

    #[test]
    fn catmull_rom_reproduces_a_parabola_and_meets_every_pixel() {
        // Its order is 3: a quadratic is exact away from the border, which bilinear misses by 1/4 in the middle.
        let g = grid(|c, _| 2.0 * c * c);
        assert!((g.catmull_rom(4.5, 3.0) - 40.5).abs() < 1e-12);
        assert!((g.bilinear(4.5, 3.0) - 41.0).abs() < 1e-12);
        for c in 0..12 {
            assert_eq!(g.catmull_rom(f64::from(c), 8.0), 2.0 * f64::from(c * c));
        }
    }

    #[test]
    fn four_at_once_are_what_each_is_alone() {
        let g = grid(|c, r| (7.0 * c * c + 3.0 * r) % 11.0);
        for i in 0..40 {
            let at = |k: i32, step: f64| 1.0 + (f64::from(i * 4 + k) * step) % 4.9;
            let (cols, rows) = ([0, 1, 2, 3].map(|k| at(k, 0.37)), [0, 1, 2, 3].map(|k| at(k, 0.53)));
            let four = g.four_catmull_rom(cols, rows).unwrap();
            for (k, value) in four.into_iter().enumerate() {
                assert_eq!(value, g.catmull_rom(cols[k], rows[k]));
            }
        }
        assert_eq!(g.four_catmull_rom([0.5, 2.0, 2.0, 2.0], [2.0; 4]), None);
        assert_eq!(g.four_catmull_rom([2.0; 4], [2.0, 2.0, 2.0, f64::NAN]), None);
    }

    #[test]
    fn pixel_centres_are_integers_and_row_0_is_north() {
        let g = grid(|_, _| 0.0);
        assert_eq!(g.pixel(100.0, 50.0), (0.0, 0.0));
        assert_eq!(g.pixel(101.0, 49.0), (2.0, 2.0));
        let b = g.bounds();
        assert_eq!((b.west_m, b.east_m, b.south_m, b.north_m), (100.0, 105.5, 46.0, 50.0));
    }
}
