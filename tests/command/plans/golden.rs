//! Golden values of the reference over the portable elevation model, through the command.

use super::planned::{plan, scratch};
use super::terrain::Terrain;

const AREA: &str = "--area 500,500,6300,1900 --height-m 555 --speed-m-s 55";

fn near(found: f64, golden: f64, digits: i32) {
    assert!((found - golden).abs() <= 0.51 * 10f64.powi(-digits), "{found} is not {golden}");
}

#[test]
fn strips_photos_bases_and_overlaps() {
    let folder = scratch("golden");
    let terrain = Terrain::portable(&folder);
    let sixty = plan(&folder, &terrain, &format!("{AREA} --overlap 60/30"));
    near(sixty.json["base_height_m"].as_f64().expect("a number"), 96.353_455_352, 9);
    let counts: Vec<usize> = sixty.strips.iter().map(|(_, photos)| photos.len()).collect();
    assert_eq!(counts, [17, 17, 16, 17]);
    for ((_, photos), y) in sixty.strips.iter().zip([500.0, 1_026.543_760, 1_504.010_117, 1_979.204_286]) {
        photos.iter().for_each(|photo| near(photo[1], y, 6));
    }
    let x = [20.48, 442.603_796, 851.400_675, 1_260.027_872, 1_668.655_069, 2_085.595_625];
    sixty.strips[0].1.iter().zip(x).for_each(|(photo, x)| near(photo[0], x, 6));
    let least = |photos: &[[f64; 2]]| photos.windows(2).map(|pair| pair[1][0] - pair[0][0]).fold(f64::MAX, f64::min);
    near(sixty.strips.iter().map(|(_, photos)| least(photos)).fold(f64::MAX, f64::min), 407.309_288_063, 9);
    near(sixty.json["overlap_min"]["forward"].as_f64().expect("pairs"), 0.6, 9);
    near(sixty.json["overlap_min"]["side"].as_f64().expect("pairs"), 0.3, 9);

    let eighty = plan(&folder, &terrain, &format!("{AREA} --overlap 80/60"));
    assert_eq!((eighty.strips.len(), eighty.json["photo_count"].as_u64()), (7, Some(212)));
    near(eighty.strips.iter().map(|(_, photos)| least(photos)).fold(f64::MAX, f64::min), 203.654_644_031, 9);

    // The scale says the same height: 555 m with f = 50 mm.
    let scaled = plan(&folder, &terrain, "--area 500,500,6300,1900 --scale 11100 --speed-m-s 55 --overlap 60/30");
    assert_eq!(scaled.strips.len(), 4);
    near(scaled.height, 555.0, 9);
}

#[test]
fn level_ground() {
    let folder = scratch("level");
    let terrain = Terrain::made_up(&folder, [161, 61], |_, _| 42.0);
    for (overlap, lines, photos) in [("60/30", 4, 64), ("80/60", 6, 168)] {
        let plan = plan(&folder, &terrain, &format!("--area 1000,500,6800,1900 --height-m 555 --overlap {overlap}"));
        assert_eq!((plan.strips.len(), plan.json["photo_count"].as_u64()), (lines, Some(photos)));
        assert_eq!(plan.json["constant_base"]["photos_saved"].as_i64().map(|saved| saved <= 0), Some(true));
    }
}

#[test]
fn opposite_headings_have_the_same_strips_and_lines_are_flown_there_and_back() {
    let folder = scratch("headings");
    let terrain = Terrain::portable(&folder);
    let east = plan(&folder, &terrain, &format!("{AREA} --overlap 60/30"));
    let west = plan(&folder, &terrain, &format!("{AREA} --overlap 60/30 --strip-heading-deg 270"));
    assert_eq!(east.json["strips"], west.json["strips"]);
    let headings: Vec<f64> = east.json["strips"]
        .as_array()
        .expect("strips")
        .iter()
        .filter_map(|strip| strip["heading_deg"].as_f64())
        .collect();
    assert_eq!(headings, [90.0, 270.0, 90.0, 270.0]);
}
