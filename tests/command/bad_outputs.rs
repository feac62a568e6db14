//! Places where nothing can be written. Whatever is refused leaves nothing behind, not even its better half.

use crate::bad_options::RECTIFY;
use crate::folder::{FLY, Folder, with};
use crate::refusals::Refusals;
use std::fs;

/// A scene with a folder, and a file that is write-protected.
fn scene(name: &str) -> Folder {
    let folder = Folder::with_scene(name);
    folder.make("folder");
    folder.write("locked.png", "old");
    let mut permissions = fs::metadata(folder.path("locked.png")).expect("there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(folder.path("locked.png"), permissions).expect("locked");
    folder
}

const PLACES: [&str; 4] = ["none/out.png", "folder", "camera.toml/out.png", "locked.png"];

#[test]
fn rectify_out() {
    let folder = scene("rectify-out");
    let mut refusals = Refusals::new(&folder);
    for place in PLACES {
        refusals.expect(&with(RECTIFY, "--out", place), &[place]);
        refusals.expect(&format!("{} --mask mask.png", with(RECTIFY, "--out", place)), &[place]);
    }
    refusals.done();
}

#[test]
fn rectify_mask() {
    let folder = scene("rectify-mask");
    let mut refusals = Refusals::new(&folder);
    for place in PLACES {
        refusals.expect(&format!("{RECTIFY} --mask {place}"), &[place]);
    }
    refusals.done();
}

/// One file cannot hold both.
#[test]
fn rectify_mask_and_out_are_two_files() {
    let folder = scene("rectify-both");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{RECTIFY} --mask out.png"), &["--mask", "--out"]);
    refusals.done();
}

#[test]
fn fly_out() {
    let folder = scene("fly-out");
    let mut refusals = Refusals::new(&folder);
    for place in ["none/out", "camera.toml", "camera.toml/out"] {
        refusals.expect(&format!("fly --frames 1 --out {place}"), &["--out", place]);
    }
    refusals.expect("fly --frames 1 --dump 1", &["--dump", "--out"]);
    refusals.done();
}

/// A folder stands where a file should go. Then none of the flight's files may appear.
#[test]
fn fly_out_with_a_folder_in_the_way() {
    let folder = Folder::with_ground("fly-in-the-way");
    let mut refusals = Refusals::new(&folder);
    for file in ["fixes.csv", "poses.csv", "report.json", "report.html", "fixes.geojson", "track.kml", "tile.tif"] {
        fs::create_dir_all(folder.path(&format!("{file}.out/{file}"))).expect("made");
        refusals.expect(&format!("{FLY} --frames 1 --out {file}.out"), &[file]);
    }
    refusals.done();
}

/// A folder of the system's that is there and takes no files: bad input like any other place.
#[cfg(target_os = "linux")]
#[test]
fn under_proc() {
    let folder = scene("under-proc");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&with(RECTIFY, "--out", "/proc/out.png"), &["cannot write /proc/out.png", "takes no files"]);
    refusals.expect("camera new --fov 60x46.8 --size 640x480 --out /proc/camera.toml", &["/proc/camera.toml"]);
    refusals.expect("fly --frames 1 --out /proc", &["/proc/fixes.csv"]);
    refusals.expect("fly --frames 1 --out /proc/out", &["/proc/out"]);
    refusals.done();
}

/// Before the work: each verb's inputs are there, but nonsense, which would be said otherwise.
#[cfg(target_os = "linux")]
#[test]
fn before_anything_is_read() {
    let folder = Folder::new("outputs-first");
    for name in ["a.toml", "a.csv", "a.json", "a.png", "a.tif", "a.log"] {
        folder.write(name, "nonsense");
    }
    // Which files are read stands in a table, which is read first.
    let rows: String = ["a.png", "a.tif", "a.log"].map(|name| format!("{name},0,0,100,0,0,0\n")).concat();
    let frames = format!("file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n{rows}");
    folder.write("frames.csv", frames);
    let angles = "--heading-deg 0 --pitch-deg 0 --roll-deg 0";
    let place = "/proc/made";
    let mut refusals = Refusals::new(&folder);
    for verb in [
        &format!("rectify --camera a.toml --frame a.png {angles} --height-m 100 --resolution-m 1 --out {place}.png"),
        &format!(
            "rectify --camera a.toml --frame a.png {angles} --height-m 100 --resolution-m 1 --out b.png --mask {place}.png"
        ),
        &format!("smooth --in a.csv --time t_s --columns a --out {place}"),
        &format!("smooth --in a.csv --time t_s --columns a --out b.csv --plot {place}.svg"),
        &format!("boresight --camera a.toml --fixes a.csv --poses a.csv --out {place}"),
        &format!("boresight --camera a.toml --fixes a.csv --poses a.csv --out b.toml --report {place}"),
        &format!("calibrate --block a.json --observations a.csv --out {place}"),
        &format!("calibrate --block a.json --observations a.csv --out b.toml --report {place}"),
        &format!("stitch --camera a.toml --frames a.png --out {place}.png"),
        &format!("configuration --camera a.toml --out {place}"),
        &format!("configuration --plan a.json --out {place}"),
        &format!("tiles --ortho a.tif --resolution-m 1 --out {place}"),
        &format!("plan --dem a.tif --area 0,0,1,1 --camera a.toml --height-m 300 --overlap 60/30 --out {place}"),
        &format!("evaluate --frames frames.csv --camera a.toml --reference a.tif --out {place}"),
        &format!("fly --scenario a.toml --out {place}"),
        &format!("fly --scenario a.toml --log {place}"),
        &format!("fly --scenario a.toml --export {place}.mcap"),
        &format!("replay a.log --out {place}"),
        &format!("camera new --from-opencv a.json --out {place}"),
        &format!("reproduce 003 --out {place}"),
    ] {
        refusals.expect(verb, &["cannot write /proc/made", "takes no files"]);
    }
    refusals.done();
}
