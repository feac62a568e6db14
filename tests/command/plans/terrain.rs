//! Terrain to plan over: a file for the command, and heights for the judge.

use plumbline_survey::crs::System;
use plumbline_survey::io::data;
use plumbline_survey::io::raster::Raster;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Posts on a grid of metres, row 0 the southern one.
pub struct Terrain {
    pub file: PathBuf,
    pub cols: usize,
    pub rows: usize,
    /// Of the south-western post.
    pub origin: [f64; 2],
    pub step: [f64; 2],
    pub heights: Vec<f64>,
    /// Longitude and latitude of the metres' origin, and metres a degree, where the file is in degrees.
    pub degrees: Option<([f64; 2], [f64; 2])>,
}

impl Terrain {
    /// The portable model of the golden values, as an ASCII grid in `folder`: z = 100 + 80 sin(x / 700) cos(y / 500).
    pub fn portable(folder: &Path) -> Self {
        Self::made_up(folder, [141, 61], |x, y| 100.0 + 80.0 * (x / 700.0).sin() * (y / 500.0).cos())
    }

    /// Posts 50 m apart from (0, 0).
    pub fn made_up(folder: &Path, [cols, rows]: [usize; 2], height: impl Fn(f64, f64) -> f64) -> Self {
        let heights: Vec<f64> =
            (0..cols * rows).map(|k| height((k % cols) as f64 * 50.0, (k / cols) as f64 * 50.0)).collect();
        let mut text = format!("ncols {cols}\nnrows {rows}\nxllcenter 0\nyllcenter 0\ncellsize 50\n");
        for row in heights.chunks(cols).rev() {
            let words: Vec<String> = row.iter().map(f64::to_string).collect();
            writeln!(text, "{}", words.join(" ")).expect("a string");
        }
        let file = folder.join("terrain.asc");
        std::fs::write(&file, text).expect("written");
        Terrain { file, cols, rows, origin: [0.0; 2], step: [50.0; 2], heights, degrees: None }
    }

    /// A real model; `centre` is that of the area, in the model's x and y.
    pub fn real(name: &str, centre: [f64; 2]) -> Option<Self> {
        let file = data::for_test("plans over real terrain", &format!("dem/{name}"))?;
        let raster = Raster::read(&file).expect("readable");
        let (cols, rows) = (raster.cols, raster.rows);
        let heights =
            (0..cols * rows).map(|k| raster.sample(k % cols, rows - 1 - k / cols, 0).map_or(f64::NAN, f64::from));
        let (x, y) = raster.geo.world_from_pixel(0.0, (rows - 1) as f64);
        let step = [raster.geo.step_x, raster.geo.step_y];
        let mut terrain = Terrain { file, cols, rows, origin: [x, y], step, heights: heights.collect(), degrees: None };
        if raster.crs == Some(System::Epsg(4326)) {
            // Radii of curvature of WGS 84: a (1 - e2) / W^3 and a / W.
            let w2 = 1.0 - 0.006_694_379_990_141 * centre[1].to_radians().sin().powi(2);
            let meridian = 6_378_137.0 * (1.0 - 0.006_694_379_990_141) / w2.powf(1.5);
            let parallel = 6_378_137.0 / w2.sqrt() * centre[1].to_radians().cos();
            let per_degree = [parallel, meridian].map(f64::to_radians);
            terrain.degrees = Some((centre, per_degree));
            terrain.origin = terrain.metres([x, y]);
            terrain.step = [step[0] * per_degree[0], step[1] * per_degree[1]];
        }
        Some(terrain)
    }

    /// Metres of the plan's x and y.
    pub fn metres(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.degrees {
            Some((origin, per_degree)) => [(x - origin[0]) * per_degree[0], (y - origin[1]) * per_degree[1]],
            None => [x, y],
        }
    }

    /// Bilinear; `None` outside and where a post is unknown.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let (u, v) = ((x - self.origin[0]) / self.step[0], (y - self.origin[1]) / self.step[1]);
        if !(0.0..=(self.cols - 1) as f64).contains(&u) || !(0.0..=(self.rows - 1) as f64).contains(&v) {
            return None;
        }
        let (i, j) = ((u.floor() as usize).min(self.cols - 2), (v.floor() as usize).min(self.rows - 2));
        let (u, v) = (u - i as f64, v - j as f64);
        let post = |i: usize, j: usize| self.heights[j * self.cols + i];
        let south = post(i, j) + u * (post(i + 1, j) - post(i, j));
        let north = post(i, j + 1) + u * (post(i + 1, j + 1) - post(i, j + 1));
        let height = south + v * (north - south);
        height.is_finite().then_some(height)
    }
}
