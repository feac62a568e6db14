//! Rolling shutter in the core: positions against the oracle's exact pose of each row, and a rendered frame rectified
//! with bands against the same with a global shutter.

use heapless::Vec as Runs;
use plumbline_core::camera::Camera;
use plumbline_core::homography::rolling::{Band, Bands, BandsError, Displacement, offset_us};
use plumbline_core::homography::{FrameFromPatch, Homography};
use plumbline_core::image::Run;
use plumbline_core::rectify::{Node, Source, rectify_into};
use plumbline_core::reduce::{Reducer, Reduction};
use plumbline_core::tilt::{Attitude, camera_from_local};
use plumbline_core::units::Radians;
use plumbline_sim::camera::render::{RenderCamera, Renderer, Station};
use plumbline_sim::oracle;
use plumbline_sim::world::{Grid, Ground};
use plumbline_tests::seeded::Random;
use std::f64::consts::TAU;

const SIDE: usize = 512;
const FOV_DEG: f64 = 60.0;
const READOUT_US: u32 = 20_000;
const COUNT: usize = 9;

/// True motion about mid-exposure of the middle row: each angle swings through 20 deg/s.
#[derive(Clone, Copy, Debug)]
struct Truth {
    /// Heading, pitch, roll, follow-up angle at time 0.
    angles: [f64; 4],
    /// Their rates there, radians a second.
    rates: [f64; 4],
    /// Angular frequency of the swing: the acceleration is at most rate x frequency.
    swing: f64,
    /// East, north, up.
    velocity: [f64; 3],
    height_m: f64,
}

impl Truth {
    /// 20 deg/s in pitch and roll and 40 m/s, at some heading; 1 Hz swings.
    fn random(random: &mut Random) -> Self {
        let rate = |random: &mut Random| if random.uniform() < 0.5 { 20f64 } else { -20.0 }.to_radians();
        let course = random.between(0.0, TAU);
        let tilt = |random: &mut Random| random.between(-10.0, 10.0).to_radians();
        let heading = random.between(0.0, TAU);
        Truth {
            angles: [heading, tilt(random), tilt(random), heading + random.between(-0.1, 0.1)],
            rates: [rate(random) / 2.0, rate(random), rate(random), rate(random) / 2.0],
            swing: TAU,
            velocity: [40.0 * course.sin(), 40.0 * course.cos(), random.between(-3.0, 3.0)],
            height_m: random.between(100.0, 150.0),
        }
    }

    fn angles(&self, t_s: f64) -> [f64; 4] {
        // Off the steepest part of the swing, so that there is an acceleration.
        let lag = 0.5;
        let swing = ((self.swing * t_s + lag).sin() - lag.sin()) / (self.swing * lag.cos());
        std::array::from_fn(|i| self.angles[i] + self.rates[i] * swing)
    }

    fn moved(&self, t_s: f64) -> [f64; 3] {
        self.velocity.map(|speed| speed * t_s)
    }

    fn station(&self, t_s: f64) -> Station {
        let [heading_rad, pitch_rad, roll_rad, follow_up_rad] = self.angles(t_s);
        let [east_m, north_m, up_m] = self.moved(t_s);
        let boresight_rad = [0.0; 3];
        let up_m = self.height_m + up_m;
        Station { east_m, north_m, up_m, heading_rad, pitch_rad, roll_rad, follow_up_rad, boresight_rad }
    }

    fn homography(&self, t_s: f64, camera: &Camera) -> Homography {
        let [heading, pitch, roll, follow_up] = self.angles(t_s).map(|angle| Radians(angle as f32));
        Homography::full(&camera_from_local(Attitude { heading, pitch, roll }, follow_up), camera)
    }

    fn bands(&self, camera: &Camera) -> Vec<Band> {
        let band = |index| {
            let t_s = 1e-6 * f64::from(offset_us(index, COUNT, READOUT_US));
            let [east_m, north_m, up_m] = self.moved(t_s).map(|m| m as f32);
            Band { homography: self.homography(t_s, camera), displacement: Displacement { east_m, north_m, up_m } }
        };
        (0..COUNT).map(band).collect()
    }

