//! What somebody meets first: the command without a verb, completions, a camera file.

use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_survey::camera_file::CameraFile;

fn camera(folder: &Folder, arguments: &str) -> CameraFile {
    let run = folder.run(&format!("camera new {arguments} --out made.toml --overwrite")).done();
    assert!(run.stdout.is_empty(), "{}", run.stdout);
    CameraFile::read(&folder.path("made.toml")).expect("a camera file")
}

#[test]
fn without_a_verb_it_says_what_there_is() {
    let folder = Folder::new("beginning-alone");
    let run = folder.run("");
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""));
    for verb in ["fly", "evaluate", "plan", "camera", "completions"] {
        assert!(run.stderr.lines().any(|line| line.trim_start().starts_with(verb)), "{verb}: {}", run.stderr);
    }
    // A misspelt one is told with what was likely meant.
    for (typed, meant) in [
        ("evalute", "evaluate"),
        ("plann", "plan"),
        ("calibrat", "calibrate"),
        ("mision", "mission"),
        ("smoth", "smooth"),
        ("fyl", "fly"),
    ] {
        let run = folder.run(typed);
        let quoted = format!("'{meant}'");
        assert!(run.code == Some(2) && run.stderr.contains(&quoted), "{}", run.stderr);
    }
}

/// A plan without its option, and the ground station's mission instead of the plan.
#[test]
fn plans_in_the_wrong_place_are_told() {
    let folder = Folder::new("beginning-plans");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("mission plan.json", &["plan.json", "--plan plan.json"]);
    let files: [(&str, &[u8], &str); 6] = [
        ("p.plan", br#"{"fileType": "Plan", "version": 1}"#, "the mission for a ground station"),
        ("p.kml", b"<?xml version=\"1.0\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"></kml>", "KML"),
        ("p.waypoints", b"QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t48.1\t11.5\t500\t1\n", "a list of waypoints"),
        ("p.geojson", br#"{"type": "FeatureCollection", "features": []}"#, "GeoJSON"),
        ("p.gpkg", b"SQLite format 3\0\xff\xfe", "no text"),
        ("p.csv", b"lat,lon\n48,11\n", "no JSON"),
    ];
    for (name, bytes, form) in files {
        folder.write(name, bytes);
        let names = [name, form, "plan.json, which `plumbline plan` writes, is meant"];
        refusals.expect(&format!("configuration --plan {name} --out c.bin"), &names);
        refusals.expect(&format!("fly --plan {name}"), &names);
    }
    refusals.expect("fly --plan .", &["is meant"]);
    refusals.done();
}

#[test]
fn shells_complete_verbs_and_options() {
    let folder = Folder::new("beginning-completions");
    for shell in ["bash", "zsh", "fish"] {
        let script = folder.run(&format!("completions {shell}")).done().stdout;
        assert!(script.contains("evaluate") && script.contains("require-rate"), "{shell}: {script}");
    }
    let mut refusals = Refusals::new(&folder);
    refusals.expect("completions tcsh", &["tcsh", "bash"]);
    refusals.done();
}

#[test]
fn a_camera_file_is_made_of_what_people_have() {
    let folder = Folder::new("beginning-camera");
    let made = camera(&folder, "--fov 60x46.8 --size 640x480");
    assert_eq!((made.cols, made.rows, made.fov_h_deg, made.fov_v_deg), (640, 480, 60.0, 46.8));
    let near = |camera: CameraFile, fov_deg: f64| assert!((camera.fov_h_deg - fov_deg).abs() < 1e-9, "{camera:?}");
    near(camera(&folder, "--focal-px 320 --size 640x480"), 90.0);
    near(camera(&folder, "--focal-mm 18 --sensor-mm 36 --size 6000x4000"), 90.0);
    near(camera(&folder, "--focal-35mm 18 --size 6000x4000"), 90.0);
    assert_eq!(camera(&folder, "--preset pi-gs-6mm").cols, 1456);
    folder.write(
        "cal.yml",
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   data: [ 320., 0., 319.5, 0., 320., 239.5, 0., 0., 1. ]\n",
    );
    near(camera(&folder, "--from-opencv cal.yml"), 90.0);
    let bare = folder.text("cal.yml").replace("image_width: 640\nimage_height: 480\n", "");
    folder.write("bare.yml", bare);
    near(camera(&folder, "--from-opencv bare.yml --size 640x480"), 90.0);
    let asked = folder.run("camera new --fov 60x60 --size 640x480").done();
    assert!(asked.stderr.contains("--fov 60x60") && asked.stderr.contains("square"), "{}", asked.stderr);
    folder.write(
        "cameras.json",
        r#"{"a": {"projection_type": "perspective", "width": 640, "height": 480, "focal": 0.5}}"#,
    );
    near(camera(&folder, "--from-odm cameras.json"), 90.0);
    // Without --out it goes to standard output, and says what each key is.
    let text = folder.run("camera new --preset paper").done().stdout;
    assert!(text.contains("# full field of view across") && text.contains("# [boresight]"), "{text}");
}

#[test]
fn what_makes_no_camera_is_refused() {
    let folder = Folder::new("beginning-refused");
    folder.write("cal.yml", "image_width: 640\n");
    folder.write("fish.yml", "image_width: 640\nimage_height: 480\ndistortion_model: equidistant\n");
    folder.write(
        "reconstruction.json",
        r#"[{"cameras": {"a": {"width": 640, "height": 480, "focal": 0.5}}, "shots": {}}]"#,
    );
    folder.write("area.geojson", r#"{"type": "FeatureCollection", "features": []}"#);
    folder.write("part.toml", "cols = 10\nrows = 10\nfov_h_deg = 30.0\n");
    let mut refusals = Refusals::new(&folder);
    for (arguments, names) in [
        ("camera new", &["--preset"][..]),
        ("camera new --fov 60x46.8", &["--size"]),
        ("camera new --fov 1.05x0.82 --size 640x480", &["radians", "60.2x47.0"]),
        ("camera new --fov 60 --size 640x480", &["60x46.8"]),
        ("camera new --focal-mm 5 --size 640x480", &["--sensor-mm"]),
        ("camera new --preset pinhole", &["pinhole", "paper"]),
        ("camera new --preset paper --focal-px 10 --size 10x10", &["--focal-px"]),
        ("camera new --preset paper --size 10x10", &["--size", "--preset"]),
        ("camera new --preset paper --name a", &["--name", "--preset"]),
        ("camera new --fov 60x46.8 --size 640x480 --sensor-mm 3.68", &["--fov", "--sensor-mm"]),
        ("camera new --fov 60x46.8 --size 640x480 --name foo", &["--fov", "--name"]),
        ("camera new --focal-px 1 --size 640x480", &["--focal-px 1", "179"]),
        ("camera new --focal-px 1e9 --size 640x480", &["--focal-px 1000000000", "0.3 to 150"]),
        ("camera new --focal-mm 3040 --sensor-mm 3.68 --size 3280x2464", &["--focal-mm 3040", "0.06"]),
        ("camera new --from-opencv cal.yml", &["cal.yml", "image_height", "camera_matrix"]),
        ("camera new --from-opencv fish.yml", &["fish.yml", "distortion_model: equidistant", "--focal-px"]),
        ("camera new --from-odm reconstruction.json", &["reconstruction.json: it is a reconstruction", "cameras.json"]),
        ("camera new --from-odm area.geojson", &["area.geojson: it has no camera", "cameras.json"]),
        ("camera new --from-opencv cal.yml --out cal.yml", &["same file"]),
        // All keys that are missing, at once.
        (
            "map --camera part.toml --heading-deg 0 --pitch-deg 0 --roll-deg 0 -- 0,0",
            &["fov_v_deg, offset_m_px, offset_n_px", "camera new"],
        ),
    ] {
        refusals.expect(arguments, names);
    }
    refusals.done();
}

#[test]
fn a_flight_with_too_few_fixes_fails_where_that_is_asked_for() {
    let folder = Folder::with_ground("beginning-rate");
    let fly = "fly --ground ground.tif --frames 12 --set send_patches=false";
    folder.run(&format!("{fly} --require-rate 20")).done();
    let run = folder.run(&format!("{fly} --fault camera.dark=0.01@0.. --require-rate 20"));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains("--require-rate asks for 20 %") && !run.stdout.is_empty(), "{}", run.stderr);
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{fly} --require-rate 120"), &["--require-rate", "between 0 and 100"]);
    refusals.expect(&format!("{fly} --require-rate 0.95"), &["percent", "write --require-rate 95"]);
    refusals.expect(&format!("{fly} --require-rate 1"), &["write --require-rate 100"]);
    refusals.expect(&format!("{fly} --speed 2"), &["--mavlink"]);
    refusals.expect(&format!("{fly} --mavlink http://localhost"), &["udp:HOST:PORT"]);
    refusals.done();
}

/// What stands in `examples` is what the command takes.
#[test]
fn the_examples_are_sound() {
    let folder = Folder::new("beginning-examples");
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");
    let run = folder.run(&format!("fly --scenario {examples}/scenario.toml --frames 12 --require-rate 80")).done();
    assert!(run.stdout.contains("12 over inproc"), "{}", run.stdout);
    let settings = format!("--camera {examples}/camera.toml --settings {examples}/settings.toml");
    folder.run(&format!("configuration {settings} --out c.bin")).done();
    let made = folder.run("camera new --preset paper").done().stdout;
    let kept = std::fs::read_to_string(format!("{examples}/camera.toml")).expect("an example");
    assert_eq!(kept, made, "examples/camera.toml is what `plumbline camera new --preset paper` writes");
}

#[test]
fn a_camera_file_is_not_lost_to_a_new_one() {
    let folder = Folder::new("beginning-overwrite");
    let new = "camera new --fov 60x46.8 --size 640x480 --out camera.toml";
    folder.run(new).done();
    // Made again, it is the same.
    folder.run(new).done();
    let calibrated = folder.text("camera.toml").replace("60", "60.1");
    folder.write("camera.toml", &calibrated);
    let mut refusals = Refusals::new(&folder);
    refusals.expect(new, &["--out camera.toml: there is another file of that name", "--overwrite"]);
    refusals.expect("camera new --preset paper --overwrite", &["--out"]);
    refusals.done();
    assert_eq!(folder.text("camera.toml"), calibrated);
    folder.run(&format!("{new} --overwrite")).done();
    assert_ne!(folder.text("camera.toml"), calibrated);
}
