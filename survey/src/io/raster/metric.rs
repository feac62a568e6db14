//! Whether a picture lies on a grid in metres with square pixels, and what to type where it does not.

use std::path::Path;

use super::GeoTransform;
use crate::crs::{Crs, System, radii_m};
use crate::error::InputError;
use crate::io::shell::names;

/// Web Mercator, EPSG:3857, and the codes that it went by before it had one.
const WEB_MERCATOR: [u32; 4] = [3857, 3785, 102_100, 900_913];
/// Radius of Web Mercator's sphere: the semi-major axis of WGS 84.
const SPHERE_M: f64 = 6_378_137.0;
/// Share by which the sides of a pixel may differ.
const SQUARE: f64 = 1e-6;

/// Refuses a picture of (columns, rows) pixels that is in degrees, in Web Mercator, or of pixels that are not square: a reference
/// tile has metres that are metres on the ground, alike in both directions.
///
/// # Errors
/// As [`check_metres`] and [`check_square`].
pub fn check_metric(path: &Path, geo: &GeoTransform, system: System, size: (usize, usize)) -> Result<(), InputError> {
    check_metres(path, geo, system, size)?;
    check_square(path, geo, "cubic")
}

/// Refuses pixels that are not square.
///
/// # Errors
/// One sentence with the command that makes square ones on the same grid, interpolated as `gdalwarp -r` names it.
pub fn check_square(path: &Path, geo: &GeoTransform, interpolation: &str) -> Result<(), InputError> {
    if (geo.step_x - geo.step_y).abs() <= SQUARE * geo.step_x {
        return Ok(());
    }
    let side_m = two_digits((geo.step_x * geo.step_y).sqrt());
    let line = line(path, &format!("-tr {side_m} {side_m} -r {interpolation}"), "square");
    Err(InputError::new(format!("{}: pixels of {} m are not square: {line}", path.display(), steps(geo))))
}

/// Refuses a picture of (columns, rows) pixels whose coordinates are no metres on the ground: degrees, or those of Web Mercator.
///
/// # Errors
/// One sentence with the command that makes a picture that is taken: `gdalwarp` to the UTM zone of its middle, with the size that its
/// pixels have on the ground.
pub fn check_metres(
    path: &Path,
    geo: &GeoTransform,
    system: System,
    (cols, rows): (usize, usize),
) -> Result<(), InputError> {
    let is_web = is_web_mercator(system);
    if !is_web && !Crs::new(system).is_ok_and(|crs| crs.is_geographic()) {
        return Ok(());
    }
    let (what, unit) = if is_web { ("in Web Mercator", "units") } else { ("in degrees", "degrees") };
    let name = path.display();
    let (x, y) = geo.world_from_pixel(0.5 * (cols as f64 - 1.0), 0.5 * (rows as f64 - 1.0));
    let (lat_deg, lon_deg) = if is_web { web_mercator(x, y) } else { (y, x) };
    if !(-90.0..=90.0).contains(&lat_deg) || !(-360.0..=360.0).contains(&lon_deg) {
        return Err(InputError::new(format!(
            "{name} is {what} ({system}), but its middle, {x}, {y}, is no place in it"
        )));
    }
    let cos = lat_deg.to_radians().cos();
    let sides_m = if is_web {
        [geo.step_x * cos, geo.step_y * cos]
    } else {
        let [meridian_m, across_m] = radii_m(lat_deg);
        [geo.step_x.to_radians() * across_m * cos, geo.step_y.to_radians() * meridian_m]
    };
    let side_m = two_digits((sides_m[0] * sides_m[1]).sqrt());
    let (utm, zone) = utm_zone(lat_deg, lon_deg);
    Err(InputError::new(format!(
        "{name} is {what} ({system}), with pixels of {} {unit}, which are {} x {} m on the ground; a grid in metres is needed: {}",
        steps(geo),
        two_digits(sides_m[0]),
        two_digits(sides_m[1]),
        line(path, &format!("-t_srs EPSG:{utm} -tr {side_m} {side_m} -r cubic"), &format!("utm{zone}"))
    )))
}

/// Whether a system is Web Mercator, whose metres are not those of the ground.
#[must_use]
pub fn is_web_mercator(system: System) -> bool {
    WEB_MERCATOR.map(System::Epsg).contains(&system)
}

fn steps(geo: &GeoTransform) -> String {
    let (x, y) = (short(geo.step_x), short(geo.step_y));
    if x == y && geo.step_x != geo.step_y {
        // The digits in which they differ.
        return format!("{} x {}", geo.step_x, geo.step_y);
    }
    format!("{x} x {y}")
}

