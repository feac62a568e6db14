//! Plans over models whose heights are probably none in metres, or above nobody says what.

use crate::elevation::grid;
use crate::folder::{Folder, with};
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes};
use serde_json::Value;

const PLAN: &str = "plan --dem dem.tif --area 600000,5200000,600400,5200300 --camera camera.toml --height-m 300 --overlap 60/30 --out out";
const STORE: &str = "configuration --plan out/plan.json --out plan.bin";

/// Posts of 25 m over 3.5 km both ways on UTM 33.
fn model(height: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let samples: Vec<f32> =
        (0..141 * 141).map(|k| height(25.0 * f64::from(k % 141), 25.0 * f64::from(k / 141)) as f32).collect();
    let geo = GeoTransform { x0: 598_500.0, y0: 5_202_000.0, step_x: 25.0, step_y: 25.0 };
    let bands = [Band { description: "height", samples: &samples }];
    geotiff_bytes(141, 141, &bands, &geo, Some(System::Epsg(32633)), f32::NAN).expect("a raster")
}

fn hills(x: f64, y: f64) -> f64 {
    160.0 + 60.0 * (x / 170.0).sin() * (y / 230.0).cos() + 12.0 * (x / 41.0 + y / 60.0).sin()
}

/// Between 0 and 1, another number at each post.
fn noise(x: f64, y: f64) -> f64 {
    ((x * 12.9898 + y * 78.233).sin() * 43_758.545_3).fract().abs()
}

fn json(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).expect("JSON")
}

#[test]
fn heights_in_kilometres_are_not_flown_over() {
    let folder = Folder::with_scene("heights-km");
    folder.write("dem.tif", model(|x, y| 1e-3 * hills(x, y)));
    let run = folder.run(PLAN);
    assert!(run.code == Some(1) && run.stderr.contains("kilometres") && run.stderr.contains("--force"), "{run:?}");
    assert_eq!(json(&folder, "out/plan.json")["checks"]["heights_doubt"], "kilometres");
    let page = folder.text("out/report.html");
    assert!(page.contains("Not safe to fly: ") && page.contains("whose heights are kilometres"));
    let mut refusals = Refusals::new(&folder);
    refusals.expect(STORE, &["out/plan.json", "kilometres", "--force"]);
    refusals.done();
    folder.run(&format!("{PLAN} --force")).done();
    // A datum is no unit. A file that says that they are metres is believed.
    assert_eq!(folder.run(&format!("{PLAN} --vertical-epsg 5773")).code, Some(1));
    folder.write("dem.asc", grid(|x, y| 1e-3 * hills(x + 1500.0, 2000.0 - y)));
    let of_grid = with(&with(PLAN, "--dem", "dem.asc"), "--area", "0,0,400,300");
    folder.write("dem.prj", crate::plan_safety::METRES);
    assert_eq!(folder.run(&of_grid).code, Some(1));
    let vertical = r#",VERTCS["EGM96_Geoid",VDATUM["EGM96_Geoid"],UNIT["Meter",1.0]]"#;
    folder.write("dem.prj", format!("{}{vertical}", crate::plan_safety::METRES));
    folder.run(&of_grid).done();
    assert!(json(&folder, "out/plan.json")["checks"].get("heights_doubt").is_none());
    folder.write("dem.tif", model(hills));
    folder.run(PLAN).done();
    folder.run(STORE).done();
}

/// As flat as land is: below the sea and above it, with noise of the survey, in floats and rounded to centimetres.
#[test]
fn a_polder_is_flown_over() {
    let folder = Folder::with_scene("heights-polder");
    for (low, high) in [(-5.0, 3.0), (0.0, 2.0), (1.0, 1.3)] {
        let polder = move |x: f64, y: f64| {
            low + (high - low) * 0.5 * (1.0 + (x / 900.0 + y / 1300.0).sin()) + 0.06 * noise(x, y)
        };
        folder.write("dem.tif", model(polder));
        folder.run(PLAN).done();
        assert!(json(&folder, "out/plan.json")["checks"].get("heights_doubt").is_none());
        folder.write("dem.asc", grid(polder));
        let local = with(&with(PLAN, "--dem", "dem.asc"), "--area", "0,0,400,300");
        folder.run(&format!("{local} --origin 52,5")).done();
    }
}

