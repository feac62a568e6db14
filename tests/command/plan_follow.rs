//! Plans whose flying heights follow the ground, every file of them against the ground itself.

use crate::elevation::grid;
use crate::folder::{Folder, with};
use crate::refusals::Refusals;
use serde_json::Value;

const PLAN: &str = "plan --dem dem.asc --area 0,0,400,300 --camera camera.toml --height-m 200 --overlap 60/30 --origin 48,11 \
                    --follow-terrain 8 --vehicle multirotor --out out";
/// What the grid's two decimals and the file's millimetres and centimetres leave.
const ROUNDED_M: f64 = 0.02;

/// A slope of 20 % with waves across it.
fn hillside(x: f64, y: f64) -> f64 {
    400.0 + 0.2 * x + 25.0 * (x / 80.0).sin() + 0.1 * y
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).expect("JSON")
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().expect("a number")
}

fn array<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    value[key].as_array().expect("a list")
}

/// Height of the ground between posts of 25 m along x, on a row of posts or between two.
fn ground(x: f64, y: f64) -> f64 {
    let post = |x: f64| 25.0 * (x / 25.0).floor();
    let along = |y: f64| {
        let share = (x - post(x)) / 25.0;
        hillside(post(x), y) * (1.0 - share) + hillside(post(x) + 25.0, y) * share
    };
    let share = (y - post(y)) / 25.0;
    along(post(y)) * (1.0 - share) + along(post(y) + 25.0) * share
}

#[test]
fn photos_and_way_points_follow_the_ground_in_every_file() {
    let folder = Folder::with_scene("follow-files");
    folder.write("dem.asc", grid(hillside));
    let text = folder.run(&format!("{PLAN} --takeoff-and-return")).done().stdout;
    assert!(text.contains("200.0 m above the ground, followed within 8 m"), "{text}");
    let plan = json(&folder, "out/plan.json");
    let mut ways = Vec::new();
    for strip in array(&plan, "strips") {
        let way: Vec<[f64; 3]> =
            array(strip, "way").iter().map(|p| [number(p, "x"), number(p, "y"), number(p, "z")]).collect();
        assert!(way.len() > 2 && way.windows(2).all(|pair| pair[1][0] > pair[0][0]), "{way:?}");
        let z_at = |x: f64| {
            let pair = way.windows(2).find(|pair| x <= pair[1][0]).expect("on the way");
            pair[0][2] + (pair[1][2] - pair[0][2]) * (x - pair[0][0]) / (pair[1][0] - pair[0][0])
        };
        for photo in array(strip, "photos") {
            assert!((z_at(number(photo, "x")) - number(photo, "z")).abs() < 1e-6, "{photo}");
        }
        // The slope's steepest part, 51 %, is more than the 30 % allowed: higher, never lower.
        for step in 0..=500 {
            let x = way[0][0] + (way[way.len() - 1][0] - way[0][0]) * f64::from(step) / 500.0;
            let above = z_at(x) - ground(x, way[0][1]);
            assert!(above >= 192.0 - ROUNDED_M, "{above} at {x}");
        }
        let steepest = way.windows(2).map(|p| ((p[1][2] - p[0][2]) / (p[1][0] - p[0][0])).abs()).fold(0.0, f64::max);
        assert!(steepest <= 0.3 + 1e-6, "{steepest}");
        let is_back = number(strip, "heading_deg") >= 180.0;
        ways.push(if is_back { way.into_iter().rev().collect() } else { way });
    }
    let checks = &plan["checks"];
    assert!(number(checks, "clearance_min_m") > 100.0 && number(checks, "climb_percent") <= 30.0 + 1e-6, "{checks}");
    let mission = json(&folder, "out/plan.plan");
    let items = array(&mission["mission"], "items");
    let altitudes: Vec<f64> =
        items.iter().filter(|item| item["command"] == 16).map(|item| number(item, "Altitude")).collect();
    let planned: Vec<f64> = ways.iter().flatten().map(|point| point[2]).collect();
    assert_eq!(altitudes.len(), planned.len());
    assert!(altitudes.iter().zip(&planned).all(|(a, z)| (a - z).abs() <= 0.0051), "{altitudes:?} {planned:?}");
    assert!(
        items.iter().filter(|item| item["command"] == 16).all(|item| item["AltitudeMode"] == 2 && item["frame"] == 0)
    );
    assert!(
        (number(&items[0], "Altitude") - planned[0]).abs() <= 0.0051,
        "it takes off to the first waypoint's height"
    );
    let page = folder.text("out/report.html");
    let heights: Vec<f64> = ways.iter().flatten().map(|point| point[2]).collect();
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let says = format!("above the ground, followed within 8 m: flown at altitudes of {low:.0} to {high:.0} m, ");
    assert!(high > low + 10.0 && page.replace('\u{202f}', " ").contains(&says), "{says}");
}