    /// Frame position of undistorted pixel (m, n) of mid-exposure, with the pose of its own row: fifty steps, exact to
    /// rounding.
    fn position(&self, judge: &oracle::Camera, m: f64, n: f64) -> (f64, f64) {
        let (k_h, k_v) = judge.tangent_per_px();
        let mut t_s = 0.0;
        let mut at = (0.0, 0.0);
        for _ in 0..50 {
            let [heading, pitch, roll, follow_up] = self.angles(t_s);
            let [east, north, up] = self.moved(t_s);
            let there = |px: f64, k: f64, moved: f64| (px * k * self.height_m - moved) / (self.height_m + up) / k;
            let a = oracle::matrix_a(heading, pitch, roll, follow_up);
            let frame = oracle::frame_from_ground(&a, judge, there(m, k_h, east), there(n, k_v, north));
            at = oracle::pixel_from_frame(judge, frame.m, frame.n);
            t_s = 1e-6 * f64::from(READOUT_US) * (at.1 / (judge.rows as f64 - 1.0) - 0.5);
        }
        at
    }
}

fn cameras(distortion: oracle::Distortion) -> (Camera, oracle::Camera) {
    let fov_rad = FOV_DEG.to_radians();
    let fov = Radians(fov_rad as f32);
    let d = distortion;
    let core = plumbline_core::camera::Distortion {
        k1: d.k1 as f32,
        k2: d.k2 as f32,
        k3: d.k3 as f32,
        p1: d.p1 as f32,
        p2: d.p2 as f32,
    };
    let judge = oracle::Camera {
        cols: SIDE,
        rows: SIDE,
        fov_h_rad: fov_rad,
        fov_v_rad: fov_rad,
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion,
    };
    (Camera::new((SIDE as u16, SIDE as u16), (fov, fov), (0.0, 0.0), Some(core)).expect("a camera"), judge)
}

/// Blending: 1.5e-6 rad at 20 deg/s and 126 deg/s², below 1e-3 px; the fixed point 2e-5 px; single precision 1e-3 px.
const POSITION_PX: f64 = 2.5e-3;

#[test]
fn positions_are_those_of_each_row_s_own_pose() {
    let mut random = Random::new(31);
    let barrel = oracle::Distortion { k1: -0.075, p1: 0.001, p2: -0.0005, ..oracle::Distortion::default() };
    let (mut worst, mut global, mut mutant) = (0.0f64, 0.0f64, f64::INFINITY);
    for case in 0..40 {
        let (camera, judge) = cameras(if case % 2 == 0 { oracle::Distortion::default() } else { barrel });
        let truth = Truth::random(&mut random);
        let height_m = truth.height_m as f32;
        let size = (101u16, 101u16);
        let scale = (height_m, height_m * camera.tangent_per_px().0 * 4.0);
        let bands = Bands::new(&truth.bands(&camera), &camera, height_m).expect("slow enough");
        let map = FrameFromPatch::rolling(&bands, &camera, scale, size);
        let still = FrameFromPatch::new(truth.homography(0.0, &camera), &camera, scale, size);
        let mut wrong = truth.bands(&camera);
        for band in &mut wrong {
            let Displacement { east_m, north_m, up_m } = band.displacement;
            band.displacement = Displacement { east_m: -east_m, north_m: -north_m, up_m: -up_m };
        }
        let wrong = Bands::new(&wrong, &camera, height_m).expect("slow enough");
        let wrong = FrameFromPatch::rolling(&wrong, &camera, scale, size);
        let mut of_wrong = 0.0f64;
        for step in 0..200 {
            let (col, row) = ((step * 37 % 101) as f32, (step * 61 % 101) as f32);
            let (m, n) = (4.0 * (f64::from(col) - 50.0), 4.0 * (50.0 - f64::from(row)));
            let exact = truth.position(&judge, m, n);
            let is_inside = [exact.0, exact.1].iter().all(|at| (-0.5..=511.5).contains(at));
            if !is_inside {
                continue;
            }
            let off = |at: Option<(f32, f32)>| {
                let at = at.expect("in front of the camera");
                (f64::from(at.0) - exact.0).hypot(f64::from(at.1) - exact.1)
            };
            worst = worst.max(off(map.frame_position(col, row)));
            global = global.max(off(still.frame_position(col, row)));
            of_wrong = of_wrong.max(off(wrong.frame_position(col, row)));
        }
        mutant = mutant.min(of_wrong);
    }
    println!("rolling: {worst:.5} px off at most; one pose for all rows {global:.2} px");
    assert!(worst < POSITION_PX, "{worst} px");
    assert!(global > 1.0 && mutant > 0.5, "{global} {mutant}");
}

