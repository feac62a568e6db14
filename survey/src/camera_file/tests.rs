//! The camera file: what is accepted, what is refused, and that it survives being written.

use super::*;

const SIX: &str = "cols = 640\nrows = 480\nfov_h_deg = 40\nfov_v_deg = 30.5\noffset_m_px = -1.25\noffset_n_px = 0\n";

fn error_of(text: &str) -> String {
    let error = CameraFile::from_toml_str(text, "cam.toml").expect_err(text);
    let sentence = error.to_string();
    assert!(sentence.contains("cam.toml"), "{sentence}");
    assert!(!sentence.contains('\n'), "{sentence}");
    sentence
}

fn full() -> CameraFile {
    let text = format!(
        "{SIX}pixel_mm = 0.0048\nversion = 3\n[distortion]\nk1 = -0.1\np2 = 1e-7\n[boresight]\nphi_deg = 0.1\n\
         omega_deg = -2\nkappa_deg = 0.3\n[lever_arms]\nantenna_to_camera_m = [0.0, 0.5, 1]\n"
    );
    CameraFile::from_toml_str(&text, "cam.toml").expect("a full file")
}

#[test]
fn six_keys_are_a_whole_file() {
    let camera = CameraFile::from_toml_str(SIX, "cam.toml").expect("six keys");
    assert_eq!((camera.cols, camera.rows), (640, 480));
    assert_eq!((camera.fov_h_deg, camera.fov_v_deg), (40.0, 30.5));
    assert_eq!((camera.offset_m_px, camera.offset_n_px), (-1.25, 0.0));
    assert_eq!(camera.distortion, None);
    assert_eq!((camera.pixel_mm, camera.crc32), (None, None));
}

#[test]
fn absent_coefficients_are_zero() {
    let wanted = Distortion { k1: -0.1, p2: 1e-7, ..Distortion::default() };
    assert_eq!(full().distortion, Some(wanted));
}

#[test]
fn what_is_written_reads_back_to_the_last_bit() {
    for mut camera in [full(), four(), CameraFile::from_toml_str(SIX, "cam.toml").expect("six keys")] {
        camera.fov_h_deg = 40.000_000_000_000_01;
        match camera.heads.first_mut() {
            None => camera.offset_m_px = -1e-300,
            Some(head) => (head.rotation_deg[1], head.d_m[2]) = (18.000_000_000_000_004, -1e-300),
        }
        let text = camera.to_toml_string();
        let mut again = CameraFile::from_toml_str(&text, "cam.toml").expect(&text);
        assert!(again.crc32.is_some());
        assert_eq!(again.to_toml_string(), text);
        again.crc32 = None;
        assert_eq!(again, camera);
    }
}

#[test]
fn the_checksum_is_of_the_text_without_its_line() {
    // CRC-32/ISO-HDLC of SIX, from Python's zlib.crc32.
    let sum = 0xb546_7c8c_u32;
    for text in [
        format!("crc32 = {sum}\n{SIX}"),
        format!("{SIX}crc32={sum:#x}"),
        format!("{SIX}  crc32  =  {sum:#010x} # checked\r\n"),
    ] {
        let camera = CameraFile::from_toml_str(&text, "cam.toml").expect(&text);
        assert_eq!(camera.crc32, Some(sum));
    }
    let altered = format!("crc32 = {sum}\n{SIX}").replace("40", "41");
    assert!(error_of(&altered).contains("crc32"));
    // A line that could be taken for the checksum.
    assert!(error_of(&format!("\"crc32\" = {sum}\n{SIX}")).contains("line of its own"));
}

#[test]
fn every_missing_key_is_named() {
    for line in SIX.lines() {
        let key = line.split(' ').next().expect("a key");
        let error = error_of(&SIX.replace(&format!("{line}\n"), ""));
        assert!(error.contains(key) && error.contains("missing"), "{error}");
    }
}

#[test]
fn unknown_keys_are_named() {
    assert!(error_of(&format!("{SIX}focal_mm = 35\n")).contains("unknown key focal_mm"));
    assert!(error_of(&format!("{SIX}[distortion]\nk4 = 1\n")).contains("unknown key distortion.k4"));
}

