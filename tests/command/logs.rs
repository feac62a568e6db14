//! Flight logs as input of `fly --replay` and `smooth`: what is read of them, and which are refused.

use crate::folder::{FLY, Folder};
use crate::refusals::Refusals;
use crate::smooth::csv;
use plumbline_survey::io::data;
use plumbline_tests::vectors::number;
use std::fs;

/// A log of the real data, copied into a folder under another name.
fn copy(folder: &Folder, log: &str, name: &str) -> Option<Vec<u8>> {
    let bytes = fs::read(data::for_test("flight logs", &format!("logs/{log}"))?).expect("it can be read");
    folder.write(name, &bytes);
    Some(bytes)
}

const LOGS: [&str; 4] = ["px4_a.ulg", "px4_zurich.ulg", "arduplane.BIN", "arduplane.tlog"];

#[test]
fn logs_are_flown_and_known_by_their_content() {
    let folder = Folder::with_ground("logs-fly");
    for log in LOGS {
        let Some(_) = copy(&folder, log, "log.csv") else { return };
        let run = folder.run(&format!("{FLY} --frames 4 --replay log.csv --json")).done();
        assert!(run.stderr.contains("log.csv: ") && run.stderr.contains(" attitudes of "), "{log}: {}", run.stderr);
    }
}

/// The flight of the log and that of the table made of it: the same poses but for the rounding of the table.
#[test]
fn a_log_is_flown_as_the_table_made_of_it() {
    let folder = Folder::with_ground("logs-table");
    let table = data::for_test("flight logs", "flights/zurich_lidar/att_q.csv");
    let (Some(table), Some(_)) = (table, copy(&folder, "px4_zurich.ulg", "log.ulg")) else { return };
    folder.write("table.csv", fs::read(table).expect("it can be read"));
    let [log, table] = ["log.ulg", "table.csv"].map(|file| {
        folder.run(&format!("{FLY} --frames 20 --replay {file} --out {file}.out")).done();
        csv(&folder, &format!("{file}.out/poses.csv")).1
    });
    assert_eq!(log.len(), table.len());
    for (a, b) in log.iter().zip(&table) {
        // A step of a microsecond at 100 degrees a second, and what seven decimals of a quaternion leave.
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3), "{a:?} {b:?}");
    }
}

#[test]
fn a_message_is_a_table() {
    let folder = Folder::new("logs-smooth");
    // pyulog and pymavlink: samples, and the first value.
    for (log, call, header, rows) in [
        ("px4_a.ulg", "--message vehicle_attitude --columns q[3]", "t_s,q[3],q[3]_rate,q[3]_sigma", 779),
        ("arduplane.BIN", "--message ATT --columns Roll,Pitch", "t_s,Roll,Roll_rate,Roll_sigma,Pitch", 963),
        ("arduplane.BIN", "--message ATT --time TimeUS --columns Roll", "TimeUS,Roll", 963),
        ("arduplane.tlog", "--message ATTITUDE --columns roll", "t_s,roll,roll_rate,roll_sigma", 60),
        ("arduplane.tlog", "--message ATTITUDE", "t_s,pitch,pitch_rate,pitch_sigma,pitchspeed", 60),
    ] {
        let Some(_) = copy(&folder, log, "log") else { return };
        let run = folder.run(&format!("smooth --in log {call} --alpha 1 --out fit.csv --json")).done();
        let (names, fit) = csv(&folder, "fit.csv");
        assert!(names.join(",").starts_with(header), "{names:?}");
        assert_eq!(fit.len(), rows, "{log} {call}");
        assert_eq!(run.stderr.contains("counts microseconds"), call.contains("TimeUS"), "{}", run.stderr);
    }
}

