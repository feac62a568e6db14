//! `plumbline evaluate`: the frames of a flight, here a simulated one's, through the board's own chain.

use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes};
use plumbline_tests::vectors::number;
use serde_json::Value;
use std::fmt::Write;

const CAMERA: &str =
    "cols = 160\nrows = 120\nfov_h_deg = 60.0\nfov_v_deg = 46.8264\noffset_m_px = 0.0\noffset_n_px = 0.0\n";
/// The flight's ground is its reference.
const FLY: &str = "fly --ground ground.tif --frames 40 --seed 5 --dump 40 --out flown --set camera_file=camera.toml \
     --set follow_up.mode=fixed --set resolution_m=5.0 --set flight.height_m=[190,200] --set flight.speed_m_s=20.0 \
     --set frame_interval_ms=2000 --set noise_dn=2.0";
const EVALUATE: &str =
    "evaluate --frames frames.csv --camera camera.toml --reference ground.tif --resolution-m 5 --out out --json";

/// A flight with its frames, and the table of them: positions off by `off` metres east, with the truth or without.
fn flown(name: &str, more: &str, off_m: f64, knows_truth: bool) -> Folder {
    let folder = Folder::with_ground(name);
    folder.write("camera.toml", CAMERA);
    folder.run(&format!("{FLY} {more}")).done();
    table(&folder, off_m, knows_truth);
    folder
}

fn table(folder: &Folder, off_m: f64, knows_truth: bool) {
    let poses = folder.text("flown/poses.csv");
    let mut table = "file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg".to_owned();
    table.push_str(if knows_truth { ",true_east_m,true_north_m\n" } else { "\n" });
    for (index, line) in poses.lines().skip(1).enumerate() {
        let pose: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
        let [east, north, height, heading, pitch, roll] = [1, 2, 3, 4, 5, 6].map(|column| pose[column]);
        // A navigation's own noise, some decimetres.
        let noise = 0.3 * (7.0 * index as f64).sin();
        let place = [east + off_m + noise, north - noise];
        let _ = write!(table, "flown/frame_{index:04}.png,{},{},{height},{heading},{pitch},{roll}", place[0], place[1]);
        let _ = if knows_truth { writeln!(table, ",{east},{north}") } else { writeln!(table) };
    }
    folder.write("frames.csv", table);
}

fn platform(summary: &Value, key: &str, index: usize) -> f64 {
    summary["platform"][key][index].as_f64().unwrap_or_else(|| panic!("{key}: {summary}"))
}

#[test]
fn a_sound_flight_is_right_and_its_camera_sits_as_its_file_says() {
    let folder = flown("evaluate-sound", "", 3.0, true);
    let summary = folder.run(EVALUATE).json();
    let [frames, accepted, right, wrong] = ["frames", "accepted", "right", "wrong"].map(|key| number(&summary, key));
    assert!(frames == 40.0 && accepted >= 36.0 && right == accepted && wrong == 0.0, "{summary}");
    assert_eq!(
        (summary["judged_against"].as_str(), summary["corrected"].is_null()),
        (Some("truth"), true),
        "{summary}"
    );
    assert!(summary["heights"].is_null(), "{summary}");
    // The positions are 3 m too far east, so the fixes lie west of them.
    let offset = [0, 1].map(|axis| summary["median_offset_m"][axis].as_f64().expect("an offset"));
    assert!((offset[0] + 3.0).abs() < 0.4 && offset[1].abs() < 0.4, "{summary}");
    assert!(number(&summary, "nees_mean") < 4.0, "{summary}");
    let csv = folder.text("out/frames.csv");
    assert_eq!(csv.lines().count(), 41, "{csv}");
    assert_eq!(csv.lines().filter(|line| line.contains(".png,1,,")).count(), accepted as usize, "{csv}");
    let page = folder.text("out/report.html");
    assert!(page.contains("sits as its file says") && !page.contains("http:"), "a page that needs nothing but itself");
    assert_eq!(serde_json::from_str::<Value>(&folder.text("out/report.json")).expect("JSON"), summary);
    // Without the truth the common offset counts for none.
    table(&folder, 3.0, false);
    let run = folder.run(EVALUATE);
    let summary = run.json();
    assert_eq!(
        (summary["judged_against"].as_str(), number(&summary, "wrong")),
        (Some("median_offset"), 0.0),
        "{summary}"
    );
}