#[test]
fn wrong_values_are_named_with_key_and_value() {
    for (line, key, value) in [
        ("cols = 640", "cols", "0"),
        ("cols = 640", "cols", "65536"),
        ("cols = 640", "cols", "-1"),
        ("cols = 640", "cols", "640.0"),
        ("rows = 480", "rows", "0"),
        ("rows = 480", "rows", "4294967297"),
        ("rows = 480", "rows", "\"480\""),
        ("fov_h_deg = 40", "fov_h_deg", "0"),
        ("fov_h_deg = 40", "fov_h_deg", "180"),
        ("fov_h_deg = 40", "fov_h_deg", "nan"),
        ("fov_v_deg = 30.5", "fov_v_deg", "-30.5"),
        ("fov_v_deg = 30.5", "fov_v_deg", "inf"),
        ("fov_v_deg = 30.5", "fov_v_deg", "true"),
        ("offset_m_px = -1.25", "offset_m_px", "nan"),
        ("offset_n_px = 0", "offset_n_px", "-inf"),
    ] {
        let error = error_of(&SIX.replace(line, &format!("{key} = {value}")));
        assert!(error.contains(&format!("{key} = {value} ")), "{error}");
    }
    for line in [
        "pixel_mm = 0.0",
        "pixel_mm = -0.1",
        "version = -1",
        "version = 1.0",
        "crc32 = 4294967296",
        "distortion = 1",
        "boresight = 1.0",
        "heads = \"four\"",
        "heads = []",
        "heads = [1]",
        "boresight = { phi_deg = 11, omega_deg = 0, kappa_deg = 0 }",
        "lever_arms = { antenna_to_camera_m = [0, 0] }",
        "covariance = { head_sd_arcsec = [], head_arcsec2 = [] }",
        "[distortion]\nk1 = nan",
        "[distortion]\np1 = \"0\"",
    ] {
        let key = line.rsplit('\n').next().and_then(|l| l.split(' ').next());
        let error = error_of(&format!("{SIX}{line}\n"));
        assert!(error.contains(key.expect("a key")), "{error}");
    }
}

#[test]
fn what_is_not_toml_is_told_by_line() {
    assert!(error_of("cols = 640\nrows =\n").contains("line 2"));
    assert!(error_of(&format!("{SIX}cols = 1\n")).contains("line 7"));
    let error = CameraFile::read(Path::new("/nonexistent/cam.toml")).expect_err("missing");
    assert!(error.to_string().contains("/nonexistent/cam.toml"));
}

/// Paper 002's camera: four heads of 7228 x 5428, a virtual image of 15400 x 10400.
fn four() -> CameraFile {
    let head = |side: f64, ahead: f64| Head {
        cols: 7228,
        rows: 5428,
        f_px: 6_911.764_705_882_353,
        offset_m_px: 0.3,
        offset_n_px: -0.1,
        distortion: (side > 0.0).then_some(Distortion { k1: -0.01, ..Distortion::default() }),
        rotation_deg: [22.0 * side, 18.0 * ahead, 0.1],
        d_m: [0.045 * side, 0.06 * ahead, 0.0],
    };
    let matrix = (0..9).map(|i| (0..9).map(|j| if i == j { 2.0 + i as f64 } else { -0.1 }).collect()).collect();
    CameraFile {
        heads: vec![head(-1.0, 1.0), head(1.0, 1.0), head(-1.0, -1.0), head(1.0, -1.0)],
        covariance: Some(Covariance::new(matrix)),
        ..CameraFile::new((15_400, 10_400), (96.175_684, 73.911_246))
    }
}

#[test]
fn a_head_is_a_camera_by_itself() {
    let camera = four().heads[1].camera();
    // Paper 002: 55.208030 x 42.876281 degrees.
    assert!((camera.fov_h_deg - 55.208_030).abs() < 1e-6 && (camera.fov_v_deg - 42.876_281).abs() < 1e-6);
    assert_eq!((camera.cols, camera.rows, camera.offset_m_px, camera.heads.len()), (7228, 5428, 0.3, 0));
    assert_eq!(camera.distortion.map(|d| d.k1), Some(-0.01));
}

