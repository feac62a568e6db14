//! `plumbline plan`: what it writes, what it leaves out, and what it refuses.

use crate::elevation::grid;
use crate::folder::{Folder, with};
use crate::refusals::Refusals;
use serde_json::Value;
use std::collections::BTreeSet;

const PLAN: &str =
    "plan --dem dem.asc --area 0,0,400,300 --camera camera.toml --height-m 300 --overlap 60/30 --out out";
const LEFT_OUT: &str = "plan.plan and plan.kml are left out, and plan.geojson has local metres alone: the elevation model has no \
     reference system, and --origin is not given\n";

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
    assert!(
        run.stderr.lines().count() == 1 && run.stderr.contains("does not say above what its heights are"),
        "{run:?}"
    );
    assert_eq!(folder.run(&format!("{PLAN} --origin 48,11 --vertical-epsg 5773")).done().stderr, "");
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
    let run = folder.run(&format!("{plan} --origin 48,11 --vertical-epsg 5773 --trigger-items")).done();
    assert!(run.stderr.starts_with("plan.plan has ") && run.stderr.ends_with("take 724\n"), "{run:?}");
    let mission: Value = serde_json::from_str(&folder.text("out/plan.plan")).expect("JSON");
    let items = mission["mission"]["items"].as_array().expect("items").len();
    assert!(items > 724 && run.stderr.contains(&items.to_string()), "{items} {run:?}");
    assert_eq!(folder.run(&format!("{plan} --origin 48,11 --vertical-epsg 5773")).done().stderr, "");
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
    folder.write(
        "holed.json",
        r#"{"type":"Polygon","coordinates":[[[0,0],[400,0],[400,300],[0,0]],[[300,50],[310,50],[310,60],[300,50]]]}"#,
    );
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
    refusals
        .expect(&format!("{optimise} --limits-m 0.0001,0.0001"), &["none of the 77 combinations", "the accuracy 77"]);
    refusals.expect(&format!("{PLAN} --speed-m-s 100 --min-interval-s 5"), &["100 m/s", "5 s"]);
    refusals.expect(&format!("{PLAN} --min-interval-s 0.01"), &["--min-interval-s 0.01", "0.038"]);
    refusals.expect(&PLAN.replace("--height-m 300", "--scale 5000"), &["pixel_mm", "camera.toml"]);
    refusals.expect(&format!("{PLAN} --origin 91,11"), &["--origin 91,11"]);
    refusals.expect(&with(PLAN, "--out", "missing/out"), &["--out", "missing"]);
    refusals.expect(&with(PLAN, "--out", "file"), &["--out", "file"]);
    refusals.expect(&with(PLAN, "--out", "taken"), &["plan.kml"]);
    refusals.done();
}

