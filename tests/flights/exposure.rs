//! Auto exposure in flight: two stops more and less light, and a dawn, against the same flight in steady light; what a fixed
//! exposure comes to there; and that links agree.

use plumbline_sim::link::Link;
use plumbline_sim::link::device::Device;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::link::serial::Serial;
use plumbline_sim::run::{FrameRecord, Keep, fly};
use plumbline_sim::scenario::{Camera, EdgeSource, Light, Scenario};
use plumbline_sim::score::stamps::stamps;
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Linked, fixes_csv, score, summarise};
use plumbline_sim::setup::Setup;

/// What a flight came to.
struct Flown {
    frames: Vec<FrameRecord>,
    accepted: usize,
    wrong: usize,
    /// Longest displacement in any frame, pixels.
    blur_px: f64,
}

/// 75 s: the 60 s of the dawn, and some of the day.
const FRAMES: u32 = 300;

/// The default scene seen by a camera of a quarter of the pixels, which is rendered in as much less time. Each frame is the mean of
/// three instants of its exposure, so that blur is there.
fn scenario(light: Light, is_on: bool) -> Scenario {
    let mut scenario = Scenario::seeded(5, FRAMES);
    scenario.camera = Camera::of_size(256, 256);
    (scenario.vehicle.auto_exposure.is_on, scenario.world.light) = (is_on, light);
    (scenario.vehicle.send_patches, scenario.world.exposure_samples) = (false, 3);
    scenario
}

fn flown(name: &str, scenario: Scenario) -> Flown {
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    let scored = score(&setup, &flight, &Unrectified::default());
    let linked = Linked { name: "inproc".into(), firmware_sha256: None, account: Default::default() };
    let summary = summarise(&setup, &flight, &scored, &linked);
    let (accepted, wrong) = (summary.accepted, summary.wrong_fixes);
    println!("{name}: {accepted} fixes, {wrong} wrong, {:?}, {:?}", summary.exposure_us, summary.refused);
    Flown { frames: flight.frames, accepted, wrong, blur_px: summary.blur.max_px.expect("motion") }
}

fn steady(stops: f64) -> Light {
    Light { stops, ..Light::default() }
}

/// Dawn: three stops too dark at first, and a minute until it is light.
fn dawn() -> Light {
    Light { from_stops: -3.0, over_s: Some(60.0), ..Light::default() }
}

/// Least fixes that a light may leave of those in steady nominal light: 2 % fewer.
fn enough(nominal: &Flown) -> usize {
    (nominal.accepted * 98).div_ceil(100)
}

#[test]
fn fixes_go_on_in_any_light() {
    let nominal = flown("nominal", scenario(steady(0.0), true));
    assert!(nominal.accepted >= 290 && nominal.wrong == 0);
    for (name, light) in [("two stops darker", steady(-2.0)), ("two stops brighter", steady(2.0)), ("dawn", dawn())] {
        let controlled = flown(name, scenario(light, true));
        assert!(controlled.wrong == 0 && controlled.accepted >= enough(&nominal), "{name}");
        assert!(controlled.blur_px < 2.0, "{name}: {} px", controlled.blur_px);
    }
}

/// What it is for: a frame that is white at most places shows little, and what several of them show together makes good a part of that.
#[test]
fn a_fixed_exposure_loses_many_fixes_in_brighter_light() {
    let fixed = flown("two stops brighter, fixed", scenario(steady(2.0), false));
    let controlled = flown("two stops brighter", scenario(steady(2.0), true));
    assert!(fixed.wrong == 0 && 3 * fixed.accepted < 2 * controlled.accepted);
}

/// In the dark it costs little: greys are few, but there. It must not cost wrong fixes.
#[test]
fn a_fixed_exposure_in_the_dark() {
    for (name, light) in [("two stops darker, fixed", steady(-2.0)), ("dawn, fixed", dawn())] {
        let fixed = flown(name, scenario(light, false));
        assert!(fixed.wrong == 0 && fixed.accepted > 0);
    }
}

/// Stamps go by the commanded exposure where one edge or none is there to measure it.
#[test]
fn stamps_are_as_good_while_the_exposure_moves() {
    for edges in [EdgeSource::Both, EdgeSource::One, EdgeSource::None] {
        let of = |light: Light, is_on: bool| {
            let mut scenario = scenario(light, is_on);
            scenario.run.frames = 80;
            (scenario.vehicle.shutter.edges, scenario.world.timer.pps) = (edges, true);
            (scenario.world.noise_dn, scenario.world.exposure_samples) = (0.0, 1);
            let frames = flown("stamps", scenario).frames;
            let changes = frames.windows(2).filter(|pair| pair[0].exposure.set_us != pair[1].exposure.set_us).count();
            (stamps(&frames), changes)
        };
        let light = Light { from_stops: -2.0, to_stops: 3.0, ..Light::default() };
        let ((fixed, none), (moved, some)) = (of(light, false), of(light, true));
        println!("{edges:?}: {fixed:?}, {some} changes: {moved:?}");
        assert!(none == 0 && some >= 10, "{some}");
        assert_eq!(fixed.sources, moved.sources, "{edges:?}");
        assert!(moved.rms_us.expect("stamps") < 1.2 * fixed.rms_us.expect("stamps"), "{edges:?}");
    }
}

/// The emulated board and a board on a line command the same exposures.
#[test]
fn links_agree_on_the_exposures() {
    let mut scenario = scenario(Light { from_stops: -2.0, to_stops: 2.0, ..Light::default() }, true);
    (scenario.run.frames, scenario.vehicle.shutter.edges) = (30, EdgeSource::One);
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let flight_over = |link: &mut dyn Link| {
        let flight = fly(&setup, link, Keep::default(), &mut ()).expect("it flies");
        let exposures: Vec<u32> = flight.frames.iter().map(|frame| frame.exposure.set_us).collect();
        (fixes_csv(&setup, &flight, &score(&setup, &flight, &Unrectified::default())), exposures)
    };
    let expected = flight_over(&mut InProcess::new(&setup.flash).expect("it boots"));
    let changes = expected.1.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(changes >= 5, "{:?}", expected.1);
    let path = std::env::temp_dir().join(format!("plumbline-{}-exposure", std::process::id()));
    let device = Device::socket(&path).expect("a socket");
    let mut line = Serial::open(&setup.flash, device.path(), Patience::default()).expect("a link");
    assert_eq!(flight_over(&mut line), expected);
    let image = default_image();
    let emulated = if image.is_file() {
        Qemu::launch(&setup.flash, &image).map_err(|why| why.to_string())
    } else {
        Err(format!("no image {}", image.display()))
    };
    match emulated {
        Ok(mut emulated) => assert_eq!(flight_over(&mut emulated), expected),
        Err(why) => println!("skipped on the emulated board: {why}"),
    }
}
