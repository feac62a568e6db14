//! Flights that cannot be flown: scenarios, links, grounds and attitude logs.

use crate::folder::{FLY, Folder};
use crate::pictures::{Crs, flat, geotiff, grey_8_tiff, texture};
use crate::refusals::Refusals;
use plumbline_tests::vectors::number;

#[test]
fn frames_and_seeds() {
    let folder = Folder::new("fly-numbers");
    let mut refusals = Refusals::new(&folder);
    for value in ["0", "-1", "1.5", "4294967296", "1000001", "many"] {
        refusals.expect(&format!("fly --frames {value} --out out"), &["--frames", value]);
    }
    for value in ["-1", "18446744073709551616", "0x1", "lucky"] {
        refusals.expect(&format!("fly --frames 1 --seed {value} --out out"), &["--seed", value]);
    }
    for value in ["-1", "all"] {
        refusals.expect(&format!("fly --frames 1 --dump {value} --out out"), &["--dump", value]);
    }
    refusals.done();
}

/// The emulated board's memory for a frame is limited: said before anything is started.
#[test]
fn frames_that_the_emulated_board_cannot_hold() {
    let folder = Folder::new("fly-large");
    folder.write("large.toml", "frames = 1\n[camera]\ncols = 4096\nrows = 4096\n");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("fly --scenario large.toml --link qemu --out out", &["4096 x 4096", "8126464"]);
    refusals.done();
}

#[test]
fn scenarios() {
    let folder = Folder::new("fly-scenarios");
    folder.make("folder");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("fly --frames 1 --scenario storm --out out", &["--scenario", "storm"]);
    refusals.expect("fly --frames 1 --scenario naib --out out", &["--scenario naib", "a similar one exists: 'naip'"]);
    refusals.expect("fly --frames 1 --scenario Closed-lop --out out", &["a similar one exists: 'closed_loop'"]);
    refusals.expect("fly --frames 1 --scenario none/a.toml --out out", &["--scenario", "none/a.toml"]);
    refusals.expect("fly --frames 1 --scenario folder --out out", &["folder"]);
    for (text, names) in [
        ("frames = 1\nspeed = 3\n", &["speed", "line 2"][..]),
        ("[flight]\naltitude_m = 3\n", &["altitude_m"]),
        ("frames = = 1\n", &["line 1"]),
        ("frames = 0\n", &["frames = 0"]),
        ("frames = -1\n", &["line 1"]),
        ("frames = \"many\"\n", &["line 1"]),
        ("resolution_m = 0.0\n", &["resolution_m"]),
        ("resolution_m = nan\n", &["resolution_m"]),
        ("search_px = 0\n", &["search_px"]),
        ("search_px = 65\n", &["search_px"]),
        ("noise_dn = inf\n", &["noise_dn"]),
        ("exposure_us = 400000\n", &["exposure_us"]),
        ("[flight]\nheight_m = [150.0, 100.0]\n", &["height_m"]),
        ("[flight]\nheight_m = [0.0, 100.0]\n", &["height_m"]),
        ("[flight]\ntilt_max_deg = 70.0\n", &["tilt_max_deg"]),
        ("[camera]\nfov_h_deg = 180.0\n", &["fov_h_deg"]),
        ("[camera]\nfov_h_deg = 40.0\n", &["fov_h_deg", "fov_v_deg"]),
        ("[camera]\ncols = 0\n", &["cols"]),
        ("[attitude]\nrate_hz = 0\n", &["rate_hz"]),
        ("[link_faults]\ncut_percent = 101.0\n", &["cut_percent"]),
        ("[ground]\nkind = \"moon\"\n", &["moon", "line 2"]),
        ("[ground]\northo = \"none.tif\"\n", &["none.tif"]),
        ("camera_file = \"none.toml\"\n", &["none.toml"]),
        ("[replay]\natt = \"none.csv\"\n", &["none.csv"]),
    ] {
        folder.write("bad.toml", text);
        let names: Vec<&str> =
            names.iter().copied().chain(["bad.toml"].into_iter().filter(|_| !text.contains("none"))).collect();
        refusals.expect("fly --scenario bad.toml --out out", &names);
    }
    folder.write("empty.toml", "");
    refusals.expect("fly --scenario empty.toml --out out", &["cannot read empty.toml: it is empty"]);
    folder.write("latin1.toml", b"# f\xfcr\nframes = 1\n");
    refusals.expect("fly --scenario latin1.toml --out out", &["latin1.toml"]);
    refusals.done();
}