#[test]
fn a_model_that_is_0_throughout_is_asked_about() {
    let folder = Folder::with_scene("heights-zero");
    folder.write("dem.tif", model(|_, _| 0.0));
    folder.write("dem.asc", grid(|_, _| 0.0));
    let local = with(&with(PLAN, "--dem", "dem.asc"), "--area", "0,0,400,300");
    for plan in [PLAN, &format!("{PLAN} --vertical-epsg 5773"), &format!("{local} --origin 52,5")] {
        let run = folder.run(plan);
        assert!(run.code == Some(1) && run.stderr.contains("0 throughout, as an empty export is"), "{plan}: {run:?}");
        folder.run(&format!("{plan} --force")).done();
    }
    // Of a place that nobody knows no mission is written, and 0 may be anywhere.
    let run = folder.run(&local).done();
    assert!(run.stderr.contains("has the height 0 m throughout: is that meant?"), "{run:?}");
    folder.write("dem.asc", grid(|_, _| 100.0));
    let run = folder.run(&format!("{local} --origin 52,5")).done();
    assert!(run.stderr.contains("has the height 100 m throughout: is that meant?"), "{run:?}");
}

/// Hills many times too high: whether there is a plan or none, what is wrong is said.
#[test]
fn heights_in_smaller_units_are_steeper_than_ground() {
    let folder = Folder::with_scene("heights-cm");
    for (times, height, code) in [(25.0, "12000", 1), (36.0, "20000", 1), (25.0, "500", 2)] {
        folder.write("dem.tif", model(|x, y| (times * hills(x, y)).round()));
        let run = folder.run(&with(PLAN, "--height-m", height));
        assert_eq!(run.code, Some(code), "{times} {height}: {run:?}");
        assert!(run.stderr.contains("steeper than ground is") && run.stderr.contains("-scale 0.1"), "{times}: {run:?}");
    }
}

/// A grid in degrees that does not say so is no terrain of some decimetres.
#[test]
fn degrees_without_a_name_are_no_metres() {
    let folder = Folder::with_scene("heights-degrees");
    let text = grid(|x, y| hills(x + 1500.0, 2000.0 - y));
    let degrees =
        text.replace("xllcenter -1500\nyllcenter -1500\ncellsize 25", "xllcenter 11\nyllcenter 48\ncellsize 0.00025");
    assert_ne!(text, degrees);
    folder.write("dem.asc", degrees);
    let plan = with(&with(PLAN, "--dem", "dem.asc"), "--area", "11.01,48.01,11.02,48.02");
    let mut refusals = Refusals::new(&folder);
    for options in ["", " --origin 48,11"] {
        let line = "gdal_translate -a_srs EPSG:4326 dem.asc dem_degrees.tif";
        refusals.expect(&format!("{plan}{options}"), &["dem.asc", "0.00025 apart", "degrees", line]);
    }
    refusals.done();
}

