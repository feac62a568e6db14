//! Files of other programs, units and places, each refused with what makes one that is read.

use crate::folder::Folder;
use crate::pictures::{Crs, geotiff, texture};
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes};

#[test]
fn pictures_of_another_format_are_told_what_converts_them() {
    let folder = Folder::with_scene("foreign-formats");
    folder.write("map.vrt", "<VRTDataset rasterXSize=\"9\" rasterYSize=\"9\"/>");
    folder.write("map.jp2", b"\0\0\0\x0CjP  \r\n\x87\n\0\0\0\0");
    folder.write("map of it.img", b"EHFA_HEADER_TAG\0\0\0");
    folder.write("empty.tif", "");
    let mut refusals = Refusals::new(&folder);
    let mut refuse = |ortho: &str, names: &[&str]| {
        refusals.expect(&format!("tiles --ortho {ortho} --resolution-m 5 --out t.bin"), names);
        refusals.expect(&format!("fly --ground {ortho} --frames 1"), names);
    };
    for (file, made) in [("frame.png", "frame_made.tif"), ("map.vrt", "map_made.tif"), ("map.jp2", "map_made.tif")] {
        refuse(file, &["it is not a TIFF file: ", &format!("gdal_translate {file} {made} makes one")]);
    }
    refuse("empty.tif", &["cannot read empty.tif: it is empty"]);
    refuse("camera.toml", &["camera.toml: it is not a TIFF file\n"]);
    refusals.expect(
        "rectify --camera camera.toml --frame map.jp2 --heading-deg 0 --pitch-deg 0 --roll-deg 0 --height-m 9 --resolution-m 1 --out p.png",
        &["gdal_translate map.jp2 map_made.tif makes one"],
    );
    refusals.expect(
        "evaluate --frames frame.png --camera camera.toml --reference frame.png --out out",
        &["cannot read frame.png: it is no text (UTF-8)"],
    );
    refusals.done();
}

/// Coordinates in US survey feet, whose code stands in the place of the reference system's.
#[test]
fn an_orthophoto_in_feet_is_told_how_to_become_one_in_metres() {
    let folder = Folder::with_ground("foreign-feet");
    let mut bytes = folder.read("ground.tif");
    // Keys 3072 and 3076: system and unit of projected coordinates.
    let entry =
        |key: u16, value: u16| [key, 0, 1, value].iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let (system, unit) = (entry(3072, 32633), entry(3076, 9003));
    let at = bytes.windows(8).position(|window| window == system).expect("the system's key");
    bytes[at..at + 8].copy_from_slice(&unit);
    folder.write("feet.tif", bytes);
    let line = "gdalwarp -t_srs EPSG:CODE -r cubic feet.tif feet_metres.tif";
    let mut refusals = Refusals::new(&folder);
    refusals.expect("tiles --ortho feet.tif --resolution-m 5 --out t.bin", &["not in metres (EPSG unit 9003)", line]);
    refusals.expect("fly --ground feet.tif --frames 1", &[line]);
    refusals.done();
}

#[test]
fn a_model_of_another_place_says_where_it_lies() {
    let folder = Folder::with_scene("foreign-place");
    geotiff(&folder.path("ground.tif"), &texture((256, 256), (0.0, 0.0)), 5.0, Crs::Projected(32633));
    let model = |epsg: u32, [x0, y0]: [f64; 2], step: f64| {
        let bands = [Band { description: "height", samples: &[150.0; 60 * 60] }];
        let geo = GeoTransform { x0, y0, step_x: step, step_y: step };
        geotiff_bytes(60, 60, &bands, &geo, Some(System::Epsg(epsg)), f32::NAN).expect("a raster")
    };
    folder.write("degrees.tif", model(4326, [-84.5, 36.5], 0.005));
    folder.write("metres.tif", model(32633, [600_000.0, 5_300_000.0], 10.0));
    let mut refusals = Refusals::new(&folder);
    let tiles = |dem: &str| format!("tiles --ortho ground.tif --dem {dem} --resolution-m 5 --out t.bin");
    refusals.expect(
        &tiles("degrees.tif"),
        &["the area 14.99", "which has -84.5,36.205,-84.205,36.5 in EPSG:4326, longitude first"],
    );
    refusals.expect(&tiles("metres.tif"), &["which has 600000,5299410,600590,5300000 in EPSG:32633"]);
    refusals.done();
}
