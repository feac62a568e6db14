//! Flights in which something fails for a time: no fix is wrong, and fixes come again behind it.

use plumbline_sim::link::Link;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::scenario::{Camera, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Linked, Scored, score, summarise};
use plumbline_sim::setup::Setup;

/// Frames of a flight, four a second, and those during which something fails. The first is taken at 3 s.
const FRAMES: u32 = 200;
const FAILING: std::ops::Range<usize> = 68..128;
const FAILING_S: &str = "20..35";
/// Frames within which fixes come again: two seconds.
const AGAIN: usize = 8;

/// What became of a flight.
struct Flown {
    wrong: usize,
    /// Frames by the reason that they have no fix for.
    refused: std::collections::BTreeMap<String, usize>,
    scored: Vec<Scored>,
}

impl Flown {
    fn accepted(&self, frames: std::ops::Range<usize>) -> usize {
        self.scored[frames].iter().filter(|scored| scored.accepted).count()
    }

    /// At least so many percent of the frames from this one on have fixes.
    fn is_as_ever_from(&self, frame: usize, percent: usize) {
        let (fixed, frames) = (self.accepted(frame..FRAMES as usize), FRAMES as usize - frame);
        assert!(fixed * 100 >= percent * frames, "{fixed} of {frames}");
    }
}

/// A vehicle with a small camera, fixed to it or followed, and with such a fault.
fn flown(fault: Option<&str>, keys: &str) -> Flown {
    flown_with(fault.map(|fault| format!("{fault}@{FAILING_S}")).as_slice(), keys)
}

/// That flight with several faults, each with its time.
fn flown_with(faults: &[String], keys: &str) -> Flown {
    flown_over(5, faults, keys)
}

/// Likewise, of another seed: over other ground.
fn flown_over(seed: u64, faults: &[String], keys: &str) -> Flown {
    let text = format!("seed = {seed}\nframes = {FRAMES}\nsend_patches = false\n{keys}\n");
    let mut scenario = Scenario::parse(&text, "faults", std::path::Path::new(""), None).expect("sound");
    scenario.camera = Camera::of_size(128, 128);
    scenario.vehicle.attitude.drift_deg = 0.2;
    let heading_deg = &mut scenario.vehicle.attitude.heading_drift_deg;
    *heading_deg = heading_deg.or(Some(0.5));
    for fault in faults {
        scenario.faults.timed.push(fault.parse().expect("a fault"));
    }
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let (mut link, mut unrectified) = (InProcess::new(&setup.flash).expect("it boots"), Unrectified::default());
    let flight = fly(&setup, &mut link, Keep::default(), &mut unrectified).expect("it flies");
    let scored = score(&setup, &flight, &unrectified);
    let linked = Linked { name: "inproc".into(), firmware_sha256: None, account: link.account() };
    let summary = summarise(&setup, &flight, &scored, &linked);
    Flown { wrong: summary.wrong_fixes, refused: summary.refused, scored }
}

/// No fix is wrong, at least this share of the frames is fixed while it fails, and those behind it from two seconds on as ever; the flight.
fn holds(fault: &str, keys: &str, during: f64) -> Flown {
    let flown = flown(Some(fault), keys);
    assert_eq!(flown.wrong, 0, "{fault}");
    let fixed = flown.accepted(FAILING) as f64 / FAILING.len() as f64;
    assert!(fixed >= during, "{fault}: {fixed} of the frames");
    flown.is_as_ever_from(FAILING.end + AGAIN, 95);
    flown
}

#[test]
fn a_laser_that_fails_costs_no_fixes() {
    for fault in ["range.off", "range.stuck", "range.scale=1.1", "range.scale=1.3", "range.bias=-10"] {
        holds(fault, "", 0.95);
    }
    // Rocking, some frames are not matched: that must not bring the hung range back.
    holds("range.stuck", "flight.tilt_max_deg = 20", 0.95);
    // Little enough to be ground that rises.
    holds("range.scale=1.05", "", 0.9);
}

#[test]
fn an_attitude_that_fails_makes_no_wrong_fix() {
    holds("attitude.bias=3", "", 0.0);
    // It jumps as it begins: some frames until pictures have shown how far.
    holds("attitude.bias=1", "", 0.9);
    // It jumps as it begins, and until the velocity is known again a swing could pass for its error: 14 frames.
    holds("attitude.scale=1.1", "", 0.7);
}

/// What else fails meanwhile says nothing of the attitude: it remains in doubt, until pictures show it right again.
#[test]
fn a_doubt_outlasts_what_interrupts_the_velocities() {
    for meanwhile in ["link.off@24..34", "position.stuck_position@28..28.4", "position.off@24..34"] {
        let flown = flown_with(&["attitude.bias=3@20..40".to_owned(), meanwhile.to_owned()], "");
        let failing = FAILING.start..FAILING.end + 20;
        assert_eq!((flown.wrong, flown.accepted(failing)), (0, 0), "{meanwhile}");
        flown.is_as_ever_from(FAILING.end + 20 + AGAIN, 95);
    }
}

/// Behind some seconds without a match the position is as uncertain as the jump of one.
#[test]
fn a_jump_does_not_hide_where_nothing_is_matched() {
    let rocking = "flight.tilt_max_deg = 20";
    for (blind, value, keys) in [
        ("camera.dead_rows=100@18..26", 3, ""),
        ("camera.dead_rows=100@18..26", 3, rocking),
        ("camera.dead_rows=100@18..26", 9, ""),
        ("attitude.off@14..26", 3, ""),
        ("attitude.off@14..26", 3, rocking),
    ] {
        let flown = flown_with(&[blind.to_owned(), format!("attitude.bias={value}@22..36")], keys);
        assert_eq!(flown.wrong, 0, "{blind} {value} {keys}");
        let again = FAILING.end + 4 + if value > 3 { 4 * AGAIN } else { AGAIN };
        flown.is_as_ever_from(again, 95);
    }
}