/// EPSG code and number of the UTM zone of a place (WGS 84), without the exceptions of Norway and Svalbard.
#[must_use]
pub fn utm_zone(lat_deg: f64, lon_deg: f64) -> (u32, u32) {
    let zone = ((lon_deg + 180.0).rem_euclid(360.0) / 6.0).floor() as u32 + 1;
    (if lat_deg < 0.0 { 32_700 } else { 32_600 } + zone, zone)
}

/// The command line, with a name for what it makes.
fn line(path: &Path, options: &str, suffix: &str) -> String {
    format!("gdalwarp {options} {}", names(path, suffix))
}

/// Latitude and longitude of a place in Web Mercator.
fn web_mercator(x: f64, y: f64) -> (f64, f64) {
    ((y / SPHERE_M).sinh().atan().to_degrees(), (x / SPHERE_M).to_degrees())
}

/// For people: two digits that count.
fn two_digits(value: f64) -> f64 {
    if !value.is_finite() || value <= 0.0 {
        return value;
    }
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// For people: four digits that count, without an exponent.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(path: &str, (x0, y0): (f64, f64), (step_x, step_y): (f64, f64), epsg: u32) -> String {
        let geo = GeoTransform { x0, y0, step_x, step_y };
        check_metric(Path::new(path), &geo, System::Epsg(epsg), (1001, 1001)).expect_err("refused").to_string()
    }

    #[test]
    fn a_picture_in_degrees_is_told_its_zone_and_the_size_of_its_pixels() {
        // 1e-5 degrees at 48.2 degrees are 0.74 m east and 1.11 m north.
        let said = refused("o/a.tif", (16.3, 48.205), (1e-5, 1e-5), 4326);
        assert!(said.contains("0.74 x 1.1 m on the ground"), "{said}");
        assert!(said.ends_with("gdalwarp -t_srs EPSG:32633 -tr 0.91 0.91 -r cubic o/a.tif o/a_utm33.tif"), "{said}");
        let said = refused("my map.tif", (144.7, -37.8), (1e-6, 1e-6), 4326);
        assert!(said.ends_with("-t_srs EPSG:32755 -tr 0.099 0.099 -r cubic 'my map.tif' 'my map_utm55.tif'"), "{said}");
    }

    #[test]
    fn web_mercators_metres_are_not_those_of_the_ground() {
        // The value of EPSG's own example of method 1024: 24 22 54.433 N, 100 20 00.000 W.
        let (lat_deg, lon_deg) = web_mercator(-11_169_055.58, 2_800_000.0);
        assert!((lat_deg - 24.381_786_9).abs() < 1e-6 && (lon_deg + 100.333_333).abs() < 1e-6, "{lat_deg} {lon_deg}");
        let said = refused("a.tif", (1_818_000.0, 6_140_500.0), (1.0, 1.0), 3857);
        assert!(said.contains("0.67 x 0.67 m") && said.contains("-t_srs EPSG:32633 -tr 0.67 0.67"), "{said}");
    }

    #[test]
    fn pixels_that_are_not_square_stay_on_their_grid() {
        let said = refused("a.tif", (600_000.0, 5_340_000.0), (2.0, 2.2), 32633);
        assert!(said.ends_with("not square: gdalwarp -tr 2.1 2.1 -r cubic a.tif a_square.tif"), "{said}");
        let geo = GeoTransform { x0: 6e5, y0: 5.34e6, step_x: 2.0, step_y: 2.0 };
        check_metric(Path::new("a.tif"), &geo, System::Epsg(32633), (10, 10)).expect("taken");
        // Posts as a public elevation model has them.
        let posts = GeoTransform { step_x: 10.003_956, step_y: 10.004_087, ..geo };
        let said = check_square(Path::new("dem.tif"), &posts, "bilinear").expect_err("not square").to_string();
        assert!(said.ends_with("gdalwarp -tr 10 10 -r bilinear dem.tif dem_square.tif"), "{said}");
    }

    #[test]
    fn zones_are_those_of_the_map() {
        // Vienna, Jacksboro (Texas), Sydney, either side of the date line.
        let places = [(48.2, 16.4, 33), (33.2, -98.2, 14), (10.0, 180.0, 1), (10.0, 179.9, 60)];
        for (lat, lon, zone) in places {
            assert_eq!(utm_zone(lat, lon), (32_600 + zone, zone));
        }
        assert_eq!(utm_zone(-33.9, 151.2), (32_756, 56));
    }
}