/// A scenario's camera file gets the same checks as its `[camera]`.
#[test]
fn scenarios_with_a_camera_file_that_cannot_fly() {
    let folder = Folder::new("fly-camera-files");
    folder.write("bad.toml", "frames = 1\ncamera_file = \"camera.toml\"\n");
    let mut refusals = Refusals::new(&folder);
    for (size, fov) in [((512, 512), (179.0, 179.0)), ((512, 512), (60.0, 40.0))] {
        folder.write(
            "camera.toml",
            format!(
                "cols = {}\nrows = {}\nfov_h_deg = {:?}\nfov_v_deg = {:?}\noffset_m_px = 0.0\noffset_n_px = 0.0\n",
                size.0, size.1, fov.0, fov.1
            ),
        );
        refusals.expect("fly --scenario bad.toml --out out", &["camera.toml"]);
    }
    refusals.done();
}

#[test]
fn links() {
    let folder = Folder::with_ground("fly-links");
    folder.make("folder");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{FLY} --frames 1 --link foo --out out"), &["--link", "foo"]);
    refusals.expect(&format!("{FLY} --frames 1 --link serial: --out out"), &["--link"]);
    refusals.expect(&format!("{FLY} --frames 1 --link serial:none --out out"), &["--link", "serial:none"]);
    refusals.expect(&format!("{FLY} --frames 1 --link qemu --firmware none.elf --out out"), &["none.elf"]);
    refusals.expect(&format!("{FLY} --frames 1 --link qemu --firmware folder --out out"), &["folder"]);
    refusals.expect(&format!("{FLY} --frames 1 --firmware none.elf --out out"), &["--firmware", "--link qemu"]);
    refusals.done();
}

#[test]
fn grounds() {
    let folder = Folder::with_ground("fly-grounds");
    folder.make("folder");
    folder.write("text.tif", "not a raster\n");
    let ground = texture((256, 256), (0.0, 0.0));
    folder.run(&format!("{FLY} --frames 1")).done();
    geotiff(&folder.path("tiny.tif"), &texture((32, 32), (0.0, 0.0)), 5.0, Crs::Projected(32633));
    geotiff(&folder.path("pixel.tif"), &flat((1, 1), 9), 5.0, Crs::Projected(32633));
    geotiff(&folder.path("unnamed.tif"), &ground, 5.0, Crs::Unnamed);
    geotiff(&folder.path("unknown.tif"), &ground, 5.0, Crs::Projected(61234));
    geotiff(&folder.path("degrees.tif"), &ground, 5e-5, Crs::Geographic(4326));
    geotiff(&folder.path("other.tif"), &ground, 5.0, Crs::Projected(32632));
    grey_8_tiff(&folder.path("plain.tif"), &ground);
    let whole = folder.read("ground.tif");
    folder.write("cut.tif", &whole[..whole.len() / 2]);

    let mut refusals = Refusals::new(&folder);
    for file in [
        "none.tif",
        "folder",
        "text.tif",
        "plain.tif",
        "cut.tif",
        "tiny.tif",
        "pixel.tif",
        "unnamed.tif",
        "unknown.tif",
        "degrees.tif",
    ] {
        refusals.expect(&format!("fly --frames 1 --ground {file} --out out"), &[file]);
    }
    refusals.expect("fly --frames 1 --ground tiny.tif --out out", &["footprint"]);
    refusals.expect("fly --frames 1 --ground unknown.tif --out out", &["61234"]);
    for option in ["--dem", "--reference"] {
        for file in ["none.tif", "folder", "text.tif", "plain.tif", "cut.tif"] {
            refusals.expect(&format!("{FLY} --frames 1 {option} {file} --out out"), &[file]);
        }
        refusals.expect(&format!("{FLY} --frames 1 {option} other.tif --out out"), &["32633", "32632"]);
    }
    refusals.expect("fly --frames 1 --dem ground.tif --out out", &["--dem", "--ground"]);
    refusals.expect("fly --frames 1 --reference ground.tif --out out", &["--reference", "--ground"]);
    refusals.done();
}

