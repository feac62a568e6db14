//! From which slope on a ray leaves the ground for good.

use super::terrain::Terrain;
use crate::dem::Dem;

impl Terrain<'_> {
    /// A rise over run from which on every ray from the ground point at (x, y) meets no terrain again, in any direction: the
    /// steepest ground in the cells around, and the steepest view of any other cell, taken at its highest post and its
    /// nearest place.
    #[must_use]
    pub fn clear_slope(&self, [x, y]: [f64; 2], ground_m: f64) -> f64 {
        let dem = self.dem();
        let [dx, dy] = dem.step_m;
        let cell = |at: f64, origin: f64, step: f64, posts: usize| {
            ((at - origin) / step).floor().clamp(0.0, (posts - 2) as f64) as usize
        };
        let (col, row) = (cell(x, dem.west_m, dx, dem.cols), cell(y, dem.south_m, dy, dem.rows));
        let around = |at: usize, posts: usize| at.saturating_sub(1)..=(at + 1).min(posts - 2);
        let (cols, rows) = (around(col, dem.cols), around(row, dem.rows));
        let near = rows.clone().flat_map(|row| cols.clone().map(move |col| (col, row)));
        let steepest = near.map(|(col, row)| gradient(dem, col, row)).fold(0.0, f64::max);
        self.steepest_view(steepest, &mut |first, last, highest, single| {
            // The cells around have been looked at as slopes; their nearest places are too near to be seen as points.
            if single && cols.contains(&first[0]) && rows.contains(&first[1]) {
                return 0.0;
            }
            let beyond = |at: f64, low: f64, high: f64| (low - at).max(at - high).max(0.0);
            let east_m = beyond(x, dem.west_m + first[0] as f64 * dx, dem.west_m + (last[0] + 1) as f64 * dx);
            let north_m = beyond(y, dem.south_m + first[1] as f64 * dy, dem.south_m + (last[1] + 1) as f64 * dy);
            // A block that holds the point may hold anything: infinity, or nothing where it is not higher.
            if highest > ground_m { (highest - ground_m) / east_m.hypot(north_m) } else { 0.0 }
        })
    }
}

/// Steepest slope of a cell: each partial derivative of the bilinear ground lies between those of two opposite sides.
fn gradient(dem: &Dem, col: usize, row: usize) -> f64 {
    let [sw, se] = [dem.at(col, row), dem.at(col + 1, row)];
    let [nw, ne] = [dem.at(col, row + 1), dem.at(col + 1, row + 1)];
    let east = (se - sw).abs().max((ne - nw).abs()) / dem.step_m[0];
    let north = (nw - sw).abs().max((ne - se).abs()) / dem.step_m[1];
    east.hypot(north)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_seen_at_its_slope_and_a_slope_at_its_own() {
        // Level at 0, a wall of 100 m from x = 500 on.
        let heights = (0..40 * 40).map(|k| if k % 40 >= 25 { 100.0 } else { 0.0 }).collect();
        let dem = Dem { cols: 40, rows: 40, west_m: 0.0, south_m: 0.0, step_m: [20.0; 2], heights };
        let terrain = Terrain::new(&dem);
        // The cell that rises begins at 480.
        assert!((terrain.clear_slope([280.0, 400.0], 0.0) - 0.5).abs() < 1e-12);
        assert_eq!(terrain.clear_slope([700.0, 400.0], 100.0), 0.0);
        // On the wall itself.
        assert_eq!(terrain.clear_slope([490.0, 400.0], 50.0), 5.0);
    }

    #[test]
    fn no_ray_that_is_called_clear_meets_the_ground() {
        let heights = (0..60 * 50).map(|k| ((k * 7919 + k / 60 * 104_729) % 97) as f64).collect();
        let dem = Dem { cols: 60, rows: 50, west_m: 3.0, south_m: -8.0, step_m: [12.0, 9.0], heights };
        let terrain = Terrain::new(&dem);
        for k in 0..200_u32 {
            let [x, y] = [3.0 + f64::from(k * 37 % 600) + 20.0, -8.0 + f64::from(k * 91 % 380) + 15.0];
            let ground = dem.height(x, y).expect("inside");
            let slope = terrain.clear_slope([x, y], ground);
            let (sin, cos) = (f64::from(k) * 0.7).sin_cos();
            for run in 1..400 {
                let run = f64::from(run);
                if let Some(height) = dem.height(x + run * cos, y + run * sin) {
                    assert!(height <= ground + slope * run + 1e-9, "{k} {run}");
                }
            }
        }
    }
}
