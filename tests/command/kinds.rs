//! Elevation models and orthophotos, each in the other's place, and numbers that are no heights.

use crate::elevation::grid;
use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::picture::Picture;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes, grey_geotiff_bytes};

const SIDE: usize = 100;
const GEO: GeoTransform = GeoTransform { x0: 599_500.0, y0: 5_200_500.0, step_x: 10.0, step_y: 10.0 };
const UTM: Option<System> = Some(System::Epsg(32633));

fn model(height: impl Fn(usize) -> f32) -> Vec<u8> {
    let samples: Vec<f32> = (0..SIDE * SIDE).map(height).collect();
    let bands = [Band { description: "height", samples: &samples }];
    geotiff_bytes(SIDE, SIDE, &bands, &GEO, UTM, f32::NAN).expect("a raster")
}

/// A camera, a board's settings and a scenario are TOML all of them.
#[test]
fn a_camera_settings_and_a_scenario_are_told_apart() {
    let folder = Folder::with_scene("kinds-toml");
    folder.write("settings.toml", include_str!("../../examples/settings.toml"));
    folder.write("scenario.toml", include_str!("../../examples/scenario.toml"));
    let map = "map --heading-deg 0 --pitch-deg 0 --roll-deg 0";
    let configuration = "configuration --camera camera.toml --out configuration.bin --settings";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{map} --camera settings.toml -- 0,0"), &["settings.toml", "this is a board's settings"]);
    refusals.expect(&format!("{map} --camera scenario.toml -- 0,0"), &["scenario.toml", "this is a scenario"]);
    refusals.expect(&format!("{configuration} scenario.toml"), &["scenario.toml", "this is a scenario, which fly"]);
    refusals.expect(&format!("{configuration} camera.toml"), &["camera.toml", "this is a camera file, which --camera"]);
    let rows = "frame.png,500300,5329700,200,0,0,0\n".repeat(3);
    folder.write("frames.csv", format!("file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n{rows}"));
    let evaluate = "evaluate --frames frames.csv --camera camera.toml --reference reference.png --out out --settings";
    refusals.expect(&format!("{evaluate} scenario.toml"), &["scenario.toml", "this is a scenario, which fly"]);
    refusals.expect(&format!("{evaluate} camera.toml"), &["camera.toml", "this is a camera file, which --camera"]);
    refusals.expect("fly --scenario camera.toml --frames 1", &["camera.toml", "this is a camera file, which --camera"]);
    // A misspelt key alone does not make it another file.
    folder.write("misspelt.toml", "serach_px = 10\n");
    let run = folder.run(&format!("{configuration} misspelt.toml"));
    assert!(run.stderr.contains("serach_px is no setting") && !run.stderr.contains("this is"), "{run:?}");
    refusals.done();
}

#[test]
fn neither_is_taken_for_the_other() {
    let folder = Folder::with_scene("kinds");
    let grey = |index: usize| (index * 7 % 251) as u8;
    let picture = Picture { cols: SIDE, rows: SIDE, pixels: (0..SIDE * SIDE).map(grey).collect() };
    folder.write("picture.tif", grey_geotiff_bytes(&picture, &GEO, UTM, None).expect("a picture"));
    folder.write("model.tif", model(|index| f32::from(grey(index))));
    // A corner of unknown posts whose file does not say so.
    folder.write("hole.tif", model(|index| if index == 5 * SIDE + 3 { -32_768.0 } else { 100.0 }));
    let tail = "--camera camera.toml --height-m 300 --overlap 60/30 --out out";
    let plan = |dem: &str, area: &str| format!("plan --dem {dem} --area {area} {tail}");
    let area = "599600,5200000,599700,5200100";
    let heights = "gdal_translate -ot Int16 picture.tif picture_int16.tif";
    let greys = "gdal_translate -ot Byte -scale model.tif model_byte.tif";
    let nodata = "gdal_edit.py -a_nodata -32768 hole.tif";
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&plan("picture.tif", area), &[heights]);
    refusals.expect(&plan("hole.tif", area), &["-32768 at x 599530, y 5200450", nodata]);
    refusals.expect("tiles --ortho model.tif --resolution-m 20 --out tiles.bin", &[greys]);
    refusals.expect("tiles --ortho picture.tif --dem picture.tif --resolution-m 20 --out tiles.bin", &[heights]);
    refusals.expect("tiles --ortho picture.tif --dem hole.tif --resolution-m 20 --out tiles.bin", &[nodata]);
    refusals.expect("fly --ground model.tif --frames 1 --out out", &[greys]);
    refusals.expect("fly --ground picture.tif --reference model.tif --frames 1 --out out", &[greys]);
    refusals.expect("fly --ground picture.tif --dem picture.tif --frames 1 --out out", &[heights]);
    refusals.expect("fly --ground picture.tif --dem hole.tif --frames 1 --out out", &[nodata]);
    folder.write("hole.asc", grid(|x, y| if (x, y) == (-350.0, 0.0) { -32_768.0 } else { 100.0 }));
    refusals.expect(&plan("hole.asc", "0,0,400,300"), &["NODATA_value -32768", "x -350, y 0"]);
    refusals.done();
}

/// What is neither said nor seen in a single number: posts of 0 in a model of 100 m, and grey values of more than 8 bits.
#[test]
fn undeclared_no_data_and_grey_values_are_no_ground() {
    let folder = Folder::with_scene("kinds-posts");
    let grey = |index: usize| (index * 7919 % 251) as u8;
    let picture = Picture { cols: SIDE, rows: SIDE, pixels: (0..SIDE * SIDE).map(grey).collect() };
    folder.write("picture.tif", grey_geotiff_bytes(&picture, &GEO, UTM, None).expect("a picture"));
    folder.write("grey.tif", model(|index| f32::from(grey(index))));
    let is_hole = |index: usize| (20..25).contains(&(index / SIDE)) && (30..40).contains(&(index % SIDE));
    folder.write(
        "zero.tif",
        model(|index| if is_hole(index) { 0.0 } else { 100.0 + 0.1 * (index % SIDE + index / SIDE) as f32 }),
    );
    let plan = |dem: &str| {
        format!(
            "plan --dem {dem} --area 599600,5200000,599700,5200100 --camera camera.toml --height-m 300 --overlap 60/30 --out out"
        )
    };
    // The raster writer declares NaN, so that a second number takes another line.
    let zero =
        ["50 posts of exactly 0", "x 599800, y 5200", "gdal_calc.py -A zero.tif --calc='numpy.where(A==0,-9999,A)'"];
    let picture = ["is this a picture?", "gdal_edit.py -units m grey.tif"];
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&plan("zero.tif"), &zero);
    refusals.expect(&plan("grey.tif"), &picture);
    for verb in
        ["tiles --ortho picture.tif --resolution-m 20 --out tiles.bin", "fly --ground picture.tif --frames 1 --out out"]
    {
        refusals.expect(&format!("{verb} --dem zero.tif"), &zero);
        refusals.expect(&format!("{verb} --dem grey.tif"), &picture);
    }
    refusals.done();
}
