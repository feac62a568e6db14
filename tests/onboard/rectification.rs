//! The core (f32) against the golden values of paper 003: tables A to E, eq. 6, and the known mistakes.
//!
//! Tolerances: 1e-3 px, 1e-4 degrees, 1e-4 cells. Single precision at 600 px from the centre has steps of 6e-5 px and
//! eq. 3 about ten roundings; degrees near 180 have steps of 1.5e-5. A mistake must miss by ten tolerances.

use plumbline_core::camera::{Camera, CameraError};
use plumbline_core::homography::Homography;
use plumbline_core::tilt::{Attitude, EquivalentTilt, camera_from_local, equivalent_tilt, follow_up_command};
use plumbline_core::units::Radians;
use plumbline_sim::oracle;
use plumbline_tests::mutants;
use plumbline_tests::vectors::{list, miss, number, rows, turn_deg};
use serde_json::Value;

const PIXELS: f64 = 1e-3;
const DEGREES: f64 = 1e-4;
const CELLS: f64 = 1e-4;
/// By how many tolerances a mistake must miss.
const MISS: f64 = 10.0;

fn angle(row: &Value, key: &str) -> Radians {
    Radians(number(row, key).to_radians() as f32)
}

fn attitude_of(row: &Value) -> Attitude {
    Attitude { heading: angle(row, "phi"), pitch: angle(row, "theta"), roll: angle(row, "gamma") }
}

fn camera(side: u16, (fov_h_deg, fov_v_deg): (f64, f64), offset: (f32, f32)) -> Camera {
    let fov = |deg: f64| Radians(deg.to_radians() as f32);
    Camera::new((side, side), (fov(fov_h_deg), fov(fov_v_deg)), offset, None).expect("a camera")
}

/// The camera of a row of table B (VH, VV) or C (V), as the core and as the oracle have it.
fn cameras_of(row: &Value) -> (Camera, oracle::Camera) {
    let (h, v) = if row["V"].is_null() { ("VH", "VV") } else { ("V", "V") };
    let (fov_h, fov_v, m0, n0) = (number(row, h), number(row, v), number(row, "m0"), number(row, "n0"));
    let side = number(row, "M") as usize;
    let judge = oracle::Camera {
        cols: side,
        rows: side,
        fov_h_rad: fov_h.to_radians(),
        fov_v_rad: fov_v.to_radians(),
        offset_m_px: m0,
        offset_n_px: n0,
        distortion: oracle::Distortion::default(),
    };
    (camera(side as u16, (fov_h, fov_v), (m0 as f32, n0 as f32)), judge)
}

/// Frame pixel (m', n') of the undistorted pixel of a row.
fn mapped(homography: &Homography, camera: &Camera, row: &Value) -> [f64; 2] {
    let (m, n) = homography.ideal(number(row, "m") as f32, number(row, "n") as f32).expect("in front of the camera");
    let (m, n) = camera.distorted(m, n);
    [m.into(), n.into()]
}

/// Eq. 3 by the core for a row of table B.
fn eq3(row: &Value) -> [f64; 2] {
    let (camera, _) = cameras_of(row);
    let a = camera_from_local(attitude_of(row), follow_up_of(row));
    mapped(&Homography::full(&a, &camera), &camera, row)
}

fn follow_up_of(row: &Value) -> Radians {
    row["beta"].as_f64().map_or_else(|| follow_up_command(attitude_of(row)), |deg| Radians(deg.to_radians() as f32))
}

/// Eq. 7 by the core for a row of table C.
fn eq7(row: &Value) -> [f64; 2] {
    let (camera, _) = cameras_of(row);
    let tilt = EquivalentTilt { pitch: angle(row, "theta1"), roll: angle(row, "gamma1") };
    mapped(&Homography::simplified(tilt, &camera), &camera, row)
}

/// Follow-up angle, equivalent pitch and roll by the core for a row of table A, degrees.
fn eq5(row: &Value) -> [f64; 3] {
    let attitude = attitude_of(row);
    let follow_up = follow_up_command(attitude);
    let tilt = equivalent_tilt(attitude, follow_up);
    [follow_up, tilt.pitch, tilt.roll].map(|angle| f64::from(angle.0).to_degrees())
}

/// How far two answers of eq. 5 are apart; the follow-up angle counts the short way round.
fn miss_eq5(a: [f64; 3], b: [f64; 3]) -> f64 {
    miss([turn_deg(a[0], b[0]), a[1], a[2]], [0.0, b[1], b[2]])
}

#[test]
fn golden_a_follow_up_and_equivalent_tilt() {
    for row in rows("003", "A_followup") {
        let ours = eq5(&row);
        assert!(miss_eq5(ours, list(&row, "out")) < DEGREES, "{ours:?} for {row}");
    }
}

