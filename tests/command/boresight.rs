//! `plumbline boresight`: from a flight whose camera is mounted otherwise than its board was told, to one that is told right.

use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_tests::vectors::number;
use serde_json::Value;
use std::fmt::Write;

/// A camera of 128 x 128 pixels, with what the board is told.
const CAMERA: &str = "cols = 128\nrows = 128\nfov_h_deg = 60.0\nfov_v_deg = 60.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n\
    version = 7\n\n[boresight]\nphi_deg = 0.2\nomega_deg = 0.1\nkappa_deg = 0.3\n";
/// That and (0.5, -0.3, 0.2): phi, omega, kappa.
const TRUE_DEG: [f64; 3] = [0.7, -0.2, 0.5];
const FIND: &str = "boresight --camera camera.toml --fixes out/fixes.csv --poses out/poses.csv --out new.toml --json";

/// A flight of so many frames with the camera of `file`, which really is mounted by [`TRUE_DEG`]; its report.
fn fly(folder: &Folder, file: &str, frames: u32, more: &str) -> Value {
    let [phi, omega, kappa] = TRUE_DEG;
    let scenario = format!(
        "frames = {frames}\nseed = 4\ncamera_file = \"{file}\"\n\
         [mount.true_boresight]\nphi_deg = {phi}\nomega_deg = {omega}\nkappa_deg = {kappa}\n{more}"
    );
    folder.write("scenario.toml", scenario);
    folder.run("fly --scenario scenario.toml --out out --json").json()
}

fn triple(json: &Value, key: &str) -> [f64; 3] {
    std::array::from_fn(|k| json[key][k].as_f64().unwrap_or_else(|| panic!("{key} in {json}")))
}

fn is_recovered(found: &Value) {
    println!("{found}");
    assert_eq!(found["determined"], serde_json::json!([true, true, true]));
    let (angles, sds) = (triple(found, "boresight_deg"), triple(found, "sd_deg"));
    for k in 0..3 {
        let off = (angles[k] - TRUE_DEG[k]) / sds[k];
        assert!(off.abs() < 3.0, "{k}: {off} sigmas, {found}");
    }
    // A twentieth of 0.5 degrees, half of 0.2, and what the fixes' errors add.
    assert!(sds[0] < 0.06 && sds[1] < 0.06 && sds[2] < 0.2, "{found}");
}

#[test]
fn a_followed_camera_is_found_and_flies_better() {
    let folder = Folder::new("boresight-followed");
    folder.write("camera.toml", CAMERA);
    let before = fly(&folder, "camera.toml", 240, "");
    let found = folder.run(FIND).json();
    is_recovered(&found);
    assert!(found["offset_m"].is_null() && number(&found, "outliers") < 10.0, "{found}");
    assert_eq!(number(&found, "fixes"), number(&before, "accepted"));
    let text = folder.text("new.toml");
    assert!(text.contains("version = 7\n") && text.contains("fov_h_deg = 60.0\n"), "{text}");
    assert!(text.contains(&format!("phi_deg = {:?}\n", triple(&found, "boresight_deg")[0])), "{text}");
    // The servo turns the camera to the north, whatever the heading.
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{FIND} --offset"), &["--offset", "out/fixes.csv", "boresight", "heading"]);
    refusals.expect(&format!("{FIND} --follow-up-deg auto"), &["--follow-up-deg", "out/poses.csv", "follow_up_deg"]);
    refusals.done();
    // Without the column the angle is worked out: the servo followed exactly.
    let poses = folder.text("out/poses.csv");
    let short: Vec<_> = poses.lines().map(|line| line.rsplit_once(',').expect("a field").0).collect();
    folder.write("short.csv", short.join("\n"));
    let again = folder.run(&FIND.replace("out/poses.csv", "short.csv")).json();
    for (a, b) in triple(&again, "boresight_deg").iter().zip(triple(&found, "boresight_deg")) {
        assert!((a - b).abs() < 1e-6, "{again}");
    }
    let by_chance = "no angle is further from that of the camera file than 2 of its standard deviations";
    assert!(!folder.run(FIND).done().stderr.contains(by_chance));
    let after = fly(&folder, "new.toml", 80, "");
    let second =
        FIND.replace("--out new.toml", "--out second.toml").replace("--camera camera.toml", "--camera new.toml");
    let run = folder.run(&second).done();
    assert!(run.stderr.contains(by_chance), "{run:?}");
    let [before_m, after_m] = [before, after].map(|report| number(&report["ground_error_m"], "mean"));
    println!("{before_m} m before, {after_m} m after");
    assert!(before_m > 1.0 && after_m < 0.35 * before_m, "{before_m} m before, {after_m} m after");
}

