//! What people type and do not mean: each is refused, or asked about, with what was probably meant and what to type.

use crate::folder::Folder;
use crate::pictures::{Crs, geotiff, texture};
use crate::refusals::Refusals;
use serde_json::Value;

const RECTIFY: &str = "rectify --camera camera.toml --frame frame.png --heading-deg 0 --roll-deg 0 --height-m 100 --resolution-m 5 --out p.png";
const MAP: &str = "map --camera camera.toml --heading-deg 0 --pitch-deg 5 --roll-deg 0";
const CALIBRATE: &str = "calibrate --block block.json --observations obs.csv --out four.toml";

#[test]
fn a_gimbals_pitch_and_points_without_dashes() {
    let folder = Folder::with_scene("mistakes-angles");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{RECTIFY} --pitch-deg -89"), &["gimbal's pitch of -89", "write --pitch-deg 1"]);
    refusals.expect(&format!("{RECTIFY} --pitch-deg -90"), &["gimbal's pitch of -90", "write --pitch-deg 0"]);
    refusals.expect(&format!("{RECTIFY} --pitch-deg -83.25"), &["write --pitch-deg 6.75"]);
    refusals.expect(&format!("{MAP} 10,20 -3,4.5"), &["points come last and after --: -- 10,20 -3,4.5"]);
    refusals.expect(&format!("{MAP} -10,20"), &["unexpected argument '-10,20' found", "-- -10,20"]);
    let gimbal = MAP.replace("--pitch-deg 5", "--pitch-deg -89");
    refusals.expect(&format!("{gimbal} -- 10,20"), &["gimbal's pitch of -89", "write --pitch-deg 1"]);
    refusals.expect(
        "intersect --focal-mm 50 --station-1-m 0,0,100 --station-2-m 0,50,100 1,2,3,4",
        &["after --: -- 1,2,3,4"],
    );
    refusals.expect("motion --focal-mm 120 --speed-m-s 50 --height-m 2000 10,-20 0,0", &["after --: -- 10,-20 0,0"]);
    refusals.done();
    folder.run(&format!("{MAP} -- 10,20 -3,4.5")).done();
    folder.run(&format!("{RECTIFY} --pitch-deg -8")).done();
}

/// An attitude log of a gimbal, whose -89 is nearly straight down.
#[test]
fn a_gimbals_log() {
    let folder = Folder::with_ground("mistakes-gimbal");
    let rows: String = (0..=100).map(|row| format!("{},0.5,{},30.0\n", f64::from(row) * 0.1, -89 - row % 2)).collect();
    folder.write("log.csv", format!("t_s,roll_deg,pitch_deg,yaw_deg\n{rows}"));
    let mut refusals = Refusals::new(&folder);
    refusals
        .expect("fly --ground ground.tif --frames 10 --replay log.csv --out out", &["log.csv, pitch_deg", "add 90"]);
    refusals.done();
}