/// Behind such a gap a frame whose picture does not show the tilt at all has no fix.
#[test]
fn a_picture_that_does_not_answer_makes_no_fix() {
    for seed in [51, 56] {
        let faults = ["attitude.off@14..26", "attitude.bias=3@22..36"].map(str::to_owned);
        let flown = flown_over(seed, &faults, "flight.tilt_max_deg = 20");
        assert!(flown.wrong == 0 && flown.accepted(0..FRAMES as usize) > 80, "{seed}: {}", flown.wrong);
    }
}

/// What pictures show goes on counting as long as they show it.
#[test]
fn a_jump_that_pictures_show_is_not_forgotten() {
    for seed in [141, 142] {
        let faults = ["camera.dead_rows=100@18..26", "attitude.bias=6@22..60"].map(str::to_owned);
        assert_eq!(flown_over(seed, &faults, "flight.tilt_max_deg = 5").wrong, 0, "{seed}");
    }
}

/// No turn tells: the perspective of the pictures does.
#[test]
fn pictures_show_within_two_seconds_that_an_attitude_is_right_again() {
    let rocking = "flight.tilt_max_deg = 20";
    for fault in ["attitude.bias=3", "attitude.bias=9", "attitude.scale=1.3", "attitude.delayed=300", "heading.bias=20"]
    {
        holds(fault, rocking, 0.0);
    }
}

#[test]
fn a_heading_that_fails_makes_no_wrong_fix() {
    let fixed = "[follow_up]\nmode = \"fixed\"";
    holds("heading.bias=3", fixed, 0.5);
    holds("heading.bias=10", fixed, 0.0);
    holds("heading.stuck", fixed, 0.0);
}

#[test]
fn a_compass_that_is_known_to_be_poor_is_corrected_by_the_turn_of_the_picture() {
    // Beside a drift of its own of 4 degrees, which the board is told; the fault begins before the first frame.
    let keys = "[follow_up]\nmode = \"fixed\"\n[[fault]]\nunit = \"heading\"\ntype = \"bias\"\nvalue = 5.0";
    let mut poor = keys.to_owned();
    poor.insert_str(0, "[attitude]\nheading_drift_deg = 4.0\n");
    let flown = flown(None, &poor);
    assert_eq!(flown.wrong, 0);
    assert!(flown.accepted(8..FRAMES as usize) >= 180, "{}", flown.accepted(8..FRAMES as usize));
}

/// A frame that waits for its attitude while the clock makes its step has a stamp of the clock before.
#[test]
fn a_clock_that_makes_a_step_makes_no_wrong_fix() {
    let rocking = "flight.tilt_max_deg = 20";
    holds("clock.offset=-200", rocking, 0.0);
    let stepped = holds("clock.offset=200", rocking, 0.0);
    assert!(stepped.refused.get("uncertain_clock").is_some_and(|count| *count > 0), "{:?}", stepped.refused);
    // So far off the attitude still arrives in time, and is of another instant.
    let late = flown(Some("clock.offset=150"), rocking);
    assert_eq!((late.wrong, late.accepted(FAILING)), (0, 0));
}

/// What it says under fresh stamps while it hangs is no velocity that the vehicle is reckoned on with.
#[test]
fn a_position_that_hangs_leaves_nothing_behind() {
    for fault in ["position.stuck", "position.stuck_position"] {
        holds(fault, "", 0.0);
    }
    // For so short a time that the way over it would be reckoned by the velocities around it, rocking and in bends.
    let short =
        "flight.tilt_max_deg = 20\n[[fault]]\nunit = \"position\"\ntype = \"stuck\"\nfrom_s = 20.0\nto_s = 25.0";
    let hung = flown(None, short);
    assert_eq!(hung.wrong, 0);
    hung.is_as_ever_from(FAILING.start + 20 + AGAIN, 95);
}

#[test]
fn a_camera_that_hangs_makes_no_fix() {
    let hung = flown(Some("camera.repeated"), "");
    assert_eq!((hung.wrong, hung.accepted(FAILING.start + 1..FAILING.end - 1)), (0, 0));
    holds("camera.repeated", "", 0.0);
}

/// Frames wait for the angle for longer than attitudes are kept.
#[test]
fn an_encoder_that_is_gone_is_what_is_told() {
    let flown = holds("encoder.off", "follow_up.mode = \"measured\"", 0.0);
    assert_eq!(flown.refused.get("no_follow_up"), Some(&FAILING.len()), "{:?}", flown.refused);
}

/// An encoder's error looks like one of the heading, and moves the nadir as the vehicle leans.
#[test]
fn an_encoder_that_is_off_is_in_the_sigma_of_fixes() {
    let flown = flown(Some("encoder.bias=3.5"), "flight.tilt_max_deg = 20\nfollow_up.mode = \"measured\"");
    let fixed: Vec<f64> =
        flown.scored[FAILING].iter().filter_map(|scored| scored.nees.filter(|_| scored.accepted)).collect();
    assert_eq!(flown.wrong, 0);
    assert!(fixed.len() >= 20, "{}", fixed.len());
    let (mean, worst) = (fixed.iter().sum::<f64>() / fixed.len() as f64, fixed.iter().copied().fold(0.0, f64::max));
    assert!(mean < 4.0 && worst < 23.0, "{mean} {worst}");
}
