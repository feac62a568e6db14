//! An output that is an input, or that two options name: refused before anything is written, also through links, detours
//! and where nothing is there yet.

use crate::bad_options::RECTIFY;
use crate::folder::{FLY, Folder, with};
use crate::refusals::Refusals;
use std::os::unix::fs::symlink;

#[test]
fn rectify() {
    let folder = Folder::with_scene("same-rectify");
    symlink(folder.path("frame.png"), folder.path("linked.png")).expect("linked");
    std::fs::hard_link(folder.path("frame.png"), folder.path("second.png")).expect("linked");
    let mut refusals = Refusals::new(&folder);
    for out in ["frame.png", "./frame.png", "linked.png", "second.png"] {
        refusals.expect(&with(RECTIFY, "--out", out), &["--out and --frame are the same file", out]);
    }
    refusals.expect(&format!("{RECTIFY} --mask ./out.png"), &["--mask and --out are the same file"]);
    refusals.expect(&format!("{RECTIFY} --mask frame.png"), &["--mask and --frame are the same file"]);
    refusals.done();
}

#[test]
fn configuration() {
    let folder = Folder::with_scene("same-configuration");
    folder.write("settings.toml", "search_px = 8\n");
    let mut refusals = Refusals::new(&folder);
    for verb in ["configuration", "mission"] {
        let call = format!("{verb} --camera camera.toml --settings settings.toml");
        refusals.expect(&format!("{call} --out ./camera.toml"), &["--out and --camera are the same file"]);
        refusals.expect(&format!("{call} --out settings.toml"), &["--out and --settings are the same file"]);
    }
    refusals.done();
}

#[test]
fn tiles_smooth_and_flights() {
    let folder = Folder::with_ground("same-others");
    folder.write("log.csv", "t_s,a\n0,1\n1,2\n2,3\n3,5\n");
    folder.make("flown");
    folder.write("flown/fixes.csv", "old");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("tiles --ortho ground.tif --resolution-m 5 --out ground.tif", &["--out and --ortho"]);
    folder.write("flown/plan.geojson", "{}");
    let height = "--camera log.csv --height-m 300 --overlap 60/30";
    refusals.expect(
        &format!("plan --dem ground.tif --area flown/plan.geojson {height} --out flown"),
        &["--out and --area", "plan.geojson"],
    );
    let smooth = "smooth --in log.csv --time t_s --columns a";
    refusals.expect(&format!("{smooth} --out log.csv"), &["--out and --in"]);
    refusals.expect(&format!("{smooth} --out new.svg --plot ./new.svg"), &["--plot and --out"]);
    let fly = format!("{FLY} --frames 1");
    refusals.expect(&format!("{fly} --out new --log new/fixes.csv"), &["--log and --out", "new/fixes.csv"]);
    refusals.expect(&format!("{fly} --log ground.tif"), &["--log and --ground"]);
    refusals.expect(&format!("{fly} --replay flown/fixes.csv --out flown"), &["--out and --replay"]);
    refusals.expect("replay flown/fixes.csv --out flown", &["--out and the log"]);
    refusals.done();
}

/// What a name promises is what is written.
#[test]
fn names_of_another_format() {
    let folder = Folder::with_scene("same-format");
    folder.write("log.csv", "t_s,a\n0,1\n1,2\n2,3\n3,5\n");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&with(RECTIFY, "--out", "out.jpg"), &["--out out.jpg", ".png"]);
    refusals.expect(&format!("{RECTIFY} --mask mask.tif"), &["--mask mask.tif", ".png"]);
    let smooth = "smooth --in log.csv --time t_s --columns a --out fit.csv";
    refusals.expect(&format!("{smooth} --plot fit.png"), &["--plot fit.png", ".svg"]);
    refusals.done();
}

/// Refused before the work, and nothing is left behind.
#[test]
fn folders_that_could_not_be_written() {
    let folder = Folder::new("same-folders");
    folder.write("flight.log", "no log");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("replay flight.log --out missing/again", &["--out missing/again", "missing does not exist"]);
    refusals.done();
}
