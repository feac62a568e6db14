use super::*;

const OPENCV: &str = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nflags: 0\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   \
    dt: d\n   data: [ 600., 0., 325.5, 0., 610., 230.,\n       0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   \
    data: [ -2.5e-01, 1.0e-01, 1.0e-03, -2.0e-03, 3.0e-02 ]\navg_reprojection_error: 0.3\n";

#[test]
fn opencvs_calibration_is_read() {
    let camera = from_opencv(OPENCV, "a.yml", None).expect("sound");
    assert_eq!((camera.cols, camera.rows), (640, 480));
    assert!((camera.fov_h_deg - 2.0 * (320.0f64 / 600.0).atan().to_degrees()).abs() < 1e-12);
    assert!((camera.fov_v_deg - 2.0 * (240.0f64 / 610.0).atan().to_degrees()).abs() < 1e-12);
    assert_eq!([camera.offset_m_px, camera.offset_n_px], [6.0, 9.5]);
    let lens = camera.distortion.expect("a lens");
    assert_eq!([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3], [-0.25, 0.1, 1e-3, -2e-3, 0.03]);
    // What OpenCV writes as JSON has the same.
    let json = r#"{"image_width": 640, "image_height": 480, "camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
        "data": [600.0, 0.0, 325.5, 0.0, 610.0, 230.0, 0.0, 0.0, 1.0]}, "distortion_coefficients": {"rows": 5, "cols": 1, "dt": "d",
        "data": [-0.25, 0.1, 1e-3, -2e-3, 0.03]}}"#;
    assert_eq!(from_opencv(json, "a.json", None).as_ref(), Ok(&camera));
    // As programs of people write it, which have matrices as lists of rows.
    let rows = r#"{"camera_matrix": [[600.0, 0.0, 325.5], [0.0, 610.0, 230.0], [0.0, 0.0, 1.0]],
        "distortion_coefficients": [[-0.25, 0.1, 1e-3, -2e-3, 0.03]], "image_width": 640, "image_height": 480}"#;
    assert_eq!(from_opencv(rows, "a.json", None), from_opencv(json, "a.json", None));
    let flat = rows.replace("[[-0.25", "[-0.25").replace("0.03]]", "0.03]");
    assert_eq!(from_opencv(&flat, "a.json", None), from_opencv(json, "a.json", None));
    for (from, to, wanted) in [
        ("600., 0., 325.5", "600., 0.5, 325.5", "camera_matrix[0][1] is 0.5, a skew"),
        ("0., 0., 1. ]", "0., 0., 2. ]", "camera_matrix[2][2] is 2, and 1 in every"),
        ("0., 0., 1. ]", "0., 3., 1. ]", "camera_matrix[2][1] is 3, and 0 in every"),
        ("image_width", "width", "image_width"),
        ("camera_matrix", "matrix", "camera_matrix"),
        ("3.0e-02 ]", "3.0e-02, 0.5 ]", "beyond k3"),
    ] {
        let error = from_opencv(&OPENCV.replace(from, to), "a.yml", None).expect_err(wanted).to_string();
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn a_camera_of_opendronemap_is_read() {
    let brown = r#"{"dji": {"projection_type": "brown", "width": 4000, "height": 3000, "focal_x": 0.7, "focal_y": 0.7, "c_x": 0.001, "c_y": 0.002,
        "k1": 0.01, "k2": 0.02, "p1": 0.03, "p2": 0.04, "k3": 0.05}}"#;
    let camera = from_odm(brown, "c.json", None).expect("sound");
    assert!((camera.fov_h_deg - 2.0 * (2000.0f64 / 2800.0).atan().to_degrees()).abs() < 1e-12);
    assert_eq!([camera.offset_m_px, camera.offset_n_px], [4.0, -8.0]);
    assert_eq!(camera.distortion.map(|lens| lens.k3), Some(0.05));
    let two = r#"{"a": {"width": 10, "height": 20, "focal": 0.5}, "b": {"projection_type": "fisheye", "width": 10, "height": 20, "focal": 0.5}}"#;
    assert!(from_odm(two, "c.json", None).expect_err("two").to_string().contains("\"a\", \"b\""));
    assert!(from_odm(two, "c.json", Some("b")).expect_err("a fisheye").to_string().contains("fisheye"));
    let camera = from_odm(two, "c.json", Some("a")).expect("sound");
    // The longer side is what lengths refer to.
    assert!((camera.fov_v_deg - 90.0).abs() < 1e-12 && camera.distortion.is_none());
}

