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
        "{SIX}pixel_mm = 0.0048\nversion = 3\n[distortion]\nk1 = -0.1\np2 = 1e-7\n[boresight]\nphi_rad = 0.002\n\
         [[heads]]\nd_m = [0.1, 0.2, 0.3]\n[[heads]]\nd_m = [-0.1, 0.2, 0.3]\n[lever_arms]\nantenna_m = [0.0, 0.5, 1.0]\n"
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
    for mut camera in [full(), CameraFile::from_toml_str(SIX, "cam.toml").expect("six keys")] {
        camera.fov_h_deg = 40.000_000_000_000_01;
        camera.offset_m_px = -1e-300;
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
    // A line that the checksum cannot be told from.
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
        ("cols = 640", "cols", "8193"),
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
