//! One reading a cell, against the same readings in `f64`.

use super::scene::{Scene, image_noise};
use super::{NO_DISTORTION, ROUNDING_DN};
use plumbline_sim::oracle::Distortion;

const BARREL: Distortion = Distortion { k1: -0.075, k2: 0.0, k3: 0.0, p1: 0.001, p2: -0.0005 };

/// On noise, whose edges are as steep as edges can be: weights of eight bits along rows are half a grey level off at most,
/// positions 1/280 px and 1e-3 px of single precision off along both axes another 2.3, and it is rounded. What a run holds
/// lies in the frame, and patches are of all widths, so that words begin anywhere in a row.
#[test]
fn readings_are_those_of_exact_positions() {
    let limit = 0.5 + 2.0 * 255.0 * (1.0 / 280.0 + 1e-3) + ROUNDING_DN;
    for (lens, name) in [(NO_DISTORTION, "no distortion"), (BARREL, "5 % barrel")] {
        let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0);
        for (i, heading) in (0..360).step_by(45).enumerate() {
            for (pitch, roll) in [(0.0, 0.0), (8.0, 10.0), (30.0, 0.0), (-20.0, 22.0)] {
                let side = 124 + i as u16;
                let angles = [f64::from(heading), pitch, roll, f64::from(heading) / 2.0];
                let scene = Scene::new((256, 256), (40.0, 40.0), lens, angles, ((side, 61), 2.5, 439.6));
                let (frame, reduction) = scene.reduce(&image_noise(256, 256), 0);
                let ours = scene.rectify(&frame, reduction).expect("the sizes fit");
                for (cell, wanted) in scene.same_readings(&frame, &reduction).iter().enumerate() {
                    if let (Some(wanted), true) = (wanted, ours.valid[cell]) {
                        let off = f64::from(ours.pixels[cell]) - wanted;
                        worst = worst.max(off.abs());
                        sum += off;
                        count += 1;
                    }
                    let (col, row) = (cell % usize::from(side), cell / usize::from(side));
                    let is_near = !ours.valid[cell] || scene.clearance(col, row, &reduction) > -1.0 / 200.0;
                    assert!(is_near, "cell {col}, {row} is read outside the frame at {angles:?}");
                    assert!(ours.valid[cell] || ours.pixels[cell] == 0);
                }
            }
        }
        let mean = sum / f64::from(count);
        println!("{name}: {count} cells, at most {worst:.2}, mean {mean:.4} DN off, limit {limit:.2}");
        assert!(count > 20_000 && worst < limit, "{worst} in {count} cells, limit {limit}");
        // A rounding term left out would show as half a grey level, or as an eighth of 1/256 px along noise.
        assert!(mean.abs() < 0.02, "{mean}");
    }
}
