//! `plumbline rectify` of frames of known position and attitude, over their terrain.

use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_survey::crs::System;
use plumbline_survey::io::raster::{Band, GeoTransform, Raster, geotiff_bytes};
use plumbline_tests::vectors::number;

const EAST: f64 = 500_000.0;
const NORTH: f64 = 5_200_000.0;
/// A vertical frame whose upper edge is in the north.
const CALL: &str = "rectify --camera camera.toml --frame frame.png --omega-deg 0 --phi-deg 0 --kappa-deg 0 --resolution-m 2 \
     --east-m 500000 --north-m 5200000 --up-m 600 --dem dem.tif --out out.tif --mask mask.png --json";

/// A scene with level ground at 500 m, or what `height` says of a place east and north of the camera.
fn scene(name: &str, height: impl Fn(f64, f64) -> f64) -> Folder {
    let folder = Folder::with_scene(name);
    let geo = GeoTransform { x0: EAST - 500.0, y0: NORTH + 500.0, step_x: 10.0, step_y: 10.0 };
    let of = |at: usize| {
        let (east, north) = geo.world_from_pixel((at % 101) as f64, (at / 101) as f64);
        height(east - EAST, north - NORTH) as f32
    };
    let samples: Vec<f32> = (0..101 * 101).map(of).collect();
    let bands = [Band { description: "height", samples: &samples }];
    let write = |name: &str, system| {
        folder.write(name, geotiff_bytes(101, 101, &bands, &geo, system, f32::NAN).expect("a raster"));
    };
    write("dem.tif", Some(System::Epsg(32633)));
    write("nowhere.tif", None);
    folder
}

#[test]
fn the_geotiff_lies_where_the_camera_is() {
    let folder = scene("oriented-place", |_, _| 500.0);
    let summary = folder.run(CALL).json();
    assert_eq!(
        ["height_m", "east_m", "north_m", "epsg"].map(|key| number(&summary, key)),
        [100.0, EAST, NORTH, 32633.0]
    );
    assert!(summary["follow_up_deg"].is_null(), "{summary}");
    let raster = Raster::read(&folder.path("out.tif")).expect("a raster");
    assert_eq!((raster.crs, raster.nodata, raster.bands), (Some(System::Epsg(32633)), Some(0.0), 1));
    let middle = raster.geo.world_from_pixel(0.5 * (raster.cols as f64 - 1.0), 0.5 * (raster.rows as f64 - 1.0));
    assert_eq!((middle, raster.geo.step_x, raster.geo.step_y), ((EAST, NORTH), 2.0, 2.0));
    // The same by a vehicle's angles over a plane, but for the way of averaging.
    let plane = "rectify --camera camera.toml --frame frame.png --heading-deg 0 --pitch-deg 0 --roll-deg 0 --height-m 100 \
         --resolution-m 2 --east-m 500000 --north-m 5200000 --epsg 32633 --out plane.tif --json";
    let run = folder.run(plane).done();
    assert!(run.stderr.contains("--dem"), "who gives a position is told that the ground is level: {}", run.stderr);
    let other = Raster::read(&folder.path("plane.tif")).expect("a raster");
    assert_eq!((other.cols, other.rows, other.geo), (raster.cols, raster.rows, raster.geo));
    let both: Vec<f32> = raster
        .data
        .iter()
        .zip(&other.data)
        .filter(|(one, other)| **one > 0.0 && **other > 0.0)
        .map(|(one, other)| (one - other).abs())
        .collect();
    let mean = both.iter().sum::<f32>() / both.len() as f32;
    assert!(both.len() > 1000 && mean < 3.0, "{mean} over {}", both.len());
}

/// Ground that rises to the east by one in two is seen further out than a plane at its height below the camera has it.
#[test]
fn each_pixel_has_its_own_height() {
    let folder = scene("oriented-relief", |east, _| 500.0 + 0.5 * east.clamp(-60.0, 60.0));
    folder.run(CALL).done();
    let over_model = Raster::read(&folder.path("out.tif")).expect("a raster");
    folder.run(&CALL.replace(" --up-m 600 --dem dem.tif", " --epsg 32633 --height-m 100")).done();
    let over_plane = Raster::read(&folder.path("out.tif")).expect("a raster");
    let row = over_model.rows / 2;
    let at = |raster: &Raster, col: usize| raster.sample(col, row, 0);
    // 25 pixels east of the nadir the ground is 25 m higher: seen at a tangent of 50 / 75, which the plane has at 66.7 m.
    let (middle, apart) = (0.5 * (over_model.cols as f64 - 1.0), |one: f32, other: f32| (one - other).abs());
    let (col, on_plane) = ((middle + 20.0) as usize, middle + 40.0 / 0.8 / 2.0);
    let (low, share) = (on_plane.floor() as usize, on_plane.fract() as f32);
    let wanted = at(&over_plane, low).zip(at(&over_plane, low + 1)).map(|(a, b)| a * (1.0 - share) + b * share);
    let (found, wanted) = (at(&over_model, col).expect("seen"), wanted.expect("seen"));
    assert!(apart(found, wanted) < 12.0, "{found} {wanted}");
}

