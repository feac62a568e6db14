//! The area that a tile is to cover: `X0,Y0,X1,Y1` in metres of the orthophoto's grid, or a GeoJSON file.
//!
//! GeoJSON is in longitude and latitude on WGS 84 and nothing else (RFC 7946); of its polygons the bounding box on the grid
//! is taken.

use crate::world::Bounds;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use serde_json::Value;
use std::path::Path;

/// The area that `text` names on the grid of `crs`.
///
/// # Errors
/// One sentence for numbers that are none, corners that are one, and a file that is missing or holds no polygon.
pub fn area(text: &str, crs: &Crs) -> Result<Bounds, InputError> {
    let points = match corners(text) {
        Some(points) => points.to_vec(),
        None => polygon(Path::new(text), crs)?,
    };
    let fold = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| points.iter().map(|p| p[axis]).fold(start, pick);
    let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
    let bounds = Bounds {
        west_m: fold(0, low, f64::min),
        east_m: fold(0, high, f64::max),
        south_m: fold(1, low, f64::min),
        north_m: fold(1, high, f64::max),
    };
    if bounds.east_m > bounds.west_m && bounds.north_m > bounds.south_m {
        Ok(bounds)
    } else {
        Err(InputError::new(format!("--area {text}: it has no extent")))
    }
}

/// Four finite numbers: two corners.
fn corners(text: &str) -> Option<[[f64; 2]; 2]> {
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    let [x0, y0, x1, y1] = numbers.try_into().ok()?;
    [x0, y0, x1, y1].iter().all(|x: &f64| x.is_finite()).then_some([[x0, y0], [x1, y1]])
}

fn polygon(path: &Path, crs: &Crs) -> Result<Vec<[f64; 2]>, InputError> {
    let name = path.display();
    let refuse = |why: String| InputError::new(format!("--area {name}: {why}"));
    let text = std::fs::read_to_string(path)
        .map_err(|error| refuse(format!("it is neither X0,Y0,X1,Y1 nor a GeoJSON file that can be read ({error})")))?;
    let document: Value = serde_json::from_str(&text).map_err(|error| refuse(format!("it is no JSON: {error}")))?;
    let mut degrees = Vec::new();
    gather(&document, &mut degrees);
    if degrees.len() < 3 {
        return Err(refuse("it holds no polygon".to_owned()));
    }
    degrees
        .into_iter()
        .map(|[lon, lat]| {
            if !((-180.0..=180.0).contains(&lon) && (-90.0..=90.0).contains(&lat)) {
                return Err(refuse(format!("{lon}, {lat} is no longitude and latitude, which GeoJSON is in")));
            }
            let (east, north) = crs.from_wgs84(lat, lon).map_err(|error| refuse(error.to_string()))?;
            Ok([east, north])
        })
        .collect()
}

/// The points of every polygon in a GeoJSON object.
fn gather(value: &Value, points: &mut Vec<[f64; 2]>) {
    match value.get("type").and_then(Value::as_str) {
        Some("FeatureCollection") => each(value.get("features"), &mut |feature| gather(feature, points)),
        Some("GeometryCollection") => each(value.get("geometries"), &mut |geometry| gather(geometry, points)),
        Some("Feature") => {
            if let Some(geometry) = value.get("geometry") {
                gather(geometry, points);
            }
        }
        Some("Polygon") => rings(value.get("coordinates"), points),
        Some("MultiPolygon") => each(value.get("coordinates"), &mut |polygon| rings(Some(polygon), points)),
        _ => {}
    }
}

fn rings(value: Option<&Value>, points: &mut Vec<[f64; 2]>) {
    each(value, &mut |ring| {
        each(Some(ring), &mut |point| {
            let at = |index: usize| point.get(index).and_then(Value::as_f64);
            points.extend(at(0).zip(at(1)).map(|(lon, lat)| [lon, lat]));
        });
    });
}

fn each(value: Option<&Value>, with: &mut dyn FnMut(&Value)) {
    value.and_then(Value::as_array).into_iter().flatten().for_each(with);
}
