//! The core's resampling: table F, area averages against the exact ones, and the mask.
//!
//! A bilinear grey level of the core is that of its reading, rounded (0.5), with 11-bit weights (0.13), at positions that
//! are off by at most the kernel's own tolerance. What an area average may be off is derived in module `area`.

mod area;
mod bilinear;
mod positions;
mod reducer;
mod scene;

use plumbline_core::image::Run;
use plumbline_core::rectify::{Node, RectifyError, Source, rectify_into};
use plumbline_core::reduce::Reduction;
use plumbline_sim::oracle;
use plumbline_tests::seeded::config;
use plumbline_tests::vectors::{number, table};
use proptest::prelude::{any, prop_assert, proptest};
use scene::{Scene, image_f, image_smooth};
use serde_json::Value;

const NO_DISTORTION: oracle::Distortion = oracle::Distortion { k1: 0.0, k2: 0.0, k3: 0.0, p1: 0.0, p2: 0.0 };
/// Rounding to whole grey levels and the 11-bit weights.
const ROUNDING_DN: f64 = 0.5 + 0.13;
/// How far off the corners of cells may be, frame pixels: stretches of a sixteenth of a box, 2e-3 of single precision. Added
/// are 1/256 of a box for cutting off and 1/512 for steps of up to 128 cells.
fn corner_px(factor: u16) -> f64 {
    2e-3 + f64::from(factor.max(1)) * (1.0 / 16.0 + 3.0 / 512.0)
}

/// The scene of table F and the table.
fn scene_f() -> (Scene, Value) {
    let f = table("003", "F_remap");
    let (side, cells) = (number(&f, "M") as u16, number(&f, "W") as u16);
    let angles = [0.0, number(&f, "theta1"), number(&f, "gamma1"), 0.0];
    let patch = ((cells, cells), number(&f, "R"), number(&f, "H"));
    let fov = number(&f, "V");
    (Scene::new((side, side), (fov, fov), NO_DISTORTION, angles, patch).centred(), f)
}

/// The bilinear kernel of table F: within one grey level where both are valid. No cell is gained, and one is lost only if
/// its reading lies within 1/256 px of the border.
#[test]
fn golden_f_bilinear() {
    let (scene, f) = scene_f();
    let (frame, reduction) = scene.reduce(&image_f(64, 64), 0);
    let patch = scene.rectify(&frame, reduction).expect("the sizes fit");
    let golden = f["bilinear"].as_array().expect("rows").iter().flat_map(|row| row.as_array().expect("a row"));
    let (mut worst, mut both) = (0.0f64, 0);
    for (i, golden) in golden.map(Value::as_f64).enumerate() {
        let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
        match (golden, patch.valid[i]) {
            (Some(golden), true) => {
                worst = worst.max((golden - f64::from(patch.pixels[i])).abs());
                both += 1;
            }
            (Some(_), false) => {
                let clearance = scene.clearance(col, row, &reduction);
                assert!(clearance < 1.0 / 256.0, "cell {col}, {row} is lost, {clearance} px inside");
            }
            (None, valid) => assert!(!valid, "cell {col}, {row} is gained"),
        }
    }
    println!("F bilinear: {both} cells, at most {worst:.3} grey levels off");
    assert!(both > 100 && worst <= 1.0, "{worst} grey levels in {both} cells");
}

/// Scenes and boxes of the mask's cases; 0 boxes: the frame is kept.
fn mask_cases() -> Vec<(Scene, u16)> {
    let mut all = Vec::new();
    let barrel = oracle::Distortion { k1: -0.075, p1: 0.001, p2: -0.0005, ..NO_DISTORTION };
    let angles =
        [[0.0, 0.0, 0.0, 0.0], [77.0, 10.0, 8.0, 75.0], [190.0, -25.0, 14.0, 180.0], [301.0, 31.0, -31.0, 0.0]];
    for (i, angles) in angles.into_iter().enumerate() {
        // No factor but 1 divides 397 x 301.
        for (factor, side, resolution_m) in [(0, 80, 1.0), (1, 80, 1.0), (2, 64, 1.9), (4, 40, 3.7), (8, 33, 7.3)] {
            let distortion = if i % 2 == 0 { NO_DISTORTION } else { barrel };
            let patch = ((side, side + 3), resolution_m, 120.0);
            all.push((Scene::new((397, 301), (60.0, 47.3), distortion, angles, patch), factor));
        }
    }
    all
}

