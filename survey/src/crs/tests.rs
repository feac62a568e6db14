//! What is refused, and that points far off are. Accuracy against another library is in `tests/crs.rs`.

use super::*;

#[test]
fn doubtful_systems_are_refused_with_code_and_reason() {
    for (epsg, reason) in [
        (0, "not in the list"),
        (99_999, "not in the list"),
        (32_767, "not in the list"),
        (4267, "grid file"),             // NAD27
        (26_714, "grid file"),           // NAD27 / UTM 14N
        (27_200, "grid file"),           // NZGD49, grid of New Zealand
        (6344, "not known"),             // NAD83(2011) / UTM 15N: no shift in the list
        (4230, "not known for certain"), // ED50: one shift for all of Europe
        (3844, "not known for certain"), // Stereo 70: the shift listed is 34 m off
        (2082, "not known for certain"), // Pampa del Castillo: 260 m off
        (31_278, "deprecated"),          // MGI / Balkans zone 8, with Austria's shift: 140 m off
        (31_291, "deprecated"),          // and from Ferro
        (27_572, "Greenwich"),           // NTF (Paris) / Lambert zone II
        (4807, "not in degrees"),        // NTF (Paris): grads
        (2263, "not in metres"),         // US survey feet
        (3857, "not conformal"),         // Web Mercator
        (3035, "laea"),                  // equal area
        (5070, "aea"),                   // equal area
        (5514, "krovak"),
        (2046, "axis"),            // Hartebeesthoek94 / Lo15: west and south axes
        (4978, "two dimensions"),  // geocentric
        (4979, "two dimensions"),  // three-dimensional
        (5555, "two dimensions"),  // compound
        (5773, "not in the list"), // vertical
    ] {
        let sentence = Crs::from_epsg(epsg).expect_err(&epsg.to_string()).to_string();
        assert!(sentence.contains(&format!("EPSG:{epsg}")), "{sentence}");
        assert!(sentence.contains(reason), "{sentence}");
    }
}

#[test]
fn every_code_answers_and_the_accepted_ones_are_those_that_were_compared() {
    let accepted = (0..=70_000).filter_map(|epsg| Crs::from_epsg(epsg).ok()).count();
    // Compared with PROJ one by one; a change of the list of definitions calls for the comparison again.
    assert_eq!(accepted, 2424);
}

#[test]
fn points_far_off_are_refused() {
    let utm = Crs::from_epsg(32633).expect("UTM");
    for (x, y) in [(f64::NAN, 0.0), (0.0, f64::INFINITY), (1e9, 0.0), (500_000.0, 1e8)] {
        assert!(utm.to_wgs84(x, y).is_err(), "{x} {y}");
        assert!(utm.convergence_rad(x, y).is_err());
        assert!(utm.point_scale(x, y).is_err());
    }
    for (lat, lon) in [(91.0, 15.0), (-90.1, 15.0), (48.0, 400.0), (f64::NAN, 15.0), (0.0, 105.0)] {
        assert!(utm.from_wgs84(lat, lon).is_err(), "{lat} {lon}");
    }
    let wgs84 = Crs::from_epsg(4326).expect("WGS 84");
    assert!(wgs84.to_wgs84(16.0, 91.0).is_err());
    assert!(wgs84.to_wgs84(f64::NAN, 48.0).is_err());
    assert_eq!(wgs84.convergence_rad(16.0, 48.0), Ok(0.0));
    assert!(wgs84.point_scale(16.0, 48.0).is_err());
    assert!(utm.convergence_rad(500_000.0, 9_997_000.0).is_err(), "near the pole");
}

#[test]
fn longitudes_beyond_180_are_the_same_place() {
    let wgs84 = Crs::from_epsg(4326).expect("WGS 84");
    let (lat, lon) = wgs84.to_wgs84(200.0, 10.0).expect("wrapped");
    assert!((lat - 10.0).abs() < 1e-12 && ((lon - 200.0).abs() < 1e-9 || (lon + 160.0).abs() < 1e-9));
    let utm = Crs::from_epsg(32701).expect("UTM 1S");
    let east = utm.from_wgs84(-18.0, 181.0).expect("east");
    let west = utm.from_wgs84(-18.0, -179.0).expect("west");
    assert!((east.0 - west.0).abs() < 1e-6 && (east.1 - west.1).abs() < 1e-6);
}
