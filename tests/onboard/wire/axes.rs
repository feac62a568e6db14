//! Axes: MAVLink's quaternions against a product of elementary turns in `f64`, and against eq. 1's rotation.

use plumbline_core::frames::{
    attitude_from_ned_quaternion, centred, follow_up_from_gimbal_quaternion, gimbal_quaternion_from_follow_up,
    ned_quaternion_from_attitude, pixel,
};
use plumbline_core::tilt::{Attitude, camera_from_local};
use plumbline_core::units::Radians;
use plumbline_tests::seeded::Random;

pub type Matrix = [[f64; 3]; 3];

pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|k| a[r][k] * b[k][c]).sum()))
}

/// North-east-down from forward-right-down: heading about down, then pitch about right, then roll about forward.
pub fn ned_from_body(heading: f64, pitch: f64, roll: f64) -> Matrix {
    let (sy, cy) = heading.sin_cos();
    let (sp, cp) = pitch.sin_cos();
    let (sr, cr) = roll.sin_cos();
    let about_down = [[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]];
    let about_right = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    let about_forward = [[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]];
    product(&about_down, &product(&about_right, &about_forward))
}

/// The rotation of a Hamilton quaternion [w, x, y, z]: the images q v q* of the three axes.
pub fn matrix_of(q: [f64; 4]) -> Matrix {
    let times = |a: [f64; 4], b: [f64; 4]| {
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    };
    let conjugate = [q[0], -q[1], -q[2], -q[3]];
    let image = |axis: usize| {
        let mut v = [0.0; 4];
        v[axis + 1] = 1.0;
        times(times(q, v), conjugate)
    };
    let images = [image(0), image(1), image(2)];
    std::array::from_fn(|r| std::array::from_fn(|c| images[c][r + 1]))
}

pub fn largest_difference(a: &Matrix, b: &Matrix) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |worst: f64, d| if d.is_finite() { worst.max(d) } else { f64::INFINITY })
}

/// Heading, pitch, roll in radians; pitch up to 85 degrees.
fn attitudes() -> Vec<[f64; 3]> {
    let mut random = Random::new(91);
    let most = [180.0f64, 85.0, 180.0].map(f64::to_radians);
    (0..500).map(|_| most.map(|most| random.between(-most, most))).collect()
}

fn core_attitude([heading, pitch, roll]: [f64; 3]) -> Attitude {
    Attitude { heading: Radians(heading as f32), pitch: Radians(pitch as f32), roll: Radians(roll as f32) }
}

#[test]
fn quaternions_are_heading_pitch_and_roll_in_that_order() {
    for angles in attitudes() {
        let q = ned_quaternion_from_attitude(core_attitude(angles));
        let off = largest_difference(&matrix_of(q.map(f64::from)), &ned_from_body(angles[0], angles[1], angles[2]));
        assert!(off < 1e-6, "{q:?} is {off} off for {angles:?}");
        // And back, for either sign of the quaternion and a norm that is off by 5 %.
        for scale in [1.0, -1.0, 1.05, -0.95] {
            let back = attitude_from_ned_quaternion(q.map(|part| part * scale)).expect("nearly a unit quaternion");
            let again = ned_from_body(back.heading.0.into(), back.pitch.0.into(), back.roll.0.into());
            // asin near 85 degrees magnifies a rounding by 11.
            assert!(largest_difference(&again, &ned_from_body(angles[0], angles[1], angles[2])) < 2e-5, "{back:?}");
        }
    }
}

/// The paper's A takes north-up-east to forward-up-right: the same turn, seen on other axes.
#[test]
fn the_three_angles_are_the_papers() {
    // Rows: north, up, east of north, east, down; and forward, up, right of forward, right, down.
    let swap: Matrix = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
    let back: Matrix = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
    for angles in attitudes() {
        let ned_from_body = ned_from_body(angles[0], angles[1], angles[2]);
        let body_from_ned: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| ned_from_body[c][r]));
        let expected = product(&swap, &product(&body_from_ned, &back));
        let a = camera_from_local(core_attitude(angles), Radians(0.0));
        let a: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| a[(r, c)].into()));
        assert!(largest_difference(&a, &expected) < 1e-6, "{a:?} for {angles:?}");
    }
}

#[test]
fn a_gimbal_yaw_to_the_right_is_a_negative_follow_up_angle() {
    for degrees in [-170.0f64, -30.0, 0.0, 0.5, 45.0, 120.0] {
        let yaw = degrees.to_radians();
        // A turn about down, clockwise from above.
        let q = [(0.5 * yaw).cos() as f32, 0.0, 0.0, (0.5 * yaw).sin() as f32];
        let follow_up = follow_up_from_gimbal_quaternion(q).expect("a unit quaternion");
        assert!((f64::from(follow_up.0) + yaw).abs() < 1e-6, "{follow_up:?} for a yaw of {degrees}");
        let again = matrix_of(gimbal_quaternion_from_follow_up(follow_up).map(f64::from));
        assert!(largest_difference(&again, &ned_from_body(yaw, 0.0, 0.0)) < 1e-6, "{degrees}");
        // The yaw of a gimbal that is pitched and rolled as well.
        let q = ned_quaternion_from_attitude(core_attitude([yaw, -0.4, 0.2]));
        let follow_up = follow_up_from_gimbal_quaternion(q).expect("a unit quaternion");
        assert!((f64::from(follow_up.0) + yaw).abs() < 1e-6, "{follow_up:?} for a yaw of {degrees}");
    }
}

#[test]
fn what_is_no_rotation_is_none() {
    let none = |q: [f32; 4]| attitude_from_ned_quaternion(q).is_none() && follow_up_from_gimbal_quaternion(q).is_none();
    assert!(none([0.0; 4]) && none([2.0, 0.0, 0.0, 0.0]) && none([0.8, 0.0, 0.0, 0.0]));
    for place in 0..4 {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            let mut q = [1.0, 0.0, 0.0, 0.0];
            q[place] = bad;
            assert!(none(q), "{q:?}");
        }
    }
}

#[test]
fn centres_are_at_half_the_size_less_one() {
    assert_eq!(centred(0.0, 0.0, 512, 480), (-255.5, 239.5));
    assert_eq!(centred(511.0, 479.0, 512, 480), (255.5, -239.5));
    assert_eq!(centred(2.0, 1.0, 5, 3), (0.0, 0.0));
    assert_eq!(pixel(-255.5, 239.5, 512, 480), (0.0, 0.0));
}
