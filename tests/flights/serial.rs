//! Flights over a line, against the same flights in-process: with a good line, a bad one, and one that is cut.

mod faults;
mod greeting;
mod messages;
mod qemu;
mod refusals;

use plumbline_sim::link::device::Device;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::serial::Serial;
use plumbline_sim::link::{Account, Link};
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::scenario::{Camera, Frame, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{Scored, fixes_csv, score};
use plumbline_sim::setup::Setup;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// A finished flight.
struct Flown {
    flight: Flight,
    scored: Vec<Scored>,
    csv: String,
    account: Account,
}

/// The default scene seen by a camera of a sixty-fourth of the pixels and by slower sensors, which makes a flight of small
/// messages that is quickly rendered.
fn small(seed: u64, frames: u32) -> Scenario {
    let mut scenario = Scenario::seeded(seed, frames);
    scenario.run.frame_interval_ms = 100;
    scenario.camera = Camera::of_size(64, 64);
    (scenario.vehicle.attitude.rate_hz, scenario.world.follow_up.rate_hz, scenario.vehicle.range.rate_hz) =
        (50, 20, 20);
    // A pose needs samples on both sides; these come every 20 ms.
    scenario.vehicle.flight.tilt_hz = [0.02, 0.05];
    scenario
}

fn setup(scenario: Scenario) -> Setup {
    Setup::prepare(scenario).expect("it can be flown")
}

fn flown(setup: &Setup, link: &mut dyn Link) -> Flown {
    let flight = fly(setup, link, Keep::default(), &mut ()).expect("it flies to the end");
    let scored = score(setup, &flight, &Unrectified::default());
    let csv = fixes_csv(setup, &flight, &scored);
    Flown { flight, scored, csv, account: link.account() }
}

fn in_process(setup: &Setup) -> Flown {
    flown(setup, &mut InProcess::new(&setup.flash).expect("it boots"))
}

impl Flown {
    fn accepted(&self) -> usize {
        self.scored.iter().filter(|scored| scored.accepted).count()
    }

    /// No fix is off by more than a pixel and a half or five sigmas.
    fn has_no_wrong_fix(&self, resolution_m: f64) {
        for scored in self.scored.iter().filter(|scored| scored.accepted) {
            let [east_m, north_m] = scored.error_m.expect("a fix has an error");
            let (error_px, sigmas) = (east_m.hypot(north_m) / resolution_m, scored.nees.expect("a covariance").sqrt());
            assert!(error_px <= 1.5 && sigmas <= 5.0, "frame {}: {error_px} px, {sigmas} sigma", scored.frame);
        }
    }
}

/// Waits short enough for a test and longer than a step takes here.
fn quick() -> Patience {
    Patience {
        first: Duration::from_millis(50),
        least: Duration::from_millis(8),
        most: Duration::from_millis(400),
        ..Patience::default()
    }
}

/// A path for a socket that nobody else uses; short, as sockets want it.
fn socket(name: &str) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("plumbline-{}-{number}-{name}", std::process::id()))
}

fn open(setup: &Setup, path: &Path, patience: Patience) -> Serial {
    Serial::open(&setup.flash, path, patience).expect("a link")
}

/// Whatever kind of line it is, the frames arrive in pieces and the fixes are those of the flight in-process, bit by bit;
/// and the same device flies again.
#[test]
fn a_good_line_changes_nothing() {
    let setup = setup(small(3, 8));
    let expected = in_process(&setup);
    assert!(expected.accepted() >= 6, "{}", expected.csv);
    let devices = [Device::socket(&socket("good")).expect("a socket"), Device::terminal().expect("a terminal")];
    for device in &devices {
        for flight in ["first", "second"] {
            let mut link = open(&setup, device.path(), Patience::default());
            let flown = flown(&setup, &mut link);
            assert!(flown.csv == expected.csv, "{flight}:\n{}\n{}", flown.csv, expected.csv);
            let trouble = flown.account.trouble.expect("it is counted");
            assert_eq!((trouble.reboots, trouble.reconnects, trouble.frames_abandoned), (0, 0, 0), "{trouble}");
            assert_eq!((trouble.bad_checksum, flown.flight.health), (0, expected.flight.health), "{trouble}");
            assert_eq!(flown.flight.messages, expected.flight.messages);
        }
    }
}

/// The largest frames and patches: rows in many pieces, and more to send than an answer holds.
#[test]
fn a_large_camera_is_served_in_pieces() {
    let mut scenario = small(4, 3);
    // Square pixels.
    let half = 30.0_f64.to_radians().tan();
    let fov_v_deg = 2.0 * (half * 480.0 / 752.0).atan().to_degrees();
    scenario.camera = Camera::Keys(Frame { cols: 752, rows: 480, fov_h_deg: 60.0, fov_v_deg, ..Frame::default() });
    let setup = setup(scenario);
    let device = Device::socket(&socket("large")).expect("a socket");
    let flown = flown(&setup, &mut open(&setup, device.path(), Patience::default()));
    assert!(flown.accepted() > 0, "{}", flown.csv);
    let expected = in_process(&setup);
    assert!(flown.csv == expected.csv, "{}\n{}", flown.csv, expected.csv);
    assert_eq!(flown.flight.messages, expected.flight.messages);
}

/// A silent attitude sensor keeps a frame waiting until after the next one has begun: the simulator holds that one's rows
/// until the board asks for them, and both links refuse and fix the same frames.
#[test]
fn a_frame_that_begins_while_another_is_at_work_waits_for_its_rows() {
    let mut scenario = small(6, 14);
    scenario.faults.attitude_faults.gap_s = Some([3.45, 3.95]);
    let setup = setup(scenario);
    let expected = in_process(&setup);
    let device = Device::socket(&socket("busy")).expect("a socket");
    let flown = flown(&setup, &mut open(&setup, device.path(), Patience::default()));
    assert!(flown.csv == expected.csv, "{}\n{}", flown.csv, expected.csv);
    assert!(flown.flight.health.frames_lost > 0 && flown.accepted() >= 6, "{}", flown.csv);
}