/// The poses of a boresight flight as a gimbal and as radians have them.
#[test]
fn poses_of_a_gimbal_or_in_radians() {
    let folder = Folder::with_scene("mistakes-poses");
    let mut fixes = "mid_exposure_us,accepted,east_m,north_m,sigma_east_m,sigma_north_m\n".to_owned();
    (0..60).for_each(|at| fixes.push_str(&format!("{at},1,{},0,0.3,0.3\n", 10 * at)));
    folder.write("fixes.csv", fixes);
    let poses = |angles: fn(f64) -> [f64; 3]| {
        let row = |at: u32| {
            let [heading, pitch, roll] = angles(f64::from(at));
            format!("{at},{},0,120,{heading},{pitch},{roll}\n", 10 * at)
        };
        let head = "mid_exposure_us,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n";
        format!("{head}{}", (0..60).map(row).collect::<String>())
    };
    let boresight = "boresight --camera camera.toml --fixes fixes.csv --poses poses.csv --out new.toml";
    let mut refusals = Refusals::new(&folder);
    folder.write("poses.csv", poses(|at| [3.0 * at, -89.0 - 0.9 * (at % 2.0), 0.5]));
    refusals.expect(boresight, &["poses.csv, pitch_deg", "looks straight down", "gimbal's pitch add 90"]);
    folder.write("poses.csv", poses(|at| [3.0 * at, -91.0, 0.5]));
    refusals.expect(boresight, &["poses.csv, line 2", "pitch_deg", "gimbal's pitch add 90"]);
    folder.write("poses.csv", poses(|at| [0.1 * at, 0.05 * (at / 3.0).sin(), 0.03]));
    refusals.expect(
        boresight,
        &[
            "larger than 5.90, which looks like radians",
            "if so, awk",
            "$5 *= 57.29577951308232; $6",
            "poses.csv > degrees.csv",
        ],
    );
    // To the north alone nobody can tell: a turn more says that they are degrees.
    folder.write("poses.csv", poses(|at| [0.01 * at, 0.05 * (at / 3.0).sin(), 0.03]));
    refusals.expect(boresight, &["looks like radians", "add 360 to heading_deg"]);
    folder.write("poses.csv", poses(|at| [300.0 * at, 100.0 * at, 50.0]));
    refusals.expect(boresight, &["angles go up to 17700, which looks like hundredths of a degree", "$5 *= 0.01"]);
    refusals.done();
    folder.write("poses.csv", poses(|at| [360.0 + 0.01 * at, 0.05 * (at / 3.0).sin(), 0.03]));
    folder.run(boresight).done();
    folder.write("poses.csv", poses(|at| [3.0 * at, 3.0 * (at / 3.0).sin(), 2.0]));
    assert!(!folder.run(boresight).stderr.contains("radians"));
}

#[test]
fn a_map_in_degrees_or_in_web_mercator_is_told_how_to_become_one_in_metres() {
    let folder = Folder::with_scene("mistakes-maps");
    let ground = texture((256, 256), (0.0, 0.0));
    // Their corner is 500000, 5330000 or 15, 48 degrees.
    geotiff(&folder.path("degrees.tif"), &ground, 5e-5, Crs::Geographic(4326));
    geotiff(&folder.path("web.tif"), &ground, 5.0, Crs::Projected(3857));
    folder.write("frames.csv", frames());
    let mut refusals = Refusals::new(&folder);
    for verb in [
        "fly --frames 1 --ground degrees.tif",
        "tiles --ortho degrees.tif --resolution-m 5 --out t.bin",
        "evaluate --frames frames.csv --camera camera.toml --reference degrees.tif --out out",
    ] {
        refusals.expect(verb, &["in degrees (EPSG:4326)", "on the ground", "gdalwarp -t_srs EPSG:326", "degrees_utm"]);
        let web = verb.replace("degrees.tif", "web.tif");
        refusals.expect(&web, &["in Web Mercator (EPSG:3857)", "gdalwarp -t_srs EPSG:326", "web_utm"]);
    }
    refusals.done();
}

#[test]
fn an_elevation_model_on_another_grid_is_told_how_to_get_on_that_of_the_map() {
    let folder = Folder::with_scene("mistakes-models");
    let ground = texture((256, 256), (0.0, 0.0));
    geotiff(&folder.path("map.tif"), &ground, 5.0, Crs::Projected(32633));
    geotiff(&folder.path("model.tif"), &ground, 5.0, Crs::Projected(32632));
    folder.write("frames.csv", frames());
    let mut refusals = Refusals::new(&folder);
    for verb in [
        "fly --frames 1 --ground map.tif --dem model.tif",
        "evaluate --frames frames.csv --camera camera.toml --reference map.tif --dem model.tif --out out",
    ] {
        let line = "gdalwarp -t_srs EPSG:32633 -r bilinear model.tif model.32633.tif";
        refusals.expect(verb, &["map.tif is in EPSG:32633", "the elevation model in EPSG:32632", line]);
    }
    refusals.done();
}

fn frames() -> String {
    let row = "frame.png,500300,5329700,100,0,0,0\n";
    format!("file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n{row}{row}{row}")
}

