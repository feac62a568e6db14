//! A mounted camera against paper 001: the golden values through the oracle, and the core against the oracle's frames and
//! against the renderer's axes.

use plumbline_core::mount::{LeverArm, Mount};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use plumbline_sim::camera::render::Station;
use plumbline_sim::oracle::mount::Mounting;
use plumbline_sim::oracle::{Matrix3, motion::ground_from_image};
use plumbline_tests::seeded::Random;
use plumbline_tests::vectors::{list, miss, number, table};
use serde_json::Value;

/// Half of the last digit that the reference prints.
const PRINTED: f64 = 0.5e-9;

fn mounting(row: &Value) -> Mounting {
    Mounting {
        ins_from_antenna_m: list(row, "r1"),
        camera_from_ins_m: list(row, "r2"),
        boresight_rad: list(row, "boresight"),
    }
}

#[test]
fn the_oracle_has_the_golden_values() {
    let row = table("001", "M_mount");
    let (mounting, antenna, body) = (mounting(&row), list(&row, "antenna"), list(&row, "body"));
    let golden: [f64; 3] = list(&row, "station");
    assert!(miss(mounting.station(antenna, body), golden) < 1.1 * PRINTED);
    let image = list::<2>(&row, "image").map(|mm| mm * 1e-3);
    let (point, lambda) =
        mounting.ground((antenna, body), number(&row, "f") * 1e-3, image, 0.0).expect("it looks down");
    assert!(miss(point, list(&row, "point")) < 1.1 * PRINTED, "{point:?}");
    assert!((lambda - number(&row, "lambda")).abs() < 1.1 * PRINTED, "{lambda}");
    // As printed, both arms begin at the antenna.
    let camera_from_antenna =
        std::array::from_fn(|axis| mounting.ins_from_antenna_m[axis] + mounting.camera_from_ins_m[axis]);
    let printed = Mounting { camera_from_ins_m: camera_from_antenna, ..mounting }.station(antenna, body);
    let off = (0..3).map(|axis| (printed[axis] - golden[axis]).powi(2)).sum::<f64>().sqrt();
    assert!((off - number(&row, "doubled")).abs() < 1e-6, "{off}");
    // And the body turned the wrong way.
    let [a, b, c] = ground_from_image(body);
    let arm = camera_from_antenna;
    let transposed = std::array::from_fn(|axis| antenna[axis] + a[axis] * arm[0] + b[axis] * arm[1] + c[axis] * arm[2]);
    assert!(miss(transposed, golden) > 0.1, "{transposed:?}");
}

/// Heading, pitch, roll of a body at phi, omega, kappa: its forward axis and its right axis in the ground frame.
fn attitude(ground_from_body: &Matrix3) -> [f64; 3] {
    let [[right_e, forward_e, _], [right_n, forward_n, _], [right_u, forward_u, up_u]] = *ground_from_body;
    assert!((right_e.hypot(right_n).hypot(right_u) - 1.0).abs() < 1e-12);
    [forward_e.atan2(forward_n), forward_u.asin(), (-right_u).atan2(up_u)]
}

fn core_attitude(angles: [f64; 3]) -> Attitude {
    let [heading, pitch, roll] = angles.map(|angle| Radians(angle as f32));
    Attitude { heading, pitch, roll }
}

/// Right, forward and up of the paper are the core's right, forward and minus down.
fn core_mount(arm: [f64; 3], boresight: &Matrix3) -> Mount {
    let [right_m, forward_m, up_m] = arm.map(|length| length as f32);
    Mount { lever_arm: LeverArm { forward_m, right_m, down_m: -up_m }, boresight: core_attitude(attitude(boresight)) }
}

/// The core's offset as X, Y, Z.
fn offset(mount: &Mount, body: &Matrix3) -> [f64; 3] {
    let [north, up, east] = mount.camera_offset(core_attitude(attitude(body))).map(f64::from);
    [east, north, up]
}

/// Half a unit in the last place of an f32 near one.
const ROUNDED: f64 = 6e-8;
/// An entry of the body's rotation is a sum of products of three sines: their six angles and values rounded (of angles up
/// to pi by 2e-7, of the rest by [`ROUNDED`]), and three multiplications.
const ENTRY: f64 = 2e-7 + 9.0 * ROUNDED;

/// Bound of the offset for an arm: each entry's error along it, and three products and sums of the size of the arm.
fn bound(arm: [f64; 3]) -> f64 {
    arm.iter().map(|length| length.abs()).sum::<f64>() * (ENTRY + 3.0 * ROUNDED)
}

