//! Camera files that are missing, broken or no camera.

use crate::bad_options::{MAP, RECTIFY};
use crate::folder::{CAMERA, Folder, with};
use crate::refusals::Refusals;

/// The good file with `key` set to `value`.
fn camera(key: &str, value: &str) -> String {
    let lines = CAMERA.lines().map(|line| match line.split_once(" = ") {
        Some((name, _)) if name == key => format!("{key} = {value}\n"),
        _ => format!("{line}\n"),
    });
    let text: String = lines.collect();
    assert_ne!(text, CAMERA, "{key} is not in the file");
    text
}

#[test]
fn values_that_no_camera_has() {
    let folder = Folder::with_scene("camera-values");
    let mut refusals = Refusals::new(&folder);
    let angles = ["180.0", "200", "0", "-60.0", "nan", "inf", "-inf", "\"wide\"", "true"];
    let sides = ["0", "-1", "8193", "4294967297", "96.5", "nan", "\"many\""];
    let offsets = ["nan", "inf", "\"left\"", "[1]"];
    let cases = [
        (["fov_h_deg", "fov_v_deg"], &angles[..]),
        (["cols", "rows"], &sides[..]),
        (["offset_m_px", "offset_n_px"], &offsets[..]),
    ];
    for (keys, values) in cases {
        for key in keys {
            for value in values {
                folder.write("bad.toml", camera(key, value));
                refusals.expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml", key]);
            }
            folder.write("bad.toml", camera(key, values[0]));
            refusals.expect(&with(RECTIFY, "--camera", "bad.toml"), &["bad.toml", key]);
        }
    }
    refusals.done();
}

#[test]
fn keys_that_are_missing_unknown_or_twice() {
    let folder = Folder::with_scene("camera-keys");
    let mut refusals = Refusals::new(&folder);
    for line in CAMERA.lines() {
        folder.write("bad.toml", CAMERA.replace(&format!("{line}\n"), ""));
        let key = line.split(' ').next().expect("a key");
        refusals.expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml", key, "missing"]);
    }
    for (more, key) in [
        ("focal_mm = 8.0\n", "focal_mm"),
        ("cols = 96\n", "line 7"),
        ("[distortion]\nk9 = 0.1\n", "k9"),
        ("[distortion]\nk1 = nan\n", "k1"),
        ("distortion = 3\n", "distortion"),
        ("pixel_mm = 0.0\n", "pixel_mm"),
        ("crc32 = 1\n", "crc32"),
    ] {
        folder.write("bad.toml", format!("{CAMERA}{more}"));
        refusals.expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml", key]);
    }
    refusals.done();
}

#[test]
fn files_that_are_no_toml() {
    let folder = Folder::with_scene("camera-files");
    folder.make("folder");
    folder.write("broken.toml", "cols = 96\nrows = = 96\n");
    folder.write("cut.toml", &CAMERA[..CAMERA.len() - 6]);
    folder.write("empty.toml", "");
    folder.write("latin1.toml", b"# f\xfcr\ncols = 96\n");
    let mut refusals = Refusals::new(&folder);
    for file in ["none.toml", "none/camera.toml", "folder", "broken.toml", "cut.toml", "empty.toml", "latin1.toml"] {
        refusals.expect(&with(MAP, "--camera", file), &[file]);
        refusals.expect(&with(RECTIFY, "--camera", file), &[file]);
    }
    refusals.expect(&with(MAP, "--camera", "broken.toml"), &["line 2"]);
    refusals.done();
}

/// Numbers that double precision holds and single precision, the board's, does not.
#[test]
fn cameras_that_the_board_cannot_hold() {
    let folder = Folder::with_scene("camera-board");
    let mut refusals = Refusals::new(&folder);
    for (key, value) in
        [("fov_h_deg", "179.99999999"), ("fov_v_deg", "1e-60"), ("offset_m_px", "1e60"), ("offset_n_px", "-1e60")]
    {
        folder.write("bad.toml", camera(key, value));
        refusals.expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml"]);
        refusals.expect(&with(RECTIFY, "--camera", "bad.toml"), &["bad.toml"]);
    }
    folder.write("bad.toml", format!("{CAMERA}[distortion]\nk1 = -1.2\n"));
    refusals
        .expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml: distortion of k1 = -1.2,", "folds the picture back"]);
    let matrix = r#""camera_matrix": [[83.0, 0, 47.5], [0, 83.0, 47.5], [0, 0, 1]]"#;
    let lens = r#""image_width": 96, "image_height": 96, "distortion_coefficients": [-120.0, 3000.0, 0, 0, 0]"#;
    folder.write("lens.json", format!("{{{matrix}, {lens}}}"));
    refusals.expect(
        "camera new --from-opencv lens.json",
        &["--from-opencv lens.json: distortion of k1 = -120, k2 = 3000,", "folds the picture back"],
    );
    folder.write("bad.toml", format!("{CAMERA}[distortion]\nk1 = 1e60\n"));
    refusals.expect(&with(MAP, "--camera", "bad.toml"), &["bad.toml"]);
    refusals.done();
}
