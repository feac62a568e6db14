//! What was likely meant by an area that does not lie on the elevation model or the orthophoto.

use crate::verbs::finite;
use plumbline_survey::crs::{Crs, System};
use plumbline_survey::io::geojson;
use plumbline_survey::io::raster::for_people;
use std::path::Path;

/// The hint for the sentence that refuses `--area`, where another reading of it lies on a model or picture of `system`; else nothing.
pub fn hint(area: &str, system: Option<System>, is_on_model: impl Fn([f64; 4]) -> bool) -> String {
    let numbers: Result<Vec<f64>, String> = area.split(',').map(|part| finite(part.trim())).collect();
    let Ok([a, b, c, d]) = numbers.as_deref() else {
        return geojson::swapped(Path::new(area), system, |[x, y]| is_on_model([x, y, x, y])).to_owned();
    };
    let readings = [
        ("its numbers are y before x, or the latitude before the longitude", Some([*b, *a, *d, *c])),
        ("its numbers are X0,X1,Y0,Y1", Some([*a, *c, *b, *d])),
        ("its numbers are degrees, longitude first, and the grid is in metres", on_grid(system, [*a, *b, *c, *d])),
        ("its numbers are degrees, latitude first, and the grid is in metres", on_grid(system, [*b, *a, *d, *c])),
    ];
    let is_area = |[x0, y0, x1, y1]: [f64; 4]| x0 < x1 && y0 < y1;
    let found = readings.into_iter().filter_map(|(what, bounds)| Some((what, bounds?)));
    let found = found.into_iter().find(|(_, bounds)| is_area(*bounds) && is_on_model(*bounds));
    let is_in_degrees = system.is_some_and(|system| Crs::new(system).is_ok_and(|crs| crs.is_geographic()));
    let other = match is_in_degrees && [a, b, c, d].iter().any(|number| number.abs() > 360.0) {
        true => "; its grid is in degrees, and so is --area: west, south, east, north, or a GeoJSON file".to_owned(),
        false => String::new(),
    };
    found.map_or(other, |(what, bounds)| {
        let typed = bounds.map(|bound| for_people(bound).to_string()).join(",");
        format!("; if {what}, type --area {typed}")
    })
}

/// Bounds in degrees (longitude and latitude, twice) on the model's grid; `None` where it has none in metres, or not there.
fn on_grid(system: Option<System>, [lon0, lat0, lon1, lat1]: [f64; 4]) -> Option<[f64; 4]> {
    let crs = Crs::new(system?).ok().filter(|crs| !crs.is_geographic())?;
    let is_place = |lat: f64, lon: f64| lat.abs() <= 90.0 && lon.abs() <= 360.0;
    if !is_place(lat0, lon0) || !is_place(lat1, lon1) {
        return None;
    }
    let ((x0, y0), (x1, y1)) = (crs.from_wgs84(lat0, lon0).ok()?, crs.from_wgs84(lat1, lon1).ok()?);
    Some([x0, y0, x1, y1])
}