#[test]
fn the_climb_is_the_vehicles_and_what_cannot_be_is_refused() {
    let folder = Folder::with_scene("follow-climb");
    folder.write("dem.asc", grid(hillside));
    let climb = |options: &str| {
        // The turns of an aeroplane at 35 m/s reach up the hillside.
        folder.run(&format!("{} --force {options}", with(PLAN, "--vehicle", "fixed-wing"))).done();
        number(&json(&folder, "out/plan.json")["checks"], "climb_percent")
    };
    assert!(climb("") <= 10.0 + 1e-6 && climb("--climb-percent 4") <= 4.0 + 1e-6 && climb("--climb-percent 25") > 10.0);
    let mut refusals = Refusals::new(&folder);
    let bare = PLAN.replace("--follow-terrain 8 ", "");
    refusals.expect(&format!("{bare} --climb-percent 5"), &["--follow-terrain"]);
    refusals.expect(&format!("{PLAN} --climb-percent 120"), &["--climb-percent 120", "45 degrees"]);
    refusals.expect(&with(PLAN, "--follow-terrain", "0"), &["--follow-terrain"]);
    refusals.done();
}

/// The board's photos over the hillside, flown by the simulated vehicle: as high above the ground as planned.
#[test]
fn the_simulator_flies_what_was_planned() {
    let folder = Folder::with_scene("follow-flown");
    folder.write("dem.asc", grid(hillside));
    let epsg = PLAN.replace("--origin 48,11 ", "");
    folder.write("dem.prj", crate::plan_safety::METRES);
    folder.run(&epsg).done();
    folder.run("fly --plan out/plan.json --frames 12 --out flown").done();
    // A simulation of what nobody should fly is told.
    folder.run(&format!("{epsg} --min-clearance-m 500 --force")).done();
    let run = folder.run("fly --plan out/plan.json --frames 1 --out unsafe").done();
    assert!(run.stderr.contains("the plan's checks failed: the flight passes"), "{run:?}");
    // So is ground that the plan was not made over; its own under another name is its own.
    folder.write("own.asc", folder.text("dem.asc"));
    folder.write("own.prj", crate::plan_safety::METRES);
    folder.write("other.asc", grid(|east, north| hillside(east, north) + 300.0));
    folder.write("other.prj", crate::plan_safety::METRES);
    let over = |dem: &str| folder.run(&format!("fly --plan out/plan.json --dem {dem} --frames 1")).done().stderr;
    assert!(!over("own.asc").contains("--dem"), "{}", over("own.asc"));
    let said = over("other.asc");
    for part in
        ["--dem other.asc: not the elevation model that out/plan.json was made over", "above the lowest flying height"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
    folder.run(&epsg).done();
    let plan = json(&folder, "out/plan.json");
    let poses = folder.text("flown/poses.csv");
    let head: Vec<&str> = poses.lines().next().expect("a head").split(',').collect();
    let column = |name: &str| head.iter().position(|key| *key == name).unwrap_or_else(|| panic!("{name} in {head:?}"));
    let photos: Vec<&Value> = array(&plan, "strips").iter().flat_map(|strip| array(strip, "photos")).collect();
    let heights: Vec<f64> = photos.iter().map(|photo| number(photo, "z")).collect();
    let range = heights.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(*z), high.max(*z)]);
    assert!(range[1] - range[0] > 40.0, "{range:?}");
    let mut rows = 0;
    for row in poses.lines().skip(1) {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let (east, north) = (row[column("east_m")], row[column("north_m")]);
        let up = row[column("height_m")] + ground(east, north);
        let nearest = photos.iter().min_by(|a, b| {
            let far = |photo: &Value| (number(photo, "x") - east).hypot(number(photo, "y") - north);
            far(a).total_cmp(&far(b))
        });
        let wanted = number(nearest.expect("photos"), "z");
        assert!((up - wanted).abs() < 4.0, "{up} for {wanted}");
        rows += 1;
    }
    assert!(rows > 6, "{rows}");
}
