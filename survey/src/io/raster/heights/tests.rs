//! Made-up posts that are heights, and such as are none.

use super::*;
use crate::io::raster::Scaling;
use std::path::Path;

const SIDE: usize = 40;

/// Hills of 800 to 1000 m, in tenths of a metre.
fn hills(col: usize, row: usize) -> f64 {
    let wave = 100.0 * ((col as f64) / 6.0).sin() * ((row as f64) / 8.0).cos();
    ((900.0 + wave) * 10.0).round() / 10.0
}

/// What is said of 40 x 40 posts every 10 m.
fn said(sample: impl Fn(usize, usize) -> f64) -> Option<String> {
    said_of("dem.tif", false, false, 10.0, sample)
}

fn said_of(
    name: &str,
    has_nodata: bool,
    are_declared_heights: bool,
    step_m: f64,
    sample: impl Fn(usize, usize) -> f64,
) -> Option<String> {
    let samples: Vec<f64> = (0..SIDE * SIDE).map(|index| sample(index % SIDE, index / SIDE)).collect();
    let posts = Posts {
        path: Path::new(name),
        samples: &samples,
        cols: SIDE,
        step_m: [step_m; 2],
        scaling: Scaling::NONE,
        unit_m: 1.0,
        has_nodata,
        are_declared_heights,
        is_ascii: name.ends_with("asc"),
        place: &|index| (600_000.0 + 10.0 * (index % SIDE) as f64, 5.0 + 10.0 * (index / SIDE) as f64),
    };
    posts.check().err().map(|error| error.to_string())
}

#[test]
fn numbers_that_stand_for_nothing_are_no_heights() {
    let one = |height: f64| move |col: usize, row: usize| if (col, row) == (2, 0) { height } else { 100.0 };
    for height in [-440.0, 8849.0] {
        let around = move |col: usize, row: usize| height + 0.1 * (col + row) as f64;
        assert_eq!(said(around), None, "the shore of the Dead Sea and Mount Everest: {height}");
    }
    let lowest = f64::from(f32::MIN);
    for (height, text) in
        [(-9999.0, "-9999 "), (-32_768.0, "-32768 "), (lowest, "-3.4028234663852886e38 "), (32_767.0, "32767 ")]
    {
        let said = said(one(height)).expect("refused");
        assert!(said.contains(&format!("-a_nodata {text}dem.tif")) && said.contains("x 600020, y 5 "), "{said}");
    }
    let said = said_of("dem.asc", false, false, 10.0, one(-9999.0)).expect("refused");
    assert!(said.contains("NODATA_value -9999"), "{said}");
}

#[test]
fn posts_of_0_far_below_what_surrounds_them_are_no_ground() {
    type Holes = fn(usize, usize) -> bool;
    let holes: [(&str, Holes, &str); 5] = [
        ("all but a cut", |col, row| !(14..26).contains(&col) || !(14..26).contains(&row), "1456 posts"),
        ("a hole", |col, row| (10..20).contains(&col) && (5..9).contains(&row), "40 posts"),
        ("one post", |col, row| (col, row) == (10, 5), "1 post "),
        ("a collar", |col, row| col + row < 20, "210 posts"),
        ("two corners", |col, row| col + row < 5 || col + row > 73, "30 posts"),
    ];
    for (name, is_in, count) in holes {
        let said = said(|col, row| if is_in(col, row) { 0.0 } else { hills(col, row) }).expect(name);
        assert!(said.contains(&format!("{count} of exactly 0").replace("  ", " ")), "{name}: {said}");
        assert!(said.contains("gdal_translate -a_nodata 0 dem.tif dem_nodata.tif"), "{name}: {said}");
    }
    let hole = |fill: f64| move |col: usize, row: usize| if col < 12 && row < 9 { fill } else { hills(col, row) };
    let said_first = said(hole(0.0)).expect("refused");
    assert!(said_first.contains("108 posts") && said_first.contains("at x 600000, y 5"), "{said_first}");
    assert!(said(hole(-1.0)).expect("any number").contains("108 posts of exactly -1"));
    let said = said_of("dem.asc", false, false, 10.0, hole(0.0)).expect("refused");
    assert!(said.contains("a line NODATA_value 0 in its header"), "{said}");
    let said = said_of("my dem.tif", true, false, 10.0, hole(0.0)).expect("refused");
    assert!(said.contains("gdal_calc.py -A 'my dem.tif' --calc='numpy.where(A==0,-9999,A)'"), "{said}");
}

