//! One camera over level ground, for the core and for the oracle at once, and the readings of a cell in `f64`.
#![allow(dead_code, reason = "each test target that includes this module needs other parts")]

use heapless::Vec as Runs;
use plumbline_core::camera::{Camera, Distortion};
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::rectify::{RectifyError, Run, Sampling, Source, rectify_into};
use plumbline_core::reduce::{Reducer, Reduction};
use plumbline_core::tilt::{Attitude, camera_from_local};
use plumbline_core::units::Radians;
use plumbline_sim::oracle;

/// Runs a patch may have in these tests.
pub const RUNS: usize = 2048;

/// Heading, pitch, roll and follow-up angle, degrees.
pub type Angles = [f64; 4];

/// A camera at an attitude, and the patch it is resampled to.
#[derive(Debug)]
pub struct Scene {
    pub camera: Camera,
    pub homography: Homography,
    pub judge: oracle::Camera,
    pub a: oracle::Matrix3,
    pub grid: oracle::Grid,
}

/// What the rectifier left.
#[derive(Debug)]
pub struct Patch {
    pub pixels: Vec<u8>,
    pub runs: Vec<Run>,
    /// The runs as a mask.
    pub valid: Vec<bool>,
}

impl Scene {
    /// `size` (cols, rows) and full fields of view of the frame, angles, and the patch: its size, metres a cell, height.
    pub fn new(
        (cols, rows): (u16, u16),
        (fov_h_deg, fov_v_deg): (f64, f64),
        d: oracle::Distortion,
        angles: Angles,
        (patch, resolution_m, height_m): ((u16, u16), f64, f64),
    ) -> Self {
        let [heading, pitch, roll, follow_up] = angles.map(f64::to_radians);
        let distortion =
            Distortion { k1: d.k1 as f32, k2: d.k2 as f32, k3: d.k3 as f32, p1: d.p1 as f32, p2: d.p2 as f32 };
        let fov = |deg: f64| Radians(deg.to_radians() as f32);
        let camera = Camera::new((cols, rows), (fov(fov_h_deg), fov(fov_v_deg)), (1.5, -2.25), Some(distortion))
            .expect("a camera");
        let [h, p, r, b] = [heading, pitch, roll, follow_up].map(|angle| Radians(angle as f32));
        let attitude = Attitude { heading: h, pitch: p, roll: r };
        Scene {
            homography: Homography::full(&camera_from_local(attitude, b), &camera),
            camera,
            judge: oracle::Camera {
                cols: cols.into(),
                rows: rows.into(),
                fov_h_rad: fov_h_deg.to_radians(),
                fov_v_rad: fov_v_deg.to_radians(),
                offset_m_px: 1.5,
                offset_n_px: -2.25,
                distortion: d,
            },
            a: oracle::matrix_a(heading, pitch, roll, follow_up),
            grid: oracle::Grid { cols: patch.0.into(), rows: patch.1.into(), resolution_m, height_m },
        }
    }

    /// The same scene without the principal point's offset.
    pub fn centred(mut self) -> Self {
        let fov = |rad: f64| Radians(rad as f32);
        let (cols, rows) = (self.judge.cols as u16, self.judge.rows as u16);
        let fovs = (fov(self.judge.fov_h_rad), fov(self.judge.fov_v_rad));
        self.camera = Camera::new((cols, rows), fovs, (0.0, 0.0), None).expect("a camera");
        self.judge.offset_m_px = 0.0;
        self.judge.offset_n_px = 0.0;
        self
    }

    /// Frame pixels a cell spans at nadir.
    pub fn ratio(&self) -> f32 {
        self.camera.ratio(self.grid.height_m as f32, self.grid.resolution_m as f32)
    }