#[test]
fn heads_that_are_none_are_named_with_their_number() {
    let text = four().to_toml_string();
    let text = text.split_once('\n').expect("a line of the checksum").1;
    assert!(CameraFile::from_toml_str(text, "cam.toml").is_ok());
    for (old, new, named) in [
        ("cols = 7228", "cols = 8193", "head 1: cols = 8193"),
        ("f_px = 6911.764705882353", "f_px = 0.5", "head 1: f_px = 0.5"),
        ("f_px = 6911.764705882353", "f_px = nan", "head 1: f_px = nan"),
        ("f_px = 6911.764705882353\n", "", "head 1: f_px is missing"),
        ("f_px = 6911.764705882353", "focal = 1.0", "head 1: focal"),
        ("offset_m_px = 0.3", "offset_m_px = inf", "head 1: offset_m_px = inf"),
        ("rotation_deg = [22.0, 18.0, 0.1]", "rotation_deg = [90.0, 18.0, 0.1]", "head 2: rotation_deg"),
        ("rotation_deg = [22.0, 18.0, 0.1]", "rotation_deg = [22.0, 18.0]", "head 2: rotation_deg"),
        ("rotation_deg = [22.0, 18.0, 0.1]", "rotation_deg = [22.0, 18.0, nan]", "head 2: rotation_deg"),
        ("d_m = [-0.045, -0.06, 0.0]", "d_m = [-101.0, 0, 0]", "head 3: d_m"),
        ("d_m = [0.045, -0.06, 0.0]\n", "", "head 4: d_m is missing"),
        ("k1 = -0.01", "k1 = nan", "head 2: distortion.k1 = nan"),
        ("\noffset_m_px = 0.0", "\noffset_m_px = 0.5", "offset_m_px = 0.5 must be 0"),
        ("\n[[heads]]", "\n[distortion]\nk1 = 0.1\n\n[[heads]]", "has no distortion"),
        ("cols = 15400", "cols = 65536", "cols = 65536"),
        ("[2.0, -0.1,", "[2.0, -0.2,", "covariance.head_arcsec2"),
        ("[2.0, -0.1,", "[2.1, -0.1,", "covariance.head_arcsec2"),
        ("[2.0, -0.1,", "[2.0,", "covariance.head_arcsec2"),
        ("head_sd_arcsec = [1.", "head_sd_arcsec = [-1.", "covariance.head_sd_arcsec"),
    ] {
        let changed = text.replacen(old, new, 1);
        assert_ne!(changed, text, "{old} is not in the file");
        let error = error_of(&changed);
        assert!(error.contains(named), "{error} instead of {named}");
    }
}

#[test]
fn what_could_not_be_read_again_is_not_written() {
    let folder = crate::io::output::tests::scratch("camera-file");
    let (path, mut camera) = (folder.join("cam.toml"), four());
    write(&path, &camera).expect("written");
    let mut again = CameraFile::read(&path).expect("read");
    again.crc32 = None;
    assert_eq!(again, camera);
    camera.heads[3].f_px = 0.0;
    assert!(write(&folder.join("other.toml"), &camera).expect_err("refused").to_string().contains("head 4"));
    camera.heads[3].f_px = f64::NAN;
    assert!(write(&folder.join("other.toml"), &camera).is_err());
    assert!(!folder.join("other.toml").exists());
}

/// OpenCV's cx and cy as offsets, micrometres as millimetres.
#[test]
fn offsets_from_the_corner_and_micrometres_are_told() {
    let error = |text: &str| CameraFile::from_toml_str(text, "a.toml").expect_err(text).to_string();
    let corner = SIX.replace("-1.25", "320.0");
    assert!(error(&corner).contains("offset_m_px = cx - 319.5 and offset_n_px = 239.5 - cy"), "{}", error(&corner));
    let inside = CameraFile::from_toml_str(&SIX.replace("-1.25", "312.0"), "a.toml").expect("a frame");
    let asked = inside.doubt().expect("asked about");
    assert!(asked.contains("offset_m_px = -7.5"), "{asked}");
    assert_eq!(CameraFile::from_toml_str(SIX, "a.toml").expect("sound").doubt(), None);
    for (written, told) in
        [("6.0", "write pixel_mm = 0.006"), ("2.4", "write pixel_mm = 0.0024"), ("1e-6", "0.0001 to 0.2 mm")]
    {
        let what = error(&format!("{SIX}pixel_mm = {written}\n"));
        assert!(what.contains(told), "{what}");
    }
}