#[test]
fn the_core_has_the_golden_lever_arm() {
    let row = table("001", "M_mount");
    let (r1, r2): ([f64; 3], [f64; 3]) = (list(&row, "r1"), list(&row, "r2"));
    let (antenna, golden): ([f64; 3], [f64; 3]) = (list(&row, "antenna"), list(&row, "station"));
    let arm = std::array::from_fn(|axis| r1[axis] + r2[axis]);
    let body = ground_from_image(list(&row, "body"));
    let mount = core_mount(arm, &ground_from_image(list(&row, "boresight")));
    let expected = std::array::from_fn(|axis| golden[axis] - antenna[axis]);
    let off = miss(offset(&mount, &body), expected);
    println!("lever arm: {off:.2e} m of {:.2e}", bound(arm));
    assert!(off < bound(arm) + PRINTED);
    // Both arms from the antenna; the rotation transposed.
    let doubled = core_mount(std::array::from_fn(|axis| arm[axis] + r1[axis]), &ground_from_image([0.0; 3]));
    assert!(miss(offset(&doubled, &body), expected) > 0.5);
    let transposed = std::array::from_fn(|row| std::array::from_fn(|col| body[col][row]));
    assert!(miss(offset(&mount, &transposed), expected) > 0.1);
}

/// Where the core has the camera's axes, as (right, forward, up) of (X, Y, Z): ground from camera.
fn core_ground_from_camera(mount: &Mount, attitude: Attitude, follow_up: f64) -> Matrix3 {
    let camera_from_local = mount.camera_from_local(attitude, Radians(follow_up as f32));
    // Rows forward, up, right; columns north, up, east.
    std::array::from_fn(|ground| {
        std::array::from_fn(|camera| f64::from(camera_from_local[([2, 0, 1][camera], [2, 0, 1][ground])]))
    })
}

/// R_C^M = R_B^M R_C^B for attitudes and boresights of every size; two rotations and their product round.
#[test]
fn the_core_turns_the_camera_as_the_oracle_does() {
    let (mut random, mut worst) = (Random::new(11), 0.0_f64);
    let row = table("001", "M_mount");
    let golden = (list(&row, "body"), list(&row, "boresight"));
    let drawn = (0..200).map(|_| {
        let body = [random.between(-0.5, 0.5), random.between(-0.5, 0.5), random.between(-3.1, 3.1)];
        (body, [(); 3].map(|()| random.between(-0.2, 0.2)))
    });
    for (body, boresight_rad) in std::iter::once(golden).chain(drawn.collect::<Vec<_>>()) {
        let mounting = Mounting { ins_from_antenna_m: [0.0; 3], camera_from_ins_m: [0.0; 3], boresight_rad };
        let mount = core_mount([0.0; 3], &ground_from_image(boresight_rad));
        let ours = core_ground_from_camera(&mount, core_attitude(attitude(&ground_from_image(body))), 0.0);
        let off = miss(ours.concat().try_into().expect("nine"), entries(&mounting.ground_from_camera(body)));
        worst = worst.max(off);
        // The boresight on the other side of the body's turn.
        let swapped = Mounting { boresight_rad: body, ..mounting }.ground_from_camera(boresight_rad);
        let turned = miss(entries(&swapped), entries(&mounting.ground_from_camera(body)));
        assert!(turned > 1e-4, "{turned}");
    }
    println!("boresight: {worst:.2e}");
    // Three entries of each side meet in one; the rows and columns that weigh them have length one.
    assert!(worst < 2.0 * 3f64.sqrt() * (ENTRY + 2.0 * ROUNDED), "{worst}");
}

fn entries(matrix: &Matrix3) -> [f64; 9] {
    std::array::from_fn(|i| matrix[i / 3][i % 3])
}

/// The renderer turns axes actively one after the other; the core multiplies matrices.
#[test]
fn the_renderer_turns_the_camera_as_the_core_does() {
    let mut random = Random::new(12);
    for _ in 0..200 {
        let angles = [random.between(-3.1, 3.1), random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
        let follow_up_rad = random.between(-3.1, 3.1);
        let boresight_rad = [(); 3].map(|()| random.between(-0.2, 0.2));
        let [heading_rad, pitch_rad, roll_rad] = angles;
        let station = Station { heading_rad, pitch_rad, roll_rad, follow_up_rad, boresight_rad, ..Station::default() };
        let axes = station.axes();
        let mount = Mount { lever_arm: LeverArm::default(), boresight: core_attitude(boresight_rad) };
        let ours = core_ground_from_camera(&mount, core_attitude(angles), follow_up_rad);
        for (camera, axis) in [axes.right, axes.forward, axes.down.map(|x| -x)].into_iter().enumerate() {
            let off = miss([0, 1, 2].map(|ground| ours[ground][camera]), axis);
            // The follow-up angle is a fourth turn of the first matrix, another angle of up to pi.
            assert!(off < 2.0 * 3f64.sqrt() * (2e-7 + ENTRY + 4.0 * ROUNDED), "{off}");
        }
    }
}