    pub fn map(&self) -> FrameFromPatch<'_> {
        let ground = (self.grid.height_m as f32, self.grid.resolution_m as f32);
        FrameFromPatch::new(self.homography, &self.camera, ground, (self.grid.cols as u16, self.grid.rows as u16))
    }

    /// The frame reduced by `factor`, as the board does it.
    pub fn reduce(&self, frame: &[u8], factor: u16) -> (Vec<u8>, Reduction) {
        let size = (self.camera.cols(), self.camera.rows());
        let reduction = Reduction::choose(size, 4.0 * f32::from(factor), usize::MAX).expect("it fits");
        assert_eq!(reduction.factor(), factor);
        let mut reducer = Reducer::new(reduction, size);
        let (cols, rows) = (usize::from(reduction.size().0), usize::from(reduction.size().1));
        let (mut sums, mut reduced) = (vec![0; cols], vec![0; cols * rows]);
        for row in frame.chunks_exact(size.0.into()) {
            reducer.take(row, &mut sums, &mut reduced).expect("a row of the frame");
        }
        assert!(reducer.is_complete());
        (reduced, reduction)
    }

    /// The core's patch of an already reduced frame.
    pub fn rectify(&self, reduced: &[u8], reduction: Reduction, sampling: Sampling) -> Result<Patch, RectifyError> {
        let mut pixels = vec![0xAA; self.grid.cols * self.grid.rows];
        let mut sums = vec![0xAAAA_AAAA; self.grid.cols];
        let mut runs: Runs<Run, RUNS> = Runs::new();
        let source = Source::new(reduced, reduction)?;
        rectify_into(&self.map(), source, sampling, &mut pixels, &mut sums, &mut runs)?;
        let mut valid = vec![false; pixels.len()];
        for run in &runs {
            let first = usize::from(run.row) * self.grid.cols;
            valid[first + usize::from(run.start)..first + usize::from(run.end)].fill(true);
        }
        Ok(Patch { pixels, runs: runs.to_vec(), valid })
    }

    /// Frame (col, row) of patch (col, row) by the oracle; `None` behind the camera, and where the way back does not lead
    /// to the same point: there the lens model folds back.
    pub fn position(&self, col: f64, row: f64) -> Option<(f64, f64)> {
        let p = oracle::frame_from_patch(&self.a, &self.judge, &self.grid, col, row);
        if !p.in_front {
            return None;
        }
        if self.judge.distortion != oracle::Distortion::default() {
            let back = oracle::ground_from_frame(&self.a, &self.judge, p.m, p.n)?;
            let (k_h, k_v) = self.judge.tangent_per_px();
            let tangent = self.grid.resolution_m / self.grid.height_m;
            let off_col = back.m * k_h / tangent + 0.5 * (self.grid.cols as f64 - 1.0) - col;
            let off_row = 0.5 * (self.grid.rows as f64 - 1.0) - back.n * k_v / tangent - row;
            if !back.in_front || off_col.abs().max(off_row.abs()) > 1e-6 {
                return None;
            }
        }
        Some(oracle::pixel_from_frame(&self.judge, p.m, p.n))
    }

    /// Frame positions of the `samples` x `samples` readings of the cell (`col`, `row`).
    pub fn readings(&self, col: usize, row: usize, samples: u16) -> Vec<Option<(f64, f64)>> {
        let offset = |i: u16| (f64::from(i) + 0.5) / f64::from(samples) - 0.5;
        let pairs = (0..samples).flat_map(|i| (0..samples).map(move |j| (i, j)));
        pairs.map(|(i, j)| self.position(col as f64 + offset(j), row as f64 + offset(i))).collect()
    }

    /// How far inside the outermost reduced pixel centres the worst reading of a cell lies, frame pixels; negative
    /// outside, −∞ behind the camera.
    pub fn clearance(&self, col: usize, row: usize, samples: u16, reduction: &Reduction) -> f64 {
        clearance(&self.readings(col, row, samples), reduction)
    }

    /// Mean of the same readings in `f64`, bilinear in the reduced frame, for each third row of cells; `None` in the
    /// others and where a reading lies outside.
    pub fn same_readings(&self, reduced: &[u8], reduction: &Reduction, samples: u16) -> Vec<Option<f64>> {
        let cells = (0..self.grid.rows).flat_map(|row| (0..self.grid.cols).map(move |col| (col, row)));
        let mean = |(col, row)| {
            if row % 3 != 1 {
                return None;
            }
            let readings = self.readings(col, row, samples);
            let sum = readings.iter().flatten().map(|&p| bilinear(reduced, reduction, p)).sum::<f64>();
            (clearance(&readings, reduction) >= 0.0).then_some(sum / readings.len() as f64)
        };
        cells.map(mean).collect()
    }
}