#[test]
fn golden_b_eq_3() {
    for row in rows("003", "B_eq3") {
        let ours = eq3(&row);
        assert!(miss(ours, list(&row, "out")) < PIXELS, "{ours:?} for {row}");
        assert!(miss(ours, list(&row, "printed")) > MISS * PIXELS, "the misprint is met: {ours:?} for {row}");
    }
}

#[test]
fn golden_c_eq_7() {
    for row in rows("003", "C_eq7") {
        let ours = eq7(&row);
        assert!(miss(ours, list(&row, "out")) < PIXELS, "{ours:?} for {row}");
        assert!(miss(ours, list(&row, "printed")) > MISS * PIXELS, "the misprint is met: {ours:?} for {row}");
    }
}

#[test]
fn golden_d_patch_size() {
    for row in rows("003", "D_size") {
        let camera = camera(512, (number(&row, "VH"), number(&row, "VV")), (0.0, 0.0));
        let (cols, lines) = camera.patch_size(number(&row, "H") as f32, number(&row, "R") as f32);
        assert!(miss([cols.into(), lines.into()], list(&row, "out")) < CELLS, "{cols} x {lines} for {row}");
    }
}

#[test]
fn golden_e_the_frame_centre_on_the_ground() {
    for row in rows("003", "E_centre") {
        let camera = camera(512, (60.0, 60.0), (0.0, 0.0));
        let attitude = Attitude { heading: Radians(0.0), pitch: angle(&row, "theta"), roll: angle(&row, "gamma") };
        let back = Homography::inverse(&camera_from_local(attitude, Radians(0.0)), &camera);
        let (m, n) = back.ideal(0.0, 0.0).expect("in front of the camera");
        let cells_per_px = f64::from(camera.tangent_per_px().0) * number(&row, "H") / number(&row, "R");
        // The table is signed as the paper prints it: a roll to the right looks to the left.
        let ours = [-f64::from(m) * cells_per_px, f64::from(n) * cells_per_px];
        assert!(miss(ours, list(&row, "out")) < CELLS, "{ours:?} for {row}");
        assert!(miss(ours, list(&row, "half_px")) > MISS * CELLS, "the half pixel is in: {ours:?} for {row}");
    }
}

/// Attitudes all round the compass with a follow-up angle that follows badly; the tilt up to `most_deg` an axis.
fn attitudes(most_deg: f32) -> Vec<(Attitude, Radians)> {
    let mut all = Vec::new();
    for heading in (0..360).step_by(37) {
        for pitch in [-1.0f32, -0.3, 0.0, 0.4, 0.9] {
            for roll in [-0.9f32, -0.35, 0.0, 0.2, 1.0] {
                let attitude = Attitude {
                    heading: Radians::from_degrees(heading as f32),
                    pitch: Radians::from_degrees(pitch * most_deg),
                    roll: Radians::from_degrees(roll * most_deg),
                };
                let lag = 0.3 * (3.0 * attitude.heading.0).sin();
                all.push((attitude, Radians(follow_up_command(attitude).0 + lag)));
            }
        }
    }
    all
}

/// Eq. 6 undoes eq. 3. The way back magnifies a rounding by up to 1/den² (den of the way back), so that is the scale.
#[test]
fn eq_6_undoes_eq_3() {
    let camera = Camera::new((640, 480), (Radians::from_degrees(63.0), Radians::from_degrees(41.0)), (0.0, 0.0), None)
        .expect("a camera");
    let (mut inside, mut worst) = (0, 0.0f32);
    for (attitude, follow_up) in attitudes(40.0) {
        let a = camera_from_local(attitude, follow_up);
        let (there, back) = (Homography::full(&a, &camera), Homography::inverse(&a, &camera));
        for (m, n) in [(0.0, 0.0), (150.0, 99.5), (-319.5, 100.25), (17.0, -239.5), (-200.0, -150.0)] {
            let Some((m_frame, n_frame)) = there.ideal(m, n) else { continue };
            if m_frame.abs() > 320.0 || n_frame.abs() > 240.0 {
                continue;
            }
            let (m_back, n_back) = back.ideal(m_frame, n_frame).expect("what was seen lies in front");
            let den = back.denominator(m_frame, n_frame);
            let off = (m_back - m).abs().max((n_back - n).abs()) * den * den;
            inside += 1;
            worst = worst.max(off);
            assert!(off < 1e-3, "({m}, {n}) comes back as ({m_back}, {n_back}) for {attitude:?}, {follow_up:?}");
        }
    }
    println!("eq. 6 round trip: {inside} points, at most {worst:.1e} px (scaled by den²)");
    assert!(inside > 400, "only {inside} points lay in the frame");
}

