//! Options that cannot be meant.

use crate::folder::{Folder, with, without};
use crate::refusals::Refusals;

/// A call that works, with every option that a test replaces.
pub const RECTIFY: &str = "rectify --camera camera.toml --frame frame.png --heading-deg 20 --pitch-deg 5 --roll-deg -3 \
     --height-m 100 --resolution-m 2 --out out.png --json";
pub const MAP: &str = "map --camera camera.toml --heading-deg 20 --pitch-deg 5 --roll-deg -3 -- 10,20";
pub const MATCH: &str = "match --patch patch.png --reference reference.png --search-px 10 --json";

/// No number at all, or none that measures anything.
const NO_NUMBERS: [&str; 4] = ["NaN", "inf", "1e999", "ten"];
/// Not a length.
const NO_LENGTHS: [&str; 3] = ["0", "-1", "-0"];

#[test]
fn the_calls_that_tests_spoil_are_good() {
    let folder = Folder::with_scene("good-calls");
    for arguments in [RECTIFY, MAP, MATCH] {
        folder.run(arguments).done();
    }
}

#[test]
fn angles() {
    let folder = Folder::with_scene("angles");
    let mut refusals = Refusals::new(&folder);
    for option in ["--heading-deg", "--pitch-deg", "--roll-deg"] {
        for value in NO_NUMBERS {
            refusals.expect(&with(RECTIFY, option, value), &[option]);
            refusals.expect(&with(MAP, option, value), &[option]);
        }
        refusals.expect(&without(RECTIFY, option), &[option]);
        refusals.expect(&without(MAP, option), &[option]);
    }
    for value in ["NaN", "inf", "sideways"] {
        refusals.expect(&format!("{RECTIFY} --follow-up-deg {value}"), &["--follow-up-deg"]);
    }
    refusals.done();
}

#[test]
fn a_camera_at_or_beyond_the_horizon() {
    let folder = Folder::with_scene("horizon");
    let mut refusals = Refusals::new(&folder);
    for (option, value) in [("--pitch-deg", "100"), ("--pitch-deg", "-90"), ("--roll-deg", "90"), ("--roll-deg", "180")]
    {
        refusals.expect(&with(RECTIFY, option, value), &[option, value, "horizon"]);
    }
    refusals.done();
}

#[test]
fn heights_ranges_and_resolutions() {
    let folder = Folder::with_scene("lengths");
    let mut refusals = Refusals::new(&folder);
    let by_range = RECTIFY.replace("--height-m", "--range-m");
    for value in NO_NUMBERS.iter().chain(&NO_LENGTHS) {
        refusals.expect(&with(RECTIFY, "--height-m", value), &["--height-m"]);
        refusals.expect(&with(RECTIFY, "--resolution-m", value), &["--resolution-m"]);
        refusals.expect(&with(&by_range, "--range-m", value), &["--range-m"]);
    }
    // What a range finder sends when it sees nothing.
    refusals.expect(&with(&by_range, "--range-m", "65535"), &["--range-m", "65535"]);
    refusals.expect(&format!("{RECTIFY} --range-m 100"), &["--range-m", "--height-m"]);
    refusals.expect(&without(RECTIFY, "--height-m"), &["--height-m"]);
    refusals.done();
}

#[test]
fn lengths_beyond_single_precision_and_patches_beyond_measure() {
    let folder = Folder::with_scene("beyond");
    let mut refusals = Refusals::new(&folder);
    // Nothing is measured beyond 1e9; 4096 pixels are the most.
    for option in ["--height-m", "--resolution-m"] {
        for value in ["1e300", "1e-300"] {
            refusals.expect(&with(RECTIFY, option, value), &[option, value, "not between 1e-9 and 1e9"]);
        }
    }
    for (option, value) in
        [("--height-m", "1e9"), ("--height-m", "1e-3"), ("--resolution-m", "1e-6"), ("--resolution-m", "1e6")]
    {
        refusals.expect(&with(RECTIFY, option, value), &["pixel"]);
    }
    for (cols, rows, name) in
        [("4097", "10", "4097"), ("10", "4097", "4097"), ("0", "10", "from 1 to 4096"), ("10", "-1", "--rows")]
    {
        refusals.expect(&format!("{RECTIFY} --cols {cols} --rows {rows}"), &[name]);
    }
    let all = usize::MAX.to_string();
    refusals.expect(&format!("{RECTIFY} --cols {all} --rows {all}"), &[&all]);
    refusals.expect(&format!("{RECTIFY} --cols 10"), &["--rows"]);
    refusals.done();
}

