//! Logs made byte by byte, whole and damaged.

mod dataflash;
mod telemetry;
mod ulog;

use super::attitude::{Attitude, Sample};
use super::{Kind, Log};

/// All of a log's messages.
fn all(kind: Kind, bytes: &[u8]) -> Log {
    assert_eq!(Kind::of(bytes), Some(kind));
    Log::read("a.log", kind, bytes, &|_| true).expect("a log")
}

/// The times and rolls of a log's attitudes, seconds and degrees.
fn rolls(log: &Log) -> Vec<(f64, f64)> {
    let attitude = Attitude::of_log(log).expect("attitudes");
    attitude.samples.iter().map(|sample| (sample.t_s, sample.roll_rad.to_degrees())).collect()
}

fn assert_near(found: &[(f64, f64)], wanted: &[(f64, f64)]) {
    let is_near = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-4;
    assert!(found.len() == wanted.len() && found.iter().zip(wanted).all(is_near), "{found:?} for {wanted:?}");
}

#[test]
fn other_files_are_no_logs() {
    for bytes in [&b""[..], b"t_s,roll_deg\n", b"\x89PNG\r\n\x1a\n", b"UL", &[0; 300], &[0xff; 300]] {
        assert_eq!(Kind::of(bytes), None, "{bytes:?}");
    }
}

#[test]
fn a_table_says_its_units() {
    let parse = |text: &str| Attitude::of_table(text, "a.csv");
    let first = |text: &str| parse(text).expect(text).samples[1];
    let seconds = first("t_s,roll_deg,pitch_deg,yaw_deg\n0,0,0,90\n0.5,30,2,90\n");
    for text in [
        "t_ms,roll_deg,pitch_deg,yaw_deg\n0,0,0,90\n500,30,2,90\n",
        "timestamp,roll_deg,pitch_deg,yaw_deg\n0,0,0,90\n500000,30,2,90\n",
        "t_us,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n500000,0.5235987755982988,0.03490658503988659,1.5707963267948966\n",
        // pymavlink's Quaternion of roll 30, pitch 2, yaw 90 degrees.
        "t_s,qw,qx,qy,qz\n0,1,0,0,0\n0.5,0.68610269,0.17106461,0.19490504,0.67971466\n",
    ] {
        let found = first(text);
        let angles = |sample: Sample| [sample.roll_rad, sample.pitch_rad, sample.yaw_rad, sample.t_s];
        let off: Vec<f64> = angles(found).iter().zip(angles(seconds)).map(|(a, b)| a - b).collect();
        // Eight decimals of a quaternion are twice as much of an angle.
        let allowed = if text.contains("qw") { 2e-8 } else { 1e-12 };
        assert!(off.iter().all(|off| off.abs() < allowed), "{text}: {found:?}");
    }
    let steps = |step: f64| format!("t_s,roll_deg,pitch_deg,yaw_deg\n0,0,0,9\n{step},30,2,9\n{},3,2,9\n", 2.0 * step);
    for (text, wanted) in [
        (
            steps(20.0),
            "look like milliseconds: if so, name the column t_ms: sed '1s/\\bt_s\\b/t_ms/' a.csv > renamed.csv",
        ),
        (steps(20000.0), "look like microseconds: if so, name the column t_us"),
        (
            "t_s,roll_deg,pitch_deg,yaw_deg\n0,0.1,0,3.1\n1,0.2,0,-3.1\n".to_owned(),
            "no angle is larger than 3.10, which looks like radians: if so, awk -F, -v OFS=, 'NR > 1 { $2 *= 57.29577951308232; $3",
        ),
        (
            "t_s,roll,pitch,yaw\n0,0.1,0,3.1\n".to_owned(),
            "a.csv has neither roll_deg, pitch_deg, yaw_deg (or _rad) nor qw",
        ),
        (
            "t,roll_deg,yaw_deg\n0,0.1,3.1\n".to_owned(),
            "a.csv has no columns t_s, pitch_deg, only t, roll_deg, yaw_deg",
        ),
        ("t,roll\n0,0.1\n".to_owned(), "nor a time (t_s, t_ms, t_us, timestamp), only t, roll"),
        (
            "t_s,roll_deg,pitch_deg,yaw_deg\n0,300,-1500,9000\n1,310,-1400,9000\n".to_owned(),
            "angles go up to 9000, which looks like hundredths of a degree: if so, awk",
        ),
        ("t_s,qw,qx,qy,qz\n0,1,0,0,0\n1,0,0,0,0\n".to_owned(), "line 3: qw = \"0\" is not part of a unit quaternion"),
    ] {
        let error = parse(&text).expect_err(&text).to_string();
        assert!(error.contains(wanted), "{error}");
    }
    // A calm vehicle that heads north may be meant: that is said, and flown.
    let calm = parse("t_s,roll_deg,pitch_deg,yaw_deg\n0,0.5,1,3\n1,0.2,0,2\n").expect("degrees");
    assert!(calm.notes[0].contains("looks like radians"), "{:?}", calm.notes);
}
