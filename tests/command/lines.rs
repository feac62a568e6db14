//! `plumbline serve` and `fly --link serial:`: a flight over a line as a user makes it.

use crate::command::plumbline;
use crate::folder::{FLY, Folder};
use crate::refusals::Refusals;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

/// A running `plumbline serve`, ended with the test.
struct Served(Child);

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts it; what it says to type.
fn serve(folder: &Folder, option: &str) -> (Served, String) {
    let mut command = plumbline(&folder.path(""), &format!("serve {option}"));
    let mut served = Served(command.stdout(Stdio::piped()).spawn().expect("the command starts"));
    let mut line = String::new();
    let stdout = served.0.stdout.take().expect("a pipe");
    BufReader::new(stdout).read_line(&mut line).expect("a line");
    (served, line.trim_end().to_owned())
}

#[test]
fn a_served_board_is_flown_and_told_of() {
    let folder = Folder::with_ground("fly-served");
    // A path short enough for a socket, whatever the folder's.
    let socket = std::env::temp_dir().join(format!("plumbline-served-{}", std::process::id()));
    folder.run(&format!("{FLY} --frames 3 --out inproc")).done();
    let on_socket = format!("--socket {}", socket.display());
    // Twice: what a killed one leaves behind is in nobody's way.
    for option in ["--pty".to_owned(), on_socket.clone(), on_socket] {
        let (_served, line) = serve(&folder, &option);
        let path = line.strip_prefix("plumbline fly --link serial:").expect("what to type");
        let run = folder.run(&format!("{FLY} --frames 3 --out line --json --link serial:{path}"));
        let report: Value = run.json();
        assert_eq!(folder.text("inproc/fixes.csv"), folder.text("line/fixes.csv"), "{option}");
        assert_eq!(report["link"], "serial");
        let counted = ["resends", "timeouts", "bad_checksum", "stale", "reconnects", "reboots", "frames_abandoned"];
        for key in counted {
            assert!(report["link_faults"][key].is_u64(), "{key}: {report}");
        }
        assert_eq!(report["link_faults"]["reboots"], 0);
        assert!(report["board"].as_str().is_some_and(|board| board.starts_with("host ")), "{report}");
        for key in ["/instructions_per_frame/mean", "/cycles_per_frame/mean", "/cycles_per_frame/max", "/core_clock_hz"]
        {
            assert_eq!(report.pointer(key), Some(&Value::Null), "{key}: {report}");
        }
        assert!(folder.text("line/report.html").contains("Serial line"));
    }
    let _ = std::fs::remove_file(&socket);
}

#[test]
fn what_cannot_be_served_is_refused() {
    let folder = Folder::with_ground("serve-refused");
    folder.write("taken", "");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("serve", &["--socket"]);
    refusals.expect("serve --pty --socket x", &["--socket"]);
    refusals.expect("serve --socket taken", &["--socket taken: there is a file of that name", "name another"]);
    refusals.expect("serve --socket .", &["--socket .: it is a folder"]);
    refusals.expect("serve --socket none/x", &["none/x"]);
    let long = "x".repeat(108);
    refusals.expect(
        &format!("serve --socket {long}"),
        &["--socket x", "the path has 108 bytes", "107 at most; name a shorter one"],
    );
    let mavlink = "serve --mavlink tcp:127.0.0.1:1";
    refusals.expect(mavlink, &["--configuration", "--tiles"]);
    refusals.expect("serve --pty --tiles x", &["--mavlink"]);
    refusals.expect("serve --mavlink 127.0.0.1:1 --configuration taken --tiles taken", &["tcp:HOST:PORT"]);
    refusals.expect(&format!("{mavlink} --configuration none --tiles taken"), &["none"]);
    refusals.expect(
        &format!("{mavlink} --configuration taken --tiles taken"),
        &["--configuration taken is no configuration store"],
    );
    refusals.expect(&format!("{FLY} --frames 1 --link serial:taken --out out"), &["serial:taken", "neither"]);
    refusals.expect(&format!("{FLY} --frames 1 --link serial:/dev/null --out out"), &["serial:/dev/null", "neither"]);
    refusals.done();
}
