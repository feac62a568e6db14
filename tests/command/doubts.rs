//! Heights that can hardly be those of ground in metres, under an orthophoto: every verb that takes an elevation model says so, and works.

use crate::folder::Folder;
use crate::pictures::{Crs, geotiff, grey_8_png, texture};
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes};

const SIDE: usize = 128;
const TAKEN: &str = "--camera camera.toml --reference ground.tif --resolution-m 5 --out out";

/// A scene over 1280 m of ground, and models of it: hills, whatever they are made into.
fn scene(name: &str) -> Folder {
    let folder = Folder::with_scene(name);
    geotiff(&folder.path("ground.tif"), &texture((256, 256), (0.0, 0.0)), 5.0, Crs::Projected(32633));
    let hills = |index: usize| {
        let [x, y] = [index % SIDE, index / SIDE].map(|post| 10.0 * post as f64);
        let wave = |length: f64| 0.1 * length * (x / length).sin() * (y / length + 1.0).cos();
        50.0 + wave(150.0) + wave(60.0)
    };
    for (model, per_metre) in [("metres", 1.0), ("kilometres", 1e-3), ("centimetres", 100.0), ("zero", 0.0)] {
        let samples: Vec<f32> = (0..SIDE * SIDE).map(|index| (per_metre * hills(index)) as f32).collect();
        let bands = [Band { description: "height", samples: &samples }];
        let geo = GeoTransform { x0: 500_000.0, y0: 5_330_000.0, step_x: 10.0, step_y: 10.0 };
        let bytes = geotiff_bytes(SIDE, SIDE, &bands, &geo, Some(System::Epsg(32633)), f32::NAN).expect("a raster");
        folder.write(&format!("{model}.tif"), bytes);
    }
    grey_8_png(&folder.path("frame.png"), &texture((96, 96), (0.0, 0.0)));
    let rows: String = (0..3).map(|at| format!("frame.png,{},5329400,100,0,0,0\n", 500_600 + 10 * at)).collect();
    folder.write("frames.csv", format!("file,east_m,north_m,height_m,heading_deg,pitch_deg,roll_deg\n{rows}"));
    folder
}

#[test]
fn every_verb_asks_about_heights_that_are_hardly_metres() {
    let folder = scene("doubts");
    for verb in [
        "tiles --ortho ground.tif --resolution-m 5 --out tiles.bin".to_owned(),
        "fly --ground ground.tif --frames 2 --out out".to_owned(),
        format!("evaluate --frames frames.csv {TAKEN}"),
        "rectify --camera camera.toml --frame frame.png --omega-deg 0 --phi-deg 0 --kappa-deg 0 --east-m 500600 \
         --north-m 5329400 --up-m 300 --epsg 32633 --resolution-m 5 --out p.png"
            .to_owned(),
    ] {
        let over = |model: &str| folder.run(&format!("{verb} --dem {model}.tif")).done().stderr;
        let asked = over("metres");
        assert!(!asked.contains("elevation model"), "{verb}: {asked}");
        for (model, why) in [("kilometres", "flatter than measured ground"), ("zero", "0 throughout")] {
            let asked = over(model);
            let wanted = format!("{model}.tif: the elevation model is {why}");
            assert_eq!(asked.matches(&wanted).count(), 1, "{verb}: {asked}");
        }
    }
    let asked =
        folder.run("tiles --ortho ground.tif --resolution-m 5 --dem centimetres.tif --out tiles.bin").done().stderr;
    assert!(asked.contains("centimetres.tif: the elevation model is steeper than ground is"), "{asked}");
}

/// Where such heights leave nothing to fly over, the refusal has them too.
#[test]
fn a_flight_that_heights_make_impossible_names_them() {
    let folder = scene("doubts-flight");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(
        "fly --ground ground.tif --dem centimetres.tif --frames 2 --out out",
        &["smaller than the footprint", "centimetres.tif: the elevation model is steeper than ground is"],
    );
    refusals.done();
}