/// The compression of a file changed to ZSTD in its header.
#[test]
fn a_compression_that_is_not_read_is_told_with_what_changes_it() {
    let folder = Folder::with_ground("mistakes-zstd");
    let mut bytes = folder.read("ground.tif");
    // Tag 259, of 16 bits (type 3), one value.
    let entry = [259u16.to_le_bytes(), 3u16.to_le_bytes()].concat();
    let at = bytes.windows(4).position(|window| window == entry).expect("a little-endian TIFF with its compression");
    bytes[at + 8..at + 10].copy_from_slice(&50_000u16.to_le_bytes());
    folder.write("zstd.tif", bytes);
    let mut refusals = Refusals::new(&folder);
    refusals.expect(
        "tiles --ortho zstd.tif --resolution-m 5 --out t.bin",
        &["zstd.tif", "ZSTD", "gdal_translate -co COMPRESS=DEFLATE"],
    );
    refusals.done();
}

#[test]
fn latitude_and_longitude_swapped() {
    let folder = Folder::with_ground("mistakes-swapped");
    let area = |corners: &str| format!(r#"{{"type":"Polygon","coordinates":[[{corners}]]}}"#);
    folder.write("dem.asc", include_str!("../../examples/plan/dem.asc"));
    folder.write("dem.prj", include_str!("../../examples/plan/dem.prj"));
    folder.write("camera.toml", include_str!("../../examples/camera.toml"));
    folder.write("swapped.json", area("[48.2062,16.3473],[48.2070,16.3581],[48.2097,16.3595],[48.2062,16.3473]"));
    folder.write("far.json", area("[-37.8,144.9],[-37.9,144.9],[-37.9,145.0],[-37.8,144.9]"));
    let plan = "plan --dem dem.asc --area swapped.json --camera camera.toml --gsd-m 0.25 --overlap 70/40 --out out";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(plan, &["longitude first"]);
    refusals.expect(&plan.replace("swapped", "far"), &["the longitude comes first"]);
    let typed = |area: &str| plan.replace("swapped.json", area);
    let meant = "--area 600100,5340100,600900,5340600";
    refusals.expect(&typed("5340100,600100,5340600,600900"), &["dem.asc", "y before x", meant]);
    refusals.expect(&typed("600100,600900,5340100,5340600"), &["X0,X1,Y0,Y1", meant]);
    refusals.expect(&typed("16.347,48.206,16.359,48.212"), &["degrees, longitude first", "--area 600078."]);
    refusals.expect(&typed("48.206,16.347,48.212,16.359"), &["degrees, latitude first", "--area 600078."]);
    let local = plan.replace("dem.asc", "local.asc").replace("swapped.json", "600100,5340100,600900,5340600");
    folder.write("local.asc", include_str!("../../examples/plan/dem.asc"));
    let mut refuse = |arguments: &str, names: &[&str]| refusals.expect(arguments, names);
    refuse(&format!("{local} --origin 144.9,-37.8"), &["--origin -37.8,144.9"]);
    refusals.done();
}

#[test]
fn overlaps_as_shares_and_fields_of_view_in_radians() {
    let folder = Folder::with_scene("mistakes-plan");
    folder.write("dem.asc", include_str!("../../examples/plan/dem.asc"));
    let plan =
        "plan --dem dem.asc --area 600100,5340100,600900,5340600 --camera camera.toml --gsd-m 1.2 --out out --overlap";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{plan} 0.7/0.4"), &["percent", "write 70/40"]);
    refusals.expect(&format!("{plan} 70/0.4"), &["percent", "write 70/40"]);
    refusals.expect(&format!("{plan} 0.7/0"), &["percent", "write 70/0"]);
    refusals.expect(&format!("{plan} 70/40 --tilt-deg 30"), &["--tilt-deg 30", "30.0 degrees along"]);
    refusals.done();
    assert_eq!(folder.run(&format!("{plan} 70/40")).done().stderr.matches("is that meant").count(), 0);
    let high = folder.run(&format!("{} 70/40", plan.replace("1.2", "15"))).stderr;
    assert!(
        high.contains("above the base plane: is that meant?") && high.contains("15.0000 m on the ground"),
        "{high}"
    );
    // Pixels of 2 and of 4 mm, of 9 and of 11 m.
    folder.write("flat.asc", crate::elevation::grid(|_, _| 100.0));
    let pixel = |gsd: &str| {
        let area = if gsd.starts_with('0') { "0,0,2,2" } else { "0,0,400,300" };
        let run = folder.run(&format!(
            "plan --dem flat.asc --area {area} --camera camera.toml --gsd-m {gsd} --overlap 60/30 --speed-m-s 1 --force --out out"
        ));
        assert_eq!(run.code, Some(0), "{run:?}");
        run.stderr
            .contains(&format!("a pixel is {gsd}0 m on the ground: is that meant? --gsd-m and --height-m are metres"))
    };
    assert_eq!(["0.002", "0.004", "9.000", "11.000"].map(pixel), [true, false, false, true]);
    // 60 degrees in radians.
    let camera = folder.text("camera.toml").replace("60.0", "1.0472");
    folder.write("camera.toml", camera);
    let mut refusals = Refusals::new(&folder);
    for arguments in [format!("{plan} 70/40"), format!("{MAP} -- 1,2")] {
        refusals.expect(&arguments, &["camera.toml", "as radians they are usual: write fov_h_deg = 60.0001"]);
    }
    let fly = "fly --frames 1 --set camera.fov_h_deg=1.0472 --set camera.fov_v_deg=1.0472 --out out";
    refusals.expect(fly, &["camera.fov_h_deg = 1.0472", "write 60.0001 and 60.0001"]);
    refusals.done();
}

/// Observations whose image coordinates are turned somehow.
fn turned(observations: &str, turn: fn(f64, f64) -> (f64, f64)) -> String {
    let mut text = "station,head,point,x_px,y_px\n".to_owned();
    for line in observations.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |k: usize| fields[k].parse::<f64>().expect("a number");
        let (x, y) = turn(number(3), number(4));
        text += &format!("{},{},{},{x},{y}\n", fields[0], fields[1], fields[2]);
    }
    text
}

