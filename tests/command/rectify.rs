//! `plumbline rectify`: what it says, where things come to lie, and which pictures it takes.

use crate::bad_options::RECTIFY;
use crate::folder::{Folder, with};
use crate::pictures::{FORMATS, flat, grey_8_png, texture};
use crate::refusals::Refusals;
use plumbline_survey::io::picture::{Picture, read_grey};
use plumbline_tests::vectors::{list, number, rows};

/// Tangent a pixel of the scene's camera: 60 degrees over 96 pixels.
fn tangent_per_px() -> f64 {
    30.0_f64.to_radians().tan() / 48.0
}

#[test]
fn the_document_and_the_files_agree() {
    let folder = Folder::with_scene("rectify-json");
    // Tilted by 10 degrees both ways: the footprint leaves corners of the patch empty.
    let arguments = with(&with(RECTIFY, "--pitch-deg", "10"), "--roll-deg", "-10");
    let summary = folder.run(&format!("{arguments} --mask mask.png")).json();
    let keys: Vec<&String> = summary.as_object().expect("an object").keys().collect();
    let wanted =
        ["cols", "equivalent_pitch_deg", "equivalent_roll_deg", "follow_up_deg", "height_m", "rows", "valid_fraction"];
    assert_eq!(keys, wanted, "{summary}");
    let (patch, mask) = (picture(&folder, "out.png"), picture(&folder, "mask.png"));
    assert_eq!((number(&summary, "cols"), number(&summary, "rows")), (patch.cols as f64, patch.rows as f64));
    assert_eq!((mask.cols, mask.rows), (patch.cols, patch.rows));
    assert!(mask.pixels.iter().all(|&value| value == 0 || value == 255), "a mask is 0 or 255");
    let valid = mask.pixels.iter().filter(|&&value| value == 255).count();
    assert!(valid > 0 && valid < mask.pixels.len(), "{valid} valid pixels show nothing");
    assert_eq!(number(&summary, "valid_fraction"), valid as f64 / mask.pixels.len() as f64);
    assert!(
        patch.pixels.iter().zip(&mask.pixels).all(|(&grey, &valid)| valid == 255 || grey == 0),
        "grey where invalid"
    );
}

fn picture(folder: &Folder, name: &str) -> Picture {
    read_grey(&folder.path(name)).expect("a picture")
}

#[test]
fn without_json_stdout_has_a_line_for_people() {
    let folder = Folder::with_scene("rectify-quiet");
    let run = folder.run(&RECTIFY.replace(" --json", "")).done();
    assert!(run.stderr.is_empty() && run.stdout.lines().count() == 1, "{run:?}");
}

#[test]
fn an_oblique_frame_is_told_what_it_does_not_share_with_the_patch() {
    let folder = Folder::with_scene("rectify-oblique");
    let level = with(&with(&with(RECTIFY, "--pitch-deg", "0"), "--roll-deg", "0"), "--heading-deg", "0");
    let said = |arguments: &str| folder.run(&arguments.replace(" --json", "")).done().stdout;
    assert!(said(&level).ends_with("valid: out.png\n"), "{}", said(&level));
    let oblique = said(&with(&level, "--pitch-deg", "40"));
    let [unseen, outside] =
        ["% of the patch is not seen by the frame", "% of the frame lies outside the patch"].map(|of| {
            let before = oblique
                .split(of)
                .next()
                .filter(|before| before.len() < oblique.len())
                .unwrap_or_else(|| panic!("{oblique}"));
            before.trim_end().rsplit(' ').next().and_then(|share| share.parse::<f64>().ok()).expect("a share")
        });
    // The nadir lies 10 degrees below the frame's edge of 30: the near half of the patch is not seen, the far part of the frame is beyond.
    assert!((40.0..80.0).contains(&unseen) && (30.0..90.0).contains(&outside), "{oblique}");
    assert_eq!(oblique.lines().count(), 1);
}

