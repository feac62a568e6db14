//! `plumbline match` on textures whose shift is known.

use crate::bad_options::MATCH;
use crate::folder::{Folder, with};
use crate::pictures::{Crs, FORMATS, geotiff, grey_8_png, texture};
use crate::refusals::Refusals;
use plumbline_tests::textures::Picture;
use plumbline_tests::vectors::number;
use serde_json::Value;

/// What the contract's users may count on.
const TOLERANCE_PX: f64 = 0.1;

/// The answer must be accepted and be `shift`: (right, down).
fn found(answer: &Value, shift: (f64, f64), what: &str) {
    let keys: Vec<&String> = answer.as_object().expect("an object").keys().collect();
    let all = [
        "accepted",
        "d_col",
        "d_row",
        "reason",
        "risk",
        "risk_coefficients",
        "score",
        "second_peak",
        "sigma_col",
        "sigma_row",
    ];
    assert_eq!(keys, all, "{answer}");
    let off = [number(answer, "d_col") - shift.0, number(answer, "d_row") - shift.1];
    assert!(off.iter().all(|axis| axis.abs() < TOLERANCE_PX), "{off:?} px off {shift:?}, {what}: {answer}");
    assert!(answer["accepted"] == true && answer["reason"].is_null(), "{what}: {answer}");
    assert!(number(answer, "score") > number(answer, "second_peak"), "{what}: {answer}");
    assert!((1e-5..=1e-4).contains(&number(answer, "risk")), "{what}: {answer}");
    let sigmas = [number(answer, "sigma_col"), number(answer, "sigma_row")];
    assert!(sigmas.iter().all(|sigma| (0.001..0.3).contains(sigma)), "{what}: {answer}");
}

#[test]
fn a_known_shift_right_and_down() {
    let folder = Folder::with_scene("match-shift");
    // Even and odd sizes: the centres are between pixels or on one.
    for (patch, reference) in [((34, 34), (74, 74)), ((33, 34), (74, 74)), ((34, 34), (75, 81)), ((35, 41), (75, 80))] {
        grey_8_png(&folder.path("reference.png"), &texture(reference, (0.0, 0.0)));
        for shift in [(3.0, 0.0), (0.0, 3.0), (3.4, -2.7), (-7.25, 5.5)] {
            grey_8_png(&folder.path("patch.png"), &texture(patch, shift));
            found(&folder.run(MATCH).json(), shift, &format!("{patch:?} in {reference:?}"));
        }
    }
}

#[test]
fn all_formats_give_one_answer() {
    let folder = Folder::with_scene("match-formats");
    let wanted = folder.run(MATCH).json();
    found(&wanted, (2.0, 1.0), "grey");
    for (name, write) in FORMATS {
        write(&folder.path(name), &texture((34, 34), (2.0, 1.0)));
        assert_eq!(folder.run(&with(MATCH, "--patch", name)).json(), wanted, "{name} as patch");
        write(&folder.path(name), &texture((74, 74), (0.0, 0.0)));
        assert_eq!(folder.run(&with(MATCH, "--reference", name)).json(), wanted, "{name} as reference");
    }
}

/// Behind the mask the patch may hold anything.
#[test]
fn what_is_masked_does_not_count() {
    let folder = Folder::with_scene("match-mask");
    let (size, shift) = ((34, 34), (3.4, -2.7));
    let (mut patch, wrong) = (texture(size, shift), texture(size, (-6.0, 6.0)));
    let mut mask = Picture { pixels: vec![255; patch.pixels.len()], size };
    // A third, from the left.
    for index in (0..patch.pixels.len()).filter(|index| index % 34 < 11) {
        patch.pixels[index] = wrong.pixels[index];
        mask.pixels[index] = 0;
    }
    grey_8_png(&folder.path("patch.png"), &patch);
    grey_8_png(&folder.path("mask.png"), &mask);
    found(&folder.run(&format!("{MATCH} --mask mask.png")).json(), shift, "masked");
}