/// Eq. 7 is eq. 3 for a camera that follows, and a22 is the product of the cosines whatever heading and follow-up.
#[test]
fn eq_7_is_eq_3_when_followed() {
    let camera = camera(512, (60.0, 60.0), (0.0, 0.0));
    for (attitude, lagging) in attitudes(30.0) {
        let followed = follow_up_command(attitude);
        let full = Homography::full(&camera_from_local(attitude, followed), &camera);
        let simplified = Homography::simplified(equivalent_tilt(attitude, followed), &camera);
        for (m, n) in [(0.0, 0.0), (120.0, -80.0), (-255.5, 255.5)] {
            let (Some(a), Some(b)) = (full.ideal(m, n), simplified.ideal(m, n)) else { continue };
            let scale = f64::from(a.0.abs().max(a.1.abs()).max(256.0)) / 256.0;
            let off = miss([a.0.into(), a.1.into()], [b.0.into(), b.1.into()]);
            assert!(off < PIXELS * scale * scale, "{a:?} by eq. 3, {b:?} by eq. 7 for {attitude:?}");
        }
        let a22 = camera_from_local(attitude, lagging)[(1, 1)];
        assert!((a22 - attitude.cos_tilt()).abs() < 1e-6, "{a22} for {attitude:?}");
    }
}

#[test]
fn cameras_that_cannot_be_are_refused() {
    let new = |size, h: f32, v: f32, offset| Camera::new(size, (Radians(h), Radians(v)), offset, None);
    assert_eq!(new((0, 480), 1.0, 1.0, (0.0, 0.0)), Err(CameraError::Size));
    assert_eq!(new((640, 9000), 1.0, 1.0, (0.0, 0.0)), Err(CameraError::Size));
    for bad in [0.0, -1.0, 3.2, f32::NAN, f32::INFINITY] {
        assert_eq!(new((640, 480), bad, 1.0, (0.0, 0.0)), Err(CameraError::FieldOfView), "{bad}");
        assert_eq!(new((640, 480), 1.0, bad, (0.0, 0.0)), Err(CameraError::FieldOfView), "{bad}");
    }
    assert_eq!(new((640, 480), 1.0, 1.0, (f32::NAN, 0.0)), Err(CameraError::NotFinite));
    assert_eq!(new((640, 480), 1.0, 1.0, (0.0, f32::INFINITY)), Err(CameraError::NotFinite));
}

fn assert_misses(name: &str, tolerance: f64, worst: f64) {
    println!("{name}: the core differs by up to {worst:.4}, tolerance {tolerance}");
    assert!(worst > MISS * tolerance, "the core gives the same as: {name}");
}

/// The core differs from every mutant where the mutant is wrong, by far more than the tolerances above.
#[test]
fn the_core_is_no_mutant() {
    let table = rows("003", "B_eq3");
    let radians = |row: &Value, key: &str| number(row, key).to_radians();
    for (name, matrix) in mutants::MATRICES {
        let worst = table.iter().map(|row| {
            let beta = f64::from(follow_up_of(row).0);
            let a = matrix(radians(row, "phi"), radians(row, "theta"), radians(row, "gamma"), beta);
            let p = oracle::frame_from_ground(&a, &cameras_of(row).1, number(row, "m"), number(row, "n"));
            miss(eq3(row), [p.m, p.n])
        });
        assert_misses(name, PIXELS, worst.fold(0.0, f64::max));
    }
    let worst = table.iter().map(|row| {
        let beta = f64::from(follow_up_of(row).0);
        let a = oracle::matrix_a(radians(row, "phi"), radians(row, "theta"), radians(row, "gamma"), beta);
        let (at, offset) = ((number(row, "m"), number(row, "n")), (number(row, "m0"), number(row, "n0")));
        let (m, n) = mutants::eq3_printed(&a, cameras_of(row).1.tangent_per_px(), at, offset);
        miss(eq3(row), [m, n])
    });
    assert_misses("eq. 3 as printed", PIXELS, worst.fold(0.0, f64::max));

    for (name, map) in mutants::EQ7 {
        let worst = rows("003", "C_eq7").into_iter().map(|row| {
            let (at, offset) = ((number(&row, "m"), number(&row, "n")), (number(&row, "m0"), number(&row, "n0")));
            let k = cameras_of(&row).1.tangent_per_px().0;
            let (m, n) = map(radians(&row, "theta1"), radians(&row, "gamma1"), k, at, offset);
            miss(eq7(&row), [m, n])
        });
        assert_misses(name, PIXELS, worst.fold(0.0, f64::max));
    }

    for (name, follow) in mutants::FOLLOW_UPS {
        let worst = rows("003", "A_followup").into_iter().map(|row| {
            let mutant = follow(radians(&row, "phi"), radians(&row, "theta"), radians(&row, "gamma"));
            miss_eq5(mutant.map(f64::to_degrees), eq5(&row))
        });
        assert_misses(name, DEGREES, worst.fold(0.0, f64::max));
    }
}
