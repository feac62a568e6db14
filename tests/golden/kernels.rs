//! The core's resampling: table F, its area average against the exact one, and the mask.
//!
//! A grey level of the core is that of its readings, rounded (0.5), with 11-bit weights (0.13), at positions that are
//! off by at most the kernel's own tolerance: 1/512 px when a cell is one reading of the frame itself, 1/16 px of the
//! reduced frame when it is an average.

#[path = "kernels/bilinear.rs"]
mod bilinear;
#[path = "kernels/positions.rs"]
mod positions;
#[path = "kernels/reducer.rs"]
mod reducer;
mod scene;
mod seeded;
mod vectors;

use plumbline_core::rectify::{RectifyError, Run, Sampling, Source, rectify_into};
use plumbline_core::reduce::Reduction;
use plumbline_sim::oracle;
use proptest::prelude::{any, prop_assert, prop_assert_eq, proptest};
use scene::{Angles, Scene, image_f, image_noise, image_smooth};
use seeded::config;
use serde_json::Value;
use vectors::{number, table};

const NO_DISTORTION: oracle::Distortion = oracle::Distortion { k1: 0.0, k2: 0.0, k3: 0.0, p1: 0.0, p2: 0.0 };
/// Rounding to whole grey levels and the 11-bit weights.
const ROUNDING_DN: f64 = 0.5 + 0.13;

/// The scene of table F and the table.
fn scene_f() -> (Scene, Value) {
    let f = table("003", "F_remap");
    let (side, cells) = (number(&f, "M") as u16, number(&f, "W") as u16);
    let angles = [0.0, number(&f, "theta1"), number(&f, "gamma1"), 0.0];
    let patch = ((cells, cells), number(&f, "R"), number(&f, "H"));
    let fov = number(&f, "V");
    (Scene::new((side, side), (fov, fov), NO_DISTORTION, angles, patch).centred(), f)
}

/// A golden kernel of table F: within one grey level where both are valid. No cell is gained, and one is lost only if a
/// reading lies within 1/256 px of the border.
fn golden_f(key: &str, samples: u16) {
    let (scene, f) = scene_f();
    let (reduced, reduction) = scene.reduce(&image_f(64, 64), 1);
    let patch = scene.rectify(&reduced, reduction, Sampling { samples }).expect("the sizes fit");
    let golden = f[key].as_array().expect("rows").iter().flat_map(|row| row.as_array().expect("a row"));
    let (mut worst, mut both) = (0.0f64, 0);
    for (i, golden) in golden.map(Value::as_f64).enumerate() {
        let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
        match (golden, patch.valid[i]) {
            (Some(golden), true) => {
                worst = worst.max((golden - f64::from(patch.pixels[i])).abs());
                both += 1;
            }
            (Some(_), false) => {
                let clearance = scene.clearance(col, row, samples, &reduction);
                assert!(clearance < 1.0 / 256.0, "{key}: cell {col}, {row} is lost, {clearance} px inside");
            }
            (None, valid) => assert!(!valid, "{key}: cell {col}, {row} is gained"),
        }
    }
    println!("F {key}: {both} cells, at most {worst:.3} grey levels off");
    assert!(both > 100 && worst <= 1.0, "{key}: {worst} grey levels in {both} cells");
}

#[test]
fn golden_f_bilinear() {
    golden_f("bilinear", 1);
}

#[test]
fn golden_f_area_of_16_readings() {
    golden_f("area4x4", 4);
}

/// Mean and largest difference to the exact area average, over cells that both have; and the grey levels' deviation.
fn against_exact_area(scene: &Scene, frame: &[u8], factor: u16) -> (f64, f64, usize) {
    let (cols, rows) = (scene.judge.cols, scene.judge.rows);
    let image = oracle::Image::new(cols, rows, frame.iter().map(|&p| p.into()).collect()).expect("the sizes fit");
    let exact = oracle::exact_area(&image, &scene.a, &scene.judge, &scene.grid);
    let (reduced, reduction) = scene.reduce(frame, factor);
    let sampling = Sampling::choose(scene.ratio(), &reduction);
    let patch = scene.rectify(&reduced, reduction, sampling).expect("the sizes fit");
    let (mut sum, mut worst, mut count) = (0.0, 0.0f64, 0);
    for (i, exact) in exact.iter().enumerate() {
        if let (Some(exact), true) = (exact, patch.valid[i]) {
            let off = (exact - f64::from(patch.pixels[i])).abs();
            sum += off;
            worst = worst.max(off);
            count += 1;
        }
    }
    println!(
        "ratio {:.2}, factor {factor}, {} readings a side: mean {:.2}, at most {worst:.2} DN in {count} cells",
        scene.ratio(),
        sampling.samples,
        sum / count as f64
    );
    (sum / count as f64, worst, count)
}