#[test]
fn a_tilted_camera_is_told_from_a_shifted_map() {
    let tilt = "--set mount.true_boresight={phi_deg=0.0,omega_deg=3.0,kappa_deg=0.0}";
    let folder = flown("evaluate-tilted", tilt, -4.0, false);
    let summary = folder.run(EVALUATE).json();
    assert_eq!(summary["platform"]["separated"].as_bool(), Some(true), "{summary}");
    let omega_deg = platform(&summary, "boresight_deg", 1);
    assert!((omega_deg - 3.0).abs() < 0.3, "{summary}");
    // The fixes lie 4 m east of positions that are 4 m too far west.
    assert!((platform(&summary, "map_offset_m", 0) - 4.0).abs() < 0.5, "{summary}");
    let corrected = &summary["corrected"];
    assert!(number(corrected, "accepted") >= 36.0 && number(corrected, "wrong") == 0.0, "{summary}");
    assert!(number(&summary, "wrong") > 0.0, "3 degrees at 195 m are 10 m, 2 pixels: {summary}");
}

/// The table with other heights.
fn with_heights(sound: &str, height_m: impl Fn(f64) -> f64) -> String {
    with_column(sound, 3, height_m)
}

fn with_column(sound: &str, column: usize, meant: impl Fn(f64) -> f64) -> String {
    let row = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(number) = fields[column].parse::<f64>() {
            fields[column] = meant(number).to_string();
        }
        fields.join(",") + "\n"
    };
    sound.lines().map(row).collect()
}

#[test]
fn heights_in_feet_or_above_the_sea_are_told() {
    let folder = flown("evaluate-heights", "", 0.0, true);
    let sound = folder.text("frames.csv");
    folder.write("frames.csv", with_heights(&sound, |metres| metres / 0.3048));
    let summary = folder.run(EVALUATE).json();
    let says = summary["heights"].as_str().expect("what they seem to be");
    assert!(says.contains("frames.csv, height_m: were it in feet") && says.contains("$4 *= 0.3048"), "{summary}");
    assert!(folder.text("out/report.html").contains("height_m: were it in feet"));
    let said = folder.run(&EVALUATE.replace(" --json", "")).done().stdout;
    assert!(said.contains(says), "{said}");
    // Level ground 150 m above the sea.
    let bands = [Band { description: "height", samples: &[150.0; 60 * 60] }];
    let geo = GeoTransform { x0: 499_900.0, y0: 5_330_100.0, step_x: 30.0, step_y: 30.0 };
    let model = geotiff_bytes(60, 60, &bands, &geo, Some(System::Epsg(32633)), f32::NAN).expect("a raster");
    folder.write("dem.tif", model);
    let over = format!("{EVALUATE} --dem dem.tif");
    folder.write("frames.csv", with_heights(&sound, |metres| metres + 150.0));
    let summary = folder.run(&over).json();
    let says = summary["heights"].as_str().expect("what they seem to be");
    assert!(says.contains("height_m: were it above the sea") && says.contains("elevation model"), "{summary}");
    folder.write("frames.csv", sound);
    assert!(folder.run(&over).json()["heights"].is_null());
}

/// A camera that is mounted with its right side forward, and the heading of the vehicle in its table.
#[test]
fn headings_of_another_side_of_the_camera_are_told() {
    let folder = flown("evaluate-headings", "", 0.0, true);
    let sound = folder.text("frames.csv");
    assert!(folder.run(EVALUATE).json()["headings"].is_null());
    for off in [90.0, 180.0] {
        folder.write("frames.csv", with_column(&sound, 4, |heading| (heading - off).rem_euclid(360.0)));
        let summary = folder.run(EVALUATE).json();
        assert!(summary["heights"].is_null(), "{summary}");
        let says = summary["headings"].as_str().expect("what they seem to be");
        let line = format!("$5 = ($5 + {off}) % 360 }} 1' frames.csv > turned.csv");
        assert!(says.contains(&format!("heading_deg: were it {off} degrees more")) && says.contains(&line), "{says}");
        assert!(folder.text("out/report.html").contains("degrees more"));
    }
}

/// The values of columns 5 to 7, heading, pitch and roll, as others have them.
fn with_attitude(sound: &str, meant: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let row = |line: &str| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let [Ok(heading), Ok(pitch), Ok(roll)] = [4, 5, 6].map(|k: usize| fields[k].parse::<f64>()) {
            let values = meant([heading, pitch, roll]).map(|value| value.to_string());
            fields[4..7].clone_from_slice(&values);
        }
        fields.join(",") + "\n"
    };
    sound.lines().map(row).collect()
}

