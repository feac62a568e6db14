//! Flights over real relief, planned and flown by the command, with an elevation model on board and without.

use crate::command::plumbline;
use crate::folder::Folder;
use plumbline_survey::io::data;
use serde_json::Value;

/// 128 x 128 pixels, 60 degrees both ways.
const CAMERA: &str =
    "cols = 128\nrows = 128\nfov_h_deg = 60.0\nfov_v_deg = 60.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n";
const RESOLUTION_M: f64 = 5.0;

/// A flight's share of accepted frames, mean error (pixels to the east and south) and mean NEES.
#[derive(Debug)]
struct Flown {
    accepted: f64,
    bias_px: [f64; 2],
    nees: f64,
}

fn flown(folder: &Folder, name: &str, posts_m: f64) -> Flown {
    let arguments = format!(
        "fly --plan plan/plan.json --frames 200 --set resolution_m={RESOLUTION_M} \
         --set reference.elevation_posts_m={posts_m} --out {name} --json"
    );
    let report = plumbline(&folder.path(""), &arguments).output().expect("it runs");
    let report: Value = crate::command::Run::from(report).json();
    let csv = String::from_utf8(folder.read(&format!("{name}/fixes.csv"))).expect("text");
    let rows = csv.lines().skip(1).map(|line| line.split(',').collect::<Vec<&str>>());
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let (mut frames, mut errors) = (0.0, Vec::new());
    for row in rows {
        frames += 1.0;
        if row[2] == "1" {
            errors.push([4, 5].map(|at| number(row[at]) - number(row[at + 2])));
        }
    }
    let count = errors.len() as f64;
    let bias_px = [0, 1].map(|axis| errors.iter().map(|error| error[axis]).sum::<f64>() / count);
    let nees = report["nees_mean"].as_f64().unwrap_or(f64::NAN);
    let flown = Flown { accepted: count / frames, bias_px, nees };
    println!("{name}: {flown:.3?}");
    flown
}

/// Plans over a part of a model and flies with and without posts. `within`: what is accepted at least with them.
fn relief(name: &str, dem: &str, area: &str, height_m: u32, within: f64) {
    let Some(dem) = data::for_test("flights over relief", &format!("dem/{dem}")) else { return };
    let folder = Folder::new(name);
    folder.write("camera.toml", CAMERA);
    let arguments = format!(
        // Turns may leave the model: they are not flown here.
        "plan --area={area} --height-m {height_m} --overlap 60/30 --force --camera camera.toml --out plan --dem {}",
        dem.display()
    );
    let planned = plumbline(&folder.path(""), &arguments).output().expect("it runs");
    crate::command::Run::from(planned).done();
    let (before, after) = (flown(&folder, "level", 0.0), flown(&folder, "sloping", 30.0));
    assert!(after.accepted >= within && after.accepted > before.accepted + 0.1, "{before:?} {after:?}");
    assert!(after.bias_px.iter().all(|bias| bias.abs() <= 0.1), "{after:?}");
    assert!((1.6..=2.6).contains(&after.nees), "{after:?}");
    let is_biased = before.bias_px.iter().any(|bias| bias.abs() > 0.2);
    assert!(is_biased || before.nees > 2.6, "level ground would do as well: {before:?}");
}

#[test]
fn over_hills_fixes_are_unbiased_and_say_how_good_they_are() {
    relief("relief-jacksboro", "jacksboro_3arcsec.tif", "-84.275,36.505,-84.255,36.520", 300, 0.9);
}

#[test]
fn over_mountains_fixes_are_unbiased_and_say_how_good_they_are() {
    relief("relief-austria", "austria_dhm_10m_west.tif", "553000,429000,556000,431000", 500, 0.9);
}
