//! Flights over hard ground, by the built-in scenarios: each flies, gives the same fixes again, and none of them is wrong.

use crate::built_in;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::scenario::Camera;
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Linked, Summary, fixes_csv, score, summarise};
use plumbline_sim::setup::Setup;

/// Enough that three pieces of ground decide and a lost position is searched far, too, and few enough for every day.
const FRAMES: u32 = 90;

/// A built-in scenario, seen by a camera of a sixteenth of the pixels.
fn setup(name: &str) -> Setup {
    let mut scenario = built_in::scenario(name, &[&format!("frames={FRAMES}"), "send_patches=false"]);
    scenario.camera = Camera::of_size(128, 128);
    Setup::prepare(scenario).expect("it can be flown")
}

fn flown(setup: &Setup) -> (String, Summary) {
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let flight = fly(setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    let scored = score(setup, &flight, &Unrectified::default());
    let linked = Linked { name: "inproc".into(), firmware_sha256: None, account: Default::default() };
    (fixes_csv(setup, &flight, &scored), summarise(setup, &flight, &scored, &linked))
}

/// Least fixes of the frames; `None` where any would be wrong.
fn check(name: &str, least: Option<usize>) {
    let setup = setup(name);
    let (csv, summary) = flown(&setup);
    assert_eq!(csv, flown(&setup).0, "{name} flies otherwise the second time");
    println!("{name}: {} of {FRAMES} frames, {} wrong, {:?}", summary.accepted, summary.wrong_fixes, summary.refused);
    assert_eq!(summary.frames, FRAMES as usize);
    let wrong = summary.shifted.map_or(summary.wrong_fixes, |shifted| shifted.wrong_fixes);
    assert_eq!(wrong, 0, "{name}");
    match least {
        Some(least) => assert!(summary.accepted >= least, "{name}: {}", summary.accepted),
        None => assert_eq!(summary.accepted, 0, "{name}"),
    }
}

#[test]
fn land_that_repeats_is_never_mistaken() {
    check("parcels", Some(0));
    check("stripes", Some(0));
}

/// Shadows are a small part of what is seen.
#[test]
fn other_shadows_leave_most_fixes() {
    check("shadows", Some(20));
}

#[test]
fn clouds_and_haze_cost_fixes_and_make_none_wrong() {
    check("clouds", Some(2));
    check("overcast", Some(0));
    check("low_contrast", Some(5));
}

#[test]
fn changed_fields_are_matched_by_what_has_not_changed() {
    check("inverted", Some(5));
    check("seasons", Some(5));
    check("ploughed", Some(10));
    check("flooded", Some(20));
}

#[test]
fn shores_are_matched_and_waves_are_not() {
    check("shore", Some(20));
}

/// Against the map as it lies; against the truth every fix is wrong, which no single frame can know.
#[test]
fn a_shifted_map_is_matched_where_it_lies() {
    check("shifted", Some(30));
}

/// Whatever is accepted is wrong.
#[test]
fn other_ground_is_never_accepted() {
    check("wrong_tile", None);
    check("outside", None);
}