#[test]
fn a_blocks_units_and_a_turned_frame() {
    let folder = Folder::new("mistakes-units");
    let block = include_str!("../../examples/calibrate/block.json");
    let observations = include_str!("../../examples/calibrate/observations.csv");
    folder.write("block.json", block);
    let mut refusals = Refusals::new(&folder);
    folder.write("obs.csv", turned(observations, |x, y| (-x, -y)));
    refusals.expect(CALIBRATE, &["the frame is turned by 180 degrees: write -x_px and -y_px"]);
    folder.write("obs.csv", turned(observations, |x, y| (0.0068 * x, 0.0068 * y)));
    refusals.expect(CALIBRATE, &["they are millimetres: write x_px / pixel_mm"]);
    folder.write("obs.csv", observations);
    folder.write("block.json", block.replace("6911.764705882353", "47.0"));
    refusals.expect(CALIBRATE, &["off the axis of a head whose f_px is 47", "were it millimetres, f_px would be 6912"]);
    folder.write("block.json", block.replace("6911.764705882353", "0.047"));
    refusals.expect(CALIBRATE, &["a head whose f_px is 0.047", "were it metres, f_px would be 6912"]);
    folder.write("block.json", block.replace("\"pixel_mm\": 0.0068", "\"pixel_mm\": 6.8"));
    refusals.expect(CALIBRATE, &["block.json: pixel_mm is 6.8, not 0.0001 to 0.2 mm", "write pixel_mm = 0.0068"]);
    // Neither unit makes a focal length of it that fits.
    for f_px in ["5", "0.9"] {
        folder.write("block.json", block.replace("6911.764705882353", f_px));
        refusals.expect(CALIBRATE, &["it is the focal length in pixels\n"]);
    }
    folder.write("block.json", block.replacen("-0.3839724354387525", "-22.0", 1));
    refusals.expect(CALIBRATE, &["head_start_rad[0] has -22", "multiply the angles by 0.0174532"]);
    refusals.done();
}