/// Ten seconds of level flight; `change` makes each row of it.
fn log(change: impl Fn(usize, &str) -> String) -> String {
    let rows = (0..=100).map(|row| change(row, &format!("{},1.0,2.0,30.0", row as f64 * 0.1)));
    "t_s,roll_deg,pitch_deg,yaw_deg\n".to_owned() + &rows.map(|row| row + "\n").collect::<String>()
}

#[test]
fn attitude_logs() {
    let folder = Folder::with_ground("fly-logs");
    folder.make("folder");
    let same = |_: usize, row: &str| row.to_owned();
    let at_50 = |other: &'static str| {
        move |index: usize, row: &str| if index == 50 { other.to_owned() } else { row.to_owned() }
    };
    folder.write("good.csv", log(same));
    folder.run(&format!("{FLY} --frames 10 --replay good.csv")).done();
    let mut refusals = Refusals::new(&folder);
    // Ten frames fly the first 6.5 s. Row 50 stands in line 52: the header is the first one, row 0 the second.
    for (text, names) in [
        (String::new(), &["empty"][..]),
        ("\n\n".to_owned(), &["empty"]),
        ("t_s,roll_deg,pitch_deg,yaw_deg\n".to_owned(), &["0 rows"]),
        (log(same).replacen("pitch_deg", "nose_deg", 1), &["pitch_deg"]),
        (log(same).replacen("t_s,", "time,", 1), &["t_s"]),
        (log(at_50("4.8,1.0,2.0,30.0")), &["line 52", "t_s", "4.8"]),
        (log(at_50("4.9,1.0,2.0,30.0")), &["line 52", "t_s", "4.9"]),
        (log(at_50("5.0,level,2.0,30.0")), &["line 52", "roll_deg", "level"]),
        (log(at_50("5.0,1.0,NaN,30.0")), &["line 52", "pitch_deg", "NaN"]),
        (log(at_50("5.0,1.0,2.0,inf")), &["line 52", "yaw_deg", "inf"]),
        (log(at_50("5.0,1.0")), &["line 52", "2 fields"]),
    ] {
        folder.write("bad.csv", text);
        let names: Vec<&str> = names.iter().copied().chain(["bad.csv"]).collect();
        refusals.expect(&format!("{FLY} --frames 10 --replay bad.csv --out out"), &names);
    }
    // Frames that see the horizon are refused on board, one by one; a flight of nothing else is none.
    folder.write("steep.csv", log(at_50("5.0,1.0,65.0,30.0")));
    let summary = folder.run(&format!("{FLY} --frames 10 --replay steep.csv --json")).json();
    assert!(number(&summary, "accepted") >= 8.0, "{summary}");
    let steep: String = (0..100).map(|row| format!("{},1.0,65.0,30.0\n", 0.1 * f64::from(row))).collect();
    folder.write("bad.csv", format!("t_s,roll_deg,pitch_deg,yaw_deg\n{steep}"));
    refusals.expect(&format!("{FLY} --frames 10 --replay bad.csv --out out"), &["horizon"]);
    refusals.expect(&format!("{FLY} --frames 10 --replay none.csv --out out"), &["none.csv"]);
    refusals.expect(&format!("{FLY} --frames 10 --replay folder --out out"), &["folder"]);
    // Ten seconds hold no hundred frames.
    refusals.expect(&format!("{FLY} --frames 100 --replay good.csv --out out"), &["good.csv", "100"]);
    folder.write("latin1.csv", b"t_s,roll_deg,pitch_deg,yaw_deg\n0,\xfc,0,0\n");
    refusals.expect(&format!("{FLY} --frames 10 --replay latin1.csv --out out"), &["latin1.csv"]);
    refusals.done();
}