#[test]
fn what_is_written_is_read_again() {
    for (name, what, ..) in PRESETS {
        let camera = preset(name).expect("a preset");
        let text = commented(&camera, what);
        assert_eq!(CameraFile::from_toml_str(&text, name), Ok(camera), "{text}");
    }
    let camera = from_opencv(OPENCV, "a.yml", None).expect("sound");
    assert_eq!(CameraFile::from_toml_str(&commented(&camera, "OpenCV"), "a"), Ok(camera));
    assert_eq!(preset("none"), None);
}

/// A sensor of 36 x 24 mm has its own focal length.
#[test]
fn equivalents_go_by_the_diagonal() {
    assert!((focal_px_of_35_mm(3600, 2400, 50.0) - 5000.0).abs() < 1e-9);
    let camera = of_focal_px(3600, 2400, 5000.0);
    assert!((camera.fov_h_deg - 2.0 * (18.0f64 / 50.0).atan().to_degrees()).abs() < 1e-12);
}

/// Its four coefficients would be read as k1, k2, p1, p2.
#[test]
fn fisheye_calibrations_are_refused() {
    for line in ["distortion_model: equidistant\n", "fisheye_model: 1\n"] {
        let error = from_opencv(&OPENCV.replace("flags: 0\n", line), "a.yml", None).expect_err(line).to_string();
        assert!(error.contains(line.trim()) && error.contains("--focal-px"), "{error}");
    }
    for line in ["distortion_model: plumb_bob\n", "fisheye_model: 0\n"] {
        assert!(from_opencv(&OPENCV.replace("flags: 0\n", line), "a.yml", None).is_ok(), "{line}");
    }
}

#[test]
fn a_size_is_what_the_calibration_is_of() {
    let bare = OPENCV.replace("image_width: 640\nimage_height: 480\n", "");
    assert_eq!(from_opencv(&bare, "a.yml", Some([640, 480])), from_opencv(OPENCV, "a.yml", None));
    let error = |text: &str, size| from_opencv(text, "a.yml", size).expect_err("refused").to_string();
    assert!(error(OPENCV, Some([640, 360])).contains("640 x 480"));
    assert!(error(&bare, Some([320, 240])).contains("outside a frame of 320 x 240"));
    let nothing = error(&bare.replace("camera_matrix", "matrix"), None);
    for key in ["image_width", "image_height", "camera_matrix"] {
        assert!(nothing.contains(key), "{nothing}");
    }
    assert!(error(&bare, None).contains("--size COLSxROWS"));
    // The frame's middle: no -0.0.
    let middle = from_opencv(&OPENCV.replace("325.5", "319.5").replace("230.", "239.5"), "a.yml", None).expect("sound");
    assert!(!commented(&middle, "a").contains("-0.0\n"), "{middle:?}");
}

#[test]
fn cameras_that_nobody_has_are_refused_or_asked_about() {
    for focal_px in [1.0, 1e9, 2_709_000.0] {
        assert!(check_made(&of_focal_px(3280, 2464, focal_px), "--focal-px").is_err(), "{focal_px}");
    }
    assert!(check_made(&of_focal_px(3280, 2464, 2709.0), "--focal-px").is_ok());
    // 2 atan(tan 30° · 480 / 640).
    let asked = not_square(&of_fov(640, 480, [60.0, 60.0])).expect("asked");
    assert!(asked.contains("60.0000x46.8264"), "{asked}");
    assert_eq!(not_square(&of_fov(640, 480, [60.0, 46.8])), None);
}