#[test]
fn what_heights_are_above_is_said_or_asked() {
    let folder = Folder::with_scene("heights-datum");
    folder.write("dem.tif", model(hills));
    let asked = "does not say above what its heights are";
    let run = folder.run(PLAN).done();
    assert!(run.stderr.contains(asked) && run.stderr.contains("--geoid FILE"), "{run:?}");
    // Gentle hills in feet are known by their numbers alone.
    assert!(run.stderr.contains("nor in which unit: ") && run.stderr.contains(" are taken for metres"), "{run:?}");
    let assumed = json(&folder, "out/plan.json");
    assert_eq!(assumed["vertical"], serde_json::json!({ "datum": "assumed", "epsg": null }));
    assert!(folder.text("out/report.html").contains("mean sea level is assumed"));
    let run = folder.run(&format!("{PLAN} --vertical-epsg 3855")).done();
    assert!(!run.stderr.contains(asked), "{run:?}");
    assert_eq!(json(&folder, "out/plan.json")["vertical"]["epsg"], 3855);
    // ESRI's text of heights above the ellipsoid, and of others.
    folder.write("dem.asc", grid(|x, y| hills(x + 1500.0, 2000.0 - y)));
    let local = with(&with(PLAN, "--dem", "dem.asc"), "--area", "0,0,400,300");
    let prj = |vertical: &str| format!("{}{vertical}", crate::plan_safety::METRES);
    folder.write("dem.prj", prj(r#",VERTCS["EGM2008_Geoid",VDATUM["EGM2008_Geoid"],UNIT["Meter",1.0]]"#));
    assert!(!folder.run(&local).stderr.contains(asked));
    folder.write("geoid.gtx", geoid(40.0));
    folder.write("model.gtx", geoid(400.0));
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{local} --geoid geoid.gtx"), &["--geoid", "above mean sea level already"]);
    folder.write("dem.prj", prj(r#",VERTCS["WGS_1984",DATUM["D_WGS_1984"],UNIT["Meter",1.0]]"#));
    refusals.expect(&local, &["above an ellipsoid", "--geoid FILE"]);
    refusals.expect(&format!("{PLAN} --vertical-epsg 4979"), &["--vertical-epsg 4979", "--geoid FILE"]);
    refusals.expect(&format!("{PLAN} --vertical-epsg 32633"), &["--vertical-epsg 32633", "no vertical system"]);
    refusals.expect(&format!("{PLAN} --geoid model.gtx"), &["model.gtx", "is it an elevation model?"]);
    refusals.expect(&format!("{PLAN} --geoid dem.tif"), &["dem.tif"]);
    refusals.expect(&format!("{PLAN} --geoid missing.gtx"), &["missing.gtx"]);
    std::fs::remove_file(folder.path("dem.prj")).expect("removed");
    refusals.expect(&format!("{local} --geoid geoid.gtx"), &["--geoid geoid.gtx", "--origin"]);
    refusals.expect(&format!("{local} --origin -52,5 --geoid geoid.gtx"), &["geoid.gtx", "does not cover"]);
    refusals.done();
}

/// GTX of 60 by 60 degrees from 10 degrees south and 5 degrees east, in steps of a degree, all of one height.
fn geoid(height_m: f32) -> Vec<u8> {
    let mut bytes: Vec<u8> = [-10.0_f64, 5.0, 1.0, 1.0].iter().flat_map(|number| number.to_be_bytes()).collect();
    [60_i32, 60].iter().for_each(|count| bytes.extend(count.to_be_bytes()));
    (0..3600).for_each(|_| bytes.extend(height_m.to_be_bytes()));
    bytes
}

#[test]
fn a_geoid_lowers_the_mission_and_nothing_else() {
    let folder = Folder::with_scene("heights-geoid");
    folder.write("dem.tif", model(hills));
    folder.write("geoid.gtx", geoid(40.0));
    folder.run(PLAN).done();
    let (plan, mission) = (json(&folder, "out/plan.json"), json(&folder, "out/plan.plan"));
    let run = folder.run(&format!("{PLAN} --geoid geoid.gtx")).done();
    assert!(!run.stderr.contains("does not say above what"), "{run:?}");
    let (mut above, lowered) = (json(&folder, "out/plan.json"), json(&folder, "out/plan.plan"));
    let vertical =
        serde_json::json!({ "datum": "ellipsoid", "epsg": null, "geoid": "geoid.gtx", "geoid_height_m": [40.0, 40.0] });
    assert_eq!(above["vertical"], vertical);
    above["vertical"] = plan["vertical"].clone();
    assert_eq!(above, plan);
    let altitudes = |mission: &Value| -> Vec<f64> {
        let items = mission["mission"]["items"].as_array().expect("items").iter();
        items.filter_map(|item| item["params"][6].as_f64().filter(|altitude| *altitude != 0.0)).collect()
    };
    let (high, low) = (altitudes(&mission), altitudes(&lowered));
    assert!(high.len() > 3 && high.len() == low.len());
    assert!(high.iter().zip(&low).all(|(high, low)| (high - low - 40.0).abs() < 0.011), "{high:?} {low:?}");
    assert!(
        folder.text("out/report.html").contains("the heights of the geoid geoid.gtx are subtracted, 40.00 to 40.00 m")
    );
}

/// A model in degrees is planned over as one in metres is; what no plan can name is told with the line that mends it.
#[test]
fn models_in_degrees() {
    let folder = Folder::with_scene("heights-degrees");
    let samples: Vec<f32> =
        (0..141 * 141).map(|k| hills(25.0 * f64::from(k % 141), 25.0 * f64::from(k / 141)) as f32).collect();
    let geo = GeoTransform { x0: 16.0, y0: 47.0, step_x: 3.3e-4, step_y: 2.25e-4 };
    let bands = [Band { description: "height", samples: &samples }];
    let degrees = geotiff_bytes(141, 141, &bands, &geo, Some(System::Epsg(4326)), f32::NAN).expect("a raster");
    folder.write("dem.tif", degrees);
    let mut refusals = Refusals::new(&folder);
    refusals.expect(PLAN, &["lies outside the elevation model dem.tif", "in degrees, and so is --area: west, south"]);
    folder.write("dem.vrt", "<VRTDataset rasterXSize=\"9\" rasterYSize=\"9\">");
    refusals.expect(&with(PLAN, "--dem", "dem.vrt"), &["gdal_translate dem.vrt dem_made.tif makes one"]);
    refusals.done();
    let area = "16.02,46.983,16.025,46.986";
    folder.run(&with(PLAN, "--area", area)).done();
    assert_eq!(json(&folder, "out/plan.json")["checks"]["photos_beyond_dem"], 0);
    let refused = folder.run(&with(&with(PLAN, "--area", area), "--height-m", "90"));
    assert_ne!(refused.code, Some(0), "less than 50 m over the hills: {refused:?}");
}