/// The scenes for the area average: ratio about 4.4 (no reduction), 14.8 (boxes of 3), 33 (boxes of 8).
fn area_scenes() -> [(Scene, u16); 3] {
    let scene = |side: u16, cells: u16, resolution_m: f64, angles: Angles| {
        Scene::new((side, side), (60.0, 60.0), NO_DISTORTION, angles, ((cells, cells), resolution_m, 150.0)).centred()
    };
    [
        (scene_f().0, 1),
        (scene(512, 34, 5.0, [30.0, 6.0, -4.0, 25.0]), 3),
        (scene(800, 24, 7.15, [200.0, -5.0, 7.0, 201.0]), 8),
    ]
}

/// On noise, neighbouring pixels unrelated with deviation s, the kernel differs from the exact area along the cell's
/// outline only: 4 r pixels long, and across it as wide as a bilinear reading of boxes of f pixels reaches. The edge of
/// the exact area is a step; the kernel's is the bilinear one, 1 − (1 − x)²/2 of f pixels, at box centres that lie evenly
/// about the edge. The mean square of the difference, integrated across, is 0.173 f; without boxes the exact edge is a
/// pixel wide as well and it is 0.00625. So the difference has the deviation 2 √(0.173 f) s / r^1.5 or 0.16 s / r^1.5,
/// a mean of 0.8 of that, and among 1000 cells none beyond 4 of it. Table F's image is smoother than noise.
#[test]
fn the_area_kernel_on_rough_texture() {
    for (scene, factor) in area_scenes() {
        for image in [image_noise, image_f] {
            let frame = image(scene.judge.cols, scene.judge.rows);
            let mean = frame.iter().map(|&p| f64::from(p)).sum::<f64>() / frame.len() as f64;
            let s = (frame.iter().map(|&p| (f64::from(p) - mean).powi(2)).sum::<f64>() / frame.len() as f64).sqrt();
            let r = f64::from(scene.ratio());
            let across = if factor > 1 { 0.173 * f64::from(factor) } else { 0.006_25 };
            let sigma = 2.0 * across.sqrt() * s / r.powf(1.5);
            let (mean, worst, count) = against_exact_area(&scene, &frame, factor);
            println!("  derived: mean {:.2}, at most {:.2} DN (s = {s:.1})", 0.8 * sigma, 4.0 * sigma);
            assert!(count > 90 && mean < 0.8 * sigma + ROUNDING_DN && worst < 4.0 * sigma + ROUNDING_DN);
        }
    }
}

/// On a smooth image only the centroid counts: positions off by f/16 px; and the exact area is that of the frame, where
/// the near side of a cell is larger, while the readings are even on the ground: r² / 12 times the relative change of
/// area a pixel, at most 3 tan(angle off axis) k, moves the centroid by less than r² k / 5 at 30 degrees. Rounding twice.
#[test]
fn the_area_kernel_on_a_smooth_image() {
    const SLOPE: f64 = 5.3;
    for (scene, factor) in area_scenes() {
        let frame = image_smooth(scene.judge.cols, scene.judge.rows);
        let (r, k) = (f64::from(scene.ratio()), scene.judge.tangent_per_px().0);
        let tolerance = SLOPE * (f64::from(factor) / 16.0 + r * r * k / 5.0) + 2.0 * ROUNDING_DN;
        let (mean, worst, count) = against_exact_area(&scene, &frame, factor);
        println!("  derived: at most {tolerance:.2} DN");
        assert!(count > 90 && worst < tolerance && mean < 0.5 * tolerance, "{mean}, {worst}");
    }
}