fn clearance(readings: &[Option<(f64, f64)>], reduction: &Reduction) -> f64 {
    let factor = f64::from(reduction.factor());
    let (cols, rows) = reduction.size();
    let inside = |x: f64, count: u16| {
        let first = 0.5 * (factor - 1.0);
        (x - first).min(first + factor * (f64::from(count) - 1.0) - x)
    };
    let of = |p: &Option<(f64, f64)>| {
        let clear = p.map_or(f64::NEG_INFINITY, |(c, r)| inside(c, cols).min(inside(r, rows)));
        if clear.is_nan() { f64::NEG_INFINITY } else { clear }
    };
    readings.iter().map(of).fold(f64::INFINITY, f64::min)
}

fn bilinear(reduced: &[u8], reduction: &Reduction, (col, row): (f64, f64)) -> f64 {
    let (cols, rows) = (usize::from(reduction.size().0), usize::from(reduction.size().1));
    let factor = f64::from(reduction.factor());
    let at = |x: f64| (x - 0.5 * (factor - 1.0)) / factor;
    let (x, y) = (at(col), at(row));
    let (c, r) = ((x.floor() as usize).min(cols - 2), (y.floor() as usize).min(rows - 2));
    let (u, v) = (x - c as f64, y - r as f64);
    let p = |c: usize, r: usize| f64::from(reduced[r * cols + c]);
    let line = |r: usize| (1.0 - u) * p(c, r) + u * p(c + 1, r);
    (1.0 - v) * line(r) + v * line(r + 1)
}

/// The test image of table F.
pub fn image_f(cols: usize, rows: usize) -> Vec<u8> {
    let grey = |i: usize| {
        let (r, c) = (i / cols, i % cols);
        ((31 * r + 17 * c + 5 * ((r * c) % 7)) & 255) as u8
    };
    (0..cols * rows).map(grey).collect()
}

/// A smooth image: three waves of 40 px and more. Its steepest slope is 5.3 grey levels a pixel.
pub fn image_smooth(cols: usize, rows: usize) -> Vec<u8> {
    let waves = [(40.0, 0.3, 24.0), (61.0, 1.7, 12.0), (97.0, 2.9, 4.0)];
    let grey = |i: usize| {
        let (x, y) = ((i % cols) as f64, (i / cols) as f64);
        let wave = |(length, direction, height): (f64, f64, f64)| {
            height * (std::f64::consts::TAU / length * (x * f64::cos(direction) + y * f64::sin(direction))).sin()
        };
        (128.0 + waves.into_iter().map(wave).sum::<f64>()).round() as u8
    };
    (0..cols * rows).map(grey).collect()
}

/// Noise: neighbouring pixels have nothing to do with each other.
pub fn image_noise(cols: usize, rows: usize) -> Vec<u8> {
    let mut random = super::seeded::Random::new(3);
    (0..cols * rows).map(|_| random.byte()).collect()
}

/// A triangle wave along the columns or the rows, 30 grey levels a pixel: it turns positions into grey levels.
pub fn image_ramp(cols: usize, rows: usize, along_rows: bool) -> Vec<u8> {
    let grey = |i: usize| {
        let at = if along_rows { i / cols } else { i % cols };
        (8 + 30 * (at % 16).abs_diff(8)) as u8
    };
    (0..cols * rows).map(grey).collect()
}