#[test]
fn unknown_keys_of_a_block_and_opencvs_axes() {
    let folder = Folder::new("mistakes-block");
    let block = include_str!("../../examples/calibrate/block.json");
    let observations = include_str!("../../examples/calibrate/observations.csv");
    folder.write("block.json", block);
    let mut refusals = Refusals::new(&folder);
    folder.write("obs.csv", turned(observations, |x, y| (x, -y)));
    refusals.expect(CALIBRATE, &["y_px counts downward, as OpenCV has it", "write -y_px"]);
    folder.write("obs.csv", turned(observations, |x, y| (y, x)));
    refusals.expect(CALIBRATE, &["x_px and y_px are swapped"]);
    // From the corner of a frame of 7230 x 5430 pixels, y down or up, whether the block says how large it is or not.
    folder.write("obs.csv", turned(observations, |x, y| (x + 3614.5, y + 2714.5)));
    refusals.expect(CALIBRATE, &["bottom left corner", "y_px - (rows - 1) / 2"]);
    folder.write("obs.csv", turned(observations, |x, y| (x + 3614.5, 2714.5 - y)));
    refusals.expect(CALIBRATE, &["top left corner", "(rows - 1) / 2 - y_px"]);
    let mut sized: Value = serde_json::from_str(block).expect("JSON");
    (sized["cols"], sized["rows"]) = (7230.into(), 5430.into());
    folder.write("block.json", sized.to_string());
    folder.write("obs.csv", turned(observations, |x, y| (x + 3614.5, 2714.5 - y)));
    refusals.expect(CALIBRATE, &["top left corner", "(rows - 1) / 2 - y_px"]);
    folder.write("obs.csv", observations);
    let mut other = sized.clone();
    (other["cols"], other["rows"]) = (100.into(), 100.into());
    folder.write("block.json", other.to_string());
    refusals.expect(CALIBRATE, &["obs.csv, line 2", "far outside a frame of 100 x 100"]);
    let keys = [
        ("weights", "sigma_px"),
        ("f_mm", "f_px"),
        ("fixed_point", "fixed_points"),
        ("sigma_pix", "sigma_px"),
        ("colour", "known are"),
    ];
    for (key, meant) in keys {
        let mut other = sized.clone();
        other[key] = serde_json::json!([1.0]);
        folder.write("block.json", other.to_string());
        refusals.expect(CALIBRATE, &[&format!("the key {key} means nothing"), meant]);
    }
    let mut other = sized.clone();
    for key in ["f_px", "heads_d_m"] {
        other.as_object_mut().expect("keys").remove(key);
    }
    folder.write("block.json", other.to_string());
    refusals.expect(CALIBRATE, &["the keys f_px, heads_d_m are missing"]);
    refusals.done();
    // The answer that a generated block knows is passed over without a word.
    folder.write("block.json", sized.to_string());
    assert!(!folder.run(CALIBRATE).done().stderr.contains("truth_heads_rad"));
}

#[test]
fn an_angle_counted_over_its_end_and_samples_that_do_not_tell_their_noise() {
    let folder = Folder::new("mistakes-smooth");
    folder.write("log.csv", include_str!("../../examples/attitude.csv"));
    let smooth = "smooth --in log.csv --time t_s --columns yaw_deg --out fit.csv";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(smooth, &["column yaw_deg", "line ", "jumps by -3", "name it under --angles"]);
    let around: String = (0..40)
        .map(|i| format!("{i},{}\n", (f64::from(i * i) * 0.003 + 3.0) % std::f64::consts::TAU - std::f64::consts::PI))
        .collect();
    folder.write("radians.csv", format!("t_s,yaw\n{around}"));
    let radians = "smooth --in radians.csv --time t_s --columns yaw --out fit.csv";
    refusals.expect(radians, &["column yaw", "jumps by -6", "pi or 2 pi radians", "name it under --angles"]);
    folder.run(&format!("{radians} --angles yaw")).done();
    refusals.done();
    folder.run(&format!("{smooth} --angles yaw_deg")).done();
    // Free of noise: GCV takes its least alpha, at which residuals are those of the smoothing and not of a sensor.
    let rows: String = (0..200).map(|i| format!("{},{}\n", f64::from(i) * 0.1, (f64::from(i) * 1.3).sin())).collect();
    folder.write("clean.csv", format!("t_s,a\n{rows}"));
    let run = folder.run("smooth --in clean.csv --time t_s --columns a --out fit.csv --json").done();
    assert!(
        run.stderr.contains("column a: GCV ends at its least alpha") && run.stderr.contains("a_sigma is left"),
        "{run:?}"
    );
    let json: Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert!(json["a"]["sigma0"].is_null() && json["a"]["alpha_at_bound"] == true, "{json}");
    assert!(folder.text("fit.csv").lines().skip(1).all(|row| row.ends_with(',')));
    // With noise there are sigmas.
    let noisy = folder.run(&format!("{smooth} --angles yaw_deg --json")).json();
    assert!(noisy["yaw_deg"]["sigma0"].as_f64() > Some(0.0), "{noisy}");
}