/// Angles, frame, patch, factor and readings of the mask's cases.
fn mask_cases() -> Vec<(Scene, u16, u16)> {
    let mut all = Vec::new();
    let barrel = oracle::Distortion { k1: -0.075, p1: 0.001, p2: -0.0005, ..NO_DISTORTION };
    let angles =
        [[0.0, 0.0, 0.0, 0.0], [77.0, 10.0, 8.0, 75.0], [190.0, -25.0, 14.0, 180.0], [301.0, 31.0, -31.0, 0.0]];
    for (i, angles) in angles.into_iter().enumerate() {
        for (samples, factor, side, resolution_m) in
            [(1, 1, 80, 1.0), (4, 1, 40, 3.7), (5, 3, 33, 5.0), (2, 2, 64, 1.9)]
        {
            let distortion = if i % 2 == 0 { NO_DISTORTION } else { barrel };
            let patch = ((side, side + 3), resolution_m, 120.0);
            all.push((Scene::new((400, 300), (60.0, 46.8), distortion, angles, patch), samples, factor));
        }
    }
    all
}

/// A cell is valid exactly when all of its readings lie in the frame. Undecided: an outermost reading as near to the
/// border as positions may be off.
#[test]
fn the_mask_is_where_all_readings_are_inside() {
    let (mut sure, mut undecided) = (0, 0);
    for (scene, samples, factor) in mask_cases() {
        let frame = image_smooth(scene.judge.cols, scene.judge.rows);
        let (reduced, reduction) = scene.reduce(&frame, factor);
        let patch = scene.rectify(&reduced, reduction, Sampling { samples }).expect("the sizes fit");
        // Positions are kept in 1/65536 reduced pixels and come from single precision.
        let average = f64::from(factor) / 16.0;
        let tolerance = if samples > 1 || factor > 1 { average } else { 1.0 / 512.0 } + 1e-3;
        for (i, &valid) in patch.valid.iter().enumerate() {
            let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
            let clearance = scene.clearance(col, row, samples, &reduction);
            if clearance.abs() < tolerance {
                undecided += 1;
            } else {
                sure += 1;
                assert_eq!(valid, clearance > 0.0, "cell {col}, {row}, {clearance} px inside, of {scene:?}");
            }
        }
    }
    println!("mask: {sure} cells agree, {undecided} lie on the border");
    assert!(undecided * 100 < sure, "too many cells on the border: {undecided}");
}

/// Pitches up to 89 degrees look over the horizon: nothing behind the camera is valid, and nothing outside the frame.
#[test]
fn nothing_beyond_the_horizon_is_valid() {
    let mut seen = 0;
    for pitch in [50.0, 65.0, -72.0, 80.0, -85.0, 89.0] {
        for (heading, roll, samples, factor) in [(0.0, 0.0, 1, 1), (45.0, 10.0, 3, 1), (120.0, -20.0, 4, 2)] {
            // Three heights to every side.
            let patch = ((60, 60), 10.0, 100.0);
            let angles = [heading, pitch, roll, 0.0];
            let scene = Scene::new((320, 240), (60.0, 47.0), NO_DISTORTION, angles, patch);
            let (reduced, reduction) = scene.reduce(&image_smooth(320, 240), factor);
            let patch = scene.rectify(&reduced, reduction, Sampling { samples }).expect("the sizes fit");
            for (i, &valid) in patch.valid.iter().enumerate() {
                let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
                let clearance = scene.clearance(col, row, samples, &reduction);
                seen += usize::from(valid);
                assert!(!valid || clearance > -0.14, "cell {col}, {row} lies {clearance} px inside of {scene:?}");
            }
        }
    }
    assert!(seen > 100, "the frames see only {seen} cells");
}

