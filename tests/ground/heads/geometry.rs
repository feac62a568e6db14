//! The golden projection, and what single precision costs.

use super::four::{F_PX, four};
use plumbline_core::homography::FrameFromPatch;
use plumbline_sim::camera::heads::{Rig, Tile, station_of};
use plumbline_sim::camera::render::{Renderer, Station};
use plumbline_sim::camera::render_camera;
use plumbline_sim::oracle::Matrix3;
use plumbline_sim::oracle::motion::ground_from_image;
use plumbline_survey::camera_file::Head;

/// Projection centre, attitude (phi, omega, kappa) and ground point.
const S: [f64; 3] = [1000.0, 2000.0, 700.0];
const ATTITUDE: [f64; 3] = [0.02, -0.03, 1.6];
const X: [f64; 3] = [1100.0, 1900.0, 20.0];
/// Image point in each head, pixels right and up of its centre.
const GOLDEN: [[f64; 2]; 4] = [
    [2055.349364083, -3252.706522372],
    [-4190.417829474, -3359.970294112],
    [1893.336232999, 1319.526243833],
    [-3827.964965134, 1229.392890469],
];
/// Projection centre of the first head.
const CENTRE: [f64; 3] = [999.941323260, 1999.953288245, 700.000228362];
/// Half of the last digit that is printed, and a double's rounding of a pixel number.
const PRINTED: f64 = 0.6e-9;

fn station(ground_from_image: &Matrix3) -> Station {
    let [[right_e, forward_e, _], [right_n, forward_n, _], [right_u, forward_u, up_u]] = *ground_from_image;
    assert!((right_e.hypot(right_n).hypot(right_u) - 1.0).abs() < 1e-12);
    Station {
        east_m: S[0],
        north_m: S[1],
        up_m: S[2],
        heading_rad: forward_e.atan2(forward_n),
        pitch_rad: forward_u.asin(),
        roll_rad: (-right_u).atan2(up_u),
        ..Station::default()
    }
}

/// X in the virtual camera: tangents right and up, and its depth.
fn virtual_ray(ground_from_image: &Matrix3) -> ([f64; 2], f64) {
    let sight: [f64; 3] = std::array::from_fn(|i| X[i] - S[i]);
    let [right, up, behind] =
        std::array::from_fn(|axis| (0..3).map(|i| ground_from_image[i][axis] * sight[i]).sum::<f64>());
    ([-right / behind, -up / behind], -behind)
}

/// Right and up of the centre of a head's frame.
fn centred((col, row): (f64, f64)) -> [f64; 2] {
    [col - 0.5 * 7227.0, 0.5 * 5427.0 - row]
}

fn off(found: [f64; 2], golden: [f64; 2]) -> f64 {
    (found[0] - golden[0]).abs().max((found[1] - golden[1]).abs())
}

/// A point at depth H in the virtual image goes where collinearity puts it: the homography of a plane at H is exact there.
#[test]
fn the_golden_projection_by_the_homography_of_its_depth() {
    let (tangents, depth_m) = virtual_ray(&ground_from_image(ATTITUDE));
    let rig = Rig::new(&four(1.0), Some(depth_m)).expect("four heads");
    let (col, row) = (0.5 * 15_399.0 + F_PX * tangents[0], 0.5 * 10_399.0 - F_PX * tangents[1]);
    for (head, golden) in GOLDEN.into_iter().enumerate() {
        let found = centred(rig.frame_position(head, col, row).expect("in front"));
        assert!(off(found, golden) < 10.0 * PRINTED, "head {}: {found:?} instead of {golden:?}", head + 1);
    }
    // Without the height it is off by the parallax, f d/H.
    let far = Rig::new(&four(1.0), None).expect("four heads");
    let found = centred(far.frame_position(0, col, row).expect("in front"));
    let parallax = off(found, GOLDEN[0]);
    assert!((0.4..1.2).contains(&parallax), "{parallax} px");
}

/// The renderer, which turns axes one after the other, by the heads' own stations.
#[test]
fn the_golden_projection_by_the_renderer() {
    let station = station(&ground_from_image(ATTITUDE));
    for (head, golden) in four(1.0).heads.iter().zip(GOLDEN) {
        let of_head = station_of(&station, head);
        // One pixel of the head is as good as all: it is its own centre, and the renderer has no rays to make for others.
        let camera = render_camera(&Head { cols: 1, rows: 1, ..head.clone() }.camera());
        let (col, row) = Renderer::new(camera, 1).project(&of_head, X).expect("in front");
        assert!(off([col, -row], golden) < 1e-7, "{col} {row} instead of {golden:?}");
    }
    let first = station_of(&station, &four(1.0).heads[0]);
    let centre = [first.east_m, first.north_m, first.up_m];
    assert!((0..3).all(|i| (centre[i] - CENTRE[i]).abs() < PRINTED), "{centre:?}");
}

/// The core's map of pieces all over the paper's image beside the f64 one. A position is a quotient of sums of three f32 of
/// up to 8192 pixels, which round by 2.4e-4 each: three in the numerator, as much again by the denominator's relative
/// 6e-8 three times, and the camera's tangent and centre once more.
#[test]
fn single_precision_holds_over_the_papers_image() {
    let file = four(1.0);
    let rig = Rig::new(&file, Some(700.0)).expect("four heads");
    let (mut worst, mut seen) = (0.0_f64, [0; 4]);
    for top in (0..10_400 - 511).step_by(899) {
        for left in (0..15_400 - 511).step_by(1063) {
            let tile = Tile { corner: (left, top), size: (512, 512) };
            for (head, seen) in seen.iter_mut().enumerate() {
                let (homography, scale) = rig.homography(head, &tile);
                let map = FrameFromPatch::new(homography, &rig.views[head].camera, scale, (512, 512));
                for (col, row) in [(0, 0), (511, 0), (0, 511), (511, 511), (100, 333)] {
                    let (at_col, at_row) = ((left + col) as f64, (top + row) as f64);
                    if rig.inside_px(head, at_col, at_row) < 0.0 {
                        continue;
                    }
                    let exact = rig.frame_position(head, at_col, at_row).expect("inside");
                    let found = map.frame_position(col as f32, row as f32).expect("inside");
                    worst = worst.max((f64::from(found.0) - exact.0).hypot(f64::from(found.1) - exact.1));
                    *seen += 1;
                }
            }
        }
    }
    println!("{worst:.2e} px of a frame, at {seen:?} points");
    assert!(seen.iter().all(|count| *count > 50), "{seen:?}");
    assert!(worst < 8.0 * 2.4e-4 * std::f64::consts::SQRT_2, "{worst}");
}
