//! Image motion (paper 000): the oracle against tables G and H, the core against both and against the oracle's exact
//! track, at any attitude. Then the known mistakes: each must miss.

use plumbline_core::camera::Camera;
use plumbline_core::motion::first_order::Stabilised;
use plumbline_core::motion::{Flow, ImageMotion, MotionError, Moving, Rates, Velocity, image_motion};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use plumbline_sim::oracle;
use plumbline_sim::oracle::motion::{Exterior, Photo, ground_from_image, intersect};
use plumbline_tests::mutants;
use plumbline_tests::seeded::Random;
use plumbline_tests::vectors::{list, miss, number, rows};
use serde_json::Value;

/// Nine digits of up to 12.3 um, in mm.
const GOLDEN_MM: f64 = 1e-10;

/// The photo of a row of table G, its image point in mm, its height and its exposure.
fn photo_g(row: &Value) -> (Photo, [f64; 2], f64, f64) {
    let angles: [f64; 3] = list(row, "ang_deg");
    let rates: [f64; 3] = list(row, "rate_deg_s");
    let height_m = number(row, "HA");
    let photo = Photo {
        opening: Exterior { station_m: [0.0, 0.0, height_m], angles_rad: angles.map(f64::to_radians) },
        rates_rad_s: rates.map(f64::to_radians),
        speed_m_s: number(row, "V"),
        focal: number(row, "f_mm"),
    };
    (photo, [number(row, "x_mm"), number(row, "y_mm")], height_m, 1e-3 * number(row, "t_ms"))
}

fn golden_mm(row: &Value, key: &str) -> [f64; 2] {
    let um: [f64; 2] = list(row, key);
    um.map(|um| 1e-3 * um)
}

#[test]
fn golden_g_exact_and_first_order() {
    for row in rows("000", "G_eq21") {
        let (photo, point, height_m, t_s) = photo_g(&row);
        let ground = photo.opening.ground(photo.focal, point, 0.0).expect("below the horizon");
        let exact = photo.exact(ground, t_s).expect("in front");
        assert!(miss(exact, golden_mm(&row, "exact_um")) < GOLDEN_MM, "{exact:?} for {row}");
        let first = photo.first_order(point, height_m, t_s);
        assert!(miss(first, golden_mm(&row, "eq21_um")) < GOLDEN_MM, "{first:?} for {row}");
    }
}

/// Single precision: some fifteen roundings of terms up to 12 um leave 1e-5 um.
#[test]
fn golden_g_by_the_core() {
    for row in rows("000", "G_eq21") {
        let (photo, [x, y], height_m, t_s) = photo_g(&row);
        let single = |values: [f64; 3]| values.map(|value| value as f32);
        let core = Stabilised {
            angles: single(photo.opening.angles_rad),
            rates: single(photo.rates_rad_s),
            velocity_per_height: (photo.speed_m_s / height_m) as f32,
            focal: photo.focal as f32,
        };
        let (ex, ey) = core.displacement(x as f32, y as f32, t_s as f32);
        let off = miss([ex.into(), ey.into()], golden_mm(&row, "eq21_um"));
        assert!(off < 1e-8, "{off} mm off for {row}");
    }
}

#[test]
fn every_wrong_eq_21_misses_a_golden_row() {
    for (name, mutant) in mutants::EQ21 {
        let worst = rows("000", "G_eq21").iter().fold(0.0f64, |worst, row| {
            let (photo, point, height_m, t_s) = photo_g(row);
            let Photo { opening, rates_rad_s, speed_m_s, focal } = photo;
            let moved = mutant(point, opening.angles_rad, rates_rad_s, speed_m_s / height_m, focal).map(|v| v * t_s);
            worst.max(miss(moved, golden_mm(row, "eq21_um")))
        });
        assert!(worst > 1e-6, "{name} passes: {worst} mm");
    }
    // The printed (1,1) is the column that the vectors give for it.
    for row in rows("000", "G_eq21") {
        let (photo, point, height_m, t_s) = photo_g(&row);
        let Photo { opening, rates_rad_s, speed_m_s, focal } = photo;
        let printed = mutants::eq24_printed(point, opening.angles_rad, rates_rad_s, speed_m_s / height_m, focal);
        assert!(miss(printed.map(|v| v * t_s), golden_mm(&row, "printed_um")) < GOLDEN_MM, "{row}");
    }
}