#[test]
fn water_masts_and_plains_are_ground() {
    type Shape = fn(usize, usize) -> f64;
    let shapes: [(&str, Shape); 9] = [
        ("a sea with a shore", |col, _| (4.0 * (col as f64 - 15.0)).max(0.0)),
        // Of 84 degrees, on half of the shore.
        ("a sea under a cliff", |col, row| {
            if col < 15 {
                0.0
            } else if row < 20 {
                100.0
            } else {
                col as f64 - 14.0
            }
        }),
        ("a lake", |col, row| 800.0 + 4.0 * ((col as f64 - 15.0).hypot(row as f64 - 20.0) - 6.0).max(0.0)),
        ("a mast on a plain", |col, row| if (col, row) == (20, 20) { 290.0 } else { 0.0 }),
        ("a plain", |_, _| 0.0),
        // Made, not measured.
        ("a step", |col, _| if col < 15 { 0.0 } else { 100.0 }),
        ("a wall", |col, _| if col == 15 { 560.0 } else { 500.0 }),
        ("a block", |col, row| if (10..20).contains(&col) && (5..25).contains(&row) { 360.0 } else { 100.0 }),
        ("a roof", |col, row| if (10..20).contains(&col) && (5..9).contains(&row) { 1200.0 } else { hills(col, row) }),
    ];
    for (name, shape) in shapes {
        assert_eq!(said(shape), None, "{name}");
    }
    // A fjord in a model of posts 90 m apart: shores of 50 degrees.
    let fjord = |col: usize, _: usize| if col < 15 { 0.0 } else { 107.0 * (col as f64 - 14.0) };
    assert_eq!(said_of("dem.tif", false, false, 90.0, fjord), None);
    let wall = |col: usize, row: usize| if col < 15 { 0.0 } else { fjord(col, row) + row as f64 };
    assert!(said_of("dem.tif", false, false, 10.0, wall).is_some(), "a wall of 85 degrees all along");
}

/// What jumps from post to post: a scrambled number from 1 to `most`.
fn noise(col: usize, row: usize, most: usize) -> f64 {
    ((col * 7919 + row * 104_729) * 2_654_435_761 % 65_521 % most + 1) as f64
}

#[test]
fn grey_values_are_no_heights() {
    for (most, step_m) in [(256, 0.3), (256, 5.0), (4000, 5.0)] {
        let said = said_of("map.tif", false, false, step_m, |col, row| noise(col, row, most)).expect("refused");
        assert!(
            said.contains("is this a picture?") && said.ends_with("gdal_edit.py -units m map.tif says so"),
            "{said}"
        );
    }
    let declared = said_of("map.tif", false, true, 5.0, |col, row| noise(col, row, 256));
    assert_eq!(declared, None, "a unit of heights says that they are");
    // Whole metres over a plain, the same in steps of 0.5 m, a town of flat roofs, mountains in whole feet.
    assert_eq!(said_of("dem.tif", false, false, 30.0, |col, row| noise(col, row, 3)), None);
    assert_eq!(said_of("dem.tif", false, false, 0.5, |col, row| ((col + row) as f64 / 7.0).round()), None);
    let town = |col: usize, row: usize| if col % 20 < 12 && row % 20 < 12 { 30.0 + (col / 20) as f64 } else { 10.0 };
    assert_eq!(said_of("dem.tif", false, false, 1.0, town), None);
    assert_eq!(said_of("dem.tif", false, false, 10.0, |col, row| (3.28084 * hills(col, row)).round()), None);
}