/// Equal poses without displacement are a global shutter, to the rounding of the blend.
#[test]
fn bands_that_agree_are_a_global_shutter() {
    let (camera, _) = cameras(oracle::Distortion::default());
    let truth = Truth::random(&mut Random::new(32));
    let homography = truth.homography(0.0, &camera);
    let still = Band { homography, displacement: Displacement::default() };
    let bands = Bands::new(&[still; COUNT], &camera, 120.0).expect("still");
    let rolling = FrameFromPatch::rolling(&bands, &camera, (120.0, 3.0), (41, 41));
    let global = FrameFromPatch::new(homography, &camera, (120.0, 3.0), (41, 41));
    assert!(rolling.is_nonlinear() && !global.is_nonlinear());
    for step in 0..41u8 {
        let at = f32::from(step);
        assert_eq!(rolling.frame_position(at, 40.0 - at), global.frame_position(at, 40.0 - at));
    }
}

#[test]
fn instants_are_spread_evenly_about_the_middle_row() {
    let all = |count, readout| (0..count).map(|index| offset_us(index, count, readout)).collect::<Vec<_>>();
    assert_eq!(all(9, 20_000), [-10_000, -7500, -5000, -2500, 0, 2500, 5000, 7500, 10_000]);
    assert_eq!(all(2, 3), [-1, 2]);
    assert_eq!((offset_us(0, 0, 5), offset_us(0, 1, 5), offset_us(7, 2, 10)), (0, 0, 5));
    assert_eq!(offset_us(usize::MAX, usize::MAX, u32::MAX), i32::MAX);
}

#[test]
fn readouts_that_cannot_be_are_refused() {
    let (camera, _) = cameras(oracle::Distortion::default());
    let truth = Truth { height_m: 120.0, ..Truth::random(&mut Random::new(33)) };
    let good = truth.bands(&camera);
    let of = |bands: &[Band], height_m: f32| Bands::new(bands, &camera, height_m).map(|_| ());
    assert_eq!(of(&good, 120.0), Ok(()));
    assert_eq!(of(&good[..1], 120.0), Err(BandsError::Count));
    assert_eq!(of(&[], 120.0), Err(BandsError::Count));
    assert_eq!(of(&[good[0]; 10], 120.0), Err(BandsError::Count));
    for height_m in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(of(&good, height_m), Err(BandsError::Height), "{height_m}");
    }
    for (displacement, error) in [
        (Displacement { east_m: f32::NAN, ..Displacement::default() }, BandsError::NotFinite),
        (Displacement { north_m: f32::INFINITY, ..Displacement::default() }, BandsError::NotFinite),
        (Displacement { up_m: f32::NAN, ..Displacement::default() }, BandsError::Height),
        (Displacement { up_m: -120.0, ..Displacement::default() }, BandsError::Height),
    ] {
        let mut bad = good.clone();
        bad[3].displacement = displacement;
        assert_eq!(of(&bad, 120.0), Err(error), "{displacement:?}");
    }
    // 300 deg/s of pitch: 2,300 px/s and more along the columns, above the 1,600 px/s of the limit.
    let fast = Truth { angles: [0.0; 4], rates: [0.0, 300f64.to_radians(), 0.0, 0.0], ..truth };
    assert_eq!(of(&fast.bands(&camera), 120.0), Err(BandsError::TooFast));
    let mut unknown = good.clone();
    let nan = Attitude { heading: Radians(f32::NAN), pitch: Radians(0.0), roll: Radians(0.0) };
    unknown[4].homography = Homography::full(&camera_from_local(nan, Radians(0.0)), &camera);
    assert_eq!(of(&unknown, 120.0), Err(BandsError::NotFinite));
    // The whole frame looks at the sky.
    let up = Attitude { heading: Radians(0.0), pitch: Radians(2.8), roll: Radians(0.0) };
    let sky = Homography::full(&camera_from_local(up, Radians(0.0)), &camera);
    let sky = Band { homography: sky, displacement: Displacement::default() };
    assert_eq!(of(&[sky; 3], 120.0), Err(BandsError::TooFast));
}

