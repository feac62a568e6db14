//! `plumbline tiles`, `mission`, `fly --log` and `replay`: what is made, what of it is told, and what is refused.

use crate::folder::{CAMERA, FLY, Folder};
use crate::refusals::Refusals;
use plumbline_firmware::boot;
use plumbline_firmware::stores::tiles::BEFORE_PIXELS;
use plumbline_firmware::stores::{configuration, key, tiles};
use plumbline_tests::vectors::number;

const TILES: &str = "tiles --ortho ground.tif --resolution-m 10 --out tiles.bin --json";

#[test]
fn a_tile_of_an_orthophoto_says_what_it_is() {
    let folder = Folder::with_ground("tiles");
    let told = folder.run(TILES).json();
    let store = folder.read("tiles.bin");
    let tile = tiles::read(&store).expect("a tile");
    // 256 pixels of 5 m: known between the outermost centres, 1275 m.
    assert_eq!(tile.size(), (127, 127));
    assert_eq!((number(&told, "cols"), number(&told, "rows")), (127.0, 127.0));
    assert_eq!(number(&told, "bytes"), (BEFORE_PIXELS + 127 * 127) as f64);
    assert_eq!(store.len(), BEFORE_PIXELS + 127 * 127);
    assert_eq!(number(&told, "epsg"), 32633.0);
    let g = tile.georeference();
    assert!((number(&told, "centre_lat") * 1e7 - f64::from(g.centre.lat_e7)).abs() < 0.5);
    assert!((number(&told, "convergence_deg") - f64::from(g.convergence.to_degrees())).abs() < 1e-6);
    // A UTM grid's metres, turned to ground metres; the board's flash is six sectors less the head, all of
    // which the bootloader writes.
    let cell = (10.0 / number(&told, "point_scale")).powi(2) * 1e-6;
    assert!((number(&told, "km2") - 127.0 * 127.0 * cell).abs() < 1e-9);
    assert!((number(&told, "km2_max") - (786_432.0 - 128.0) * cell).abs() < 1e-9);
    assert!((number(&told, "km2_max_dfu") - (786_432.0 - 128.0) * cell).abs() < 1e-9);
    assert_eq!(number(&told, "unknown_cells"), 0.0);
    // A part of it, by its corners and by GeoJSON with the same corners.
    let [lat, lon] = [g.centre.lat_e7, g.centre.lon_e7].map(|e7| f64::from(e7) * 1e-7);
    let ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let ring = ring.map(|[x, y]| format!("[{}, {}]", lon + 0.003 * x, lat + 0.002 * y)).join(",");
    folder.write("area.geojson", format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}]}}"#
    ));
    let part = folder.run(&format!("{TILES} --area area.geojson")).json();
    // 0.006 degrees of longitude and 0.004 of latitude there, and the turn of the grid.
    let across = 0.006 * 111_320.0 * lat.to_radians().cos() / 10.0;
    assert!((number(&part, "cols") - across).abs() < 3.0, "{part} against {across}");
    assert!((number(&part, "rows") - 0.004 * 111_200.0 / 10.0).abs() < 3.0, "{part}");
}

#[test]
fn a_configuration_is_its_camera_and_its_settings() {
    let folder = Folder::new("configuration");
    folder.write("camera.toml", CAMERA);
    folder.write("settings.toml", "search_px = 8\nsend_patches = false\n[mount]\nlever_arm_m = [1.0, 0.5, -0.25]\n");
    let told = folder.run("mission --camera camera.toml --settings settings.toml --out mission.bin --json").json();
    let configuration = configuration::read(&folder.read("mission.bin")).expect("a configuration");
    assert_eq!((configuration.frame, configuration.search_px, configuration.send_patches), ((96, 96), 8, false));
    assert_eq!((configuration.lever_arm_m, number(&told, "search_px")), ([1.0, 0.5, -0.25], 8.0));
    folder.run("mission --camera camera.toml --out plain.bin").done();
    let plain = configuration::read(&folder.read("plain.bin")).expect("a configuration");
    assert_eq!((plain.search_px, plain.send_patches, plain.lever_arm_m), (10, true, [0.0; 3]));
    assert_eq!(plain.sigmas, configuration.sigmas);
}

#[test]
fn what_is_made_boots() {
    let folder = Folder::with_ground("boots");
    folder.write("camera.toml", CAMERA);
    folder.run(TILES).done();
    folder.run("mission --camera camera.toml --out mission.bin").done();
    assert!(boot::read(&folder.read("mission.bin"), &folder.read("tiles.bin"), &[]).is_ok());
}

