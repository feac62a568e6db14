//! `cargo xtask figures`: measures what `docs/figures.md` tells, and writes it there between two marks.
//!
//! A flight is a row of the first table, from its `report.json`; a figure of `cargo xtask budget --json` that has a limit is
//! one of the second. What is measured otherwise stands below the marks and is left alone.

use super::process::output;
use super::{Failure, build, places};
use serde_json::Value;
use std::env;
use std::fmt::Write;
use std::fs;
use std::process::Command;

const BEGIN: &str = "<!-- cargo xtask figures: begin -->";
const END: &str = "<!-- cargo xtask figures: end -->";

/// Flights of the first table: what they are, and the options of `plumbline fly`.
const FLIGHTS: [(&str, &[&str]); 5] = [
    ("default scene", &[]),
    ("rolling shutter, smear, one edge, 20°/s, antenna 1 m off", &["--scenario", "rolling"]),
    ("attitude 0.35°, heading 1.5°, servo 0.1 s late", &["--scenario", "honest"]),
    ("real orthophoto, terrain and attitude, 2 m a pixel", &["--scenario", "vienna"]),
    ("real farmland and lakes, 5 m a pixel", &["--scenario", "naip"]),
];

/// Flies, counts, and writes the page.
///
/// # Errors
/// A sentence on what could not be built, flown, counted or written; nothing is written then.
pub fn figures() -> Result<(), Failure> {
    build::build()?;
    let mut flights = Vec::new();
    for (what, options) in FLIGHTS {
        eprintln!("flies: {what}");
        let mut command = Command::new(places::plumbline());
        command.arg("fly").args(options).arg("--json");
        let report = output(&mut command).ok_or_else(|| format!("plumbline fly {} failed", options.join(" ")))?;
        flights.push((what, options, parsed(&report)?));
    }
    let program = env::current_exe().map_err(|error| format!("this program does not find itself: {error}"))?;
    let counted = output(Command::new(program).args(["budget", "--json"])).ok_or("cargo xtask budget failed")?;
    let path = places::root().join("docs/figures.md");
    let name = path.display();
    let page = fs::read_to_string(&path).map_err(|error| format!("{name}: {error}"))?;
    let page = filled(&page, &tables(&flights, &parsed(&counted)?)).ok_or_else(|| format!("{name}: no marks"))?;
    fs::write(&path, page).map_err(|error| format!("{name}: {error}"))
}

fn parsed(text: &str) -> Result<Value, Failure> {
    serde_json::from_str(text).map_err(|error| format!("no JSON: {error}"))
}

/// The page with `text` between its marks.
fn filled(page: &str, text: &str) -> Option<String> {
    let (head, rest) = page.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n{text}{END}{tail}"))
}

fn tables(flights: &[(&str, &[&str], Value)], counted: &Value) -> String {
    let mut text = String::from(
        "
## Flights

Matching error in pixels of the reference, accepted frames (the raw frame and the whole-pixel peak: see
[report.json](formats.md#reportjson)); ground error in metres; NEES, 2 expected.

| flight | command | frames | fixes | raw | whole pixel | mean | 95 % | largest | ground, mean | NEES |
|---|---|---|---|---|---|---|---|---|---|---|
",
    );
    for (what, options, report) in flights {
        let number = |at: &str, digits: usize| {
            report.pointer(at).and_then(Value::as_f64).map_or("-".to_owned(), |value| format!("{value:.digits$}"))
        };
        // Writing to a string cannot fail.
        let _ = write!(text, "| {what} | `{}` ", [&["plumbline", "fly"], *options].concat().join(" "));
        for (at, digits) in [("/frames", 0), ("/accepted", 0)] {
            let _ = write!(text, "| {} ", number(at, digits));
        }
        for key in ["unrectified_mean", "rectified_integer_mean"] {
            let _ = write!(text, "| {} ", number(&format!("/matching_error_px/{key}"), 2));
        }
        for key in ["rectified_mean", "rectified_p95", "accepted_max"] {
            let _ = write!(text, "| {} ", number(&format!("/matching_error_px/{key}"), 3));
        }
        let _ = writeln!(text, "| {} | {} |", number("/ground_error_m/mean", 2), number("/nees_mean", 2));
    }
    text.push_str(
        "
## Cost

What `cargo xtask budget` says, worst of 192 poses: exact counts of the emulated Cortex-M7, and the serial estimate of
[Timing](design/timing.md), a model and no measurement.

| workload | figure | value | limit |
|---|---|---|---|
",
    );
    let limited = counted.as_array().into_iter().flatten().filter(|figure| !figure["limit"].is_null());
    for figure in limited.filter(|figure| figure["metric"] != "instructions") {
        let words = |key: &str| figure[key].as_str().unwrap_or("-").to_owned();
        let number = |key: &str| figure[key].as_f64().map_or("-".to_owned(), three_digits);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            words("workload"),
            words("metric"),
            number("value"),
            number("limit")
        );
    }
    text.push('\n');
    text
}

/// A whole number as it is, others with three significant digits.
fn three_digits(value: f64) -> String {
    if value.fract() == 0.0 {
        return format!("{value}");
    }
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0);
    format!("{value:.0$}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::{BEGIN, END, filled, tables, three_digits};
    use serde_json::json;

    #[test]
    fn only_what_lies_between_the_marks_changes() {
        let page = format!("head\n{BEGIN}\nold\n{END}\ntail\n");
        assert_eq!(filled(&page, "new\n"), Some(format!("head\n{BEGIN}\nnew\n{END}\ntail\n")));
        assert_eq!(filled("no marks", "new"), None);
    }

    #[test]
    fn a_flight_and_a_limit_are_a_row_each() {
        let report = json!({"frames": 300, "accepted": 299, "matching_error_px": {"rectified_mean": 0.04398}});
        let counted = json!([
            {"workload": "frame", "metric": "serial estimate at 480 MHz, ms", "value": 3.7012, "limit": 12.0},
            {"workload": "frame", "metric": "floor, cycles", "value": 1.0, "limit": null},
        ]);
        let text = tables(&[("a", &["--scenario", "b"], report)], &counted);
        assert!(
            text.contains("| a | `plumbline fly --scenario b` | 300 | 299 | - | - | 0.044 | - | - | - | - |"),
            "{text}"
        );
        assert!(text.contains("| frame | serial estimate at 480 MHz, ms | 3.70 | 12 |"), "{text}");
        assert!(!text.contains("floor"), "{text}");
    }

    #[test]
    fn numbers_keep_three_digits() {
        assert_eq!([3.7012, 12.0, 0.4351, 262_144.0].map(three_digits), ["3.70", "12", "0.435", "262144"]);
    }
}
