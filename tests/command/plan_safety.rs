//! Plans over ground of many kinds: one that ends with exit code 0 clears it, whoever looks.

use crate::elevation::grid;
use crate::folder::{Folder, with};
use plumbline_survey::io::data::for_test;
use plumbline_survey::io::raster::Raster;
use serde_json::Value;
use std::path::Path;

/// What is kept clear unless it is said otherwise.
const CLEARANCE_M: f64 = 50.0;
const PLAN: &str = "plan --dem dem.asc --area 0,0,400,300 --camera camera.toml --height-m 300 --overlap 60/30 --origin 48,11 --out out";

fn plan(folder: &Folder) -> Value {
    serde_json::from_str(&folder.text("out/plan.json")).expect("JSON")
}

/// Strips from photo to photo, at the nearest post every few metres: the least height above the terrain as far as the model reaches,
/// and whether that is all. Written apart from the planner; in the model's own x and y.
fn clearance_m(plan: &Value, raster: &Raster) -> (f64, bool) {
    let number = |photo: &Value, key: &str| photo[key].as_f64().expect("a number");
    let (mut least, mut is_all) = (f64::INFINITY, true);
    for strip in plan["strips"].as_array().expect("strips") {
        let photos = strip["photos"].as_array().expect("photos");
        for (a, b) in photos.iter().zip(photos.iter().skip(1).chain(photos.last())) {
            for step in 0..=20 {
                let along = f64::from(step) / 20.0;
                let at = |key| number(a, key) + along * (number(b, key) - number(a, key));
                let (col, row) = raster.geo.pixel_from_world(at("x"), at("y"));
                let ground = raster.sample(col.round() as usize, row.round() as usize, 0);
                is_all &= ground.is_some() && col > -0.5 && row > -0.5;
                least = least
                    .min(ground.map_or(f64::INFINITY, |ground| at("z") - f64::from(ground) * raster.height_unit_m));
            }
        }
    }
    (least, is_all)
}

#[test]
fn ground_that_is_not_known_under_the_turns_is_not_flown_over() {
    let folder = Folder::with_scene("safety-unknown");
    // Under the first turn.
    let hole = |height: f64| grid(move |x, y| if (x, y) == (-350.0, 0.0) { height } else { 100.0 });
    folder.write("dem.asc", hole(-9999.0));
    let run = folder.run(PLAN);
    assert!(
        run.code == Some(1) && run.stderr.contains("posts without a height") && run.stderr.contains("--force"),
        "{run:?}"
    );
    assert_eq!(plan(&folder)["checks"]["passes_unknown"], true);
    folder.run(&format!("{PLAN} --force")).done();
    folder.write("dem.asc", hole(100.0));
    folder.run(PLAN).done();
    assert_eq!(plan(&folder)["checks"]["passes_unknown"], false);
}