/// A cell is valid exactly when all of it, or its reading, lies in what is kept of the frame. Undecided: a corner as near
/// to the border as positions may be off.
#[test]
fn the_mask_is_where_the_whole_cell_is_inside() {
    let (mut sure, mut undecided) = (0, 0);
    for (scene, factor) in mask_cases() {
        let frame = image_smooth(scene.judge.cols, scene.judge.rows, 1.0);
        let (kept, reduction) = scene.reduce(&frame, factor);
        let patch = scene.rectify(&kept, reduction).expect("the sizes fit");
        let tolerance = if factor > 0 { corner_px(factor) } else { 1.0 / 280.0 + 1e-3 };
        for (i, &valid) in patch.valid.iter().enumerate() {
            let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
            let clearance = scene.clearance(col, row, &reduction);
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

/// Pitches up to 89 degrees look over the horizon: nothing behind the camera is valid, and nothing outside the frame; and
/// what lies in it is valid.
#[test]
fn nothing_beyond_the_horizon_is_valid() {
    let (mut seen, mut lost) = (0, 0);
    for pitch in [50.0, 65.0, -72.0, 80.0, -85.0, 89.0] {
        for (heading, roll, factor) in [(0.0, 0.0, 0), (45.0, 10.0, 4), (120.0, -20.0, 8), (200.0, 0.0, 8)] {
            // Three heights to every side.
            let patch = ((60, 60), 10.0, 100.0);
            let angles = [heading, pitch, roll, 0.0];
            let scene = Scene::new((320, 240), (60.0, 47.0), NO_DISTORTION, angles, patch);
            let (kept, reduction) = scene.reduce(&image_smooth(320, 240, 1.0), factor);
            let patch = scene.rectify(&kept, reduction).expect("the sizes fit");
            for (i, &valid) in patch.valid.iter().enumerate() {
                let (col, row) = (i % scene.grid.cols, i / scene.grid.cols);
                let clearance = scene.clearance(col, row, &reduction);
                seen += usize::from(valid);
                assert!(
                    !valid || clearance > -corner_px(factor),
                    "cell {col}, {row} lies {clearance} px inside of {scene:?}"
                );
                lost += usize::from(!valid && clearance > corner_px(factor));
            }
        }
    }
    println!("horizon: {seen} cells are valid, {lost} are lost");
    assert!(seen > 100 && lost * 100 < seen, "the frames see {seen} cells and lose {lost}");
}

/// Cells of more than 128 boxes are more than their integrals hold: none is valid, rather than wrong. Those of fewer are.
#[test]
fn cells_of_more_than_128_boxes_are_not_valid() {
    for (resolution_m, is_valid) in [(3.5, true), (3.6, false)] {
        let side = 640;
        let scene = Scene::new((side, side), (53.13, 53.13), NO_DISTORTION, [0.0; 4], ((16, 16), resolution_m, 200.0));
        assert_eq!(scene.ratio() * scene.ratio() < 128.0, is_valid, "a cell spans {} boxes a side", scene.ratio());
        let (kept, reduction) = scene.reduce(&vec![255; usize::from(side) * usize::from(side)], 1);
        let patch = scene.rectify(&kept, reduction).expect("the sizes fit");
        let wanted = if is_valid { 255 } else { 0 };
        assert!(patch.pixels.iter().all(|&grey| grey == wanted), "{:?}", patch.pixels);
        assert_eq!(patch.runs.len(), if is_valid { 16 } else { 0 });
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let scene = scene_f().0;
    for factor in [0, 1] {
        let (kept, reduction) = scene.reduce(&image_f(64, 64), factor);
        assert!(matches!(Source::new(&kept[1..], reduction), Err(RectifyError::Size)));
        let other = Reduction::choose((64, 66), 3.0, usize::MAX).expect("it fits");
        assert!(matches!(Source::new(&kept, other), Err(RectifyError::Size)));
        let source = Source::new(&kept, reduction).expect("the sizes fit");
        let attempt = |pixels: usize, nodes: usize| {
            let mut runs: heapless::Vec<Run, 64> = heapless::Vec::new();
            let (mut pixels, mut nodes) = (vec![0; pixels], vec![Node::NOWHERE; nodes]);
            rectify_into(&scene.map(), source, &mut pixels, &mut nodes, &mut runs)
        };
        assert_eq!((attempt(144, 26), attempt(143, 26)), (Ok(()), Err(RectifyError::Capacity)));
        // A frame that is read as it is needs none.
        assert_eq!(attempt(144, 25), if factor == 0 { Ok(()) } else { Err(RectifyError::Capacity) });
        // Too few places for runs: what does not fit stays invalid, and 0.
        let (mut pixels, mut nodes) = (vec![7; 144], vec![Node::NOWHERE; 26]);
        let mut runs: heapless::Vec<Run, 3> = heapless::Vec::new();
        let done = rectify_into(&scene.map(), source, &mut pixels, &mut nodes, &mut runs);
        assert_eq!((done, runs.len()), (Ok(()), 3));
        let last = usize::from(runs[2].row + 1) * 12;
        assert!(pixels[last..].iter().all(|&p| p == 0), "pixels outside every run");
    }
}

proptest! {
    #![proptest_config(config(11, 600))]

    /// Any attitude, size and height: no panic, runs sorted, apart and inside, of one grey what the frame is, everything
    /// else 0.
    #[test]
    fn runs_are_sorted_inside_and_the_rest_is_zero(
        angles in proptest::array::uniform4(-180.0f64..180.0), side in 2u16..90, lines in 2u16..70,
        patch_cols in 1u16..50, patch_rows in 1u16..50, power in 0u32..=5,
        fov in 1.0f64..170.0, resolution_m in 0.01f64..50.0, height_m in 1.0f64..500.0, k1 in -0.4f64..0.4, seed in any::<u8>(),
    ) {
        let factor = (1 << power) >> 1;
        let (cols, rows) = (side.max(2 * factor), lines.max(2 * factor));
        let distortion = oracle::Distortion { k1, ..NO_DISTORTION };
        let patch = ((patch_cols, patch_rows), resolution_m, height_m);
        let scene = Scene::new((cols, rows), (fov, 0.8 * fov), distortion, angles, patch);
        // No black pixel, so that a 0 is one that was left out.
        let grey = seed.max(3);
        let frame = vec![grey; usize::from(cols) * usize::from(rows)];
        let (kept, reduction) = scene.reduce(&frame, factor);
        let patch = scene.rectify(&kept, reduction);
        prop_assert!(patch.is_ok());
        let Ok(patch) = patch else { return Ok(()) };
        for run in &patch.runs {
            prop_assert!(run.start < run.end && run.end <= patch_cols && run.row < patch_rows, "{run:?}");
        }
        for pair in patch.runs.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            prop_assert!(a.row < b.row || (a.row == b.row && a.end < b.start), "{a:?} before {b:?}");
        }
        for (i, (&pixel, &valid)) in patch.pixels.iter().zip(&patch.valid).enumerate() {
            let (col, row) = (i % usize::from(patch_cols), i / usize::from(patch_cols));
            let reach = || scene.reach(col, row, &reduction);
            // One grey comes out as it is; but sums are read to 1/128 of a box, which cells of about one box can see.
            let is_fine = !valid || pixel == grey || (factor > 0 && area::one_grey_may_be_off(&reach(), factor));
            prop_assert!(is_fine && (valid || pixel == 0), "{pixel} for {grey}, {valid}: {:?}", reach());
        }
    }

    /// The rectifier's numbers may be anything: still no panic.
    #[test]
    fn no_number_makes_it_panic(angles in proptest::array::uniform4(any::<f32>()), height in any::<f32>(), resolution in any::<f32>(), power in 0u32..=4) {
        let scene = Scene::new((64, 64), (60.0, 60.0), NO_DISTORTION, angles.map(f64::from),
                               ((20, 20), f64::from(resolution), f64::from(height)));
        let (kept, reduction) = scene.reduce(&image_f(64, 64), (1 << power) >> 1);
        let patch = scene.rectify(&kept, reduction);
        prop_assert!(patch.is_ok());
        let _ = Reduction::choose((64, 64), scene.ratio(), 4096);
    }
}