#[test]
#[ignore = "long: a second flight of 240 frames; everyday runs fly a camera that follows"]
fn a_fixed_camera_is_found_over_a_map_that_is_shifted() {
    let folder = Folder::new("boresight-fixed");
    folder.write("camera.toml", CAMERA);
    fly(&folder, "camera.toml", 240, "[follow_up]\nmode = \"fixed\"\n");
    let poses = folder.text("out/poses.csv");
    let shifted = poses.lines().map(|line| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        for (place, by_m) in [(1, -2.0), (2, 1.5)] {
            if let Ok(metres) = fields[place].parse::<f64>() {
                fields[place] = (metres + by_m).to_string();
            }
        }
        fields.join(",")
    });
    folder.write("out/poses.csv", shifted.collect::<Vec<_>>().join("\n"));
    let found = folder.run(&format!("{FIND} --offset")).json();
    is_recovered(&found);
    for (axis, wanted_m) in [2.0, -1.5].into_iter().enumerate() {
        let [metres, sd_m] = ["offset_m", "offset_sd_m"].map(|key| found[key][axis].as_f64().expect("a number"));
        assert!((metres - wanted_m).abs() < 3.0 * sd_m && sd_m < 0.05, "{found}");
    }
}

/// Fixes and poses of `count` frames with tilts and turns and without errors; the fixes' rows are cut short.
fn made_up(folder: &Folder, count: usize) {
    folder.write("camera.toml", CAMERA);
    let mut fixes = "mid_exposure_us,accepted,east_m,north_m,sigma_east_m,sigma_north_m\n".to_owned();
    let mut poses = "mid_exposure_us,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n".to_owned();
    for i in 0..count {
        let _ = writeln!(fixes, "{},1,{},{},0.2,0.2", 1_000_000 + 1000 * i, 100 + i, 200 + i % 3);
        let _ = writeln!(poses, "{},{},{},{},{},{},{}", 1_000_000 + 1000 * i, 100 + i, 200, 120, 40 * i, i % 7, i % 5);
    }
    fixes.push_str("5,0,,,,\n");
    folder.write("fixes.csv", fixes);
    folder.write("poses.csv", poses);
}

/// Fixes that are sound and too rough: the work failed.
#[test]
fn fixes_that_show_no_angle() {
    let folder = Folder::new("boresight-rough");
    made_up(&folder, 30);
    // Some 40 m to either side, at 120 m of height.
    let rough = |(index, line): (usize, &str)| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        for (axis, field) in fields[2..4].iter_mut().enumerate() {
            if let Ok(metres) = field.parse::<f64>() {
                *field = (metres + 60.0 * (2.3 * index as f64 + 1.1 * axis as f64).sin()).to_string();
            }
        }
        fields.join(",") + "\n"
    };
    folder.write("fixes.csv", folder.text("fixes.csv").lines().enumerate().map(rough).collect::<String>());
    let run = folder
        .run("boresight --camera camera.toml --fixes fixes.csv --poses poses.csv --out new.toml --follow-up-deg none");
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stderr.contains("fixes.csv: neither phi nor omega is known to") && !folder.path("new.toml").exists());
}

#[test]
fn all_columns_that_are_missing_are_named() {
    let folder = Folder::new("boresight-columns");
    made_up(&folder, 30);
    let call = "boresight --camera camera.toml --fixes fixes.csv --poses poses.csv --out new.toml";
    let sound = folder.text("poses.csv");
    let mut refusals = Refusals::new(&folder);
    folder.write("poses.csv", sound.replace("north_m,height_m", "n,h"));
    refusals.expect(call, &["poses.csv has no columns north_m, height_m, only mid_exposure_us, east_m, n, h,"]);
    folder.write("poses.csv", sound);
    folder.write("fixes.csv", folder.text("fixes.csv").replace("accepted,east_m", "valid,east"));
    refusals.expect(call, &["fixes.csv has no columns accepted, east_m, only mid_exposure_us, valid, east,"]);
    refusals.done();
}

