//! Flights whose messages are signed: they fly as others do, on every link, refuse what they should, and their logs need no key.

use crate::replay::flown::{csv, replayed, scenario};
use crate::strangers::sealed;
use plumbline_firmware::stores::key::STORE_BYTES;
use plumbline_firmware::wire::decoder::Decoder;
use plumbline_firmware::wire::signature::SIGNATURE;
use plumbline_firmware::wire::signing::Verdict;
use plumbline_sim::link::device::Device;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::link::serial::Serial;
use plumbline_sim::link::{Event, Link, LinkError};
use plumbline_sim::replay::End;
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::setup::Setup;
use plumbline_sim::vehicle::autopilot::Autopilot;
use std::path::PathBuf;

const DIGITS: &str = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";

/// A scenario with a key.
pub fn signed(mut scenario: Scenario, name: &str) -> Scenario {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.key"));
    std::fs::write(&path, format!("{DIGITS}\n")).expect("written");
    scenario.run.link.signing_key_path = Some(path);
    scenario
}

fn flown(setup: &Setup) -> (Flight, Vec<u8>) {
    let mut link = InProcess::logged(&setup.flash).expect("it boots");
    let flight = fly(setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    (flight, link.close_log())
}

#[test]
fn a_signed_flight_has_its_fixes_and_its_log_replays_without_the_key() {
    let setup = Setup::prepare(signed(scenario(1, 30), "quiet")).expect("it can be flown");
    let (flight, bytes) = flown(&setup);
    let (report, by_autopilot) = flight.signing.expect("it was signed");
    assert_eq!((report, flight.health.foreign), Default::default(), "nothing of a good link is refused");
    // Until it has heard the autopilot it does not know the time.
    assert!((1..20).contains(&by_autopilot.expect("it is known")), "{by_autopilot:?}");
    let accepted = flight.frames.iter().filter(|frame| frame.report.is_some_and(|report| report.fix.is_some())).count();
    assert!(accepted > 25, "{accepted} fixes");
    let (_, replayed) = replayed(&bytes);
    assert_eq!((replayed.first_difference, replayed.gaps, replayed.end), (None, 0, End::Closed));
    assert_eq!((replayed.same, replayed.replayed, replayed.accepted), (replayed.frames, replayed.records, accepted));
}

/// Somebody on the link: what he forges comes before each message, and what he has recorded behind it.
struct Intruder {
    link: InProcess,
    recorded: Vec<u8>,
}

impl Link for Intruder {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        let Event::Bytes(bytes) = event else { return self.link.step(timer, event) };
        let all = [&forged(bytes), bytes, &self.recorded].concat();
        self.recorded = bytes.to_vec();
        self.link.step(timer, Event::Bytes(&all))
    }
}

/// The message without its signature; an attitude is level and points north. With the stamp of the true one, which would be
/// refused behind it.
fn forged(message: &[u8]) -> Vec<u8> {
    let Some(unsigned) = message.len().checked_sub(SIGNATURE) else { return Vec::new() };
    let mut forged = message[..unsigned].to_vec();
    forged[2] = 0;
    if forged[7..10] == [30, 1, 0] {
        forged[18..34].copy_from_slice(&[1.0f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat());
    }
    sealed(forged)
}

#[test]
fn an_intruder_changes_nothing_is_counted_and_a_replay_refuses_him_too() {
    let setup = Setup::prepare(signed(scenario(2, 20), "intruder")).expect("it can be flown");
    let (alone, _) = flown(&setup);
    let mut link = Intruder { link: InProcess::logged(&setup.flash).expect("it boots"), recorded: Vec::new() };
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    assert_eq!(csv(&setup, &flight), csv(&setup, &alone));
    let (report, _) = flight.signing.expect("it was signed");
    assert!(report.replayed > 1000 && report.unsigned > 1000, "{report:?}");
    assert_eq!((report.wrong, report.late, report.crowded), (0, 0, 0));
    let (_, replayed) = replayed(&link.link.close_log());
    assert_eq!((replayed.first_difference, replayed.different, replayed.gaps), (None, 0, 0));
    assert_eq!((replayed.same, replayed.replayed), (replayed.frames, replayed.records));
}

#[test]
fn a_bad_link_damages_signatures_too() {
    let mut scenario = signed(scenario(6, 20), "damage");
    scenario.faults.link_faults.bit_error_percent = 0.02;
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let (flight, bytes) = flown(&setup);
    let (report, _) = flight.signing.expect("it was signed");
    assert!(report.wrong > 10, "{report:?}");
    let (_, replayed) = replayed(&bytes);
    assert_eq!((replayed.first_difference, replayed.different), (None, 0));
}

#[test]
fn the_key_is_in_no_log() {
    let setup = Setup::prepare(signed(scenario(3, 4), "secret")).expect("it can be flown");
    let key = setup.signing.expect("a key").0;
    assert_eq!(setup.flash.key.len(), STORE_BYTES);
    assert!(setup.flash.key.windows(key.len()).any(|piece| piece == key));
    let (_, bytes) = flown(&setup);
    for piece in [&key[..8], &key[24..]] {
        assert!(!bytes.windows(piece.len()).any(|window| window == piece));
    }
}

#[test]
fn an_unsigned_autopilot_is_refused_and_nothing_goes_out_unsigned() {
    let setup = Setup::prepare(signed(scenario(4, 4), "unsigned")).expect("it can be flown");
    let mut link = InProcess::new(&setup.flash).expect("it boots");
    let mut autopilot = Autopilot::new(300, 1);
    let (mut decoder, mut sent) = (Decoder::new(), 0);
    for second in 0..5u32 {
        let bytes = link.step(second * 1_000_000, Event::Bytes(&autopilot.heartbeat())).expect("a host's firmware");
        decoder.take(&bytes, |packet| {
            sent += 1;
            assert!(packet.signed.is_some());
        });
    }
    assert!(sent > 10, "{sent} messages");
}

#[test]
fn a_damaged_key_flies_nothing() {
    let setup = Setup::prepare(signed(scenario(5, 4), "damaged")).expect("it can be flown");
    let mut stores = setup.flash.stores().expect("usable");
    stores.key[40] ^= 1;
    let said = InProcess::boot(&stores, false).step(0, Event::Nothing).expect("a host's firmware");
    assert!(String::from_utf8_lossy(&said).contains("no fixes: key store: content damaged"));
    assert_eq!(Verdict::from_code(6), None);
}

/// The links carry the key, and what the firmware signs and refuses is the same on each.
#[test]
fn every_link_flies_with_a_key() {
    let mut scenario = signed(scenario(7, 4), "links");
    scenario.faults.link_faults.bit_error_percent = 0.01;
    let setup = Setup::prepare(scenario).expect("it can be flown");
    let flight_over = |link: &mut dyn Link| {
        let flight = fly(&setup, link, Keep::default(), &mut ()).expect("it flies");
        (csv(&setup, &flight), flight.signing, flight.messages)
    };
    let expected = flight_over(&mut InProcess::new(&setup.flash).expect("it boots"));
    assert!(expected.1.is_some_and(|(report, _)| report.wrong > 0), "{:?}", expected.1);
    let path = std::env::temp_dir().join(format!("plumbline-{}-signing", std::process::id()));
    let device = Device::socket(&path).expect("a socket");
    assert_eq!(
        flight_over(&mut Serial::open(&setup.flash, device.path(), Patience::default()).expect("a link")),
        expected
    );
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