/// What is below strips beyond the model nobody knows: such a plan fails. So does one of which turns alone, or the photo by which a strip
/// overshoots the area, are beyond it, if ground as high as the model's highest would be too near there; otherwise it is asked about.
#[test]
fn strips_and_turns_beyond_the_model_are_not_safe() {
    let folder = Folder::with_scene("safety-beyond");
    // The model ends at 2000 both ways, half a post further counts. Bases are 138 m, lines 242 m apart.
    let (strips, turns) = ("1 of the strips leave the elevation model", "the ends of strips or the turns reach beyond");
    let asked = "the clearance there is not known";
    let peak = |height: f64| grid(move |x, y| if (x, y) == (-1000.0, -1000.0) { height } else { 100.0 });
    for (area, peak_m, is_safe, strips_off, why) in [
        ("0,1700,400,1999", 100.0, false, 1, strips),
        ("1200,0,1850,300", 450.0, false, 0, turns),
        ("1000,0,1800,300", 450.0, false, 0, turns),
        ("1000,0,1800,300", 100.0, true, 0, asked),
    ] {
        folder.write("dem.asc", peak(peak_m));
        let planned = with(PLAN, "--area", area);
        let run = folder.run(&planned);
        let checks = &plan(&folder)["checks"];
        assert_eq!((&checks["leaves_model"], &checks["strips_off_dem"]), (&true.into(), &strips_off.into()), "{area}");
        assert!(run.code == Some(i32::from(!is_safe)) && run.stderr.contains(why), "{area}: {run:?}");
        assert!(run.stderr.contains("larger elevation model"), "{area}: {run:?}");
        assert!(run.stdout.contains("where the ground is known"), "{run:?}");
        let page = folder.text("out/report.html");
        let said = page.find(if is_safe { "Look at this first: " } else { "Not safe to fly: " });
        assert!(said.is_some() && said < page.find("is kept everywhere"), "{area}: {said:?}");
        let says = |option: &str| page.contains(&format!("narrower turns, a lower {option} "));
        assert!(says(r#"<span class="option">--speed-m-s</span>"#) || !is_safe, "{area}");
        assert!(!says("--speed-m-s"), "{area}");
        assert!(page.contains(">not known everywhere<") && !page.contains(">clear<"), "{area}");
        let store = "configuration --plan out/plan.json --out plan.bin";
        if is_safe {
            folder.run(store).done();
            continue;
        }
        folder.run(&format!("{planned} --force")).done();
        let mut refusals = crate::refusals::Refusals::new(&folder);
        refusals.expect(store, &["out/plan.json", why, "--force"]);
        refusals.done();
        folder.run(&format!("{store} --force")).done();
    }
    // The same area with the narrow turns of a slow vehicle.
    folder.run(&format!("{} --vehicle multirotor", with(PLAN, "--area", "1000,0,1600,300"))).done();
    assert_eq!(plan(&folder)["checks"]["leaves_model"], false);
}

#[test]
fn heights_in_feet_are_no_metres_and_two_bands_are_no_model() {
    let folder = Folder::with_scene("safety-feet");
    let feet = 0.304_8;
    let tower = |unit: f64| grid(move |x, y| if (x, y) == (200.0, 100.0) { 360.0 / unit } else { 100.0 / unit });
    let plan = PLAN.replace("--origin 48,11 ", "");
    folder.write("dem.asc", tower(1.0));
    let metres = folder.run(&plan);
    let height = plan_height(&folder);
    folder.write("dem.asc", tower(feet));
    folder.write("dem.prj", FEET);
    let in_feet = folder.run(&plan);
    assert_eq!((metres.code, in_feet.code), (Some(1), Some(1)), "{metres:?} {in_feet:?}");
    for run in [&metres, &in_feet] {
        let wanted = format!("the flight passes {:.1} m above the terrain", height - 360.0);
        assert!(run.stderr.contains(&wanted), "{wanted}: {run:?}");
    }
    assert!((plan_height(&folder) - height).abs() < 0.05, "{height}");
    let two = plumbline_survey::io::raster::geotiff_bytes(
        8,
        8,
        &[band("a", &[100.0; 64]), band("b", &[500.0; 64])],
        &plumbline_survey::io::raster::GeoTransform { x0: -1000.0, y0: 1500.0, step_x: 400.0, step_y: 400.0 },
        None,
        -9999.0,
    );
    folder.write("two.tif", two.expect("written"));
    let run = folder.run(&with(&plan, "--dem", "two.tif"));
    assert!(
        run.code == Some(2) && run.stderr.contains("has 2 bands") && run.stderr.contains("gdal_translate -b"),
        "{run:?}"
    );
}

fn band<'a>(description: &'a str, samples: &'a [f32]) -> plumbline_survey::io::raster::Band<'a> {
    plumbline_survey::io::raster::Band { description, samples }
}

fn plan_height(folder: &Folder) -> f64 {
    plan(folder)["strips"][0]["photos"][0]["z"].as_f64().expect("a height")
}

/// A grid in metres, its heights too.
pub const METRES: &str = r#"PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32633"]]"#;

/// A grid in metres whose heights are feet.
const FEET: &str =
    r#"PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32633"]],VERTCS["x",VDATUM["y"],UNIT["Foot",0.3048]]"#;

#[test]
fn steep_ground_is_cleared_or_the_plan_fails() {
    let folder = Folder::with_scene("safety-steep");
    type Shape = fn(f64, f64) -> f64;
    let shapes: [(&str, Shape); 4] = [
        ("slope", |x, _| 0.5 * x),
        ("cliff", |x, _| if x > 200.0 { 280.0 } else { 0.0 }),
        ("ridge", |_, y| (260.0 - (y - 150.0).abs()).max(0.0)),
        ("needle", |x, y| if (x, y) == (200.0, 150.0) { 290.0 } else { 0.0 }),
    ];
    let (mut flown, mut failed) = (0, 0);
    for (name, shape) in shapes {
        folder.write("dem.asc", grid(shape));
        for height in ["120", "300", "600"] {
            let run = folder.run(&with(PLAN, "--height-m", height));
            if run.code != Some(0) {
                failed += 1;
                assert!(matches!(run.code, Some(1 | 2)) && !run.stderr.is_empty(), "{name} {height}: {run:?}");
                continue;
            }
            flown += 1;
            let plan = plan(&folder);
            for photo in
                plan["strips"].as_array().expect("strips").iter().flat_map(|s| s["photos"].as_array().expect("photos"))
            {
                let at = |key: &str| photo[key].as_f64().expect("a number");
                assert!(at("z") - shape(at("x"), at("y")) >= CLEARANCE_M, "{name} {height}: {photo}");
            }
        }
    }
    assert!(flown >= 3 && failed >= 3, "{flown} are flown, {failed} fail");
}

/// Real mountains, one model in degrees, one on a grid.
#[test]
fn real_mountains_are_cleared_or_the_plan_fails() {
    let folder = Folder::with_scene("safety-real");
    let (mut flown, mut failed, mut beyond) = (0, 0, 0);
    for model in ["dem/jacksboro_3arcsec.tif", "dem/austria_dhm_10m_west.tif"] {
        let Some(path) = for_test("real_mountains_are_cleared_or_the_plan_fails", model) else { return };
        let raster = Raster::read(Path::new(&path)).expect("readable");
        for (share, height) in [(0.3, "150"), (0.5, "250"), (0.5, "600"), (0.7, "900"), (0.4, "400")] {
            let at = |size: usize| share * size as f64;
            let (x0, y1) = raster.geo.world_from_pixel(at(raster.cols), at(raster.rows));
            let metres = if raster.geo.step_x < 0.1 { 1.0 / 111_000.0 } else { 1.0 };
            let area = format!("{x0},{},{},{y1}", y1 - 800.0 * metres, x0 + 1000.0 * metres);
            let run = folder.run(&format!(
                "plan --dem {} --area {area} --camera camera.toml --height-m {height} --overlap 60/30 --speed-m-s 20 --out out",
                path.display()
            ));
            if run.code != Some(0) {
                failed += 1;
                assert!(matches!(run.code, Some(1 | 2)), "{model} {share} {height}: {run:?}");
                continue;
            }
            flown += 1;
            let plan = plan(&folder);
            let (clearance, is_all) = clearance_m(&plan, &raster);
            assert!(clearance >= CLEARANCE_M, "{model} {share} {height}: {clearance} m");
            assert!(is_all || run.stderr.contains("beyond the elevation model"), "{model} {share} {height}: {run:?}");
            beyond += usize::from(!is_all);
        }
    }
    assert!(flown >= 2 && failed >= 2, "{flown} are flown, {failed} fail, {beyond} overshoot the model");
}

#[test]
fn an_allowance_for_tilt_keeps_the_overlap_of_tilted_photos() {
    let folder = Folder::with_scene("safety-tilt");
    folder.write("dem.asc", grid(|_, _| 100.0));
    let base = |options: &str| {
        folder.run(&format!("{PLAN} {options}")).done();
        plan(&folder)["base_min_m"].as_f64().expect("a number")
    };
    let (level, tilted) = (base(""), base("--tilt-deg 2"));
    // 300 m over ground 100 m high, 60 degrees along: edges at 30 degrees, with the allowance at 28.
    let edge = |deg: f64| 2.0 * 300.0 * deg.to_radians().tan();
    assert!((level - 0.4 * edge(30.0)).abs() < 0.5 && (tilted - 0.4 * edge(28.0)).abs() < 0.5, "{level} {tilted}");
    // Two neighbours that lean away from each other by 2 degrees: the share that both see of what one of them sees.
    let front = |deg: f64| 300.0 * deg.to_radians().tan();
    let overlap = |base_m: f64| (front(28.0) - (base_m - front(28.0))) / (2.0 * front(28.0));
    assert!(overlap(tilted) >= 0.6 - 1e-3 && overlap(level) < 0.57, "{} {}", overlap(tilted), overlap(level));
    assert_eq!(plan(&folder)["tilt_deg"], 2.0);
}

#[test]
fn missions_for_every_vehicle() {
    let folder = Folder::with_scene("safety-vehicles");
    folder.write("dem.asc", grid(|_, _| 100.0));
    for (options, vehicle, firmware, takeoff) in [
        ("", 1, 3, None),
        ("--vehicle fixed-wing --autopilot px4 --takeoff-and-return", 1, 12, Some(22)),
        ("--vehicle vtol --takeoff-and-return", 20, 3, Some(84)),
        ("--vehicle multirotor --autopilot px4 --takeoff-and-return", 2, 12, Some(22)),
    ] {
        folder.run(&format!("{PLAN} {options}")).done();
        let mission: Value = serde_json::from_str(&folder.text("out/plan.plan")).expect("JSON");
        let (mission, flown) = (&mission["mission"], plan(&folder));
        assert_eq!(
            (&mission["vehicleType"], &mission["firmwareType"]),
            (&vehicle.into(), &firmware.into()),
            "{options}"
        );
        let items = mission["items"].as_array().expect("items");
        let commands: Vec<u64> = items.iter().map(|item| item["command"].as_u64().expect("a command")).collect();
        let first_and_last = takeoff.map(|command| (command, 20));
        let wanted = first_and_last.unwrap_or((178, 16));
        assert_eq!((commands[0], commands[commands.len() - 1]), wanted, "{options}");
        if takeoff.is_some() {
            assert_eq!(items[0]["Altitude"], items[2]["Altitude"], "it climbs to where it flies");
        }
        let speed = if vehicle == 2 { 10.0 } else { 35.0 };
        assert_eq!(flown["speed_m_s"], speed, "{options}");
        for (index, item) in items.iter().enumerate() {
            assert_eq!(item["doJumpId"], Value::from(index + 1));
        }
    }
    let text = folder.run(&with(PLAN, "--area", "0,0,400,300")).done().stdout;
    assert!(text.contains("on commonly seen ground") && text.contains("of a swath in common"), "{text}");
    folder.write("dem.asc", grid(|x, _| 100.0 + 0.01 * x));
    let auto = folder.run(&format!("{PLAN} --strip-heading-deg 90.00006052775883")).done().stdout;
    assert!(auto.contains("heading 90 degrees"), "{auto}");
}

#[test]
fn a_plan_that_no_board_can_hold_is_refused_before_it_is_flashed() {
    let folder = Folder::with_scene("safety-flash");
    folder.write("dem.asc", grid(|_, _| 100.0));
    let large = with(&with(PLAN, "--height-m", "60"), "--overlap", "95/95");
    folder.run(&large).done();
    let photos = plan(&folder)["photo_count"].as_u64().expect("a count");
    let mut refusals = crate::refusals::Refusals::new(&folder);
    refusals.expect(
        "configuration --plan out/plan.json --out plan.bin",
        &[&format!("its {photos} photos take"), "65536", "plan parts of the area"],
    );
    refusals.done();
    assert!(photos > 8_186, "{photos} photos of 8 bytes and a head fit");
    folder.run(PLAN).done();
    folder.run("configuration --plan out/plan.json --out plan.bin").done();
}