/// What the store of a key says, and that nothing of the key is told.
#[test]
fn a_key_becomes_a_store_and_is_not_told() {
    let folder = Folder::with_ground("key");
    let digits = "C0ffee000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c";
    folder.write("key.txt", format!("{digits}\n"));
    let told = folder.run("configuration --signing-key key.txt --out key.bin --json").done();
    assert!(!told.stdout.to_lowercase().contains("c0ffee") && !told.stderr.to_lowercase().contains("c0ffee"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::metadata(folder.path("key.bin")).expect("written").permissions().mode();
        assert_eq!(mode & 0o077, 0, "others read it: {mode:o}");
    }
    let stored = key::read(&folder.read("key.bin")).expect("a good store").expect("a key");
    assert_eq!((&stored.key.0[..4], stored.key.0[31]), (&[0xc0, 0xff, 0xee, 0][..], 0x1c));
    // Made after 2026 and before 2100.
    assert!((34_715_520_000_000..268_000_000_000_000).contains(&stored.first), "{}", stored.first);
    let short = "c0ffee000102030405060708090a0b0c0d0e0f101112131415161718191a1b";
    for (name, text) in [("short", short.to_owned()), ("long", format!("{digits}00")), ("word", "key".repeat(21) + "e")]
    {
        folder.write(&format!("{name}.txt"), &text);
    }
    folder.write("zeros.txt", "0".repeat(64));
    let mut refused = Refusals::new(&folder);
    for name in ["short", "long", "word"] {
        refused.expect(
            &format!("configuration --signing-key {name}.txt --out k.bin"),
            &[&format!("{name}.txt"), "64 hexadecimal digits"],
        );
    }
    refused.expect("configuration --signing-key zeros.txt --out k.bin", &["zeros.txt", "zeros"]);
    refused.expect("configuration --signing-key none.txt --out k.bin", &["none.txt"]);
    refused.expect("configuration --signing-key key.txt --out key.txt", &["key.txt"]);
    folder.write("flight.toml", "[link]\nsigning_key_path = \"none.txt\"\n");
    refused.expect("fly --scenario flight.toml --frames 2", &["none.txt"]);
    refused.done();
}

#[test]
fn a_flight_replays_to_its_own_fixes() {
    let folder = Folder::with_ground("replay");
    folder.run(&format!("{FLY} --frames 6 --out flight --log flight.log")).done();
    let told = folder.run("replay flight.log --out again --json").json();
    assert_eq!(folder.read("flight/fixes.csv"), folder.read("again/fixes.csv"));
    assert_eq!((number(&told, "frames"), number(&told, "same"), number(&told, "different")), (6.0, 6.0, 0.0));
    assert_eq!((told["end"].as_str(), told["first_difference"].is_null()), (Some("closed"), true));
    // Cut before it holds the tile: the tile has to be given, and it must be the flight's.
    let log = folder.read("flight.log");
    folder.write("cut.log", &log[..log.len() / 2]);
    assert_eq!(folder.run("replay cut.log --json").json()["end"].as_str(), Some("cut"));
    // Another tile in flash gives another flight: exit 1 and what differs.
    let mut other = log.clone();
    other.truncate(512);
    folder.write("start.log", &other);
    folder.run(TILES).done();
    let mut refused = Refusals::new(&folder);
    refused.expect("replay start.log", &["start.log", "--tiles"]);
    refused.expect("replay start.log --tiles tiles.bin", &["start.log", "not the one"]);
    refused.expect("replay ground.tif", &["ground.tif", "no log"]);
    refused.expect("replay none.log", &["none.log"]);
    refused.expect("replay flight.log --number 1", &["flight.log", "1 logs"]);
    refused.expect("replay flight.log --out ground.tif", &["ground.tif"]);
    refused.expect(&format!("{FLY} --frames 2 --log none/flight.log"), &["none"]);
    refused.expect(&format!("{FLY} --frames 2 --link qemu --log other.log"), &["--log"]);
    refused.done();
}

#[test]
fn what_makes_no_store_is_refused() {
    let folder = Folder::with_ground("no-store");
    folder.write("camera.toml", CAMERA);
    folder.write("wide.toml", "[attitude]\nwhite_deg = 100.0\n");
    folder.write("world.toml", "[reference]\ngamma = 1.0\n");
    folder.write("slip.toml", "send_patches = true\n[attitude]\nwhite_degree = 1.0\n");
    folder.write("many.toml", "send_patches = false\nsearch_px = \"many\"\n");
    folder.write("latency.toml", "[attitude]\nlatency_us = 1\n");
    folder.write("point.geojson", r#"{"type":"Point","coordinates":[15.0, 40.0]}"#);
    folder.write("metres.geojson", r#"{"type":"Polygon","coordinates":[[[5e5,5e6],[6e5,5e6],[6e5,6e6],[5e5,5e6]]]}"#);
    let mut refused = Refusals::new(&folder);
    refused.expect("tiles --ortho ground.tif --resolution-m 0.5 --out tiles.bin", &["ground.tif", "km2"]);
    refused.expect("tiles --ortho ground.tif --resolution-m 5000 --out tiles.bin", &["ground.tif", "5000"]);
    refused.expect("tiles --ortho none.tif --resolution-m 5 --out tiles.bin", &["none.tif"]);
    refused.expect("tiles --ortho ground.tif --resolution-m 5 --out none/tiles.bin", &["none"]);
    refused.expect(&format!("{TILES} --area 0,0,10,10"), &["ground.tif", "beyond"]);
    refused.expect(&format!("{TILES} --area 1,2,3"), &["1,2,3"]);
    refused.expect(&format!("{TILES} --area 1,2,1,5"), &["1,2,1,5", "extent"]);
    refused.expect(&format!("{TILES} --area point.geojson"), &["point.geojson", "polygon"]);
    refused.expect(&format!("{TILES} --area metres.geojson"), &["metres.geojson", "longitude"]);
    refused.expect("mission --camera none.toml --out mission.bin", &["none.toml"]);
    let options = "mission --camera camera.toml --out mission.bin --settings";
    refused.expect(&format!("{options} wide.toml"), &["attitude.white_deg"]);
    refused.expect(&format!("{options} world.toml"), &["world.toml, line 1", "reference"]);
    refused.expect(&format!("{options} latency.toml"), &["latency.toml, line 2", "attitude.latency_us"]);
    refused.expect(&format!("{options} slip.toml"), &["slip.toml, line 3", "attitude.white_degree"]);
    refused.expect(&format!("{options} many.toml"), &["many.toml, line 2", "search_px"]);
    refused.expect(&format!("{options} none.toml"), &["none.toml"]);
    folder.write("empty.toml", "\n");
    refused.expect(&format!("{options} empty.toml"), &["cannot read empty.toml: it is empty"]);
    refused.done();
}

/// What is no store, and what of a store is refused, each with what makes a right one.
#[test]
fn a_companion_says_which_file_is_no_store() {
    let folder = Folder::with_ground("companion");
    folder.write("camera.toml", CAMERA);
    folder.write("key.txt", "c0ffee000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c\n");
    folder.run(TILES).done();
    folder.run("configuration --camera camera.toml --out configuration.bin").done();
    folder.run("tiles --ortho ground.tif --resolution-m 40 --out small.bin").done();
    let mut damaged = folder.read("tiles.bin");
    *damaged.last_mut().expect("pixels") ^= 1;
    folder.write("damaged.bin", damaged);
    let serve = |configuration: &str, tiles: &str, key: &str| {
        format!("serve --mavlink tcp:127.0.0.1:1 --configuration {configuration} --tiles {tiles}{key}")
    };
    let mut refusals = Refusals::new(&folder);
    for file in ["camera.toml", "tiles.bin"] {
        let no_store = format!("--configuration {file} is no configuration store");
        refusals.expect(
            &serve(file, "tiles.bin", ""),
            &[&no_store, "plumbline configuration --camera CAMERA --out FILE writes a right one"],
        );
    }
    let writer = "plumbline tiles --ortho ORTHO --resolution-m M --out FILE writes a right one";
    for (file, why) in [
        ("ground.tif", "--tiles ground.tif is no tile store"),
        ("damaged.bin", "--tiles damaged.bin is a tile store that the firmware refuses: content damaged"),
        ("small.bin", "--tiles small.bin is a tile store that the firmware refuses: smaller than the search"),
    ] {
        refusals.expect(&serve("configuration.bin", file, ""), &[why, writer]);
    }
    refusals.expect(
        &serve("configuration.bin", "tiles.bin", " --key key.txt"),
        &["--key key.txt is no key store", "plumbline configuration --signing-key KEY --out FILE"],
    );
    refusals.done();
}