/// Table A by the printed degrees: single precision near 180 degrees has steps of 1.5e-5.
#[test]
fn golden_a_angles() {
    let folder = Folder::with_scene("rectify-angles");
    for row in rows("003", "A_followup") {
        let [phi, theta, gamma] = ["phi", "theta", "gamma"].map(|key| number(&row, key).to_string());
        let arguments = with(&with(&with(RECTIFY, "--heading-deg", &phi), "--pitch-deg", &theta), "--roll-deg", &gamma);
        let summary = folder.run(&arguments).json();
        let [follow_up, pitch, roll] = list(&row, "out");
        let turn = (number(&summary, "follow_up_deg") - follow_up + 180.0).rem_euclid(360.0) - 180.0;
        assert!(turn.abs() < 1e-4, "{summary} for {row}");
        assert!((number(&summary, "equivalent_pitch_deg") - pitch).abs() < 1e-4, "{summary} for {row}");
        assert!((number(&summary, "equivalent_roll_deg") - roll).abs() < 1e-4, "{summary} for {row}");
    }
}

/// Table D: eq. 4 rounded down. Columns go with the field of view across.
#[test]
fn golden_d_sizes() {
    let folder = Folder::with_scene("rectify-sizes");
    for row in rows("003", "D_size") {
        let [height, fov_h, fov_v, resolution] = ["H", "VH", "VV", "R"].map(|key| number(&row, key));
        folder.write(
            "camera.toml",
            format!(
                "cols = 96\nrows = 96\nfov_h_deg = {fov_h:?}\nfov_v_deg = {fov_v:?}\noffset_m_px = 0\noffset_n_px = 0\n"
            ),
        );
        let arguments = with(RECTIFY, "--height-m", &height.to_string());
        let summary = folder.run(&with(&arguments, "--resolution-m", &resolution.to_string())).json();
        let [cols, rows] = list(&row, "out").map(f64::floor);
        assert_eq!([number(&summary, "cols"), number(&summary, "rows")], [cols, rows], "{summary} for {row}");
    }
    let summary = folder.run(&format!("{RECTIFY} --cols 20 --rows 30")).json();
    assert_eq!([number(&summary, "cols"), number(&summary, "rows")], [20.0, 30.0], "{summary}");
}

/// A slant range is along the camera's axis: height = range cos(pitch) cos(roll).
#[test]
fn height_by_range() {
    let folder = Folder::with_scene("rectify-range");
    let summary = folder.run(&RECTIFY.replace("--height-m 100", "--range-m 100")).json();
    let wanted = 100.0 * 5.0_f64.to_radians().cos() * 3.0_f64.to_radians().cos();
    // The cosines are single precision.
    assert!((number(&summary, "height_m") - wanted).abs() < 1e-4, "{summary} instead of {wanted}");
}

/// Where the light of a picture has its centre, (column, row).
fn centre_of_light(picture: &Picture) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for (index, &grey) in picture.pixels.iter().enumerate() {
        let (col, row) = ((index % picture.cols) as f64, (index / picture.cols) as f64);
        for (sum, value) in sums.iter_mut().zip([1.0, col, row]) {
            *sum += f64::from(grey) * value;
        }
    }
    assert!(sums[0] > 0.0, "the patch is dark");
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// One lit square of 8 x 8 pixels in a dark frame, `m` to the right and `n` forward of its centre; where it comes to lie
/// in a patch of 57 x 57 pixels of 2 m from 100 m: (east, north) of the centre, metres.
fn lit(folder: &Folder, (m, n): (i32, i32), attitude: &str) -> [f64; 2] {
    let mut frame = flat((96, 96), 0);
    for row in 44 - n..52 - n {
        for col in 44 + m..52 + m {
            frame.pixels[(row * 96 + col) as usize] = 250;
        }
    }
    grey_8_png(&folder.path("frame.png"), &frame);
    let fixed = "rectify --camera camera.toml --frame frame.png --height-m 100 --resolution-m 2 --out out.png --json";
    let summary = folder.run(&format!("{fixed} {attitude}")).json();
    // 2 * 100 * tan 30 / 2 = 57.7.
    assert_eq!([number(&summary, "cols"), number(&summary, "rows")], [57.0, 57.0]);
    let [col, row] = centre_of_light(&picture(folder, "out.png"));
    [2.0 * (col - 28.0), 2.0 * (28.0 - row)]
}

