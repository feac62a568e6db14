//! One camera over level ground, for the core and for the oracle at once, and the readings of a cell in `f64`.

use heapless::Vec as Runs;
use plumbline_core::camera::{Camera, Distortion};
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::image::Run;
use plumbline_core::rectify::{Node, RectifyError, Source, rectify_into};
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

    /// The scene without the principal point's offset.
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

    /// What the board keeps of the frame: sums of boxes of `factor`, a power of two, or for 0 the frame.
    pub fn reduce(&self, frame: &[u8], factor: u16) -> (Vec<u8>, Reduction) {
        let size = (self.camera.cols(), self.camera.rows());
        let reduction = match factor {
            0 => Reduction::none(size),
            _ => Reduction::choose(size, 3.0 * f32::from(factor), usize::MAX).expect("it fits"),
        };
        assert_eq!((reduction.is_boxes(), reduction.factor()), (factor > 0, factor.max(1)));
        let mut reducer = Reducer::new(reduction, size);
        let mut kept = vec![0xAA; reduction.bytes()];
        let mut rows = frame;
        while !rows.is_empty() {
            let (next, rest) = rows.split_at(usize::from(size.0) * usize::from(reducer.rows_wanted()));
            reducer.take(next, &mut kept).expect("rows of the frame");
            rows = rest;
        }
        assert!(reducer.is_complete());
        (kept, reduction)
    }

    /// The core's patch of what was kept.
    pub fn rectify(&self, kept: &[u8], reduction: Reduction) -> Result<Patch, RectifyError> {
        let mut pixels = vec![0xAA; self.grid.cols * self.grid.rows];
        let mut nodes = vec![Node { at: [-1; 2], integrals: [0xAAAA_AAAA; 2] }; 2 * (self.grid.cols + 1)];
        let mut runs: Runs<Run, RUNS> = Runs::new();
        let source = Source::new(kept, reduction)?;
        rectify_into(&self.map(), source, &mut pixels, &mut nodes, &mut runs)?;
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

    /// Frame positions of a cell's corners, clockwise from the top left; of the cell's centre where the frame is kept.
    pub fn reach(&self, col: usize, row: usize, reduction: &Reduction) -> Vec<Option<(f64, f64)>> {
        let at = |(right, down): (f64, f64)| self.position(col as f64 + right, row as f64 + down);
        if reduction.is_boxes() {
            [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(at).to_vec()
        } else {
            vec![at((0.0, 0.0))]
        }
    }

    /// How far inside what is kept a cell lies, frame pixels: its corners within the outermost boxes' edges, or its reading
    /// within the outermost pixels' centres. Negative outside, −∞ behind the camera.
    pub fn clearance(&self, col: usize, row: usize, reduction: &Reduction) -> f64 {
        let factor = f64::from(reduction.factor());
        let edge = if reduction.is_boxes() { 0.5 } else { 0.0 };
        let inside = |x: f64, count: u16| (x + edge).min(factor * f64::from(count) - 1.0 + edge - x);
        let of = |p: &Option<(f64, f64)>| {
            let clear =
                p.map_or(f64::NEG_INFINITY, |(c, r)| inside(c, reduction.size().0).min(inside(r, reduction.size().1)));
            if clear.is_nan() { f64::NEG_INFINITY } else { clear }
        };
        self.reach(col, row, reduction).iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// The bilinear readings of a kept frame in `f64`, for each third row of cells; `None` in the others and where a
    /// reading lies outside.
    pub fn same_readings(&self, frame: &[u8], reduction: &Reduction) -> Vec<Option<f64>> {
        let cells = (0..self.grid.rows).flat_map(|row| (0..self.grid.cols).map(move |col| (col, row)));
        let reading = |(col, row)| {
            let is_inside = row % 3 == 1 && self.clearance(col, row, reduction) >= 0.0;
            let position = self.position(col as f64, row as f64).filter(|_| is_inside)?;
            Some(bilinear(frame, reduction.size(), position))
        };
        cells.map(reading).collect()
    }

    /// The exact area averages of what is kept of `frame`, by the oracle.
    pub fn exact_area(&self, frame: &[u8]) -> Vec<Option<f64>> {
        let values = frame.iter().map(|&pixel| pixel.into()).collect();
        let image = oracle::Image::new(self.judge.cols, self.judge.rows, values).expect("the sizes fit");
        oracle::exact_area(&image, &self.a, &self.judge, &self.grid)
    }
}

fn bilinear(frame: &[u8], (cols, rows): (u16, u16), (x, y): (f64, f64)) -> f64 {
    let (cols, rows) = (usize::from(cols), usize::from(rows));
    let (c, r) = ((x.floor() as usize).min(cols - 2), (y.floor() as usize).min(rows - 2));
    let (u, v) = (x - c as f64, y - r as f64);
    let p = |c: usize, r: usize| f64::from(frame[r * cols + c]);
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

/// A smooth image: three waves of 40 px and more, `stretch` times longer. Its steepest slope is 5.3 / `stretch` grey levels
/// a pixel.
pub fn image_smooth(cols: usize, rows: usize, stretch: f64) -> Vec<u8> {
    let waves = [(40.0, 0.3, 24.0), (61.0, 1.7, 12.0), (97.0, 2.9, 4.0)];
    let grey = |i: usize| {
        let (x, y) = ((i % cols) as f64 / stretch, (i / cols) as f64 / stretch);
        let wave = |(length, direction, height): (f64, f64, f64)| {
            height * (std::f64::consts::TAU / length * (x * f64::cos(direction) + y * f64::sin(direction))).sin()
        };
        (128.0 + waves.into_iter().map(wave).sum::<f64>()).round() as u8
    };
    (0..cols * rows).map(grey).collect()
}

/// Noise: neighbouring pixels have nothing to do with each other.
pub fn image_noise(cols: usize, rows: usize) -> Vec<u8> {
    let mut random = plumbline_tests::seeded::Random::new(3);
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
