//! `plumbline stitch`: what it makes of frames, what it says of seams, and what it refuses.

use crate::folder::{Folder, with};
use crate::pictures::{flat, grey_8_png, grey_16_png, rgb_8_png, texture};
use crate::refusals::Refusals;
use image::ImageReader;
use plumbline_survey::io::picture::read_grey;

const HEAD: &str = "[[heads]]\ncols = 240\nrows = 200\nf_px = 300\nrotation_deg = [0, 0, 0]\nd_m = [0, 0, 0]\n";
/// Two frames of two heads.
const STITCH: &str = "stitch --camera heads.toml --frames f1.png f2.png --out out.png";

/// A virtual camera of the heads' own size and focal length.
fn camera() -> String {
    let fov = |side: f64| 2.0 * (0.5 * side / 300.0).atan().to_degrees();
    format!(
        "cols = 240\nrows = 200\nfov_h_deg = {:?}\nfov_v_deg = {:?}\noffset_m_px = 0\noffset_n_px = 0\n",
        fov(240.0),
        fov(200.0)
    )
}

/// Two heads that look the same way, the second of which sees the ground two columns and a row further.
fn scene(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("heads.toml", format!("{}{HEAD}{HEAD}", camera()));
    grey_8_png(&folder.path("f1.png"), &texture((240, 200), (0.0, 0.0)));
    grey_8_png(&folder.path("f2.png"), &texture((240, 200), (2.0, 1.0)));
    folder
}

