//! `plumbline map` against the golden values of paper 003.

use crate::bad_options::MAP;
use crate::folder::Folder;
use plumbline_tests::vectors::{list, miss, number, rows};
use serde_json::Value;

/// Single precision at 600 px from the centre has steps of 6e-5 px and eq. 3 about ten roundings.
const CORE_PX: f64 = 1e-3;
/// The golden values have nine significant digits: half a digit of a value below 1000 is 5e-7.
const ORACLE_PX: f64 = 1e-6;

/// Writes the camera of a row of table B (VH, VV) or C (V).
fn write_camera(folder: &Folder, row: &Value) {
    let (h, v) = if row["V"].is_null() { ("VH", "VV") } else { ("V", "V") };
    let [fov_h, fov_v, m0, n0] = [h, v, "m0", "n0"].map(|key| number(row, key));
    let side = row["M"].as_u64().expect("a side");
    folder.write(
        "camera.toml",
        format!(
            "cols = {side}\nrows = {side}\nfov_h_deg = {fov_h:?}\nfov_v_deg = {fov_v:?}\noffset_m_px = {m0:?}\noffset_n_px = {n0:?}\n"
        ),
    );
}

/// Frame pixel of the row's point by `options`.
fn mapped(folder: &Folder, row: &Value, options: &str) -> [f64; 2] {
    let line =
        folder.run(&format!("map --camera camera.toml {options} -- {},{}", number(row, "m"), number(row, "n"))).json();
    assert_eq!(line["in_front"], true, "{line}");
    assert_eq!([number(&line, "m"), number(&line, "n")], [number(row, "m"), number(row, "n")], "{line}");
    [number(&line, "m_frame"), number(&line, "n_frame")]
}

fn close(found: [f64; 2], row: &Value, tolerance: f64, options: &str) {
    let off = miss(found, list(row, "out"));
    assert!(off < tolerance, "{off} px off: {found:?} by {options} for {row}");
}

#[test]
fn golden_b_in_full() {
    let folder = Folder::new("map-b");
    for row in rows("003", "B_eq3") {
        write_camera(&folder, &row);
        let [phi, theta, gamma] = ["phi", "theta", "gamma"].map(|key| number(&row, key));
        let follow_up = row["beta"].as_f64().map_or_else(|| "auto".to_owned(), |deg| deg.to_string());
        let options = format!(
            "--heading-deg {phi} --pitch-deg {theta} --roll-deg {gamma} --follow-up-deg {follow_up} --model full"
        );
        close(mapped(&folder, &row, &options), &row, CORE_PX, &options);
        let options = format!("{options} --oracle");
        close(mapped(&folder, &row, &options), &row, ORACLE_PX, &options);
    }
}

/// Table C gives the equivalent angles. At heading 0 they are pitch and roll themselves (table A).
#[test]
fn golden_c_simplified() {
    let folder = Folder::new("map-c");
    for row in rows("003", "C_eq7") {
        write_camera(&folder, &row);
        let [theta, gamma] = ["theta1", "gamma1"].map(|key| number(&row, key));
        for (model, oracle, tolerance) in [
            ("simplified", "", CORE_PX),
            ("simplified", "--oracle", ORACLE_PX),
            ("full", "", CORE_PX),
            ("full", "--oracle", ORACLE_PX),
        ] {
            let options = format!("--heading-deg 0 --pitch-deg {theta} --roll-deg {gamma} --model {model} {oracle}");
            close(mapped(&folder, &row, &options), &row, tolerance, &options);
        }
    }
}

#[test]
fn a_line_a_point_in_their_order() {
    let folder = Folder::with_scene("map-lines");
    let points = ["0,0", "10,20", "-10,20.5", "1e3,-1e-3"];
    let run = folder.run(&MAP.replace("10,20", &points.join(" "))).done();
    let lines: Vec<Value> = run.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(lines.len(), points.len(), "{run:?}");
    for (line, point) in lines.iter().zip(points) {
        let keys: Vec<&String> = line.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["in_front", "m", "m_frame", "n", "n_frame"], "{line}");
        let wanted: Vec<f64> = point.split(',').map(|word| word.parse().expect("a number")).collect();
        assert_eq!([number(line, "m"), number(line, "n")][..], wanted, "{line}");
    }
}

/// Numbers are printed in their shortest form: every f32 reads back as itself, and no shorter text does.
#[test]
fn numbers_are_in_shortest_form() {
    let folder = Folder::with_scene("map-shortest");
    let line = folder.run(MAP).done().stdout;
    let text = line.split_once("\"m_frame\":").expect("the key").1.split(',').next().expect("a value");
    assert_eq!(text.parse::<f32>().expect("a number").to_string(), text, "{line}");
}

#[test]
fn behind_the_camera_there_is_no_pixel() {
    let folder = Folder::with_scene("map-behind");
    // den = cos 60 + n k sin 60 with k = tan 30 / 48: negative below n = -48.
    for oracle in ["", "--oracle"] {
        let line = folder
            .run(&format!("map --camera camera.toml --heading-deg 0 --pitch-deg 60 --roll-deg 0 {oracle} -- 0,-500"))
            .json();
        assert_eq!(line["in_front"], false, "{line}");
        assert!(line["m_frame"].is_null() && line["n_frame"].is_null(), "{line}");
    }
}

/// Any finite heading is the same one, turns apart.
#[test]
fn headings_beyond_a_turn() {
    let folder = Folder::with_scene("map-turns");
    let at = |heading: &str| {
        let line = folder.run(&MAP.replace("--heading-deg 20", &format!("--heading-deg {heading}"))).json();
        [number(&line, "m_frame"), number(&line, "n_frame")]
    };
    let once = at("20");
    for heading in ["380", "-340", "36000020", "-719999980"] {
        assert!(miss(at(heading), once) < CORE_PX, "{heading}: {:?} instead of {once:?}", at(heading));
    }
    at("1e300");
}
