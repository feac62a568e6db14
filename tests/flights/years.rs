//! Flights over ground that is not as the map has it: fixes come once several pieces of ground agree, and none is wrong.

use crate::built_in;
use crate::slopes::{Land, flown};
use plumbline_sim::link::Link;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::scenario::{Camera, Frame, Ground, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Scored, fixes_csv, score};
use plumbline_sim::setup::Setup;
use plumbline_survey::io::data::for_test;
use std::path::{Path, PathBuf};

/// Off by more, pixels, a fix is wrong.
const WRONG_PX: f64 = 3.0;

fn errors_px(scored: &[Scored]) -> Vec<f64> {
    let errors = scored.iter().filter(|scored| scored.accepted).filter_map(|scored| scored.error_px);
    errors.map(|[col, row]| col.hypot(row)).collect()
}

/// A level flight over a land of which the map has what is bright dark. It is some ten footprints wide.
fn in_another_state(land: &Land, seed: u64, frames: u32) -> Scenario {
    let reference = land.picture("reference.tif", |grey| 255.0 - grey);
    let mut scenario = land.scenario([0.0; 2], 1.0, seed, frames);
    scenario.run.flight.height_m = [50.0, 55.0];
    if let Ground::Ortho { reference: place, .. } = &mut scenario.world.ground {
        *place = Some(reference);
    }
    scenario
}

#[test]
fn ground_in_another_state_is_fixed_by_its_directions() {
    let land = Land::new("state");
    let (mut accepted, mut frames, mut squares) = (0, 0, 0.0);
    for seed in [61, 62] {
        let scored = flown(in_another_state(&land, seed, 160));
        let errors = errors_px(&scored);
        assert!(errors.iter().all(|&error| error <= WRONG_PX), "seed {seed}: {errors:?}");
        (accepted, frames) = (accepted + errors.len(), frames + scored.len());
        squares += errors.iter().map(|error| error * error).sum::<f64>();
        let first = scored.iter().position(|scored| scored.accepted);
        println!("seed {seed}: {} of {} frames, the first {first:?}", errors.len(), scored.len());
        // One piece of ground decides nothing.
        assert!(first.is_none_or(|first| first > 10), "{first:?}");
    }
    assert!(accepted * 10 >= frames * 4, "{accepted} of {frames}");
    // The vehicle flies in circles, and its velocity is some 0.2 s old: without the acceleration evidence is carried aside by 0.7 m/s.
    let rms_px = (squares / accepted as f64).sqrt();
    assert!(rms_px < 0.3, "{rms_px}");
}

/// The products of both kernels, and all that is added up of them.
#[test]
fn the_emulated_board_adds_up_the_same() {
    let land = Land::new("emulated");
    let setup = Setup::prepare(in_another_state(&land, 61, 90)).expect("it can be flown");
    let csv = |link: &mut dyn Link| {
        let flight = fly(&setup, link, Keep::default(), &mut ()).expect("it flies");
        let scored = score(&setup, &flight, &Unrectified::default());
        let accepted = scored.iter().filter(|scored| scored.accepted).count();
        (fixes_csv(&setup, &flight, &scored), accepted)
    };
    let host = csv(&mut InProcess::new(&setup.flash).expect("it boots"));
    assert!(host.1 > 20, "{} frames are accepted", host.1);
    // Each fix says how probable it is that it is wrong, and no refused frame does.
    for row in host.0.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>()) {
        let risk = row[14].parse::<f64>().ok();
        assert_eq!(risk.is_some_and(|risk| (9e-5..1e-3).contains(&risk)), row[2] == "1", "{row:?}");
        assert_eq!(row[14].is_empty(), row[2] == "0", "{row:?}");
    }
    let image = default_image();
    if !image.is_file() {
        eprintln!("skipped: the emulated board has no image at {} (cargo xtask build)", image.display());
        return;
    }
    let board = csv(&mut Qemu::launch(&setup.flash, &image).expect("it boots"));
    assert_eq!(host, board);
}