/// Lists, areas and places written as other programs write them.
#[test]
fn other_separators_formats_and_units() {
    let folder = Folder::with_ground("mistakes-forms");
    folder.write("log.csv", "t_s,roll_deg,pitch_deg,yaw_deg\n0,1e300,0,0\n1,0,0,0\n");
    folder.write("area.kml", "<kml/>");
    folder.write("x16.toml", b"\xFF\xFEc\0");
    crate::pictures::grey_8_png(&folder.path("frame.png"), &texture((96, 96), (0.0, 0.0)));
    folder.write("camera.toml", crate::folder::CAMERA);
    let tiles = "tiles --ortho ground.tif --resolution-m 10 --out t.bin --area";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{tiles} 1;2;3;4"), &["if it is X0,Y0,X1,Y1, type --area 1,2,3,4"]);
    refusals.expect(&format!("{tiles} area.kml"), &["ogr2ogr -t_srs EPSG:4326 area.geojson area.kml"]);
    refusals.expect(
        &format!("{tiles} 5329500,500300,5329700,500500"),
        &["if its numbers are y before x", "type --area 500300,5329500,500500,5329700"],
    );
    refusals
        .expect("fly --scenario x16.toml --frames 1", &["x16.toml: it is text in UTF-16", "iconv -f UTF-16 -t UTF-8"]);
    refusals.expect("fly --frames 1 --replay log.csv", &["log.csv, line 2: roll_deg", "no angle in degrees"]);
    folder.write("returns.csv", "t_s,roll_deg,pitch_deg,yaw_deg\r0,1,0,0\r1,0,0,0\r");
    folder.write("plan.json", "{\n \"version\": 1\n}\n");
    let smooth = "smooth --time t_s --columns roll_deg --out fit.csv --in";
    for verb in ["fly --frames 1 --replay", smooth] {
        let line = "lines end with carriage returns alone: tr '\\r' '\\n' < returns.csv > returns.lines.csv";
        refusals.expect(&format!("{verb} returns.csv"), &[line]);
        refusals.expect(&format!("{verb} plan.json"), &["plan.json: it is no table (CSV), as it begins with {"]);
    }
    refusals.expect("fly --frames 1e3", &["--frames", "not a whole number"]);
    refusals.expect("fly --frames 1 --set range.sigma_m=1e300", &["range.sigma_m = 1e300 is not between"]);
    refusals.expect(&format!("{MAP} -- 1e300,0"), &["1000000 pixels"]);
    refusals.expect(&format!("{RECTIFY} --pitch-deg 1e300"), &["--pitch-deg 1e300: not between -360 and 360"]);
    let place = format!("{RECTIFY} --pitch-deg 0 --epsg 32633").replace("p.png", "p.tif");
    refusals.expect(&format!("{place} --east-m 16.4 --north-m 48.2"), &["look like degrees", "gdaltransform"]);
    refusals.expect(
        &format!("{place} --east-m 5330000 --north-m 500300"),
        &["far outside of EPSG:32633", "type --east-m 500300 --north-m 5330000"],
    );
    refusals.expect(&format!("{RECTIFY} --pitch-deg 0 --cols 0 --rows 9"), &["--cols", "from 1 to 4096"]);
    refusals.done();
    folder.run(&format!("{place} --east-m 500300 --north-m 5330000")).done();
    folder.run("camera new --fov 60×46.8 --size 640×480").done();
}