#[test]
fn what_cannot_be_used_is_refused() {
    let folder = Folder::new("boresight-refused");
    made_up(&folder, 30);
    let call = "boresight --camera camera.toml --fixes fixes.csv --poses poses.csv --out new.toml --follow-up-deg none";
    folder.run(call).done();
    let with = |file: &str, old: &str, new: &str| {
        let text = folder.text(file);
        assert!(text.contains(old), "{old} in {file}");
        let bad = format!("bad-{}-{file}", new.len() + old.len());
        folder.write(&bad, text.replacen(old, new, 1));
        call.replace(file, &bad)
    };
    let mut refusals = Refusals::new(&folder);
    for (file, option) in [("camera.toml", "--camera"), ("fixes.csv", "--fixes"), ("poses.csv", "--poses")] {
        refusals.expect(&call.replace(file, "none.csv"), &["none.csv"]);
        refusals.expect(&call.replace("new.toml", file), &["--out", option, file]);
    }
    refusals.expect(&call.replace("new.toml", "none/new.toml"), &["none"]);
    refusals.expect(&with("fixes.csv", "3000,1,103,", "3000,1,NaN,"), &["fixes.csv", "line 5", "east_m", "NaN"]);
    refusals.expect(&with("fixes.csv", "3000,1,", "3000,yes,"), &["fixes.csv", "line 5", "accepted", "yes"]);
    refusals.expect(&with("fixes.csv", "0.2,0.2\n1004000", "0.0,0.2\n1004000"), &["line 5", "sigma_east_m", "above 0"]);
    refusals.expect(&with("fixes.csv", "3000,1", "2000,1"), &["fixes.csv", "line 5", "mid_exposure_us", "line 4"]);
    refusals.expect(&with("fixes.csv", "sigma_east_m", "sigma_e"), &["fixes.csv", "no column sigma_east_m"]);
    refusals.expect(&with("poses.csv", "heading_deg", "heading"), &["poses.csv", "no column heading_deg"]);
    refusals.expect(&with("poses.csv", "3000,103,200,120", "3000,103,200,-1"), &["poses.csv", "line 5", "height_m"]);
    refusals.expect(&with("poses.csv", "3000,103,200,120,120,3", "3000,103,200,120,120,95"), &["line 5", "pitch_deg"]);
    refusals.expect(&with("poses.csv", "3000,103,200,120,120,3", "3000,103,200,120,120,70"), &["line 5", "ground"]);
    refusals.expect(&with("poses.csv", "3000,103", "3000.5,103"), &["line 5", "microseconds"]);
    folder.write("heads.toml", include_str!("../../hil-sim/scenarios/heads/camera.toml"));
    refusals.expect(&call.replace("camera.toml", "heads.toml"), &["heads.toml", "heads"]);
    for (name, text) in
        [("empty.csv", ""), ("header.csv", "mid_exposure_us,accepted,east_m,north_m,sigma_east_m,sigma_north_m")]
    {
        folder.write(name, text);
        refusals.expect(&call.replace("fixes.csv", name), &[name]);
        refusals.expect(&call.replace("poses.csv", name), &[name]);
    }
    let later = folder.text("poses.csv").replace("000,1", "500,1");
    folder.write("later.csv", later);
    refusals.expect(&call.replace("poses.csv", "later.csv"), &["later.csv", "fixes.csv", "30", "mid_exposure_us"]);
    let few: Vec<_> = folder.text("poses.csv").lines().take(10).map(str::to_owned).collect();
    folder.write("few.csv", few.join("\n"));
    refusals.expect(&call.replace("poses.csv", "few.csv"), &["few.csv", "9 of 30", "10"]);
    let ahead = folder.text("poses.csv");
    let ahead: Vec<String> = ahead
        .lines()
        .map(|line| {
            let mut fields: Vec<&str> = line.split(',').collect();
            if fields[4] != "heading_deg" {
                fields[4] = "90";
            }
            fields.join(",")
        })
        .collect();
    folder.write("ahead.csv", ahead.join("\n"));
    refusals.expect(&format!("{} --offset", call.replace("poses.csv", "ahead.csv")), &["--offset", "heading"]);
    refusals.done();
}
