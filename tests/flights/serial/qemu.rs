//! The boards' end of the line in the emulated Cortex-M7, over its UART.

use super::{Flown, flown, in_process, open, setup, small, socket};
use plumbline_firmware::serial::message::Counts;
use plumbline_sim::fault::line::{FaultyLine, LineFaults};
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{default_image, emulator};
use plumbline_sim::setup::Setup;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

/// A running emulator, its UART on a socket.
struct Emulator {
    process: Child,
    socket: PathBuf,
}

impl Emulator {
    /// `None`, visibly, where emulator or image is missing.
    fn start() -> Option<Self> {
        let image = default_image().with_file_name("serial");
        let (socket, mut serial) = (socket("qemu"), std::ffi::OsString::from("unix:"));
        serial.push(&socket);
        serial.push(",server=on,wait=off");
        if !image.is_file() {
            println!("skipped: there is no image {}, `cargo xtask build` makes it", image.display());
            return None;
        }
        let process = emulator()
            .args(["-M", "mps2-an500", "-icount", "shift=1,sleep=off", "-nodefaults", "-display", "none"])
            .args(["-monitor", "none", "-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(image)
            .arg("-serial")
            .arg(serial)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            // Its warnings concern devices that nobody asked for.
            .stderr(Stdio::null())
            .spawn();
        let Ok(process) = process else {
            println!("skipped: qemu-system-arm is not installed");
            return None;
        };
        let emulator = Emulator { process, socket };
        for _ in 0..500 {
            if emulator.socket.exists() {
                return Some(emulator);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("the emulator made no socket");
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.socket);
    }
}

fn fly(setup: &Setup, path: &Path) -> Flown {
    flown(setup, &mut open(setup, path, Patience::default()))
}

fn is_equal(flown: &Flown, expected: &Flown) {
    assert!(flown.csv == expected.csv, "{}\n{}", flown.csv, expected.csv);
    assert!(expected.accepted() >= 2, "{}", expected.csv);
    assert_eq!(flown.account.counts, Counts::Instructions);
    let work = flown.account.work.expect("it counts");
    assert!(u64::from(work.max) > 100_000 && work.total > work.steps, "{work:?}");
    let board = flown.account.board.as_deref().expect("a name");
    assert!(board.starts_with("mps2-an500 "), "{board}");
}

/// Once as it is; once more, for which the board has to reboot; and once over a bad line.
#[test]
fn the_emulated_board_finds_what_the_host_finds() {
    let Some(emulator) = Emulator::start() else { return };
    let setup = setup(small(3, 4));
    let expected = in_process(&setup);
    let clean = fly(&setup, &emulator.socket);
    is_equal(&clean, &expected);
    let trouble = clean.account.trouble.expect("it is counted");
    assert_eq!((trouble.reboots, trouble.bad_checksum, trouble.frames_abandoned), (0, 0, 0), "{trouble}");
    println!("clean: {trouble}, {:?}", clean.account.work);

    let faults = LineFaults {
        lost: 1.0,
        doubled: 1.0,
        reordered: 1.0,
        corrupted: 1.0,
        stalled: 1.0,
        stall: Duration::from_millis(300),
        cut: 0.3,
        absence: Duration::from_millis(100),
        ..LineFaults::default()
    };
    let line = FaultyLine::new(&socket("bad"), &emulator.socket, faults, 2, || ()).expect("a proxy");
    let bad = fly(&setup, line.path());
    is_equal(&bad, &expected);
    let trouble = bad.account.trouble.expect("it is counted");
    println!("{:?}: {trouble}", line.counts());
    assert!(trouble.resends >= 5 && trouble.reboots == 0, "{trouble}");
    // Counts do not depend on the line: each step is done once.
    let instructions = |flown: &Flown| flown.scored.iter().map(|scored| scored.cost).collect::<Vec<_>>();
    assert_eq!(instructions(&bad).len(), 4);
    assert!(instructions(&bad).iter().flatten().all(|&count| count > 100_000), "{:?}", instructions(&bad));
}