/// 16 x 16 readings, the most there may be, and none of them in the frame.
#[test]
fn cells_of_256_readings_outside_are_not_valid() {
    let scene = Scene::new((64, 64), (20.0, 20.0), NO_DISTORTION, [0.0; 4], ((24, 24), 10.0, 100.0));
    let (reduced, reduction) = scene.reduce(&image_f(64, 64), 1);
    let patch = scene.rectify(&reduced, reduction, Sampling { samples: 16 }).expect("the sizes fit");
    for (i, &valid) in patch.valid.iter().enumerate() {
        let clearance = scene.clearance(i % 24, i / 24, 16, &reduction);
        assert!(!valid || clearance > -0.07, "cell {i} lies {clearance} px inside");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let scene = scene_f().0;
    let (reduced, reduction) = scene.reduce(&image_f(64, 64), 1);
    assert!(matches!(Source::new(&reduced[1..], reduction), Err(RectifyError::Size)));
    let source = Source::new(&reduced, reduction).expect("the sizes fit");
    let attempt = |pixels: usize, sums: usize, samples: u16| {
        let mut runs: heapless::Vec<Run, 64> = heapless::Vec::new();
        let (mut pixels, mut sums) = (vec![0; pixels], vec![0; sums]);
        rectify_into(&scene.map(), source, Sampling { samples }, &mut pixels, &mut sums, &mut runs)
    };
    assert_eq!(attempt(144, 12, 1), Ok(()));
    for (pixels, sums, samples) in [(143, 12, 1), (144, 11, 1), (144, 12, 0), (144, 12, 17)] {
        assert_eq!(attempt(pixels, sums, samples), Err(RectifyError::Capacity), "{pixels}, {sums}, {samples}");
    }
    // Too few places for runs: what does not fit stays invalid, and 0.
    let (mut pixels, mut sums) = (vec![7; 144], vec![0; 12]);
    let mut runs: heapless::Vec<Run, 3> = heapless::Vec::new();
    let done = rectify_into(&scene.map(), source, Sampling { samples: 1 }, &mut pixels, &mut sums, &mut runs);
    assert_eq!((done, runs.len()), (Ok(()), 3));
    let last = usize::from(runs[2].row + 1) * 12;
    assert!(pixels[last..].iter().all(|&p| p == 0), "pixels outside every run");
}

proptest! {
    #![proptest_config(config(11, 400))]

    /// Any attitude, size and height: no panic, runs sorted, apart and inside, everything else 0.
    #[test]
    fn runs_are_sorted_inside_and_the_rest_is_zero(
        angles in proptest::array::uniform4(-180.0f64..180.0), side in 2u16..90, lines in 2u16..70,
        patch_cols in 1u16..50, patch_rows in 1u16..50, samples in 1u16..=15, factor in 1u16..=16,
        fov in 1.0f64..170.0, resolution_m in 0.01f64..50.0, height_m in 1.0f64..500.0, k1 in -0.4f64..0.4, seed in any::<u8>(),
    ) {
        let (cols, rows) = (side.max(2 * factor), lines.max(2 * factor));
        let distortion = oracle::Distortion { k1, ..NO_DISTORTION };
        let patch = ((patch_cols, patch_rows), resolution_m, height_m);
        let scene = Scene::new((cols, rows), (fov, 0.8 * fov), distortion, angles, patch);
        // No black pixel, so that a 0 is one that was left out.
        let frame = vec![seed | 1; usize::from(cols) * usize::from(rows)];
        let (reduced, reduction) = scene.reduce(&frame, factor);
        let patch = scene.rectify(&reduced, reduction, Sampling { samples });
        prop_assert!(patch.is_ok());
        let Ok(patch) = patch else { return Ok(()) };
        for run in &patch.runs {
            prop_assert!(run.start < run.end && run.end <= patch_cols && run.row < patch_rows, "{run:?}");
        }
        for pair in patch.runs.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            prop_assert!(a.row < b.row || (a.row == b.row && a.end < b.start), "{a:?} before {b:?}");
        }
        for (pixel, valid) in patch.pixels.iter().zip(&patch.valid) {
            prop_assert_eq!(*pixel, if *valid { seed | 1 } else { 0 });
        }
    }

    /// The rectifier's numbers may be anything: still no panic.
    #[test]
    fn no_number_makes_it_panic(angles in proptest::array::uniform4(any::<f32>()), height in any::<f32>(), resolution in any::<f32>()) {
        let scene = Scene::new((64, 64), (60.0, 60.0), NO_DISTORTION, angles.map(f64::from),
                               ((20, 20), f64::from(resolution), f64::from(height)));
        let (reduced, reduction) = scene.reduce(&image_f(64, 64), 1);
        let patch = scene.rectify(&reduced, reduction, Sampling { samples: 2 });
        prop_assert!(patch.is_ok());
        let _ = Sampling::choose(scene.ratio(), &reduction);
        let _ = Reduction::choose((64, 64), scene.ratio(), 4096);
    }
}
