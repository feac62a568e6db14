//! Elevation models as their files describe them: what their heights are above, how many posts they leave without one, how samples become heights.

use crate::folder::Folder;
use crate::pictures::heights;
use crate::refusals::Refusals;

const TILES: &str = "tiles --ortho ground.tif --resolution-m 10 --out tiles.bin --dem";
const PLAN: &str =
    "plan --area 500400,5329000,500700,5329300 --camera camera.toml --height-m 300 --overlap 60/30 --out out --dem";
/// GeoTIFF's number of the key of a vertical system.
const VERTICAL: u16 = 4096;

fn hills(col: usize, row: usize) -> f32 {
    160.0 + 20.0 * (col as f32 / 4.0).sin() + 15.0 * (row as f32 / 5.0).cos()
}

#[test]
fn a_tiles_heights_are_above_what_their_model_says() {
    let folder = Folder::with_ground("tile-heights");
    folder.write("camera.toml", crate::folder::CAMERA);
    heights(&folder.path("said.tif"), &[(VERTICAL, 5703)], [0.0; 2], hills);
    heights(&folder.path("unsaid.tif"), &[], [0.0; 2], hills);
    for (call, epsg) in [
        ("said.tif", 5703),
        ("said.tif --vertical-epsg 0", 5703),
        ("said.tif --vertical-epsg 5703", 5703),
        ("unsaid.tif --vertical-epsg 5773", 5773),
        ("unsaid.tif", 0),
    ] {
        assert_eq!(folder.run(&format!("{TILES} {call} --json")).json()["vertical_epsg"], epsg, "{call}");
    }
    assert!(folder.run(&format!("{TILES} said.tif")).done().stdout.contains("posts, above EPSG:5703"));
    let mut refusals = Refusals::new(&folder);
    refusals.expect(&format!("{TILES} said.tif --vertical-epsg 5773"), &["--vertical-epsg 5773", "EPSG:5703"]);
    for (epsg, why) in [
        (4326, "no vertical system"),
        (32633, "no vertical system"),
        (4979, "ellipsoid"),
        (5706, "depths"),
        (6360, "gdal_edit.py -units ft"),
    ] {
        refusals.expect(&format!("{TILES} unsaid.tif --vertical-epsg {epsg}"), &["--vertical-epsg", why]);
    }
    for code in [4979, 5030] {
        heights(&folder.path("ellipsoid.tif"), &[(VERTICAL, code)], [0.0; 2], hills);
        let line = "gdalwarp -t_srs EPSG:32633+3855 ellipsoid.tif ellipsoid_sea.tif";
        refusals.expect(&format!("{TILES} ellipsoid.tif"), &["above an ellipsoid", line]);
        refusals.expect(&format!("{PLAN} ellipsoid.tif"), &["above an ellipsoid", line, "--geoid FILE"]);
    }
    for code in [4326, 32633] {
        heights(&folder.path("flat.tif"), &[(VERTICAL, code)], [0.0; 2], hills);
        let said = format!("EPSG:{code}");
        let line = "gdal_translate -a_srs EPSG:32633+5773 flat.tif flat_vertical.tif";
        for verb in [TILES, PLAN] {
            refusals.expect(&format!("{verb} flat.tif"), &["flat.tif", &said, "no vertical system", line]);
        }
    }
    refusals.done();
}

#[test]
fn posts_without_a_height_are_told() {
    let folder = Folder::with_ground("tile-posts");
    heights(&folder.path("dem.tif"), &[], [0.0; 2], hills);
    let whole = folder.run(&format!("{TILES} dem.tif --posts-m 100")).done();
    assert!(whole.stdout.contains("15 x 15 posts, of a datum"), "{whole:?}");
    let west = |col: usize, row: usize| if col < 20 { hills(col, row) } else { f32::NAN };
    heights(&folder.path("west.tif"), &[], [0.0; 2], west);
    let half = folder.run(&format!("{TILES} west.tif --posts-m 100 --json")).json();
    // 15 columns around 500640: from the eighth on they are beyond 500625, the model's last post.
    assert_eq!((&half["posts"][0], &half["unknown_posts"]), (&15.into(), &(15 * 8).into()), "{half}");
    let half = folder.run(&format!("{TILES} west.tif --posts-m 100")).done();
    assert!(half.stdout.contains("15 x 15 posts, 120 of these 225 without a height, of"), "{half:?}");
    let mut refusals = Refusals::new(&folder);
    refusals.expect(
        &format!("{TILES} dem.tif --posts-m 1500"),
        &["dem.tif", "8 of 9 posts 1500 m apart", "a smaller --posts-m"],
    );
    refusals.done();
}

/// Programs do not agree on whether these tags are applied, and without them heights are too low by a factor.
#[test]
fn heights_that_the_pixel_scale_multiplies_are_refused() {
    let folder = Folder::with_ground("tile-scale");
    folder.write("camera.toml", crate::folder::CAMERA);
    let low = |col: usize, row: usize| 0.1 * hills(col, row);
    heights(&folder.path("ten.tif"), &[], [10.0, 0.0], low);
    heights(&folder.path("more.tif"), &[(VERTICAL, 5703)], [0.0, 50.0], low);
    heights(&folder.path("one.tif"), &[], [1.0, 0.0], hills);
    let mut refusals = Refusals::new(&folder);
    for verb in [TILES, PLAN] {
        let line = "gdal_calc.py -A ten.tif --calc='10*A.astype(float)+(0)' --type=Float64 --outfile=ten_scaled.tif";
        refusals.expect(&format!("{verb} ten.tif"), &["ten.tif", "10 times", line]);
        refusals.expect(&format!("{verb} more.tif"), &["more.tif", "50 more", "--calc='1*A.astype(float)+(50)'"]);
    }
    refusals.expect("fly --ground ground.tif --frames 2 --dem ten.tif", &["ten.tif", "10 times", "gdal_calc.py"]);
    refusals.done();
    folder.run(&format!("{TILES} one.tif")).done();
}