/// A second copy of the ground in the reference, behind the mask.
#[test]
fn what_is_masked_of_the_reference_is_not_matched() {
    let folder = Folder::with_scene("match-reference-mask");
    let (size, shift, decoy) = ((34, 34), (3.4, -2.7), (-9i32, 9i32));
    let patch = texture(size, shift);
    let mut reference = texture((74, 74), (0.0, 0.0));
    let mut mask = Picture { pixels: vec![255; reference.pixels.len()], size: (74, 74) };
    for index in 0..34 * 34 {
        let (col, row) = (20 + decoy.0 + index % 34, 20 + decoy.1 + index / 34);
        let at = (row * 74 + col) as usize;
        (reference.pixels[at], mask.pixels[at]) = (patch.pixels[index as usize], 0);
    }
    grey_8_png(&folder.path("patch.png"), &patch);
    grey_8_png(&folder.path("reference.png"), &reference);
    grey_8_png(&folder.path("reference_mask.png"), &mask);
    let misled = folder.run(MATCH).json();
    assert!((number(&misled, "d_col") - 3.4).abs() > 3.0 || misled["accepted"] == false, "{misled}");
    let answer = folder.run(&format!("{MATCH} --reference-mask reference_mask.png")).json();
    let off = [number(&answer, "d_col") - 3.4, number(&answer, "d_row") + 2.7];
    assert!(off.iter().all(|axis| axis.abs() < 0.5), "{answer}");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{MATCH} --reference-mask patch.png"), &["34 x 34", "74 x 74"]);
    grey_8_png(&folder.path("nothing.png"), &Picture { pixels: vec![0; 74 * 74], size: (74, 74) });
    refusals.expect(&format!("{MATCH} --reference-mask nothing.png"), &["nothing.png", "leaves nothing"]);
    refusals.done();
}

#[test]
fn without_json_there_is_one_line() {
    let folder = Folder::with_scene("match-line");
    let run = folder.run(&MATCH.replace(" --json", "")).done();
    assert!(run.stdout.lines().count() == 1 && run.stdout.contains("accepted"), "{run:?}");
}

/// The ground of another year in another season: where it was dark it is bright. Of less texture less is certain, and what is accepted
/// is what was asked for.
#[test]
fn reversed_contrast_is_found_and_the_risk_decides() {
    let folder = Folder::with_scene("match-reversed");
    let mut patch = texture((34, 34), (3.4, -2.7));
    patch.pixels.iter_mut().for_each(|grey| *grey = 255 - *grey / 2);
    grey_8_png(&folder.path("reference.png"), &texture((74, 74), (0.0, 0.0)));
    grey_8_png(&folder.path("patch.png"), &patch);
    let answer = folder.run(MATCH).json();
    let off = [number(&answer, "d_col") - 3.4, number(&answer, "d_row") + 2.7];
    assert!(answer["accepted"] == true && off.iter().all(|axis| axis.abs() < 0.5), "{answer}");
    let mut small = texture((12, 12), (3.4, -2.7));
    small.pixels.iter_mut().for_each(|grey| *grey -= *grey % 64);
    grey_8_png(&folder.path("patch.png"), &small);
    let risk = number(&folder.run(MATCH).json(), "risk");
    for (asked, accepted) in [(2.0 * risk, true), (0.5 * risk, false)] {
        let answer = folder.run(&format!("{MATCH} --risk {asked:e}")).json();
        assert_eq!(answer["accepted"], accepted, "{asked}: {answer}");
    }
}

#[test]
fn a_risk_that_nothing_supports_is_refused() {
    let folder = Folder::with_scene("match-risk");
    for risk in ["1e-6", "0", "1", "-0.1", "nan"] {
        let run = folder.run(&format!("{MATCH} --risk {risk}"));
        assert!(run.code == Some(2) && run.stderr.contains("risk"), "{risk}: {run:?}");
    }
}