/// Waves of 9 to 60 m, so that a patch pixel of 5 m as well as one of 0.5 m has texture.
fn land() -> Ground {
    let (side, step_m) = (900usize, 0.75);
    let mut random = Random::new(34);
    let waves: Vec<[f64; 4]> = (0..24)
        .map(|i| {
            let length = 9.0 * (60f64 / 9.0).powf(f64::from(i) / 23.0);
            let (sin, cos) = random.between(0.0, TAU).sin_cos();
            [TAU / length * sin, TAU / length * cos, random.between(0.0, TAU), 2.2 * length.sqrt()]
        })
        .collect();
    let half = 0.5 * (side - 1) as f64 * step_m;
    let grey = |i: usize| {
        let (east, north) = ((i % side) as f64 * step_m - half, half - (i / side) as f64 * step_m);
        let sum: f64 = waves.iter().map(|[a, b, c, size]| size * (a * east + b * north + c).sin()).sum();
        (128.0 + sum).clamp(0.0, 255.0) as f32
    };
    let albedo = Grid {
        cols: side,
        rows: side,
        west_m: -half,
        north_m: half,
        step_m,
        data: (0..side * side).map(grey).collect(),
    };
    Ground::new(albedo, None, 32633).expect("a ground")
}

/// A patch and which of its pixels are valid.
struct Patch {
    pixels: Vec<u8>,
    valid: Vec<bool>,
}

fn rectified(map: &FrameFromPatch<'_>, frame: &[u8], ratio: f32) -> Patch {
    let size = (SIDE as u16, SIDE as u16);
    let reduction = Reduction::choose(size, ratio, usize::MAX).expect("it fits");
    let mut reducer = Reducer::new(reduction, size);
    let mut kept = vec![0; reduction.bytes()];
    let mut rows = frame;
    while !rows.is_empty() {
        let (next, rest) = rows.split_at(SIDE * usize::from(reducer.rows_wanted()));
        reducer.take(next, &mut kept).expect("rows of the frame");
        rows = rest;
    }
    let cols = usize::from(map.size().0);
    let mut pixels = vec![0; cols * usize::from(map.size().1)];
    let mut nodes = vec![Node::NOWHERE; 2 * (cols + 1)];
    let mut runs: Runs<Run, 2048> = Runs::new();
    let source = Source::new(&kept, reduction).expect("what was kept");
    rectify_into(map, source, &mut pixels, &mut nodes, &mut runs).expect("it fits");
    let mut valid = vec![false; pixels.len()];
    for run in &runs {
        let first = usize::from(run.row) * cols;
        valid[first + usize::from(run.start)..first + usize::from(run.end)].fill(true);
    }
    Patch { pixels, valid }
}