/// Farmland and lakes of 5 m a pixel, each year over the next one.
#[test]
fn flights_between_real_years_have_no_wrong_fix() {
    let name = "flights_between_real_years_have_no_wrong_fix";
    let picture = |date: &str| for_test(name, &format!("images/m_4709963_se_14_1_{date}.tif"));
    let dates = ["20150926", "20160816", "20170827", "20180716"];
    let Some(pictures) = dates.iter().map(|date| picture(date)).collect::<Option<Vec<PathBuf>>>() else { return };
    let mut errors = Vec::new();
    for (seed, years) in pictures.windows(2).enumerate() {
        let own = errors_px(&flown(between(&years[0], &years[1], 70 + seed as u64)));
        println!(
            "{:?}: {} of 100 frames, the worst {:.2?}",
            dates[seed],
            own.len(),
            own.iter().copied().reduce(f64::max)
        );
        errors.extend(own);
    }
    assert!(errors.iter().all(|&error| error <= WRONG_PX), "{errors:?}");
    assert!(errors.len() >= 60, "{} of 300 frames", errors.len());
}

/// All the evidence goes astray with it, and there is some top near every place.
#[test]
fn a_velocity_that_is_off_by_ten_of_its_sigmas_gives_no_wrong_fix() {
    let name = "a_velocity_that_is_off_by_ten_of_its_sigmas_gives_no_wrong_fix";
    let picture = |date: &str| for_test(name, &format!("images/m_4709963_se_14_1_{date}.tif"));
    for (ground, reference, seed) in [("20090818", "20170827", 59_004), ("20140720", "20150926", 59_016)] {
        let (Some(ground), Some(reference)) = (picture(ground), picture(reference)) else { return };
        let fault = "position.wrong_velocity=1@40..80";
        none_is_wrong(between(&ground, &reference, seed), [145.0, 155.0], fault, 30);
    }
}

/// Where frames of poor ground are not matched, the evidence of all of them goes astray over a map of the ground's own year as well.
#[test]
fn a_wrong_velocity_over_poor_ground_of_the_same_year_gives_no_wrong_fix() {
    let name = "a_wrong_velocity_over_poor_ground_of_the_same_year_gives_no_wrong_fix";
    if for_test(name, "images/m_4709963_se_14_1_20200831.tif").is_none() {
        return;
    }
    for (seed, fault) in [(66_008, "position.wrong_velocity=3@20..55"), (113_069, "position.wrong_velocity=1.5@20..55")]
    {
        let keys = ["send_patches=false", "flight.tilt_max_deg=20", "attitude.drift_deg=0.2"];
        let mut scenario = built_in::scenario("naip", &keys);
        scenario.run.seed = seed;
        none_is_wrong(scenario, [152.0, 152.0], fault, 90);
    }
}

/// What has jumped is seen by matches that follow at once, or by the peaks of frames that are not matched, and not half a minute later.
#[test]
fn an_attitude_that_begins_to_be_off_gives_no_wrong_fix() {
    let name = "an_attitude_that_begins_to_be_off_gives_no_wrong_fix";
    let picture = |date: &str| for_test(name, &format!("images/m_4709963_se_14_1_{date}.tif"));
    let flights = [
        ("20170827", "20150926", 69_038, "attitude.bias=2@40..80"),
        ("20200831", "20170827", 68_054, "attitude.bias=3@40..80"),
    ];
    for (ground, reference, seed, fault) in flights {
        let (Some(ground), Some(reference)) = (picture(ground), picture(reference)) else { return };
        none_is_wrong(between(&ground, &reference, seed), [270.0, 280.0], fault, 60);
    }
}

/// A flight of 300 frames by a small camera at such a height with a fault: no fix is wrong, and there are at least so many.
fn none_is_wrong(mut scenario: Scenario, height_m: [f64; 2], fault: &str, least: usize) {
    let seed = scenario.run.seed;
    let camera = Frame { cols: 128, rows: 128, ..Frame::default() };
    (scenario.run.frames, scenario.camera) = (300, Camera::Keys(camera));
    scenario.run.flight.height_m = height_m;
    scenario.faults.timed.push(fault.parse().expect("a fault"));
    let errors = errors_px(&flown(scenario));
    let worst = errors.iter().copied().reduce(f64::max);
    println!("seed {seed}: {} of 300 frames, the worst {worst:.2?}", errors.len());
    assert!(errors.iter().all(|&error| error <= WRONG_PX), "seed {seed}: {errors:?}");
    assert!(errors.len() > least, "seed {seed}: {} of 300 frames", errors.len());
}

fn between(ground: &Path, reference: &Path, seed: u64) -> Scenario {
    let mut scenario = Scenario::seeded(seed, 100);
    (scenario.vehicle.resolution_m, scenario.vehicle.send_patches) = (5.0, false);
    scenario.run.flight.height_m = [250.0, 280.0];
    let (ortho, reference) = (ground.to_owned(), Some(reference.to_owned()));
    scenario.world.ground = Ground::Ortho { ortho, dem: None, reference };
    scenario
}
