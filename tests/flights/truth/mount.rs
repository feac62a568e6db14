//! A camera far from the antenna that looks askew: the firmware that knows both is as good as without them.

use super::{Flown, flown, flown_told, scenario};
use plumbline_sim::scenario::vehicle::Mount;
use plumbline_sim::scenario::{Boresight, Scenario};
use plumbline_sim::setup::Setup;

const FRAMES: u32 = 50;
/// Two pixels of the reference, and one at 125 m.
const MOUNT: Mount =
    Mount { lever_arm_m: [8.0, -3.0, 4.0], boresight: Boresight { phi_deg: -1.0, omega_deg: -2.0, kappa_deg: -1.5 } };

fn mounted(mount: Mount, frames: u32) -> Scenario {
    let mut scenario = scenario(2, frames);
    scenario.vehicle.mount = mount;
    scenario
}

fn told(name: &str, flown: &Flown) -> f64 {
    let (rms_m, nees) = (flown.rms_m(), flown.nees());
    println!("{name}: {} accepted, {rms_m:.3} m off, NEES {nees:.2}", flown.accepted());
    rms_m
}

/// Two flights of 50 frames see the same ground from the same places, but through other pixels, so that their matching
/// errors differ: each RMS of a hundred components is good to 7 %, their ratio to 10 %; three of that. The mean of their
/// normalised squares has twice the relative spread.
#[test]
fn a_mount_that_is_known_costs_nothing() {
    let (plain, known) = (flown(mounted(Mount::default(), FRAMES)), flown(mounted(MOUNT, FRAMES)));
    let (without_m, with_m) = (told("without", &plain), told("with both", &known));
    assert!(with_m < 1.3 * without_m && with_m > without_m / 1.3);
    assert!(known.nees() < 1.6 * plain.nees() && known.nees() > plain.nees() / 1.6);
    assert!(plain.accepted() >= 48 && known.accepted() >= 48);
}

/// Eight metres and a half off where the antenna is believed in the camera, four where the camera is believed aligned. No
/// sign goes unseen, not even that of the turn about the axis: it moves what the tilts have put off the axis.
#[test]
fn a_mount_that_is_not_told_is_seen() {
    let mounted = || mounted(MOUNT, 8);
    let arm = flown_told(mounted(), |configuration| configuration.lever_arm_m = [0.0; 3]);
    assert!(told("arm not told", &arm) > 8.0);
    let turn = flown_told(mounted(), |configuration| configuration.boresight_rad = [0.0; 3]);
    assert!(told("boresight not told", &turn) > 3.5);
    for (axis, least_m) in [0.7, 7.0, 3.5].into_iter().enumerate() {
        let flipped = flown_told(mounted(), |configuration| configuration.boresight_rad[axis] *= -1.0);
        assert!(told(&format!("boresight {axis} of the other sign"), &flipped) > least_m);
    }
}

/// It is strapped to the follow-up axis beside the camera, so that the core may take its slant for that axis.
#[test]
fn the_laser_does_not_share_the_boresight() {
    let [plain, turned] = [Mount::default(), MOUNT].map(|mount| Setup::prepare(mounted(mount, 2)).expect("a setup"));
    for t_us in (3_000_000..3_500_000).step_by(100_000) {
        let state = plain.motion.state(t_us);
        assert_eq!(turned.slant_m(&state), plain.slant_m(&state));
        assert_ne!(turned.station(&state).axes(), plain.station(&state).axes());
    }
}
