//! A board that uses one head of a camera of four (paper 002): it looks 28 degrees aside of the platform's axis, and its fixes
//! are as good as those of a camera that looks down.

use super::{Flown, flown, flown_told, scenario};
use plumbline_sim::scenario::{Camera, FollowUpMode, Scenario};
use plumbline_survey::camera_file::{CameraFile, Head, write};
use std::path::{Path, PathBuf};

const FRAMES: u32 = 40;
/// Of the heads: 47 mm, 7228 x 5428 pixels of 6.8 um, in pixels 56 times as large.
const F_PX: f64 = 122.5;

/// Four heads of 128 x 96 pixels in the paper's arrangement, their places so much farther out.
fn camera(name: &str, wider: f64) -> PathBuf {
    let head = |side: f64, ahead: f64| Head {
        cols: 128,
        rows: 96,
        f_px: F_PX,
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: None,
        rotation_deg: [22.0 * side, 18.0 * ahead, 0.0],
        d_m: [0.045 * side * wider, 0.06 * ahead * wider, 0.0],
    };
    let fov_deg = |side: f64| 2.0 * (0.5 * side / F_PX).atan().to_degrees();
    let file = CameraFile {
        heads: vec![head(-1.0, 1.0), head(1.0, 1.0), head(-1.0, -1.0), head(1.0, -1.0)],
        ..CameraFile::new((274, 184), (fov_deg(274.0), fov_deg(184.0)))
    };
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    write(&path, &file).expect("written");
    path
}

fn of_head(head: u8, camera: &Path, frames: u32) -> Scenario {
    let mut scenario = Scenario { camera: Camera::File(camera.to_owned()), ..scenario(2, frames) };
    scenario.vehicle.head = Some(head);
    scenario
}

fn told(name: &str, flown: &Flown) -> f64 {
    let (rms_m, nees) = (flown.rms_m(), flown.nees());
    println!("{name}: {} accepted, {rms_m:.3} m off, NEES {nees:.2}", flown.accepted());
    rms_m
}

/// Fixes of the default camera's class, though a head sees about half the ground of the default camera and a tilt's error
/// reaches it by a longer way, 1/cos² of 28 degrees.
#[test]
fn a_head_gives_fixes_of_the_default_camera_s_class() {
    let camera = camera("heads.toml", 1.0);
    let down_m = told("looking down", &flown(scenario(2, FRAMES)));
    for head in [1, 4] {
        let flight = flown(of_head(head, &camera, FRAMES));
        let head_m = told(&format!("head {head}"), &flight);
        assert!(flight.accepted() >= FRAMES as usize * 9 / 10, "{} accepted", flight.accepted());
        assert!(head_m < 2.0 * down_m, "{head_m} m beside {down_m} m");
        assert!(flight.nees() < 5.0, "NEES {}", flight.nees());
    }
}

/// Another head than the one that flies is believed: nothing fits.
#[test]
fn a_head_that_is_taken_for_another_has_no_fixes() {
    let camera = camera("heads-wrong.toml", 1.0);
    let flight = flown_told(of_head(1, &camera, 12), |configuration| configuration.boresight_rad[2] *= -1.0);
    let wrong = flight.scored.iter().filter(|scored| scored.accepted).count();
    assert!(wrong == 0, "{wrong} of 12 accepted, {} m off", flight.rms_m());
}

/// Heads three metres from the middle on a camera without a servo: the board has their place in its lever arm.
#[test]
fn the_place_of_a_head_is_in_the_lever_arm() {
    let camera = camera("heads-wide.toml", 40.0);
    let fixed = |frames| {
        let mut scenario = of_head(2, &camera, frames);
        scenario.vehicle.follow_up.mode = FollowUpMode::Fixed;
        scenario
    };
    let known_m = told("place known", &flown(fixed(20)));
    let forgotten_m =
        told("place not told", &flown_told(fixed(20), |configuration| configuration.lever_arm_m = [0.0; 3]));
    assert!(known_m < 1.0 && forgotten_m > 2.5, "{known_m} {forgotten_m}");
}