/// Signs and axes, by plane trigonometry. Tolerance: half a patch pixel; a wrong sign or axis is 14 pixels off, or 28.
#[test]
fn the_patch_is_north_up_around_the_nadir() {
    let folder = Folder::with_scene("rectify-signs");
    let step_m = 100.0 * tangent_per_px();
    // Beside the axis by 14 pixels, which is 9.56 degrees, so that 10 degrees of tilt bring it near the nadir.
    let beside_m = 100.0 * (10.0_f64.to_radians() - (14.0 * tangent_per_px()).atan()).tan();
    for (place, attitude, [east, north]) in [
        ((0, 24), "--heading-deg 0 --pitch-deg 0 --roll-deg 0", [0.0, 24.0 * step_m]),
        ((24, 0), "--heading-deg 0 --pitch-deg 0 --roll-deg 0", [24.0 * step_m, 0.0]),
        // The camera follows: whatever the heading, its row 0 looks north.
        ((0, 24), "--heading-deg 90 --pitch-deg 0 --roll-deg 0", [0.0, 24.0 * step_m]),
        // It does not follow: its row 0 looks where the vehicle flies.
        ((0, 24), "--heading-deg 90 --pitch-deg 0 --roll-deg 0 --follow-up-deg none", [24.0 * step_m, 0.0]),
        ((0, 24), "--heading-deg 180 --pitch-deg 0 --roll-deg 0 --follow-up-deg none", [0.0, -24.0 * step_m]),
        // Turned back by 90 degrees counter-clockwise from east: north again.
        ((0, 24), "--heading-deg 90 --pitch-deg 0 --roll-deg 0 --follow-up-deg 90", [0.0, 24.0 * step_m]),
        // Nose up: the axis looks ahead, the nadir lies behind it.
        ((0, -14), "--heading-deg 0 --pitch-deg 10 --roll-deg 0", [0.0, beside_m]),
        // Right wing down: the axis looks to the left, the nadir lies to its right.
        ((14, 0), "--heading-deg 0 --pitch-deg 0 --roll-deg 10", [-beside_m, 0.0]),
    ] {
        let found = lit(&folder, place, attitude);
        let off = [found[0] - east, found[1] - north];
        assert!(off[0].abs() < 1.0 && off[1].abs() < 1.0, "{off:?} m off: {found:?} m for {place:?} with {attitude}");
    }
}

/// Twelve pixels of 2 m below a camera that looks 40 degrees aside, and ground that no model knows.
#[test]
fn a_frame_that_sees_nothing_of_the_patch_is_refused() {
    let folder = Folder::with_scene("rectify-blind");
    let blind = with(&with(RECTIFY, "--pitch-deg", "40"), "--roll-deg", "0");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(
        &format!("{blind} --cols 12 --rows 12 --mask mask.png"),
        &["frame.png sees nothing of the patch, 12 x 12 pixels of 2 m", "--cols"],
    );
    refusals.done();
    folder.run(&format!("{blind} --cols 120 --rows 120 --mask mask.png")).done();
}

/// Equal greys in any format make one patch. With three equal bands luma is that grey, and 257 times a grey is
/// the same in 16 bits.
#[test]
fn all_formats_give_one_patch() {
    let folder = Folder::with_scene("rectify-formats");
    folder.run(RECTIFY).done();
    let wanted = folder.read("out.png");
    for (name, write) in FORMATS {
        write(&folder.path(name), &texture((96, 96), (0.0, 0.0)));
        std::fs::remove_file(folder.path("out.png")).expect("there");
        folder.run(&with(RECTIFY, "--frame", name)).done();
        assert_eq!(folder.read("out.png"), wanted, "{name}");
    }
}