#[test]
fn what_is_missing_or_mixed_is_told() {
    let folder = scene("oriented-bad", |_, _| 500.0);
    let mut refusals = Refusals::new(&folder);
    let mut expect = |from: &str, to: &str, names: &[&str]| refusals.expect(&CALL.replace(from, to), names);
    expect(" --omega-deg 0 --phi-deg 0 --kappa-deg 0", "", &["--heading-deg", "--omega-deg"]);
    expect(" --phi-deg 0", "", &["--phi-deg"]);
    expect("--omega-deg 0", "--omega-deg 100", &["--omega-deg 100", "horizon"]);
    expect(
        "--kappa-deg 0",
        "--kappa-deg 0 --heading-deg 3 --pitch-deg 0 --roll-deg 0",
        &["--omega-deg", "--heading-deg"],
    );
    expect(" --north-m 5200000", "", &["--north-m"]);
    expect(" --up-m 600", "", &["--up-m"]);
    expect(" --up-m 600 --dem dem.tif", "", &["--height-m", "--dem"]);
    expect("--up-m 600", "--up-m 400", &["--up-m 400", "dem.tif", "500.0 m"]);
    expect("--up-m 600", "--up-m 600 --height-m 100", &["--height-m", "--dem"]);
    expect("--east-m 500000", "--east-m 510000", &["dem.tif"]);
    expect("--dem dem.tif", "--dem dem.tif --epsg 4326", &["EPSG:4326", "degrees"]);
    expect("--dem dem.tif", "--dem dem.tif --epsg 99999", &["99999"]);
    expect("--dem dem.tif", "--dem none.tif", &["none.tif"]);
    expect("--out out.tif", "--out dem.tif", &["--out", "--dem"]);
    expect("--out out.tif", "--out out.jpg", &["--out", ".png"]);
    let plain = "rectify --camera camera.toml --frame frame.png --heading-deg 0 --pitch-deg 0 --roll-deg 0 --height-m 100 \
         --resolution-m 2 --out out.tif --json";
    refusals.expect(plain, &["--out", "--east-m"]);
    refusals.done();
}

#[test]
fn a_model_without_a_system_is_on_the_grid() {
    let folder = scene("oriented-local", |_, _| 500.0);
    let summary = folder.run(&CALL.replace("dem.tif", "nowhere.tif")).json();
    assert!(summary.get("epsg").is_none(), "{summary}");
    assert_eq!(Raster::read(&folder.path("out.tif")).expect("a raster").crs, None);
}

/// UTM zone 33 about another meridian, as ESRI writes it.
const ABOUT_15_5: &str = "PROJCS[\"x\",GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,298.257223563]],\
    PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],\
    PARAMETER[\"False_Easting\",500000.0],PARAMETER[\"False_Northing\",0.0],PARAMETER[\"Central_Meridian\",15.5],\
    PARAMETER[\"Scale_Factor\",0.9996],PARAMETER[\"Latitude_Of_Origin\",0.0],UNIT[\"Meter\",1.0]]";

/// A system that its file spells out serves where places are compared, and is refused where its code has to be written.
#[test]
fn a_system_without_a_code_is_kept() {
    let folder = scene("oriented-user-defined", |_, _| 500.0);
    let rows = vec!["500 ".repeat(101); 101].join("\n");
    let head = "ncols 101\nnrows 101\nxllcenter 499500\nyllcenter 5199500\ncellsize 10\n";
    folder.write("dem.asc", format!("{head}{rows}\n"));
    folder.write("dem.prj", ABOUT_15_5);
    let call = CALL.replace("dem.tif", "dem.asc");
    let patch = call.replace("--json", "--cols 35 --rows 35 --json");
    assert!(folder.run(&patch).json().get("epsg").is_none(), "it has no code");
    let written = Raster::read(&folder.path("out.tif")).expect("a raster");
    assert!(matches!(written.crs, Some(System::UserDefined(_))), "{:?}", written.crs);

    folder.run(&call.replace("out.tif", "map.tif")).done();
    let find = "match --patch out.tif --reference map.tif --search-px 4 --json";
    let found = folder.run(find).json();
    assert!((number(&found, "east_m") - EAST).abs() < 0.1, "{found}");

    let mut refusals = Refusals::new(&folder);
    folder.run(&patch.replace("dem.asc", "dem.tif").replace("out.tif", "grid_33.tif")).done();
    folder.run(&CALL.replace("out.tif", "map_33.tif")).done();
    let other = find.replace("map.tif", "map_33.tif");
    refusals.expect(&other, &["+lon_0=15.5", "gdalwarp -t_srs EPSG:32633"]);
    let other = find.replace("out.tif", "grid_33.tif");
    refusals.expect(&other, &["gdalwarp -t_srs '+proj=tmerc +lon_0=15.5", "+datum=WGS84"]);
    refusals.expect("tiles --ortho map.tif --resolution-m 2 --out tiles.bin", &["map.tif", "user-defined", "gdalwarp"]);
    let plan = "plan --dem dem.asc --area 499800,5199800,500200,5200200 --camera camera.toml --height-m 100 --overlap 60/30 --out out";
    refusals.expect(plan, &["dem.asc", "user-defined", "gdalwarp -t_srs EPSG:32633"]);
    refusals.done();
}