/// With -cos omega in (3,3), as printed, R turns nothing into a mirror: the ground lies behind the lens.
#[test]
fn the_rotation_is_one() {
    assert_eq!(ground_from_image([0.0; 3]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let r = ground_from_image([0.3, -0.2, 1.1]);
    let [a, b, c] = r;
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    assert!((a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2] - 1.0).abs() < 1e-15);
}

/// The two photos of table H.
fn photos_h() -> [Photo; 2] {
    [0.0, 0.4 * 44.8 / 120.0 * 2000.0].map(|y| Photo {
        opening: Exterior { station_m: [0.0, y, 2000.0], angles_rad: [0.5f64.to_radians(); 3] },
        rates_rad_s: [0.3f64.to_radians(); 3],
        speed_m_s: 110.0 / 3.6,
        focal: 120.0,
    })
}

/// Image points with nine digits are good to 5e-8 mm, 8e-7 m on the ground; heights are worse by H over base, 7.
#[test]
fn golden_h_intersection() {
    for row in rows("000", "H_intersection") {
        let [first, second] = photos_h();
        let stamps: [f64; 2] = list(&row, "stamp_ms");
        let points: [[f64; 2]; 2] = [list(&row, "img1_mm"), list(&row, "img2_mm")];
        let [s1, s2] = stamps.map(|ms| 1e-3 * ms);
        let found = intersect(120.0, [(first.at(s1), points[0]), (second.at(s2), points[1])]).expect("a base");
        assert!(miss(found, list(&row, "out")) < 1e-5, "{found:?} for {row}");
        let wrong = intersect(120.0, [(first.at(0.0), points[0]), (second.at(0.0), points[1])]).expect("a base");
        assert!(s1 == 0.0 && s2 == 0.0 || miss(wrong, list(&row, "out")) > 0.01, "stamps do not matter in {row}");
    }
    let [first, _] = photos_h();
    assert_eq!(intersect(120.0, [(first.at(0.0), [1.0, 2.0]), (first.at(0.0), [1.0, 2.0])]), None, "no base");
}

/// A flight's camera, core's and oracle's.
fn cameras() -> (Camera, oracle::Camera) {
    let (fov_h_rad, fov_v_rad) = (60f64.to_radians(), 47f64.to_radians());
    let fov = (Radians(fov_h_rad as f32), Radians(fov_v_rad as f32));
    let judge = oracle::Camera {
        cols: 512,
        rows: 384,
        fov_h_rad,
        fov_v_rad,
        offset_m_px: 4.0,
        offset_n_px: -7.0,
        distortion: oracle::Distortion::default(),
    };
    (Camera::new((512, 384), fov, (4.0, -7.0), None).expect("a camera"), judge)
}

/// True motion over an exposure around time 0: constant rates of all four angles, constant velocity.
#[derive(Clone, Copy, Debug)]
struct Truth {
    /// Heading, pitch, roll, follow-up angle.
    angles: [f64; 4],
    rates: [f64; 4],
    /// North, up, east.
    velocity: [f64; 3],
    height_m: f64,
}

impl Truth {
    fn random(random: &mut Random) -> Self {
        let tilt = |random: &mut Random| random.between(-30.0, 30.0).to_radians();
        let turn = |random: &mut Random| random.between(-180.0, 180.0).to_radians();
        let angles = [turn(random), tilt(random), tilt(random), turn(random)];
        let rates = [(); 4].map(|()| random.between(-25.0, 25.0).to_radians());
        let velocity = [random.between(-40.0, 40.0), random.between(-5.0, 5.0), random.between(-40.0, 40.0)];
        Truth { angles, rates, velocity, height_m: random.between(40.0, 200.0) }
    }

    fn core(&self) -> Moving {
        let [heading, pitch, roll, follow_up] = self.angles.map(|angle| Radians(angle as f32));
        let [h, p, r, f] = self.rates.map(|rate| rate as f32);
        let [north, up, east] = self.velocity.map(|speed| speed as f32);
        Moving {
            attitude: Attitude { heading, pitch, roll },
            follow_up,
            rates: Rates { heading: h, pitch: p, roll: r, follow_up: f },
            velocity: Velocity { north, up, east },
            height_m: self.height_m as f32,
        }
    }

    fn matrix(&self, t_s: f64) -> oracle::Matrix3 {
        let [h, p, r, f] = std::array::from_fn(|i| self.angles[i] + self.rates[i] * t_s);
        oracle::matrix_a(h, p, r, f)
    }

    /// Frame position at `t_s` of the ground point that is at ideal frame position `point` at time 0.
    fn seen(&self, judge: &oracle::Camera, [m, n]: [f64; 2], t_s: f64) -> [f64; 2] {
        let (k_h, k_v) = judge.tangent_per_px();
        let offset = [judge.offset_m_px, judge.offset_n_px];
        let level =
            oracle::ground_from_frame(&self.matrix(0.0), judge, m + offset[0], n + offset[1]).expect("a pinhole");
        assert!(level.in_front);
        let [north, up, east] = self.velocity.map(|speed| speed * t_s);
        let tangent = |px: f64, k: f64, moved: f64| (px * k * self.height_m - moved) / (self.height_m + up) / k;
        let (m, n) = (tangent(level.m, k_h, east), tangent(level.n, k_v, north));
        let frame = oracle::frame_from_ground(&self.matrix(t_s), judge, m, n);
        [frame.m - offset[0], frame.n - offset[1]]
    }

    /// Displacement over an exposure.
    fn moved(&self, judge: &oracle::Camera, point: [f64; 2], exposure_s: f64) -> [f64; 2] {
        let [from, to] = [-0.5, 0.5].map(|half| self.seen(judge, point, half * exposure_s));
        [to[0] - from[0], to[1] - from[1]]
    }
}

/// The core's velocity is the derivative of the collinearity equations: against central differences of the oracle's
/// track.
///
/// A difference over 2 ms is off by h² x'''/6, with x''' below 1e3 px/s³: 2e-4 px/s; single precision takes twenty
/// roundings of up to 1,500 px/s: 2e-3 px/s.
#[test]
fn flow_is_the_exact_derivative_at_any_attitude() {
    let (camera, judge) = cameras();
    let mut random = Random::new(21);
    let mut worst = 0.0f64;
    for _ in 0..500 {
        let truth = Truth::random(&mut random);
        let flow = Flow::new(&camera, &truth.core()).expect("a flight");
        let point = [random.between(-256.0, 256.0), random.between(-192.0, 192.0)];
        let (across, along) = flow.at(point[0] as f32, point[1] as f32);
        let exact = truth.moved(&judge, point, 1e-3).map(|px| px * 1e3);
        worst = worst.max(miss([across.into(), along.into()], exact));
    }
    println!("flow: at most {worst:.5} px/s off");
    assert!(worst < 3e-3, "{worst} px/s");
}

/// The largest of the whole frame, searched on a fine raster, is what corners and sides say; the displacement over 5 ms
/// is the velocity at mid-exposure times 5 ms.
#[test]
fn blur_is_the_largest_displacement_of_the_frame() {
    let (camera, judge) = cameras();
    let mut random = Random::new(22);
    for _ in 0..60 {
        let truth = Truth::random(&mut random);
        let ImageMotion { max_px, at, centre_px, exposure_max_us } =
            image_motion(&camera, &truth.core(), 5000).expect("a flight");
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let mut most = 0.0f64;
        for row in 0..=48 {
            for col in 0..=64 {
                let point = [-256.0 - 4.0 + 8.0 * f64::from(col), -192.0 + 7.0 + 8.0 * f64::from(row)];
                most = most.max(length(truth.moved(&judge, point, 5e-3)));
            }
        }
        // Eight points a side may leave 0.004 px at 20 deg/s and 60 degrees, 0.006 at this test's rates.
        assert!((f64::from(max_px) - most).abs() < 6e-3, "{max_px} instead of {most} px");
        let there = truth.moved(&judge, [f64::from(at.0) - 4.0, f64::from(at.1) + 7.0], 5e-3);
        assert!((length(there) - f64::from(max_px)).abs() < 2e-5, "{there:?} at {at:?}");
        let centre = truth.moved(&judge, [-4.0, 7.0], 5e-3);
        assert!(miss([centre_px.0.into(), centre_px.1.into()], centre) < 2e-5, "{centre_px:?} {centre:?}");
        // The longest exposure keeps the blur at half a pixel.
        let longest = image_motion(&camera, &truth.core(), exposure_max_us).expect("a flight");
        assert!((longest.max_px - 0.5).abs() < 1e-3 && !longest.exceeds_standard(), "{longest:?}");
        let longer = image_motion(&camera, &truth.core(), exposure_max_us + 100).expect("a flight");
        assert!(longer.is_blurred(), "{longer:?}");
    }
}

/// The mean of the exact track lies at the point of mid-exposure up to T² x''/24 (and T⁴ terms a thousand times
/// smaller); the start lies T x'/2 away. This is why an exposure is stamped by its middle.
#[test]
fn the_smear_centroid_is_the_point_of_mid_exposure() {
    let (_, judge) = cameras();
    let mut random = Random::new(23);
    let (mut worst, mut nearest_start) = (0.0f64, f64::INFINITY);
    let exposure_s = 5e-3;
    for _ in 0..200 {
        let truth = Truth::random(&mut random);
        let point = [random.between(-256.0, 256.0), random.between(-192.0, 192.0)];
        // Midpoint rule with 1,000 parts: its own error is T² x''/24 of a thousandth part, a million times less.
        let mut mean = [0.0; 2];
        for part in 0..1000 {
            let [x, y] = truth.seen(&judge, point, exposure_s * ((f64::from(part) + 0.5) / 1000.0 - 0.5));
            mean = [mean[0] + x / 1000.0, mean[1] + y / 1000.0];
        }
        let [before, mid, after] = [-0.5, 0.0, 0.5].map(|half| truth.seen(&judge, point, half * exposure_s));
        for axis in 0..2 {
            // T² x'' = 4 (x(-T/2) - 2 x(0) + x(T/2)), and a 24th of it.
            let bend = 4.0 * (before[axis] - 2.0 * mid[axis] + after[axis]) / 24.0;
            assert!((mean[axis] - mid[axis] - bend).abs() < 1e-3 * bend.abs() + 1e-9, "{mean:?} {mid:?} {bend}");
            worst = worst.max((mean[axis] - mid[axis]).abs());
        }
        nearest_start = nearest_start.min((mean[0] - before[0]).hypot(mean[1] - before[1]));
    }
    println!("centroid: at most {worst:.6} px from mid-exposure, the start at least {nearest_start:.3} px");
    assert!(worst < 2e-3 && nearest_start > 10.0 * worst, "{worst} {nearest_start}");
}

/// Pitch, roll and follow-up angle, at heading north, of a camera with the paper's φ, ω, κ. On axes right, forward, up,
/// R = Rφ Rω Rκ turns by −φ about forward, ω about right, κ about up; eq. 1 of paper 003 by pitch about right, roll
/// about forward, follow-up angle about up.
fn as_in_flight(angles: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = ground_from_image(angles);
    [(-b[2]).atan2(c[2]), a[2].asin(), (-a[1]).atan2(a[0])]
}

/// For small residual angles the form used in flight is eq. 21: what that leaves out is of second order, so a tenth of
/// the angles leaves a hundredth of the difference, down to what single precision does to 350 px/s.
#[test]
fn for_small_angles_both_forms_agree() {
    let side = Radians(60f32.to_radians());
    let camera = Camera::new((512, 512), (side, side), (0.0, 0.0), None).expect("a camera");
    let focal = 1.0 / camera.tangent_per_px().0;
    let mut random = Random::new(24);
    let mut worst = [0.0f32; 2];
    for (worst, size_deg) in worst.iter_mut().zip([2.0f64, 0.2]) {
        for _ in 0..300 {
            let angles = [(); 3].map(|()| random.between(-size_deg, size_deg).to_radians());
            let rates = [(); 3].map(|()| random.between(-20.0, 20.0).to_radians());
            let at = |t_s: f64| as_in_flight(std::array::from_fn(|i| angles[i] + rates[i] * t_s));
            let ([pitch, roll, follow_up], before, after) = (at(0.0), at(-1e-4), at(1e-4));
            let [d_pitch, d_roll, d_follow_up] = std::array::from_fn(|i| ((after[i] - before[i]) / 2e-4) as f32);
            let radians = |angle: f64| Radians(angle as f32);
            let moving = Moving {
                attitude: Attitude { heading: Radians(0.0), pitch: radians(pitch), roll: radians(roll) },
                follow_up: radians(follow_up),
                rates: Rates { heading: 0.0, pitch: d_pitch, roll: d_roll, follow_up: d_follow_up },
                velocity: Velocity { north: 40.0, up: 0.0, east: 0.0 },
                height_m: 150.0,
            };
            let single = |values: [f64; 3]| values.map(|value| value as f32);
            let (angles, rates) = (single(angles), single(rates));
            let paper = Stabilised { angles, rates, velocity_per_height: 40.0 / 150.0, focal };
            let (x, y) = (random.between(-256.0, 256.0) as f32, random.between(-256.0, 256.0) as f32);
            let (ex, ey) = paper.displacement(x, y, 1.0);
            let (ax, ay) = Flow::new(&camera, &moving).expect("a flight").at(x, y);
            *worst = worst.max((ex - ax).abs()).max((ey - ay).abs());
        }
    }
    println!("eq. 21 and flight: {:.4} px/s apart at 2 degrees, {:.5} at 0.2", worst[0], worst[1]);
    assert!(worst[0] < 1.5 && worst[1] < 0.011 * worst[0] + 1e-3, "{worst:?}");
}

#[test]
fn motion_that_cannot_be_is_refused() {
    let (camera, _) = cameras();
    let good = Truth::random(&mut Random::new(1)).core();
    let of = |moving: Moving| image_motion(&camera, &moving, 2000).map(|_| ());
    assert_eq!(of(good), Ok(()));
    for bad in [f32::NAN, f32::INFINITY] {
        assert_eq!(of(Moving { rates: Rates { heading: bad, ..good.rates }, ..good }), Err(MotionError::NotFinite));
        assert_eq!(of(Moving { velocity: Velocity { up: bad, ..good.velocity }, ..good }), Err(MotionError::NotFinite));
        assert_eq!(of(Moving { follow_up: Radians(bad), ..good }), Err(MotionError::NotFinite));
        assert_eq!(of(Moving { height_m: bad, ..good }), Err(MotionError::Height));
        assert_eq!(
            of(Moving { attitude: Attitude { roll: Radians(bad), ..good.attitude }, ..good }),
            Err(MotionError::Tilt)
        );
    }
    assert_eq!(of(Moving { height_m: 0.0, ..good }), Err(MotionError::Height));
    let over = Attitude { pitch: Radians(1.6), ..good.attitude };
    assert_eq!(of(Moving { attitude: over, ..good }), Err(MotionError::Tilt));
    // Nothing moves: no exposure is too long.
    let still = Moving { rates: Rates::default(), velocity: Velocity::default(), ..good };
    let motion = image_motion(&camera, &still, u32::MAX).expect("a flight");
    assert_eq!((motion.max_px, motion.exposure_max_us), (0.0, u32::MAX));
    // Rates beyond single precision are no number.
    for rates in
        [Rates { pitch: 1e30, ..good.rates }, Rates { heading: 3e38, pitch: 3e38, roll: 3e38, follow_up: 3e38 }]
    {
        assert_eq!(of(Moving { rates, ..good }), Err(MotionError::NotFinite), "{rates:?}");
    }
}