/// One head that is the virtual camera: the picture is the frame, to the last grey and colour.
#[test]
fn a_head_that_is_the_virtual_camera_gives_its_own_frame() {
    let folder = scene("stitch-one");
    folder.write("one.toml", format!("{}{HEAD}", camera()));
    let one = "stitch --camera one.toml --frames f1.png --out out.png --json";
    let summary = folder.run(one).json();
    assert_eq!(summary.to_string(), r#"{"cols":240,"coverage":1.0,"rows":200,"seams":[]}"#);
    let frame = read_grey(&folder.path("f1.png")).expect("a frame");
    assert_eq!(read_grey(&folder.path("out.png")).expect("an image"), frame);
    rgb_8_png(&folder.path("f1.png"), &texture((240, 200), (0.0, 0.0)));
    folder.run(one).json();
    let colours = ImageReader::open(folder.path("out.png")).expect("there").decode().expect("a picture");
    assert_eq!(colours.color(), image::ColorType::Rgb8);
    assert_eq!(read_grey(&folder.path("out.png")).expect("an image"), frame);
    grey_16_png(&folder.path("f1.png"), &texture((240, 200), (0.0, 0.0)));
    folder.run(one).json();
    assert_eq!(read_grey(&folder.path("out.png")).expect("an image"), frame);
}

/// Root of five is 2.236; the matching is good to some hundredths.
#[test]
fn a_seam_that_does_not_fit_is_told_in_pixels() {
    let folder = scene("stitch-seam");
    let summary = folder.run(&format!("{STITCH} --json")).json();
    let seams = summary["seams"].as_array().expect("a list");
    assert_eq!((seams.len(), seams[0]["heads"].to_string()), (1, "[1,2]".to_owned()), "{summary}");
    let number = |key: &str| seams[0][key].as_f64().expect("a number");
    assert!(number("windows") >= 10.0, "{summary}");
    assert!((number("rms_px") - 5f64.sqrt()).abs() < 0.05 && number("max_px") < 5f64.sqrt() + 0.15, "{summary}");
    let run = folder.run(&format!("{STITCH} --seam hard")).done();
    assert!(run.stderr.is_empty() && run.stdout.contains("heads 1 and 2: 2.2"), "{run:?}");
    // Both axes are equally near everywhere: the first head has it all.
    assert_eq!(folder.read("out.png"), {
        folder.run("stitch --camera heads.toml --frames f1.png f1.png --out again.png").done();
        folder.read("again.png")
    });
}

/// Ground without texture cannot be matched: no window, no figure, but an image.
#[test]
fn nothing_to_match_is_no_figure() {
    let folder = scene("stitch-flat");
    for name in ["f1.png", "f2.png"] {
        grey_8_png(&folder.path(name), &flat((240, 200), 90));
    }
    let summary = folder.run(&format!("{STITCH} --json")).json();
    let seam = &summary["seams"][0];
    assert!(seam["max_px"].is_null() && seam["rms_px"].is_null() && seam["windows"] == 0, "{summary}");
    assert!(seam["tried"].as_u64().is_some_and(|tried| tried > 0), "{summary}");
}

#[test]
fn bad_input_is_refused() {
    let folder = scene("stitch-bad");
    folder.write("none.toml", camera());
    folder.write("nan.toml", format!("{}{}", camera(), HEAD.replace("300", "nan")));
    folder.write("wide.toml", format!("{}{}", camera(), HEAD.replace("[0, 0, 0]\nd_m", "[0, 91, 0]\nd_m")));
    folder.write("broken.png", &folder.read("f1.png")[..2000]);
    folder.write("text.png", "no picture");
    folder.make("folder");
    grey_8_png(&folder.path("small.png"), &flat((240, 199), 90));
    rgb_8_png(&folder.path("colour.png"), &texture((240, 200), (0.0, 0.0)));
    let mut refusals = Refusals::new(&folder);
    let camera = |file: &str| with(STITCH, "--camera", file);
    refusals.expect(&camera("none.toml"), &["none.toml", "no heads"]);
    refusals.expect(&camera("nan.toml"), &["nan.toml", "head 1", "f_px"]);
    refusals.expect(&camera("wide.toml"), &["wide.toml", "head 1", "rotation_deg"]);
    refusals.expect(&camera("missing.toml"), &["missing.toml"]);
    let frames = |frames: &str| STITCH.replace("f1.png f2.png", frames);
    refusals.expect(&frames("f1.png"), &["heads.toml", "heads: 2", "pictures: 1"]);
    refusals.expect(&frames("f1.png f2.png f2.png"), &["heads: 2", "pictures: 3"]);
    refusals.expect(&frames("f1.png small.png"), &["small.png", "240 x 199", "head 2"]);
    refusals.expect(&frames("f1.png colour.png"), &["f1.png", "colour.png", "colour"]);
    for bad in ["broken.png", "text.png", "missing.png", "folder"] {
        refusals.expect(&frames(&format!("f1.png {bad}")), &[bad]);
    }
    for place in ["none/out.png", "folder", "f1.png/out.png"] {
        refusals.expect(&with(STITCH, "--out", place), &[place]);
    }
    for height in ["0", "-5", "nan", "inf", "high"] {
        refusals.expect(&format!("{STITCH} --height-m {height}"), &["--height-m"]);
    }
    refusals.expect(&format!("{STITCH} --seam soft"), &["--seam", "soft"]);
    refusals.expect("stitch --camera heads.toml --out out.png", &["--frames"]);
    refusals.done();
}

/// A file of several heads flies one of them, which has to be said; a file of one flies that.
#[test]
fn a_configuration_is_of_one_head() {
    let folder = scene("stitch-configuration");
    folder.write("one.toml", format!("{}{HEAD}", camera()));
    folder.write("plain.toml", camera());
    folder.write("settings.toml", "head = 2\n");
    let heads = "mission --camera heads.toml --out mission.bin --json";
    let of_option = folder.run(&format!("{heads} --head 2")).json();
    assert_eq!((of_option["cols"].as_u64(), of_option["rows"].as_u64()), (Some(240), Some(200)));
    assert_eq!(folder.run(&format!("{heads} --settings settings.toml")).json(), of_option);
    assert_eq!(folder.run(&with(heads, "--camera", "one.toml")).json()["crc32"], of_option["crc32"]);
    std::fs::remove_file(folder.path("mission.bin")).expect("there");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(heads, &["heads.toml", "2 heads", "--head"]);
    for head in ["3", "255"] {
        refusals.expect(&format!("{heads} --head {head}"), &["heads.toml", "2 heads", head]);
    }
    for head in ["0", "-1", "256", "nan", "two"] {
        refusals.expect(&format!("{heads} --head {head}"), &["--head"]);
    }
    refusals.expect(&format!("{heads} --head 1 --settings settings.toml"), &["settings.toml", "--head"]);
    refusals.expect(&format!("{} --head 1", with(heads, "--camera", "plain.toml")), &["plain.toml", "0 heads"]);
    folder.write("flight.toml", "head = 1\n");
    refusals.expect("fly --scenario flight.toml --frames 1", &["flight.toml", "head = 1", "camera_file"]);
    refusals.done();
}
