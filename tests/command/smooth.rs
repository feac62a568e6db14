//! `plumbline smooth` against the golden values of paper 001.

use crate::folder::Folder;
use plumbline_tests::track::{self, Track};
use plumbline_tests::vectors::{number, rows, table};
use serde_json::Value;
use std::fmt::Write;

/// A call that works on [`samples`].
pub const SMOOTH: &str =
    "smooth --in samples.csv --time t_s --columns z,short --order 2 --alpha 10 --out fit.csv --json";

/// The golden values have nine decimals.
const GOLDEN: f64 = 1e-8;

/// A folder with `samples.csv`: the golden track `z`, another column and a third of weights.
pub fn samples(name: &str) -> (Folder, Track) {
    let folder = Folder::new(name);
    let track = track::golden();
    let mut text = "t_s,z,short,p\n".to_owned();
    for (i, (t, z)) in track.t_s.iter().zip(&track.observed).enumerate() {
        let _ = writeln!(text, "{t},{z},{},{}", [0.0, 1.0, 0.0, 1.0, 0.0, 3.0, 2.0][i % 7], i % 2 + 1);
    }
    folder.write("samples.csv", text);
    (folder, track)
}

/// A CSV file: its header, and its rows as numbers.
pub fn csv(folder: &Folder, name: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = folder.text(name);
    let mut lines = text.lines();
    let header = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let row = |line: &str| line.split(',').map(|field| field.parse().expect("a number")).collect();
    (header, lines.map(row).collect())
}

fn near(found: f64, row: &Value, key: &str) {
    let wanted = number(row, key);
    assert!((found - wanted).abs() < GOLDEN, "{key}: {found} for {row}");
}

#[test]
fn golden_short() {
    let folder = Folder::new("smooth-short");
    for row in rows("001", "S_short") {
        let y = row["y"].as_array().expect("samples");
        let lines: Vec<String> = y.iter().enumerate().map(|(i, y)| format!("{i},{y}")).collect();
        folder.write("samples.csv", format!("t,y\n{}\n", lines.join("\n")));
        let json = folder
            .run(&format!(
                "smooth --in samples.csv --time t --columns y --order {} --alpha {} --out fit.csv --json",
                row["d"], row["alpha"]
            ))
            .json();
        near(number(&json["y"], "constant"), &row, "constant");
        let (header, fit) = csv(&folder, "fit.csv");
        assert_eq!(header, ["t", "y", "y_rate", "y_sigma"]);
        for (i, line) in fit.iter().enumerate() {
            assert_eq!(line[0], i as f64);
            assert!((line[1] - row["g"][i].as_f64().expect("g")).abs() < GOLDEN, "{line:?} {row}");
            assert!(line[3] > 0.0);
        }
    }
}

#[test]
fn golden_track() {
    let (folder, track) = samples("smooth-track");
    for row in rows("001", "S_track") {
        let [d, alpha] = ["d", "alpha"].map(|key| row[key].to_string());
        let json = folder.run(&SMOOTH.replace("--order 2 --alpha 10", &format!("--order {d} --alpha {alpha}"))).json();
        let z = &json["z"];
        assert_eq!(number(z, "alpha"), number(&row, "alpha"));
        near(number(z, "edf"), &row, "edf");
        let freedom = 301.0 - number(&row, "edf");
        assert!((number(z, "sigma0") - (number(&row, "vv") / freedom).sqrt()).abs() < GOLDEN);
        if !row["gcv"].is_null() {
            near(number(z, "gcv"), &row, "gcv");
        }
        let (header, fit) = csv(&folder, "fit.csv");
        assert_eq!(header, ["t_s", "z", "z_rate", "z_sigma", "short", "short_rate", "short_sigma"]);
        assert_eq!(fit.iter().map(|line| line[0]).collect::<Vec<_>>(), track.t_s, "in shortest round-trip form");
        for (i, key) in [(0, "first"), (150, "middle"), (300, "last")] {
            near(fit[i][1], &row, key);
        }
    }
}

