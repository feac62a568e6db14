//! The area that a tile is to cover: `X0,Y0,X1,Y1` in metres of the orthophoto's grid, or a GeoJSON file.
//!
//! Of the polygons of a GeoJSON file the bounding box on the grid is taken.

use crate::world::Bounds;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;
use plumbline_survey::io::geojson;
use std::path::Path;

/// The area that `text` names on the grid of `crs`.
///
/// # Errors
/// One sentence for numbers that are none, corners that are one, and a file that is missing or holds no polygon.
pub fn area(text: &str, crs: &Crs) -> Result<Bounds, InputError> {
    let points = match corners(text) {
        Some(points) => points.to_vec(),
        None => {
            let polygons = geojson::polygons(Path::new(text), Some(crs.system()));
            let why = |error: InputError| {
                let what = format!("--area {text} is neither X0,Y0,X1,Y1 nor GeoJSON");
                match geojson::with_commas(text) {
                    hint if hint.is_empty() => error.at(what),
                    hint => InputError::new(what + &hint),
                }
            };
            let polygons = polygons.map_err(why)?;
            polygons.into_iter().flat_map(|polygon| polygon.outer).collect()
        }
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
