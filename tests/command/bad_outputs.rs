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
