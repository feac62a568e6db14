//! Where the core reads the frame, against the oracle: the exact positions, and those between the segments' ends.

use super::scene::{Angles, Scene, image_ramp};
use super::{NO_DISTORTION, ROUNDING_DN};
use plumbline_sim::oracle::Distortion;

/// 5 % at the corner of 60 x 60 degrees (r² = 2/3), and a little of everything else.
const BARREL: Distortion = Distortion { k1: -0.075, k2: 0.0, k3: 0.0, p1: 0.001, p2: -0.0005 };
/// Grey levels a pixel of the ramp image.
const RAMP_DN: f64 = 30.0;
/// Stretches of 1/280 px, and 1e-3 px of single precision; weights of eight bits along rows are half of 1/256 px off.
const READING_DN: f64 = RAMP_DN * (1.0 / 280.0 + 1e-3 + 0.5 / 256.0) + ROUNDING_DN;

/// Tilts from none to 45 degrees, all round the compass, follow-up angles that follow badly.
const ANGLES: [Angles; 7] = [
    [0.0, 0.0, 0.0, 0.0],
    [33.0, 10.0, 8.0, 31.0],
    [120.0, -20.0, 5.0, 130.0],
    [200.0, 0.0, 30.0, 200.0],
    [260.0, 33.0, -33.0, -90.0],
    [300.0, 45.0, 0.0, 15.0],
    [350.0, 0.0, -45.0, 0.0],
];

#[test]
fn exact_positions_inside_the_frame() {
    for (distortion, name) in [(NO_DISTORTION, "no distortion"), (BARREL, "5 % barrel")] {
        let (mut worst, mut inside) = (0.0f64, 0);
        for angles in ANGLES {
            let scene = Scene::new((512, 512), (60.0, 60.0), distortion, angles, ((70, 61), 5.0, 150.0));
            let map = scene.map();
            for i in 0..4 * 70 * 61 {
                let (col, row) = (f64::from(i % 140) / 2.0, f64::from(i / 140) / 2.0);
                let Some((x, y)) = scene.position(col, row) else { continue };
                if !(-0.5..=511.5).contains(&x) || !(-0.5..=511.5).contains(&y) {
                    continue;
                }
                let found = map.frame_position(col as f32, row as f32);
                let Some((x_core, y_core)) = found else { panic!("({x}, {y}) is lost for {angles:?}") };
                let off = (f64::from(x_core) - x).abs().max((f64::from(y_core) - y).abs());
                worst = worst.max(off);
                inside += 1;
                assert!(off < 2e-3, "({x_core}, {y_core}) for ({x}, {y}), {angles:?}");
            }
        }
        println!("positions, {name}: {inside} inside, at most {worst:.1e} px off");
        assert!(inside > 20_000, "only {inside} positions inside");
    }
}

/// A lens model may fold back and then open out again. Beyond the fold it shows points far outside the field of view a
/// second time, and no such point may be read: here 1 − 1.2 r² + 0.3 r⁴, the slope of the radius, is below zero from 48 to
/// 59 degrees off the axis, and above again from there.
#[test]
fn nothing_beyond_a_fold_of_the_lens_is_read() {
    let lens = Distortion { k1: -0.4, k2: 0.06, ..NO_DISTORTION };
    let scene = Scene::new((512, 512), (60.0, 60.0), lens, [0.0, 40.0, 0.0, 0.0], ((64, 200), 5.0, 150.0));
    let map = scene.map();
    let (mut read, mut folded) = (0, 0);
    for i in 0..64 * 200 {
        let (col, row) = (f64::from(i % 64), f64::from(i / 64));
        let Some((x, y)) = map.frame_position(col as f32, row as f32) else { continue };
        if (0.0..=511.0).contains(&x) && (0.0..=511.0).contains(&y) {
            read += 1;
            folded += usize::from(scene.position(col, row).is_none());
        }
    }
    assert!(read > 500 && folded == 0, "{folded} of {read} cells in the frame are not seen there");
}

/// The ramp image turns positions into grey levels, 30 a pixel and never steeper: a reading that is off by e px is off by
/// at most 30 e.
#[test]
fn positions_between_segment_ends_stay_within_their_tolerance() {
    for (distortion, name) in [(NO_DISTORTION, "no distortion"), (BARREL, "5 % barrel")] {
        let mut worst = [0.0f64; ANGLES.len()];
        for (angles, worst) in ANGLES.into_iter().zip(&mut worst) {
            let scene = Scene::new((512, 512), (60.0, 60.0), distortion, angles, ((170, 170), 1.0, 150.0));
            for along_rows in [false, true] {
                let (frame, reduction) = scene.reduce(&image_ramp(512, 512, along_rows), 0);
                let ours = scene.rectify(&frame, reduction).expect("the sizes fit");
                for (i, wanted) in scene.same_readings(&frame, &reduction).iter().enumerate() {
                    if let (Some(wanted), true) = (wanted, ours.valid[i]) {
                        *worst = worst.max((wanted - f64::from(ours.pixels[i])).abs());
                    }
                }
            }
        }
        println!("one reading, {name}: {worst:.2?} DN, limit {READING_DN:.2}");
        assert!(worst.iter().all(|&worst| worst < READING_DN), "{worst:?} grey levels, limit {READING_DN}");
    }
}

/// Positions where the patch reaches the horizon: the segments are planned on a map that is steep, and partly has no value.
#[test]
fn positions_near_the_horizon_stay_within_their_tolerance() {
    for pitch in [50.0, 60.0, 70.0, 80.0] {
        for (heading, roll) in [(0.0, 0.0), (60.0, 20.0), (200.0, -10.0)] {
            let angles = [heading, pitch, roll, 0.0];
            let scene = Scene::new((320, 240), (60.0, 47.0), NO_DISTORTION, angles, ((120, 120), 10.0, 100.0));
            let (mut worst, mut seen, mut lost) = (0.0f64, 0, 0);
            for along_rows in [false, true] {
                let (frame, reduction) = scene.reduce(&image_ramp(320, 240, along_rows), 0);
                let ours = scene.rectify(&frame, reduction).expect("the sizes fit");
                for (i, wanted) in scene.same_readings(&frame, &reduction).iter().enumerate() {
                    match (wanted, ours.valid[i]) {
                        (Some(wanted), true) => {
                            worst = worst.max((wanted - f64::from(ours.pixels[i])).abs());
                            seen += 1;
                        }
                        (Some(_), false) => lost += 1,
                        _ => {}
                    }
                }
            }
            assert!(worst < READING_DN, "{worst} DN at {angles:?}, limit {READING_DN}");
            assert!(seen > 300 && lost * 100 <= seen, "{lost} of {seen} cells are lost at {angles:?}");
        }
    }
}
