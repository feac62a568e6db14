//! Live flights with a vehicle that plays the autopilot's part over two sockets.

mod vehicle;

use mavlink::MessageData;
use mavlink::dialects::common::TIMESYNC_DATA;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::live::LiveError;
use plumbline_sim::live::approach::{Approach, Limits};
use plumbline_sim::live::connection::{Door, Waiting};
use plumbline_sim::live::desk::{Sitter, sit};
use plumbline_sim::live::flight::{Flown, Wanted, fly};
use plumbline_sim::live::messages::SIM_STATE;
use plumbline_sim::live::truth::Place;
use plumbline_sim::run::Keep;
use plumbline_sim::scenario::{LIVE, Scenario};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{self, Linked, Summary};
use plumbline_sim::setup::{Setup, Start};
use plumbline_sim::vehicle::motion::Motion;
use plumbline_survey::crs::Crs;
use std::net::TcpListener;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use vehicle::{CENTRE, EPSG, HOME_M, Manner, OFF_M, Vehicle};

struct Patient;

impl Waiting for Patient {
    fn waits(&mut self, _: &str) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

/// In real time one flight at a time is enough for two processors.
static TURNS: Mutex<()> = Mutex::new(());

/// Doors to the two ports.
fn doors([autopilot, truth]: [u16; 2]) -> [Door; 2] {
    [("--autopilot", autopilot), ("--truth", truth)]
        .map(|(option, port)| Door::new(option, format!("tcp:127.0.0.1:{port}").parse().expect("an end")))
}

fn approach(ports: [u16; 2], wait_s: f64) -> Result<Approach, LiveError> {
    Approach::begin(&mut doors(ports), Limits { wait: Duration::from_secs_f64(wait_s) }, &mut Patient)
}

/// A flight of that many frames with `vehicle`, over a small tile.
fn flown(vehicle: &Vehicle, frames: u32) -> (Flown, Summary) {
    let _turn = TURNS.lock().unwrap_or_else(PoisonError::into_inner);
    let approach = approach(vehicle.ports, 10.0).expect("a vehicle");
    let start = approach.start().expect("a place");
    assert!((start.home_alt_m - HOME_M).abs() < 0.01, "{start:?}");
    let text = format!("frames = {frames}\n[live]\ntile_side_m = 1600.0\n[attitude]\ndelay_us = 16000\n");
    let scenario = Scenario::parse_over(LIVE, &text, "live", Path::new(""), None).expect("a scenario");
    let mut setup = Setup::live(scenario, &start).expect("a ground");
    let mut link = InProcess::new(&setup.flash).expect("a firmware");
    let place = Place { crs: setup.crs.clone(), home_alt_m: start.home_alt_m };
    let wanted = Wanted { frames: Some(frames), keep: Keep::default(), reconnects: 0 };
    let mut unrectified = Unrectified::default();
    let flown = fly(&setup, &place, &mut link, approach, &wanted, &mut (), &mut unrectified).expect("a flight");
    let flown = flown.expect("an armed vehicle");
    setup.motion = Motion::recorded(flown.motion.clone());
    let scored = score::score(&setup, &flown.flight, &unrectified);
    let linked = Linked { name: "inproc".to_owned(), firmware_sha256: None, account: Default::default() };
    let summary = score::summarise(&setup, &flown.flight, &scored, &linked);
    (flown, summary)
}

/// Has a flight flown, again where it fails: it runs in real time, and the machine may have been busy with something else. One
/// of three is enough.
fn in_real_time(flight: fn()) {
    for _ in 0..2 {
        if std::panic::catch_unwind(flight).is_ok() {
            return;
        }
    }
    flight();
}

/// A whole flight: frames match the reference where the truth says, times are known, all bytes pass.
#[test]
fn a_flight_with_a_vehicle_on_two_sockets() {
    in_real_time(on_two_sockets);
}

fn on_two_sockets() {
    let vehicle = Vehicle::new(Manner { lost_s: 18.0, ..Manner::default() });
    let (flown, summary) = flown(&vehicle, 60);
    println!("{:#?}\n{:?}", flown.live, summary.refused);
    let (live, navigation) = (&flown.live, flown.navigation.as_ref().expect("positions"));
    assert_eq!((live.ended.as_str(), flown.flight.frames.len()), ("frames", 60));
    assert!(live.truth.pinned > 0.95 && live.truth.error_ms <= 0.5, "{live:?}");
    let [delay_ms, sigma_ms] = live.truth.attitude_delay_ms.expect("turns");
    assert!((delay_ms - 16.0).abs() < 1.0 + 3.0 * sigma_ms, "{live:?}");
    assert!((navigation.rms_m - OFF_M).abs() < 0.1, "{}", navigation.rms_m);
    assert!(navigation.gnss_lost_at_s.is_some() && navigation.gnss_lost_s.is_some());
    let accepted = summary.accepted as f64 / summary.frames as f64;
    assert!(accepted > 0.5 && summary.wrong_fixes == 0, "{} fixes, {:?}", summary.accepted, summary.refused);
    let error_m = summary.ground_error_m.mean.expect("fixes");
    assert!(error_m < 1.0, "{error_m}: half a pixel");
    let heard = vehicle.heard.lock().expect("nobody panics with it");
    assert!(heard.skipped == 0 && heard.bytes > 10_000, "{heard:?}");
    // Nobody but the firmware speaks on its connection.
    assert!(heard.messages.keys().all(|(system, component, _)| (*system, *component) == (1, 154)), "{heard:?}");
}

/// Its clock runs thrice as fast, and stands still for half a second.
#[test]
fn a_clock_of_its_own_is_followed() {
    in_real_time(clock_of_its_own);
}

fn clock_of_its_own() {
    let vehicle = Vehicle::new(Manner { speed: 3.0, pause: (22.0, 0.5), ..Manner::default() });
    let (flown, _) = flown(&vehicle, 80);
    println!("{:#?}", flown.live);
    let clock = &flown.live.clock;
    assert!((clock.rate - 3.0).abs() < 0.05 && clock.jumps >= 1, "{clock:?}");
    assert!(flown.live.truth.error_ms <= 0.5 && flown.flight.frames.len() == 80);
}

/// One sentence each, which names the end and what is wrong.
#[test]
fn what_is_no_simulated_vehicle_is_refused() {
    let sentence = |ports, wait_s| match approach(ports, wait_s) {
        Err(LiveError::Input(error)) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let other = Vehicle::new(Manner { system: 7, ..Manner::default() });
    assert!(sentence(other.ports, 5.0).contains("system 7"));
    let real = Vehicle::new(Manner { denies: SIM_STATE, ..Manner::default() });
    let why = sentence(real.ports, 5.0);
    assert!(why.contains("SIM_STATE") && why.contains("simulated"), "{why}");
    // Somebody who listens and says nothing, and one who speaks something else.
    let [silent, loud] = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").expect("a port"));
    let ports = [&silent, &loud].map(|listener| listener.local_addr().expect("an address").port());
    let why = sentence(ports, 0.5);
    assert!(why.contains("--autopilot") && why.contains("nothing came"), "{why}");
    let (first, _) = silent.accept().expect("it has connected");
    drop(first);
    let answers = std::thread::spawn(move || {
        use std::io::Write;
        let (mut end, _) = silent.accept().expect("it connects");
        let _ = end.write_all(b"SSH-2.0-none\r\n");
        std::thread::sleep(Duration::from_secs(1));
    });
    let why = sentence(ports, 0.7);
    assert!(why.contains("not MAVLink 2"), "{why}");
    answers.join().expect("it ends");
}

/// Sits at a desk until it has heard a line, or for too long.
struct Listening {
    line: &'static str,
    until: Instant,
    heard: Vec<String>,
}

impl Waiting for Listening {
    fn waits(&mut self, what: &str) {
        self.heard.push(what.to_owned());
    }

    fn is_interrupted(&self) -> bool {
        self.heard.iter().any(|line| line == self.line) || Instant::now() > self.until
    }
}

impl Sitter for Listening {
    fn hears(&mut self, _: f64, line: &str) {
        self.heard.push(line.to_owned());
    }
}

/// At a desk the clock is tied and streams come, and what the vehicle does not have is told.
#[test]
fn at_a_desk_the_firmware_says_what_is_missing() {
    let _turn = TURNS.lock().unwrap_or_else(PoisonError::into_inner);
    let vehicle = Vehicle::new(Manner::default());
    let [port, truth] = vehicle.ports;
    let _nobody_asks = std::net::TcpStream::connect(("127.0.0.1", truth)).expect("a port");
    let crs = Crs::from_epsg(EPSG).expect("a zone");
    let (lat_deg, lon_deg) = crs.to_wgs84(CENTRE[0], CENTRE[1]).expect("a place");
    let start = Start { lat_deg, lon_deg, home_alt_m: HOME_M };
    let scenario = Scenario::parse_over(LIVE, "[live]\ntile_side_m = 1600.0\n", "live", Path::new(""), None);
    let setup = Setup::live(scenario.expect("a scenario"), &start).expect("a ground");
    let mut link = InProcess::new(&setup.flash).expect("a firmware");
    let door = Door::new("--mavlink", format!("tcp:127.0.0.1:{port}").parse().expect("an end"));
    let line = "no fixes: the autopilot's EKF has no origin";
    let mut sitter = Listening { line, until: Instant::now() + Duration::from_mins(1), heard: Vec::new() };
    sit(&mut link, door, &mut sitter).expect("nothing fails");
    assert_eq!(sitter.heard.last().map(String::as_str), Some(line), "{:?}", sitter.heard);
    let heard = vehicle.heard.lock().expect("nobody panics with it");
    assert!(heard.skipped == 0 && heard.messages.contains_key(&(1, 154, TIMESYNC_DATA::ID)), "{heard:?}");
}