#[test]
fn points_and_models() {
    let folder = Folder::with_scene("points");
    let oblong = "cols = 96\nrows = 96\nfov_h_deg = 60.0\nfov_v_deg = 45.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n";
    folder.write("oblong.toml", oblong);
    let mut refusals = Refusals::new(&folder);
    for point in ["1", "1,", ",1", "1,2,3", "NaN,1", "1,inf", "a,b"] {
        refusals.expect(&MAP.replace("10,20", point), &[point]);
    }
    refusals.expect("map --camera camera.toml --heading-deg 0 --pitch-deg 0 --roll-deg 0 --", &["M,N"]);
    let simplified = MAP.replace("--camera", "--model simplified --camera");
    refusals.expect(&with(&simplified, "--camera", "oblong.toml"), &["--model simplified", "oblong.toml"]);
    for follow_up in ["none", "3"] {
        let arguments = simplified.replace(" -- ", &format!(" --follow-up-deg {follow_up} -- "));
        refusals.expect(&arguments, &["--model simplified"]);
    }
    refusals.expect(&MAP.replace("--camera", "--model perfect --camera"), &["--model", "perfect"]);
    refusals.done();
}

#[test]
fn search_radii() {
    let folder = Folder::with_scene("search");
    let mut refusals = Refusals::new(&folder);
    for value in ["0", "-1", "257", "65536", "1.5", "NaN"] {
        refusals.expect(&with(MATCH, "--search-px", value), &["--search-px", value]);
    }
    refusals.expect(&without(MATCH, "--search-px"), &["--search-px"]);
    // 34 + 2 * 20 = 74 just fits, one more does not.
    folder.run(&with(MATCH, "--search-px", "20")).done();
    refusals.expect(&with(MATCH, "--search-px", "21"), &["reference.png", "74 x 74", "76 x 76"]);
    refusals.done();
}

#[test]
fn verbs_and_options_that_do_not_exist() {
    let folder = Folder::with_scene("unknown");
    let mut refusals = Refusals::new(&folder);
    refusals.expect("hover", &["hover"]);
    refusals.expect("fly --altitude 3", &["--altitude"]);
    refusals.expect(&format!("{RECTIFY} stray"), &["stray"]);
    refusals.expect(&format!("{RECTIFY} --out again.png"), &["--out"]);
    refusals.expect("reproduce 005", &["005"]);
    refusals.done();
}

#[test]
fn negative_numbers_are_refused_by_what_they_are() {
    let folder = Folder::with_scene("negative");
    let mut refusals = Refusals::new(&folder);
    for (call, value, option, why) in [
        ("tiles --ortho g.tif --resolution-m 5 --out t.bin --dem d.tif --posts-m -5", "-5", "--posts-m", "above 0"),
        ("fly --wait-s -1", "-1", "--wait-s", "not between 0.1"),
        ("replay flight.log --number -1", "-1", "--number", "not a whole number from 0 on"),
        ("adjust --bal b.txt --iterations -3", "-3", "--iterations", "not in 1..=65535"),
        ("camera new --size 640x480 --fov -60x40", "-60x40", "--fov", "between 0 and 180"),
        ("camera new --size -640x480 --fov 60x40", "-640x480", "--size", "not of the form"),
        ("plan --overlap -60/30", "-60/30", "--overlap", "-60 is not between 0 and 95"),
    ] {
        refusals.expect(call, &[&format!("invalid value '{value}' for '{option}"), why]);
    }
    refusals.done();
}
