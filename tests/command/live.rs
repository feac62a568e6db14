//! `fly --autopilot --truth`: what it refuses, and a flight with ArduPilot's own program where there is one.

use crate::command::{Run, plumbline};
use crate::folder::Folder;
use crate::refusals::Refusals;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavModeFlag, MavState, MavType,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Names ArduPilot's plane, built for its simulator.
const VARIABLE: &str = "PLUMBLINE_ARDUPLANE";
/// What it is started with: a loop that has time for the streams, ports without a serial line's time, a laser, and a wing that
/// flies by the program's own model.
const PARAMETERS: &str = "SCHED_LOOP_RATE 300\nSERIAL1_PROTOCOL 2\nSERIAL1_BAUD 921\nSERIAL2_PROTOCOL 2\nSERIAL2_BAUD 921\n\
    RNGFND1_TYPE 100\nRNGFND1_ORIENT 25\nRNGFND1_MIN 0.2\nRNGFND1_MAX 300\nARMING_SKIPCHK -1\nTKOFF_ALT 100\nTKOFF_THR_MAX 100\n\
    TKOFF_THR_MINACC 0\nTKOFF_ROTATE_SPD 0\nARSPD_USE 1\n";
/// The plane's mode that takes off and circles.
const TAKEOFF: f32 = 13.0;
/// Arms past the checks.
const FORCE: f32 = 21_196.0;

/// A port that nobody listens at.
fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address").port()
}

#[test]
fn what_is_no_live_flight_is_refused() {
    let folder = Folder::new("fly-live-refused");
    let ends = "fly --autopilot tcp:127.0.0.1:1 --truth tcp:127.0.0.1:2";
    let mut refusals = Refusals::new(&folder);
    refusals.expect("fly --autopilot tcp:127.0.0.1:5762", &["--truth"]);
    refusals.expect("fly --truth tcp:127.0.0.1:5762", &["--autopilot"]);
    for end in ["udp:127.0.0.1:5762", "tcp:5762", "127.0.0.1:5762", "tcp:127.0.0.1:x"] {
        refusals.expect(&format!("fly --truth tcp:127.0.0.1:1 --autopilot {end}"), &["--autopilot", end]);
    }
    for (option, name) in [
        ("--plan p.json", "--plan"),
        ("--replay a.csv", "--replay"),
        ("--dem d.tif", "--dem"),
        ("--link qemu", "--link"),
        ("--wait-s 0", "--wait-s"),
    ] {
        refusals.expect(&format!("{ends} {option}"), &[name]);
    }
    let port = free_port();
    let nobody = format!("fly --autopilot tcp:127.0.0.1:{port} --truth tcp:127.0.0.1:{port} --wait-s 0.2 --out out");
    let run = Run::from(plumbline(&folder.path(""), &nobody).output().expect("the command starts"));
    assert_eq!(run.code, Some(2), "{run:?}");
    let last = run.stderr.lines().last().expect("a sentence");
    assert!(last.contains(&format!("tcp:127.0.0.1:{port}")), "{run:?}");
    refusals.done();
}

/// Ends with the test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a user's script would do: asks again and again to be armed and to take off.
fn command(stream: &mut TcpStream, sequence: &mut u8) {
    let mut send = |bytes: Vec<u8>| stream.write_all(&bytes).expect("the plane lives");
    send(encoded(
        sequence,
        &HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: MavType::MAV_TYPE_GCS,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        },
    ));
    let wanted = [(MavCmd::MAV_CMD_DO_SET_MODE, [1.0, TAKEOFF]), (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, FORCE])];
    for (command, [param1, param2]) in wanted {
        let data = COMMAND_LONG_DATA {
            param1,
            param2,
            command,
            target_system: 1,
            target_component: 1,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        send(encoded(sequence, &data));
    }
}

fn encoded<D: MessageData>(sequence: &mut u8, data: &D) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    *sequence = sequence.wrapping_add(1);
    raw.serialize_message_data(MavHeader { system_id: 255, component_id: 190, sequence: *sequence }, data);
    raw.raw_bytes().to_vec()
}

/// Starts the plane with its ports; `None` where there is none.
fn plane(folder: &Folder, [script, autopilot, truth]: [u16; 3]) -> Option<Ended> {
    let program = std::env::var_os(VARIABLE)?;
    folder.write("plane.parm", PARAMETERS);
    let client = |port: u16| format!("tcpclient:127.0.0.1:{port}");
    let mut plane = Command::new(program);
    plane.current_dir(folder.path("")).args(["--wipe", "--model", "plane", "--defaults", "plane.parm"]);
    plane.args(["--home", "-35.363261,149.165230,584,353", "--serial0", &format!("tcp:{script}")]);
    plane.args(["--serial1", &client(autopilot), "--serial2", &client(truth)]);
    Some(Ended(plane.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the plane starts")))
}

#[test]
fn a_flight_with_ardupilots_own_program() {
    let folder = Folder::new("fly-live-plane");
    let ports = [(); 3].map(|()| free_port());
    if std::env::var_os(VARIABLE).is_none() {
        eprintln!("skipped: {VARIABLE} names no plane");
        return;
    }
    let options = format!(
        "fly --autopilot tcp:127.0.0.1:{} --truth tcp:127.0.0.1:{} --frames 40 --out out --log flight.log",
        ports[1], ports[2]
    );
    let mut flight = plumbline(&folder.path(""), &options);
    let flight = flight.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    let mut flight = Ended(flight);
    thread::sleep(Duration::from_secs(2));
    let _plane = plane(&folder, ports).expect("a plane");
    thread::sleep(Duration::from_secs(2));
    let mut script = TcpStream::connect(("127.0.0.1", ports[0])).expect("the plane listens");
    script.set_read_timeout(Some(Duration::from_millis(10))).expect("a socket");
    let (until, mut sequence) = (Instant::now() + Duration::from_secs(240), 0);
    let status = loop {
        if let Some(status) = flight.0.try_wait().expect("it was started") {
            break status;
        }
        assert!(Instant::now() < until, "no flight within four minutes");
        command(&mut script, &mut sequence);
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(2) {
            let _ = script.read(&mut [0; 4096]);
            thread::sleep(Duration::from_millis(5));
        }
    };
    let said = |pipe: Option<Box<dyn Read>>| {
        let mut text = String::new();
        pipe.into_iter().for_each(|mut pipe| drop(pipe.read_to_string(&mut text)));
        text
    };
    let out = said(flight.0.stdout.take().map(|pipe| Box::new(pipe) as Box<dyn Read>));
    println!("{out}");
    assert!(status.success(), "{out} {}", said(flight.0.stderr.take().map(|pipe| Box::new(pipe) as Box<dyn Read>)));
    judged(&folder);
}

/// What such a flight has to be.
fn judged(folder: &Folder) {
    let report: serde_json::Value = serde_json::from_str(&folder.text("out/report.json")).expect("a document");
    let number = |pointer: &str| report.pointer(pointer).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    assert_eq!(report["frames"], 40);
    assert!(number("/live/truth/error_ms") <= 5.0 && number("/live/clock/scatter_ms") <= 5.0, "{report}");
    assert!(number("/navigation/rms_m") < 10.0, "{report}");
    assert!(folder.text("out/report.html").contains("With a real autopilot"));
    let replayed = plumbline(&folder.path(""), "replay flight.log").output().expect("the command starts");
    Run::from(replayed).done();
    assert!(Path::new(&folder.path("out/poses.csv")).exists());
}
