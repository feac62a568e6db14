//! One made-up geoid in all formats: a plane in latitude and longitude, which is what bilinear interpolation gives exactly.

use super::*;
use crate::crs::System;
use crate::io::output::tests::scratch;
use crate::io::raster::{Band, GeoTransform, geotiff_bytes};
use std::path::PathBuf;

/// Metres; longitudes from -180.
fn height(lat: f64, lon: f64) -> f64 {
    40.0 + 0.25 * lat - 0.125 * lon
}

/// GTX of a grid of 15 minutes from a corner.
fn gtx([south, west]: [f64; 2], (cols, rows): (i32, i32), height: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let mut bytes: Vec<u8> = [south, west, 0.25, 0.25].iter().flat_map(|number| number.to_be_bytes()).collect();
    bytes.extend(rows.to_be_bytes());
    bytes.extend(cols.to_be_bytes());
    for index in 0..cols * rows {
        let (lat, lon) = (south + 0.25 * f64::from(index / cols), west + 0.25 * f64::from(index % cols));
        bytes.extend((height(lat, lon) as f32).to_be_bytes());
    }
    bytes
}

/// GeographicLib's PGM of the whole Earth in steps of a degree.
fn pgm() -> Vec<u8> {
    let head = "P5\n# Geoid file in PGM format for the GeographicLib::Geoid class\n# Description made up\n# Offset -108\n# Scale 0.003125\n\
                # Origin 90N 0E\n# AREA_OR_POINT Point\n360 181\n65535\n";
    let mut bytes = head.as_bytes().to_vec();
    for index in 0..360 * 181 {
        let (lat, lon) = (90.0 - f64::from(index / 360), f64::from(index % 360));
        let lon = if lon >= 180.0 { lon - 360.0 } else { lon };
        bytes.extend((((height(lat, lon) + 108.0) / 0.003_125).round() as u16).to_be_bytes());
    }
    bytes
}

fn geotiff(path: &str, system: Option<System>) -> PathBuf {
    let path = scratch("geoid-tiff").join(path);
    let samples: Vec<f32> =
        (0..80 * 60).map(|k| height(50.0 - 0.25 * f64::from(k / 80), 5.0 + 0.25 * f64::from(k % 80)) as f32).collect();
    let geo = GeoTransform { x0: 5.0, y0: 50.0, step_x: 0.25, step_y: 0.25 };
    let band = Band { description: "geoid_undulation", samples: &samples };
    std::fs::write(&path, geotiff_bytes(80, 60, &[band], &geo, system, -9999.0).expect("a raster")).expect("written");
    path
}

#[test]
fn all_formats_have_the_same_heights() {
    let folder = scratch("geoid");
    let (whole, part, grid) = (folder.join("whole.GTX"), folder.join("part.gtx"), folder.join("grid.pgm"));
    std::fs::write(&whole, gtx([-90.0, -180.0], (1440, 721), height)).expect("written");
    std::fs::write(&part, gtx([40.0, 5.0], (60, 60), height)).expect("written");
    std::fs::write(&grid, pgm()).expect("written");
    for path in [&whole, &part, &grid, &geotiff("grid.tif", Some(System::Epsg(4326)))] {
        let geoid = Geoid::over(path, [11.1, 47.9, 11.3, 48.2]).expect("a geoid");
        for (lat, lon) in [(47.9, 11.1), (48.0, 11.25), (48.13, 11.171), (48.2, 11.3)] {
            let found = geoid.height_m(lat, lon).expect("covered");
            assert!((found - height(lat, lon)).abs() < 1e-5, "{}: {found} {}", path.display(), height(lat, lon));
        }
        assert_eq!(geoid.height_m(44.0, 11.2), None);
        let [least, most] = geoid.range_m();
        assert!(
            (least - height(47.9, 11.3)).abs() < 1e-5 && (most - height(48.2, 11.1)).abs() < 1e-5,
            "{least} {most}"
        );
    }
    // West of Greenwich, where GeographicLib's grid begins, and on both sides of it.
    for area in [[-70.4, -30.2, -70.1, -30.0], [-0.3, 51.0, 0.4, 51.2]] {
        let geoid = Geoid::over(&grid, area).expect("a geoid");
        for lon in [area[0], 0.3 * area[0] + 0.7 * area[2]] {
            let found = geoid.height_m(area[1], lon).expect("covered");
            assert!((found - height(area[1], lon)).abs() < 1e-5, "{lon}: {found}");
        }
    }
}

#[test]
fn a_grid_around_the_earth_has_no_seam() {
    let folder = scratch("geoid-seam");
    let wave = |lat: f64, lon: f64| 0.1 * lat + 30.0 * lon.to_radians().sin();
    for (name, cols) in [("open.gtx", 1440), ("closed.gtx", 1441)] {
        let path = folder.join(name);
        std::fs::write(&path, gtx([-90.0, -180.0], (cols, 721), wave)).expect("written");
        let geoid = Geoid::over(&path, [179.6, -20.0, 180.4, -19.5]).expect("a geoid");
        for lon in [179.75, 180.0, 180.25] {
            let found = geoid.height_m(-19.75, lon).expect("covered");
            assert!((found - wave(-19.75, lon)).abs() < 1e-5, "{name} {lon}: {found}");
        }
    }
}

#[test]
fn what_is_no_geoid_of_the_place_is_refused() {
    let folder = scratch("geoid-refused");
    let munich = [11.1, 47.9, 11.3, 48.2];
    let refused = |name: &str, bytes: &[u8], says: &str| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).expect("written");
        let error = Geoid::over(&path, munich).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains(says), "{name}: {error}");
    };
    let whole = gtx([40.0, 5.0], (60, 60), height);
    refused("short.gtx", &whole[..whole.len() - 5], "ends early");
    refused("other.bin", &whole, "no GTX file, no PGM file");
    refused("head.gtx", &whole[..30], "no GTX file");
    refused("zero.gtx", &[0; 400], "header is none of a GTX");
    refused("beside.gtx", &gtx([0.0, 5.0], (60, 60), height), "does not cover");
    refused("edge.gtx", &gtx([40.0, 5.0], (60, 33), height), "does not cover");
    refused("holes.gtx", &gtx([40.0, 5.0], (60, 60), |_, _| -88.8888), "without a height");
    refused("model.gtx", &gtx([40.0, 5.0], (60, 60), |_, _| 520.0), "is it an elevation model?");
    refused("picture.pgm", b"P5\n4 4\n255\n0123456789abcdef", "none of GeographicLib's");
    refused("cut.pgm", b"P5\n# Offset -108\n# Scale 0.003\n1440", "none of GeographicLib's");
    refused("short.pgm", &pgm()[..5000], "ends early");
    let on_grid = geotiff("grid.tif", Some(System::Epsg(32633)));
    assert!(Geoid::over(&on_grid, munich).is_err());
    let local = geotiff("local.tif", None);
    assert!(Geoid::over(&local, munich).expect_err("no system").to_string().contains("not in degrees"));
    assert!(Geoid::over(&folder.join("missing.gtx"), munich).is_err());
}
