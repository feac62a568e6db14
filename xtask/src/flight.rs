//! Short flights over both links: the emulated Cortex-M7 must find what the host finds, byte for byte.

use super::process::run;
use super::{Failure, places};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The scenarios that are flown, and frames of each: the default, and one that has everything else.
const FLIGHTS: [(&str, usize); 2] = [("rolling", 30), ("default", FRAMES)];
const FRAMES: usize = 60;

/// Flies each over both links and compares.
pub fn flight() -> Result<(), Failure> {
    for (scenario, frames) in FLIGHTS {
        let in_process = fly("inproc", scenario, frames)?;
        let emulated = fly("qemu", scenario, frames)?;
        let [ours, theirs] = [read(&in_process.join("fixes.csv"))?, read(&emulated.join("fixes.csv"))?];
        compare(&ours, &theirs, frames).map_err(|error| format!("{scenario}: {error}"))?;
        report(&emulated)?;
    }
    Ok(())
}

/// The report of the emulated default flight that [`flight`] has flown.
pub fn flown() -> Option<Value> {
    report(&folder("qemu", "default", FRAMES)).ok()
}

/// Bytes of RAM that a short emulated flight takes, static data and the stack's high-water mark.
pub fn ram_bytes(frames: usize) -> Result<u32, Failure> {
    let report = report(&fly("qemu", "default", frames)?)?;
    Ok(number(&report, "/ram_bytes") as u32)
}

/// The report of an emulated flight, with the figures that it must have.
fn report(folder: &Path) -> Result<Value, Failure> {
    let report = read(&folder.join("report.json"))?;
    let report: Value = serde_json::from_str(&report).map_err(|error| format!("report.json is no JSON: {error}"))?;
    check(&report)?;
    Ok(report)
}

/// One flight; the folder it wrote.
fn fly(link: &str, scenario: &str, frames: usize) -> Result<PathBuf, Failure> {
    let folder = folder(link, scenario, frames);
    // What an earlier run left there must not pass for this one's.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut command = Command::new(places::tested("plumbline"));
    command
        .args(["fly", "--link", link, "--scenario", scenario, "--frames", &frames.to_string(), "--out"])
        .arg(&folder);
    if link == "qemu" {
        command.arg("--firmware").arg(places::image("an500"));
    }
    // Standard output may be for figures.
    run(command.stdout(std::io::stderr()))?;
    Ok(folder)
}

/// Where a flight is written.
fn folder(link: &str, scenario: &str, frames: usize) -> PathBuf {
    places::scratch().join(format!("flight-{scenario}-{link}-{frames}"))
}

/// Equal, of the right length, and not empty of fixes.
fn compare(ours: &str, theirs: &str, frames: usize) -> Result<(), Failure> {
    let rows = ours.lines().skip(1).count();
    if rows != frames {
        return Err(format!("fixes.csv has {rows} rows for {frames} frames"));
    }
    if ours == theirs {
        return Ok(());
    }
    let unequal = ours.lines().zip(theirs.lines()).enumerate().find(|(_, (ours, theirs))| ours != theirs);
    Err(match unequal {
        Some((line, (ours, theirs))) => {
            format!("fixes.csv differs in line {}:\n  in-process {ours}\n  emulated   {theirs}", line + 1)
        }
        None => format!("the emulated fixes.csv has {} lines, not {}", theirs.lines().count(), rows + 1),
    })
}

/// What the emulated flight must say of itself.
fn check(report: &Value) -> Result<(), Failure> {
    let accepted = number(report, "/accepted");
    if accepted.is_nan() || accepted <= 0.0 {
        return Err("the emulated flight accepted no fix at all".into());
    }
    for field in ["/instructions_per_frame/mean", "/ram_bytes"] {
        let value = number(report, field);
        // NaN, for a missing field, is caught as well.
        if value.is_nan() || value <= 0.0 {
            return Err(format!("report.json of the emulated flight has no {}", field.trim_start_matches('/')));
        }
    }
    Ok(())
}

/// A number of the report; NaN where there is none.
pub fn number(report: &Value, pointer: &str) -> f64 {
    report.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN)
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::{FRAMES, check, compare};
    use serde_json::json;

    #[test]
    fn equal_flights_pass_and_the_first_difference_is_named() {
        let flight = format!("frame,accepted\n{}", "0,1\n".repeat(FRAMES));
        assert_eq!(compare(&flight, &flight, FRAMES), Ok(()));
        let other = flight.replacen("0,1\n", "0,0\n", 1);
        assert!(compare(&flight, &other, FRAMES).unwrap_err().contains("line 2"));
        let longer = format!("{flight}0,1\n");
        assert!(compare(&flight, &longer, FRAMES).unwrap_err().contains("62 lines"));
        assert!(compare("frame\n", "frame\n", FRAMES).unwrap_err().contains("0 rows"));
    }

    #[test]
    fn a_report_without_its_figures_fails() {
        let good = json!({"accepted": 50, "instructions_per_frame": {"mean": 1e6}, "ram_bytes": 20000});
        assert_eq!(check(&good), Ok(()));
        for field in ["accepted", "instructions_per_frame", "ram_bytes"] {
            let mut bad = good.clone();
            bad[field] = json!(null);
            assert!(check(&bad).is_err(), "{field}");
        }
    }
}