/// The corner of a [`geotiff`] is at (500000, 5330000).
#[test]
fn a_georeferenced_reference_gives_metres() {
    let folder = Folder::with_scene("match-metres");
    let (patch, reference) = (texture((34, 34), (3.0, -2.0)), texture((74, 74), (0.0, 0.0)));
    grey_8_png(&folder.path("patch.png"), &patch);
    geotiff(&folder.path("reference.tif"), &reference, 5.0, Crs::Projected(32633));
    let call = with(MATCH, "--reference", "reference.tif");
    let answer = folder.run(&call).json();
    let value = |key| number(&answer, key);
    assert_eq!(value("epsg"), 32633.0);
    // Half of the reference's 74 pixels from its corner, and the shift; north is up.
    assert!((value("east_m") - (500_000.0 + 5.0 * (37.0 + value("d_col")))).abs() < 1e-6, "{answer}");
    assert!((value("north_m") - (5_330_000.0 - 5.0 * (37.0 + value("d_row")))).abs() < 1e-6, "{answer}");
    assert!((value("d_col") - 3.0).abs() < TOLERANCE_PX && (value("d_row") + 2.0).abs() < TOLERANCE_PX, "{answer}");
    assert!((value("sigma_east_m") - 5.0 * value("sigma_col")).abs() < 1e-6, "{answer}");
    assert!(answer.get("offset_east_m").is_none(), "{answer}");
    // What the map may be off is beside it, metres.
    let wider = folder.run(&format!("{call} --map-sigma-m 20")).json();
    let wanted = value("sigma_east_m").hypot(20.0);
    assert!((number(&wider, "sigma_east_m") - wanted).abs() < 1e-3, "{wider}");
    assert_eq!(wider["east_m"], answer["east_m"]);
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{call} --map-sigma-m -1"), &["--map-sigma-m", "between 0 and 1000"]);
    grey_8_png(&folder.path("reference.png"), &reference);
    refusals.expect(&format!("{MATCH} --map-sigma-m 20"), &["--map-sigma-m 20", "reference.png"]);
    refusals.done();
    // In degrees there are no metres, and that is told.
    geotiff(&folder.path("reference.tif"), &reference, 1e-5, Crs::Geographic(4326));
    let run = folder.run(&call).done();
    assert!(!run.stdout.contains("east_m") && run.stderr.contains("gdalwarp"), "{run:?}");
}

/// Both files have their corner at the same place: the patch says that its middle is 17 pixels from there, and the reference is far larger
/// than the search.
#[test]
fn a_georeferenced_patch_is_looked_for_where_it_says() {
    let folder = Folder::with_scene("match-claimed");
    let reference = texture((300, 300), (0.0, 0.0));
    geotiff(&folder.path("reference.tif"), &reference, 5.0, Crs::Projected(32633));
    // The part of the reference from its pixel (4, 3) on.
    let pixels = (0..34 * 34).map(|at| reference.pixels[(at / 34 + 3) * 300 + at % 34 + 4]).collect();
    geotiff(&folder.path("patch.tif"), &Picture { pixels, size: (34, 34) }, 5.0, Crs::Projected(32633));
    let call = with(&with(MATCH, "--reference", "reference.tif"), "--patch", "patch.tif");
    let answer = folder.run(&call).json();
    let off = [("offset_east_m", 20.0), ("offset_north_m", -15.0), ("d_col", 20.5 - 149.5), ("d_row", 19.5 - 149.5)];
    for (key, wanted) in off {
        assert!((number(&answer, key) - wanted).abs() < 5.0 * TOLERANCE_PX, "{key} is not {wanted}: {answer}");
    }
    let mut refusals = Refusals::new(&folder);
    geotiff(&folder.path("patch.tif"), &texture((34, 34), (0.0, 0.0)), 5.0, Crs::Projected(32632));
    refusals.expect(&call, &["patch.tif", "EPSG:32632", "gdalwarp -t_srs EPSG:32633"]);
    geotiff(&folder.path("patch.tif"), &texture((34, 34), (0.0, 0.0)), 4.9, Crs::Projected(32633));
    refusals.expect(&call, &["patch.tif", "4.9", "gdalwarp -tr 5 5"]);
    refusals.done();
}