#[test]
fn the_page_has_the_plans_figures_and_needs_nothing_else() {
    let folder = scene("plan-page");
    folder.write("a<b&c.asc", grid(hills));
    let file = folder.run(&format!("{} --json", with(PLAN, "--dem", "a<b&c.asc"))).json();
    let number = |pointer: &str| file.pointer(pointer).and_then(Value::as_f64).expect("a number");
    let page = folder.text("out/report.html");
    let (photos, strips) = (number("/photo_count"), file["strips"].as_array().expect("strips"));
    for figure in [
        format!("<h1>{photos} photos on {} lines</h1>", strips[strips.len() - 1]["line"].as_u64().expect("a line") + 1),
        format!("{:.3}\u{202f}m", number("/accuracy/plan_m")),
        format!("{:.3}\u{202f}m", number("/accuracy/height_m")),
        format!("{:.1}\u{202f}min", number("/checks/flight_time_s") / 60.0),
        format!("{:.3}\u{202f}s", number("/interval_min_s")),
        format!("{:.1}\u{202f}m", number("/constant_base/base_m")),
        "a&lt;b&amp;c.asc".to_owned(),
    ] {
        assert!(page.contains(&figure), "{figure}");
    }
    let (_, map) = page.split_once("</style>").expect("a style");
    let dots = map.split("stroke=\"#b3261e\"").next().and_then(|before| before.rsplit("d=\"").next());
    assert_eq!(dots.map(|path| path.matches("h0").count()), Some(photos as usize), "a dot each");
    for outside in ["http:", "https:", "<script", "src=\"/", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn the_order_of_flight_and_the_model_are_in_the_plan() {
    let folder = scene("plan-order");
    let plan = folder.run(&format!("{PLAN} --json")).json();
    let order: Vec<[usize; 2]> = serde_json::from_value(plan["flight_order"].clone()).expect("pairs");
    let mut wanted = Vec::new();
    for (strip, of) in plan["strips"].as_array().expect("strips").iter().enumerate() {
        let photos = 0..of["photos"].as_array().expect("photos").len();
        let is_back = of["heading_deg"] == 270.0;
        wanted.extend(
            if is_back { photos.rev().collect::<Vec<_>>() } else { photos.collect() }
                .iter()
                .map(|photo| [strip, *photo]),
        );
    }
    assert_eq!(order, wanted);
    assert!(wanted.windows(2).any(|pair| pair[1][1] < pair[0][1] && pair[1][1] > 0), "a strip is flown back");
    assert_eq!(plan["dem"], "dem.asc");
    assert_eq!(plan["dem_path"].as_str().map(std::path::PathBuf::from), folder.path("dem.asc").canonicalize().ok());
    assert_eq!(plan["dem_sha256"].as_str().map(str::len), Some(64));
    // Over hills two strips see less in common than their overlap says, on level ground just as much.
    let side =
        |plan: &Value| [&plan["overlap_min"], &plan["swath_min"]].map(|least| least["side"].as_f64().expect("pairs"));
    let [overlap, swath] = side(&plan);
    assert!((0.1..overlap).contains(&swath), "{overlap} {swath}");
    folder.write("dem.asc", grid(|_, _| 100.0));
    let [overlap, swath] = side(&folder.run(&format!("{PLAN} --json")).json());
    assert!((overlap - 0.3).abs() < 1e-9 && (swath - 0.3).abs() < 1e-6, "{overlap} {swath}");
}

/// A tower beside the area, under the first turn: 7.7 m below the flying height.
#[test]
fn a_flight_too_near_the_ground_fails_unless_it_is_forced() {
    let folder = scene("plan-clearance");
    let altitude =
        folder.run(&format!("{PLAN} --json")).json()["strips"][0]["photos"][0]["z"].as_f64().expect("a height");
    let tower = move |top: f64| grid(move |x, y| if (x, y) == (-350.0, 0.0) { top } else { hills(x, y) });
    folder.write("dem.asc", tower(altitude - 7.7));
    for (options, code) in [("", 1), (" --force", 0), (" --min-clearance-m 5", 0), (" --min-clearance-m 8", 1)] {
        let _ = std::fs::remove_dir_all(folder.path("out"));
        let run = folder.run(&format!("{PLAN}{options}"));
        assert_eq!(run.code, Some(code), "{options}: {run:?}");
        assert!(run.stderr.contains("7.7 m above the terrain") == (code == 1), "{options}: {run:?}");
        let place = "on strip 1 near x -350, y 0, where the ground is at ";
        assert!(run.stderr.contains(place) == (code == 1), "{options}: {run:?}");
        let page = folder.text("out/report.html");
        assert!(page.contains(r#"<g id="nearest""#) && page.contains("m on strip 1 at x "), "{options}");
        assert!(written(&folder).contains("plan.json"), "{options}");
        assert!(
            folder.text("out/report.html").contains(">too low<") == (code == 1 || options == " --force"),
            "{options}"
        );
    }
    folder.write("dem.asc", tower(altitude + 20.0));
    let run = folder.run(PLAN);
    assert!(run.code == Some(1) && run.stderr.contains("rises 20.0 m above the flying height"), "{run:?}");
}

/// Files of more than 32 KiB cannot be written, as on a disk that is full: the page is the last and the only one so long.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_earlier_plan_as_it_was() {
    let folder = scene("plan-full");
    folder.run(PLAN).done();
    let before = folder.content();
    let limited = format!("trap '' XFSZ; ulimit -f 32; exec \"$0\" {}", with(PLAN, "--height-m", "320"));
    let run = std::process::Command::new("bash")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_plumbline")])
        .current_dir(folder.path(""))
        .output()
        .expect("it runs");
    let stderr = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.code() == Some(1) && stderr.contains("cannot write out/"), "{stderr}");
    assert!(folder.content() == before);
}
