//! What cannot be flown is said in one sentence, and nothing waits for ever.

use super::{quick, setup, small, socket};
use plumbline_firmware::serial::frame::encode;
use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Welcome};
use plumbline_firmware::serial::{FRAME_MAX, VERSION};
use plumbline_sim::link::device::Device;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::serial::Serial;
use plumbline_sim::link::{Event, Flash, Link, LinkError};
use plumbline_sim::run::{Keep, fly};
use std::io::{Read, Write};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::time::Duration;

fn hurried() -> Patience {
    let [hello, stall, absence] = [300, 300, 400].map(Duration::from_millis);
    Patience { hello, stall, absence, ..quick() }
}

fn refusal(flash: &Flash, path: &Path) -> String {
    match Serial::open(flash, path, hurried()) {
        Err(LinkError::Input(error)) => error.to_string(),
        Err(other) => panic!("not the user's to mend: {other}"),
        Ok(_) => panic!("it opened"),
    }
}

/// A board that answers every request with these bytes, or not at all.
fn answering(name: &str, answer: impl Fn(u32, u32) -> Vec<u8> + Send + 'static) -> std::path::PathBuf {
    let path = socket(name);
    let listener = UnixListener::bind(&path).expect("a socket");
    std::thread::spawn(move || {
        use plumbline_firmware::serial::frame::{Receiver, Unframed, decode};
        use plumbline_firmware::serial::message::Request;
        for mut stream in listener.incoming().flatten() {
            let mut receiver = Receiver::new();
            let mut buffer = [0; 256];
            while let Ok(count) = stream.read(&mut buffer) {
                if count == 0 {
                    break;
                }
                for &byte in &buffer[..count] {
                    if let Unframed::Body(body) = receiver.take(byte)
                        && let Some(envelope) = decode::<Request<'_>>(body)
                    {
                        let _ = stream.write_all(&answer(envelope.session, envelope.id));
                    }
                }
            }
        }
    });
    path
}

fn welcome(version: u16, tile_capacity: u32) -> impl Fn(u32, u32) -> Vec<u8> + Send + 'static {
    move |session, id| {
        let welcome = Welcome {
            version,
            boot: 1,
            core_clock_hz: 0,
            counts: Counts::Nothing,
            piece_max: 2048,
            configuration_capacity: 4096,
            tile_capacity,
            plan_capacity: 4096,
            key_capacity: 128,
            board: "test",
            firmware: "0",
        };
        let mut buffer = [0; FRAME_MAX];
        encode(&Envelope { session, id, message: Answer::Welcome(welcome) }, &mut buffer).expect("room").to_vec()
    }
}

#[test]
fn every_line_that_cannot_be_flown_has_its_sentence() {
    let setup = setup(small(1, 1));
    let flash = &setup.flash;
    let missing = socket("missing");
    let file = socket("file");
    std::fs::write(&file, "text").expect("a file");
    let deserted = socket("deserted");
    drop(UnixListener::bind(&deserted).expect("a socket"));
    let cases = [
        (missing.as_path(), "there is no such port or socket"),
        (file.as_path(), "neither a serial port nor a socket"),
        (Path::new("/dev/null"), "neither a serial port nor a socket"),
        (Path::new("/"), "neither a serial port nor a socket"),
        (deserted.as_path(), "nobody listens on this socket"),
        (&answering("silent", |_, _| Vec::new()), "nobody answers"),
        (&answering("babbling", |_, _| b"\0login: \0\0AT OK\0".to_vec()), "nobody answers"),
        (
            &answering("newer", welcome(VERSION + 1, 1 << 20)),
            "speaks version 4 of the protocol, this command version 3",
        ),
        (&answering("small", welcome(VERSION, 10_000)), "and the board has room for 10000"),
    ];
    for (path, expected) in cases {
        let sentence = refusal(flash, path);
        assert!(sentence.contains(expected) && sentence.contains(&path.display().to_string()), "{sentence}");
        assert!(!sentence.contains('\n'), "{sentence}");
        if path.starts_with(std::env::temp_dir()) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// A version whose welcome has other fields is told apart from noise.
#[test]
fn a_welcome_of_another_layout_still_tells_its_version() {
    let setup = setup(small(1, 1));
    let path = answering("other", |session, id| {
        let mut buffer = [0; 64];
        // Variant 0, version 9, and something that is no welcome of ours.
        encode(&Envelope { session, id, message: (0u8, 9u16, 0xffu8) }, &mut buffer).expect("room").to_vec()
    });
    assert!(refusal(&setup.flash, &path).contains("version 9"));
    let _ = std::fs::remove_file(path);
}

/// The simulator refuses it before the board is asked; the board flies the next one.
#[test]
fn a_configuration_that_the_firmware_refuses() {
    let setup = setup(small(1, 2));
    let device = Device::socket(&socket("refusing")).expect("a socket");
    let mut flash = setup.flash.clone();
    flash.configuration.search_px = 0;
    assert!(matches!(Serial::open(&flash, device.path(), hurried()), Err(LinkError::Input(_))));
    let mut link = Serial::open(&setup.flash, device.path(), hurried()).expect("a link");
    let flight = fly(&setup, &mut link, Keep::default(), &mut ()).expect("it flies");
    assert_eq!(flight.frames.len(), 2);
}

/// A board that is gone in mid-flight is an error with what was counted, after a time that is bounded: once with the
/// line, once silently.
#[test]
fn a_board_that_stays_away_ends_the_flight() {
    let setup = setup(small(1, 1));
    let device = Device::socket(&socket("leaving")).expect("a socket");
    let mut link = Serial::open(&setup.flash, device.path(), hurried()).expect("a link");
    assert!(link.step(5, Event::Nothing).is_ok());
    drop(device);
    let Err(LinkError::Lost(why)) = link.step(6, Event::Nothing) else { panic!("it goes on") };
    assert!(why.contains("unplugged") && why.contains("1 reconnects"), "{why}");

    // The proxy swallows everything from the tenth message on.
    let device = Device::socket(&socket("stalling")).expect("a socket");
    let faults =
        plumbline_sim::fault::line::LineFaults { stalled: 0.2, stall: Duration::from_secs(3600), ..Default::default() };
    let line = plumbline_sim::fault::line::FaultyLine::new(&socket("stalled"), device.path(), faults, 4, || ())
        .expect("a proxy");
    let mut link = Serial::open(&setup.flash, line.path(), hurried()).expect("a link");
    let why = (0..100_000).find_map(|timer| match link.step(timer, Event::Nothing) {
        Ok(_) => None,
        Err(error) => Some(error.to_string()),
    });
    let why = why.expect("it goes on for ever");
    assert!(why.contains("no answer for") && why.contains("time-outs"), "{why}");
}