/// Pitch positive nose down, roll positive left wing down, their columns swapped, headings counted to the left: most frames have a fix all the same, and
/// many of them a wrong one.
#[test]
fn attitudes_of_other_conventions_are_told() {
    let folder = flown("evaluate-signs", "--set flight.tilt_max_deg=12", 0.0, true);
    let sound = folder.text("frames.csv");
    type Meant = fn([f64; 3]) -> [f64; 3];
    let cases: [(Meant, &str, &str); 6] = [
        (|[h, p, r]| [h, -p, -r], "pitch_deg and roll_deg: were they of the other sign", "$6 = -$6; $7 = -$7"),
        (|[h, p, r]| [h, -p, r], "pitch_deg: were it of the other sign", "{ $6 = -$6 }"),
        (|[h, p, r]| [h, p, -r], "roll_deg: were it of the other sign", "{ $7 = -$7 }"),
        (|[h, p, r]| [h, r, p], "pitch_deg and roll_deg: were they swapped", "t = $6; $6 = $7; $7 = t"),
        (|[h, p, r]| [-h, p, r], "heading_deg: were it counted from north to the left", "$5 = (720 - $5) % 360"),
        (|[h, p, r]| [90.0 - h, p, r], "heading_deg: were it counted from east to the left", "$5 = (810 - $5) % 360"),
    ];
    let mut wrong = String::new();
    for (meant, what, line) in cases {
        folder.write("frames.csv", with_attitude(&sound, meant));
        let summary = folder.run(EVALUATE).json();
        let says = summary["headings"].as_str().unwrap_or_default();
        if !says.contains(&format!("frames.csv, {what}")) || !says.contains(line) {
            let _ = writeln!(wrong, "{what}: {summary}");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    folder.write("frames.csv", sound);
    let summary = folder.run(EVALUATE).json();
    assert!(summary["headings"].is_null() && summary["heights"].is_null(), "{summary}");
}

/// Places as a camera's EXIF data has them.
#[test]
fn places_in_degrees_are_told_how_to_become_metres() {
    let folder = flown("evaluate-degrees", "", 0.0, false);
    // The ground's corner, 500000 m east, is on the meridian of 15 degrees, and 5329700 m north is at 48.1183 degrees.
    let sound = folder.text("frames.csv");
    let degrees = with_column(&with_column(&sound, 1, |_| 15.0006), 2, |_| 48.1183);
    let mut refusals = Refusals::new(&folder);
    let line = "| gdaltransform -s_srs EPSG:4326 -t_srs EPSG:32633 -output_xy";
    folder.write("frames.csv", &degrees);
    refusals.expect(EVALUATE, &["as longitude and latitude in degrees it would", "{ print $2, $3 }' frames.csv", line]);
    let swapped = with_column(&with_column(&sound, 1, |_| 48.1183), 2, |_| 15.0006);
    folder.write("frames.csv", swapped);
    refusals.expect(EVALUATE, &["as latitude and longitude in degrees it would", "{ print $3, $2 }' frames.csv", line]);
    let elsewhere = with_column(&with_column(&sound, 1, |_| 16.5), 2, |_| 47.25);
    folder.write("frames.csv", elsewhere);
    refusals.expect(EVALUATE, &["they look like longitude and latitude in degrees: if they are, awk", line]);
    folder.write("frames.csv", with_column(&sound, 1, |_| 15.0006));
    refusals.expect(EVALUATE, &["nor is any other frame\n"]);
    refusals.done();
}

#[test]
fn a_table_that_cannot_be_meant_is_refused() {
    let folder = flown("evaluate-bad", "", 0.0, false);
    let sound = folder.text("frames.csv");
    let mut refusals = Refusals::new(&folder);
    let mut refuse = |text: String, wanted: &str| {
        folder.write("frames.csv", text);
        refusals.expect(EVALUATE, &[wanted]);
    };
    refuse(sound.replace("frame_0007", "frame_0777"), "line 9");
    refuse(sound.replace("pitch_deg", "tilt_deg"), "pitch_deg");
    // As programs write tables where the comma is the decimal mark.
    let semicolons = sound.replace(',', ";").replace('.', ",");
    refuse(
        semicolons,
        "separated by semicolons, and commas are read: sed 's/,/./g; s/;/,/g' frames.csv > frames.commas.csv",
    );
    refuse(sound.replace(',', "\t"), "separated by tabs, and commas are read: sed 's/,/./g; s/\\t/,/g' frames.csv");
    let swapped = sound.replacen("east_m,north_m", "north_m,east_m", 1);
    refuse(swapped, "swapped");
    refuse(sound.lines().take(3).collect::<Vec<_>>().join("\n"), "at least 3");
    folder.write("frames.csv", sound);
    // What makes a table of degrees leaves it beside its pictures.
    let hundredths =
        (4..7).fold(folder.text("frames.csv"), |text, column| with_column(&text, column, |deg| 100.0 * deg + 3000.0));
    folder.write("flown/frames.csv", hundredths.replace("flown/", ""));
    let made = "' flown/frames.csv > flown/degrees.csv";
    refusals.expect(&EVALUATE.replace("--frames frames", "--frames flown/frames"), &["hundredths of a degree", made]);
    refusals.expect(&format!("{EVALUATE} --dem other.tif"), &["other.tif"]);
    refusals.expect(&EVALUATE.replace("--out out", "--out flown/poses.csv"), &["not a folder"]);
    refusals.done();
}