#[test]
fn golden_between() {
    let (folder, _) = samples("smooth-between");
    folder.write("at.csv", "t_s,note\n10.05,a\n10.10,b\n30.13,c\n");
    folder.write("only.csv", "when\n30.13\n10.05\n");
    let call = SMOOTH.replace("--alpha 10", "--alpha 100");
    folder.run(&format!("{call} --at at.csv")).done();
    let (_, fit) = csv(&folder, "fit.csv");
    let golden = rows("001", "S_between");
    assert_eq!(fit.len(), golden.len());
    for (line, row) in fit.iter().zip(&golden) {
        assert_eq!(line[0], number(row, "t"));
        near(line[1], row, "value");
    }
    folder.run(&format!("{call} --at only.csv")).done();
    let (_, other) = csv(&folder, "fit.csv");
    assert_eq!(other, [fit[2].clone(), fit[0].clone()]);
}

/// GCV's alpha on the golden track is where the reference's table has it for this period, and its score is a minimum.
#[test]
fn gcv() {
    let (folder, _) = samples("smooth-gcv");
    let score =
        |alpha: &str| folder.run(&SMOOTH.replace("--alpha 10", &format!("--alpha {alpha}"))).json()["z"].clone();
    let best = score("gcv");
    let golden = table("001", "S_interpolants")[2]["d2_log_alpha"].as_f64().expect("a logarithm");
    assert!((number(&best, "alpha").log10() - golden).abs() < 0.25, "{best}");
    for factor in [0.9, 1.1] {
        let other = score(&(factor * number(&best, "alpha")).to_string());
        assert!(number(&other, "gcv") > number(&best, "gcv"), "{best} {other}");
    }
}

#[test]
fn weights_angles_gate_gaps_and_plot() {
    let folder = Folder::new("smooth-options");
    let mut text = "t,heading,p\n".to_owned();
    for i in 0..60 {
        let heading = (300.0 + 3.0 * f64::from(i) + 0.1 * f64::from(i * 7 % 5)).rem_euclid(360.0);
        // One outlier, one sample that is not there, a gap of ten.
        let (heading, p) = match i {
            20 => ("100".to_owned(), 1),
            33 => (String::new(), 0),
            _ => (heading.to_string(), 1),
        };
        if !(40..50).contains(&i) {
            let _ = writeln!(text, "{i},{heading},{p}");
        }
    }
    folder.write("log.csv", text);
    let call =
        "smooth --in log.csv --time t --columns heading --weights p --alpha 5 --gate 8 --gap-s 15 --json --out fit.csv";
    let run = folder.run(&format!("{call} --angles heading --plot fit.svg")).done();
    let json: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(json["heading"]["rejected_s"], serde_json::json!([20.0]));
    let (_, fit) = csv(&folder, "fit.csv");
    for line in &fit {
        assert!((line[1] - (300.2 + 3.0 * line[0])).abs() < 0.3 && (line[2] - 3.0).abs() < 0.3, "{line:?}");
    }
    let plot = folder.text("fit.svg");
    assert!(plot.starts_with("<svg") && plot.trim_end().ends_with("</svg>") && plot.contains("heading"));
    // Without weights the empty field is no number.
    assert_eq!(folder.run(&call.replace("--weights p", "")).code, Some(2));
}

/// A gap longer than usual that was allowed is told.
#[test]
fn gaps_that_were_allowed_are_told() {
    let folder = Folder::new("smooth-gaps");
    let lines: Vec<String> = (0..30).map(|i| format!("{},{}", if i < 15 { i } else { i + 40 }, i * i % 7)).collect();
    folder.write("log.csv", format!("t,y\n{}\n", lines.join("\n")));
    let call = "smooth --in log.csv --time t --columns y --alpha 5 --json --out fit.csv";
    let run = folder.run(&format!("{call} --gap-s 41")).done();
    assert!(run.stderr.contains("gap of 41.000 s bridged, 14 s to 55 s"), "{run:?}");
    let json: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(json["y"]["gaps_s"], serde_json::json!([[14.0, 55.0]]));
    assert_eq!(folder.run(call).code, Some(2));
}

/// Equal inputs give equal bytes.
#[test]
fn twice_the_same() {
    let (folder, _) = samples("smooth-twice");
    let all = || {
        let json = folder.run(&format!("{SMOOTH} --plot fit.svg").replace("--alpha 10", "--alpha gcv")).done().stdout;
        (json, folder.text("fit.csv"), folder.text("fit.svg"))
    };
    assert_eq!(all(), all());
}