/// What sets `other` apart from `patch`: the shift in pixels (columns, rows) by least squares over the slopes of
/// `patch`, and the RMS in grey levels.
fn apart(patch: &Patch, other: &Patch, cols: usize) -> ([f64; 2], f64) {
    let (mut normal, mut right, mut squares, mut count) = ([0.0; 3], [0.0; 2], 0.0, 0.0);
    let grey = |i: usize| f64::from(patch.pixels[i]);
    for i in cols + 1..patch.pixels.len() - cols - 1 {
        let needed = [i - cols, i - 1, i, i + 1, i + cols];
        if !needed.iter().all(|&i| patch.valid[i]) || !other.valid[i] {
            continue;
        }
        let (x, y) = (0.5 * (grey(i + 1) - grey(i - 1)), 0.5 * (grey(i + cols) - grey(i - cols)));
        let d = f64::from(other.pixels[i]) - grey(i);
        normal = [normal[0] + x * x, normal[1] + x * y, normal[2] + y * y];
        right = [right[0] - x * d, right[1] - y * d];
        (squares, count) = (squares + d * d, count + 1.0);
    }
    assert!(count > 300.0, "{count} pixels in common");
    let [a, b, c] = normal;
    let determinant = a * c - b * b;
    let shift = [(c * right[0] - b * right[1]) / determinant, (a * right[1] - b * right[0]) / determinant];
    (shift, f64::sqrt(squares / count))
}

/// Frames of 20 ms readout at 20 deg/s and 40 m/s: rectified with bands they are the global shutter's within 0.05 px
/// RMS and, pixel by pixel, within what two different samplings of one ground by whole greys differ; with one pose they
/// are not.
#[test]
fn a_rolling_frame_rectifies_to_the_global_one() {
    let land = land();
    let (camera, _) = cameras(oracle::Distortion::default());
    let fov_rad = FOV_DEG.to_radians();
    let renderer = Renderer::new(
        RenderCamera {
            cols: SIDE,
            rows: SIDE,
            fov_h_rad: fov_rad,
            fov_v_rad: fov_rad,
            offset_m_px: 0.0,
            offset_n_px: 0.0,
            distortion: None,
        },
        2,
    );
    let mut random = Random::new(35);
    // Metres a patch pixel, and its pixels: by area and by bilinear readings.
    let kernels = [(5.0f32, 25u16), (0.5, 200)];
    let mut sums = [[0.0f64; 4]; 2];
    const CASES: usize = 6;
    for _ in 0..CASES {
        let truth = Truth::random(&mut random);
        let height_m = truth.height_m as f32;
        let global = renderer.render(&land, &truth.station(0.0), 0.0, 0, 0);
        let row_s = |row: usize| 1e-6 * f64::from(READOUT_US) * (row as f64 / (SIDE - 1) as f64 - 0.5);
        let rolling = renderer.render_rows(&land, &|row| vec![truth.station(row_s(row))], (1.0, 0.0), 0, 0);
        assert_eq!((global.outside, rolling.outside), (0, 0));
        let bands = Bands::new(&truth.bands(&camera), &camera, height_m).expect("slow enough");
        for ((resolution_m, side), sums) in kernels.into_iter().zip(&mut sums) {
            let scale = (height_m, resolution_m);
            let ratio = camera.ratio(height_m, resolution_m);
            let at_once = FrameFromPatch::new(truth.homography(0.0, &camera), &camera, scale, (side, side));
            let by_rows = FrameFromPatch::rolling(&bands, &camera, scale, (side, side));
            let wanted = rectified(&at_once, &global.pixels, ratio);
            let cols = usize::from(side);
            let (shift, grey) = apart(&wanted, &rectified(&by_rows, &rolling.pixels, ratio), cols);
            let (off, grey_off) = apart(&wanted, &rectified(&at_once, &rolling.pixels, ratio), cols);
            let square = |[x, y]: [f64; 2]| x * x + y * y;
            *sums =
                [sums[0] + square(shift), sums[1] + grey * grey, sums[2] + square(off), sums[3] + grey_off * grey_off];
        }
    }
    for ((resolution_m, _), sums) in kernels.into_iter().zip(sums) {
        let [shift, grey, off, grey_off] = sums.map(|sum| (sum / CASES as f64).sqrt());
        println!(
            "{resolution_m} m: {shift:.5} px and {grey:.3} greys; with one pose {off:.3} px and {grey_off:.2} greys"
        );
        assert!(shift < 0.01 && grey < 1.0, "{shift} px, {grey} greys");
        assert!(grey_off > 2.0 * grey && off > 3.0 * shift, "one pose: {off} px, {grey_off} greys");
    }
}
