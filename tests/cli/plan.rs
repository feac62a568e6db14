//! `plumbline plan`: what it writes, what it leaves out, and what it refuses.

use crate::folder::{Folder, with};
use crate::refusals::Refusals;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;

const PLAN: &str =
    "plan --dem dem.asc --area 0,0,400,300 --camera camera.toml --height-m 300 --overlap 60/30 --out out";
const LEFT_OUT: &str = "plan.plan and plan.kml are left out: the elevation model has no reference system, and --origin is not given\n";

/// An ESRI ASCII grid of 25 m over -1500 to 2000 both ways; `height` may be its no-data.
fn grid(height: impl Fn(f64, f64) -> f64) -> String {
    let mut text = "ncols 141\nnrows 141\nxllcenter -1500\nyllcenter -1500\ncellsize 25\nNODATA_value -9999\n".to_owned();
    for row in 0..141 {
        let y = 2000.0 - 25.0 * f64::from(row);
        for col in 0..141 {
            let _ = write!(text, "{:.2} ", height(-1500.0 + 25.0 * f64::from(col), y));
        }
        text.push('\n');
    }
    text
}

fn hills(x: f64, y: f64) -> f64 {
    100.0 + 30.0 * (x / 300.0).sin() * (y / 200.0).cos()
}

fn scene(name: &str) -> Folder {
    let folder = Folder::with_scene(name);
    folder.write("dem.asc", grid(hills));
    folder
}

/// Names of the files in `out`.
fn written(folder: &Folder) -> BTreeSet<String> {
    let out = folder.path("out");
    let paths = folder.content().into_keys().filter(|path| path.parent() == Some(&out));
    paths.filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())).collect()
}

fn names(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn local_metres_leave_two_files_out_and_an_origin_brings_them() {
    let folder = scene("plan-local");
    let run = folder.run(PLAN).done();
    assert_eq!(run.stderr, LEFT_OUT);
    assert!(run.stdout.contains("60.00 % forward"), "{run:?}");
    assert_eq!(written(&folder), names(&["coverage.tif", "plan.geojson", "plan.json", "report.html"]));
    let run = folder.run(&format!("{PLAN} --origin 48,11")).done();
    assert_eq!(run.stderr, "");
    let all = ["coverage.tif", "plan.geojson", "plan.json", "plan.kml", "plan.plan", "report.html"];
    assert_eq!(written(&folder), names(&all));
    let plan: Value = serde_json::from_str(&folder.text("out/plan.json")).expect("JSON");
    // x = 0, y = 0 is the first line's second photo: a nominal base behind its first.
    let photo = &plan["strips"][0]["photos"][1];
    assert_eq!((photo["x"].as_f64(), photo["y"].as_f64()), (Some(0.0), Some(0.0)), "{photo}");
    assert_eq!((photo["lat"].as_f64(), photo["lon"].as_f64()), (Some(48.0), Some(11.0)));
    // Without the origin again, the files that would be of another plan go.
    folder.run(PLAN).done();
    assert_eq!(written(&folder), names(&["coverage.tif", "plan.geojson", "plan.json", "report.html"]));
}

#[test]
fn json_is_the_plans_file_and_the_same_request_gives_the_same_bytes() {
    let folder = scene("plan-json");
    let request = format!("{PLAN} --origin 48,11 --json");
    let plan = folder.run(&request).json();
    let file: Value = serde_json::from_str(&folder.text("out/plan.json")).expect("JSON");
    assert_eq!(plan, file);
    let least = plan["overlap_min"]["forward"].as_f64().expect("a number");
    assert!((0.6..0.7).contains(&least), "{least}");
    let before = folder.content();
    folder.run(&request).done();
    assert!(folder.content() == before);
}

#[test]
fn a_mission_longer_than_autopilots_take_is_told() {
    let folder = scene("plan-items");
    let plan = with(&with(PLAN, "--height-m", "150"), "--overlap", "94/80");
    let run = folder.run(&format!("{plan} --origin 48,11 --trigger-items")).done();
    assert!(run.stderr.starts_with("plan.plan has ") && run.stderr.ends_with("take 724\n"), "{run:?}");
    let mission: Value = serde_json::from_str(&folder.text("out/plan.plan")).expect("JSON");
    let items = mission["mission"]["items"].as_array().expect("items").len();
    assert!(items > 724 && run.stderr.contains(&items.to_string()), "{items} {run:?}");
    assert_eq!(folder.run(&format!("{plan} --origin 48,11")).done().stderr, "");
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let folder = scene("plan-refused");
    let hole = |x: f64, y: f64| if x == 200.0 && y == 100.0 { -9999.0 } else { hills(x, y) };
    folder.write("hole.asc", grid(hole));
    folder.write("peak.asc", grid(|x, y| if x == 200.0 && y == 100.0 { 5000.0 } else { hills(x, y) }));
    folder.write("odd.asc", grid(hills));
    folder.write("odd.prj", "somewhere");
    folder.write("bow.json", r#"{"type":"Polygon","coordinates":[[[0,0],[400,300],[400,0],[0,300],[0,0]]]}"#);
    folder.write("holed.json", r#"{"type":"Polygon","coordinates":[[[0,0],[400,0],[400,300],[0,0]],[[300,50],[310,50],[310,60],[300,50]]]}"#);
    folder.write("file", "");
    folder.make("taken");
    folder.make("taken/plan.kml");
    let optimise = PLAN.replace("--overlap 60/30", "--optimise");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&with(PLAN, "--area", "0,0,9000,300"), &["outside", "dem.asc"]);
    refusals.expect(&with(PLAN, "--area", "0,0,400"), &["--area"]);
    refusals.expect(&with(PLAN, "--area", "bow.json"), &["crosses"]);
    refusals.expect(&with(PLAN, "--area", "holed.json"), &["holed.json", "hole"]);
    refusals.expect(&with(PLAN, "--dem", "hole.asc"), &["no height under the area", "x 200.0", "y 100.0"]);
    refusals.expect(&with(PLAN, "--dem", "peak.asc"), &["terrain rises to 5000.0 m", "flying height"]);
    refusals.expect(&with(PLAN, "--dem", "odd.asc"), &["odd.prj"]);
    refusals.expect(&with(PLAN, "--dem", "frame.png"), &["frame.png"]);
    refusals.expect(&format!("{optimise} --limits-m 0.0001,0.0001"), &["none of the 77 combinations", "the accuracy 77"]);
    refusals.expect(&format!("{PLAN} --speed-m-s 100 --min-interval-s 5"), &["100 m/s", "5 s"]);
    refusals.expect(&format!("{PLAN} --min-interval-s 0.01"), &["--min-interval-s 0.01", "0.038"]);
    refusals.expect(&PLAN.replace("--height-m 300", "--scale 5000"), &["pixel_mm", "camera.toml"]);
    refusals.expect(&format!("{PLAN} --origin 91,11"), &["--origin 91,11"]);
    refusals.expect(&with(PLAN, "--out", "missing/out"), &["--out", "missing"]);
    refusals.expect(&with(PLAN, "--out", "file"), &["--out", "file"]);
    refusals.expect(&with(PLAN, "--out", "taken"), &["plan.kml"]);
    refusals.done();
}