#[test]
fn logs_that_cannot_be_used_are_refused() {
    let folder = Folder::with_ground("logs-bad");
    let fly = |file: &str| format!("{FLY} --frames 4 --replay {file} --out out");
    let smooth = |file: &str, message: &str| format!("smooth --in {file} {message} --out fit.csv");
    folder.write("empty.ulg", "");
    folder.write("begun.ulg", b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0");
    folder.write("cut.ulg", b"ULog\x01\x12\x35\x01");
    folder.write("other.bin", [0xab; 400]);
    folder.write("zeros.tlog", [0; 400]);
    folder.write("text.log", "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n");
    folder.write("table.csv", "t_s,roll_deg\n0,1\n1,3\n2,2\n3,4\n");
    folder.write("radians.csv", "t_s,roll_deg,pitch_deg,yaw_deg\n0,0.1,0,3.1\n1,0.2,0,-3.1\n");
    folder.write("milliseconds.csv", "t_s,roll_deg,pitch_deg,yaw_deg\n0,1,0,31\n20,2,0,31\n40,2,0,31\n");
    let mut refusals = Refusals::new(&folder);
    for (file, names) in [
        ("empty.ulg", &["empty.ulg is empty"][..]),
        ("begun.ulg", &["begun.ulg", "holds no message"]),
        ("cut.ulg", &["cut.ulg", "within its header"]),
        ("other.bin", &["other.bin", "DataFlash (.bin)"]),
        ("zeros.tlog", &["zeros.tlog", "(.tlog)"]),
        ("text.log", &["text.log", "(.bin)"]),
        ("radians.csv", &["radians.csv", "looks like radians", "awk ", "$2 *= 57.29577951308232"]),
        ("milliseconds.csv", &["milliseconds.csv", "steps of 20", "milliseconds", "t_ms"]),
    ] {
        refusals.expect(&fly(file), names);
    }
    refusals.expect(&smooth("table.csv", "--message ATT"), &["table.csv", "--message"]);
    refusals.expect(&smooth("table.csv", "--columns roll_deg"), &["table.csv", "--time", "t_s,roll_deg"]);
    refusals.expect(&smooth("begun.ulg", "--message vehicle_attitude"), &["begun.ulg", "holds no message"]);
    if let Some(bytes) = copy(&folder, "px4_zurich.ulg", "log.ulg") {
        folder.write("definitions.ulg", &bytes[..20_000]);
        for (call, names) in [
            (smooth("log.ulg", ""), &["log.ulg is a ULog log: --message", "vehicle_attitude"][..]),
            (smooth("log.ulg", "--message ATT"), &["no message ATT, only", "input_rc (:0, :1)"]),
            (smooth("log.ulg", "--message input_rc:7"), &["no message input_rc:7"]),
            (smooth("log.ulg", "--message vehicle_attitude --columns roll"), &["no number roll, only", "q[0]"]),
            (fly("definitions.ulg"), &["definitions.ulg"]),
            (
                format!("{FLY} --frames 200 --replay log.ulg --out out"),
                &["log.ulg", "5080.904 s", "200 frames", "--frames 142 fits"],
            ),
        ] {
            refusals.expect(&call, names);
        }
    }
    if let Some(bytes) = copy(&folder, "arduplane.tlog", "log.tlog") {
        folder.write("reboot.tlog", [&bytes[..], &bytes[..]].concat());
        refusals.expect(
            &fly("reboot.tlog"),
            &["reboot.tlog, ATTITUDE_QUATERNION:1.1", "time goes back from 119.999 s to 60.001 s"],
        );
        refusals.expect(&smooth("reboot.tlog", "--message ATTITUDE"), &["reboot.tlog", "sample 61", "goes back"]);
    }
    refusals.done();
}

/// A table whose columns say degrees and seconds: what it seems to be is told, and where turns are to be added, refused.
#[test]
fn an_attitude_in_other_units_is_told_by_smooth() {
    let folder = Folder::new("logs-units");
    let table = |step: f64, unit: f64| {
        let row = |k: u32| {
            let (t, angle) = (f64::from(k) * step, 12.0 * (0.3 * f64::from(k)).sin() + f64::from(k % 3));
            format!("{t},x,{},{},{}\n", unit * angle, -0.4 * unit * angle, unit * (200.0 + angle))
        };
        format!("t_s,mode,roll_deg,pitch_deg,yaw_deg\n{}", (0..60).map(row).collect::<String>())
    };
    let smooth = "smooth --in log.csv --time t_s --columns roll_deg,pitch_deg,yaw_deg --alpha 5 --out fit.csv";
    let line = |factor: &str| {
        format!(
            "awk -F, -v OFS=, 'NR > 1 {{ $3 *= {factor}; $4 *= {factor}; $5 *= {factor} }} 1' log.csv > degrees.csv"
        )
    };
    folder.write("log.csv", table(0.1, 1.0));
    assert_eq!(folder.run(smooth).done().stderr, "");
    folder.write("log.csv", table(0.1, 100.0));
    let hundredths = format!("which looks like hundredths of a degree: if so, {}", line("0.01"));
    assert!(folder.run(smooth).done().stderr.contains(&hundredths));
    let named = |text: &str| text.replace("roll_deg,pitch_deg,yaw_deg", "Roll,Pitch,Yaw");
    folder.write("log.csv", named(&table(0.1, 100.0)));
    assert!(folder.run(&named(smooth)).done().stderr.contains(&hundredths));
    folder.write("log.csv", named(&table(0.1, 1.0_f64.to_radians())));
    assert!(!folder.run(&named(smooth)).done().stderr.contains("radians"));
    folder.write("log.csv", table(0.1, 100.0));
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{smooth} --angles yaw_deg"), &["log.csv: angles go up to", &hundredths]);
    refusals.done();
    folder.write("log.csv", table(0.1, 1.0_f64.to_radians()));
    let radians = format!("which looks like radians: if so, {}", line("57.29577951308232"));
    assert!(folder.run(smooth).done().stderr.contains(&radians));
    folder.write("log.csv", table(100.0, 1.0));
    let steps = "t_s goes in steps of 100, which look like milliseconds: if so";
    let said = folder.run(smooth).done().stderr;
    assert!(said.contains(steps) && said.contains("'NR > 1 { $1 *= 0.001 } 1' log.csv > seconds.csv"), "{said}");
}

/// Half a log, and one with a hole in it, are flown as far as they go, and it is told what is missing.
#[test]
fn damaged_logs_are_flown_as_far_as_they_go() {
    let folder = Folder::with_ground("logs-damaged");
    for log in ["px4_zurich.ulg", "arduplane.BIN", "arduplane.tlog"] {
        let Some(bytes) = copy(&folder, log, "whole") else { return };
        let middle = bytes.len() / 2;
        folder.write("half", &bytes[..middle + 1]);
        folder.write("hole", [&bytes[..middle], &[0xfe; 999], &bytes[middle + 500..]].concat());
        for (name, told) in [("half", "ends within a record"), ("hole", "are damaged and were skipped")] {
            let run = folder.run(&format!("{FLY} --frames 4 --replay {name} --json")).done();
            assert!(run.stderr.contains(told), "{log} {name}: {}", run.stderr);
            let summary: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
            assert_eq!(number(&summary, "frames"), 4.0);
        }
    }
}
