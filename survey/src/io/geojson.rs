//! Polygons from a GeoJSON file (RFC 7946; the older `crs` member is understood).

use super::input;
use super::shell::files;
use crate::crs::{Crs, System};
use crate::error::InputError;
use serde_json::Value;
use std::path::Path;

/// What the coordinates of a file are.
enum Coordinates {
    /// WGS 84 longitude and latitude.
    Degrees,
    /// A named system.
    Named(Box<Crs>),
}

/// A polygon of a file: its outer ring, and how many holes it has.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Corners, the first repeated at the end.
    pub outer: Vec<[f64; 2]>,
    /// Inner rings.
    pub holes: usize,
}

/// The polygons of a file in x and y of a reference system.
///
/// Coordinates are WGS 84 longitude and latitude, as RFC 7946 has it, unless a member `crs` names another system. Without a
/// reference system (`None`) they are local metres and left as they are.
///
/// # Errors
/// One sentence: unreadable, not GeoJSON, no polygon, coordinates that are no numbers or cannot be places, a system that is
/// not known.
pub fn polygons(path: &Path, system: Option<System>) -> Result<Vec<Polygon>, InputError> {
    read(path, system, &|corner| corner)
}

/// What was likely meant by a file whose polygons do not lie where they have to: the hint for the sentence that refuses it, where with
/// latitude and longitude swapped a corner of them does.
#[must_use]
pub fn swapped(path: &Path, system: Option<System>, lies_right: impl Fn([f64; 2]) -> bool) -> &'static str {
    let polygons = system.and_then(|_| read(path, system, &|[x, y]| [y, x]).ok()).unwrap_or_default();
    let is_there = polygons.iter().flat_map(|polygon| &polygon.outer).any(|corner| lies_right(*corner));
    if is_there {
        "; with its numbers swapped it would: GeoJSON has the longitude first, [longitude, latitude]"
    } else {
        ""
    }
}

/// The line that makes GeoJSON of a file in another format of geographic information systems, by its name.
fn by_ogr(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_lowercase();
    let is_other = ["kml", "kmz", "shp", "gpkg", "gml", "gpx", "dxf", "tab", "fgb"].contains(&extension.as_str());
    let made = path.with_extension("geojson");
    let words = files([&made, path], " ");
    (is_other && path.is_file()).then(|| format!("ogr2ogr -t_srs EPSG:4326 {words}"))
}

fn read(path: &Path, system: Option<System>, order: &dyn Fn([f64; 2]) -> [f64; 2]) -> Result<Vec<Polygon>, InputError> {
    let name = path.display();
    let refuse = |why: String| InputError::new(format!("{name}: {why}"));
    if let Some(line) = by_ogr(path) {
        return Err(refuse(format!("it is no GeoJSON: {line} makes it")));
    }
    let json: Value =
        serde_json::from_str(&input::text(path)?).map_err(|error| refuse(format!("it is no JSON: {error}")))?;
    let mut found = Vec::new();
    gather(&json, &mut found).map_err(&refuse)?;
    if found.is_empty() {
        return Err(refuse("it has no polygon".to_owned()));
    }
    let Some(system) = system else { return Ok(found) };
    let target = Crs::new(system)?;
    let coordinates = match json.get("crs") {
        None | Some(Value::Null) => Coordinates::Degrees,
        Some(crs) => named(crs).map_err(&refuse)?,
    };
    for corner in found.iter_mut().flat_map(|polygon| &mut polygon.outer) {
        let [x, y] = order(*corner);
        let (lat, lon) = match &coordinates {
            Coordinates::Named(crs) if crs.system() == system => continue,
            Coordinates::Named(crs) => crs.to_wgs84(x, y).map_err(|error| error.at(name.to_string()))?,
            Coordinates::Degrees if x.abs() <= 180.0 && y.abs() <= 90.0 => (y, x),
            Coordinates::Degrees => {
                let is_swapped = x.abs() <= 90.0 && y.abs() <= 180.0;
                let what = if is_swapped {
                    "the longitude comes first, [longitude, latitude]"
                } else {
                    "coordinates of another system need a member crs that names it"
                };
                return Err(refuse(format!("{x}, {y} is no longitude and latitude in degrees; {what}")));
            }
        };
        let (x, y) = target.from_wgs84(lat, lon).map_err(|error| error.at(name.to_string()))?;
        *corner = [x, y];
    }
    Ok(found)
}

/// All polygons within.
fn gather(json: &Value, found: &mut Vec<Polygon>) -> Result<(), String> {
    let member = |key: &str| json.get(key).ok_or_else(|| format!("a {} has no {key}", kind(json)));
    let list = |key: &str| member(key)?.as_array().ok_or_else(|| format!("{key} is no list"));
    match kind(json) {
        "FeatureCollection" => list("features")?.iter().try_for_each(|feature| gather(feature, found)),
        "Feature" => match member("geometry")? {
            Value::Null => Ok(()),
            geometry => gather(geometry, found),
        },
        "GeometryCollection" => list("geometries")?.iter().try_for_each(|geometry| gather(geometry, found)),
        "Polygon" => polygon(member("coordinates")?).map(|polygon| found.push(polygon)),
        "MultiPolygon" => {
            list("coordinates")?.iter().try_for_each(|rings| polygon(rings).map(|polygon| found.push(polygon)))
        }
        "Point" | "MultiPoint" | "LineString" | "MultiLineString" => Ok(()),
        other => Err(format!("its type \"{other}\" is none of GeoJSON's")),
    }
}

fn kind(json: &Value) -> &str {
    json.get("type").and_then(Value::as_str).unwrap_or("")
}

fn polygon(coordinates: &Value) -> Result<Polygon, String> {
    let rings = coordinates.as_array().ok_or("a polygon's coordinates are no list")?;
    let outer = rings.first().ok_or("a polygon has no ring")?.as_array().ok_or("a polygon's ring is no list")?;
    let corners = outer.iter().map(|at| place(at).ok_or_else(|| format!("{at} is no place")));
    Ok(Polygon { outer: corners.collect::<Result<_, String>>()?, holes: rings.len() - 1 })
}

fn place(at: &Value) -> Option<[f64; 2]> {
    let numbers = at.as_array()?;
    let [x, y] = [numbers.first()?.as_f64()?, numbers.get(1)?.as_f64()?];
    (x.is_finite() && y.is_finite()).then_some([x, y])
}

/// A `crs` member of the older GeoJSON: a name such as `EPSG:31287` or `urn:ogc:def:crs:EPSG::31287`.
fn named(crs: &Value) -> Result<Coordinates, String> {
    let name = crs.pointer("/properties/name").and_then(Value::as_str).ok_or("its crs has no name")?;
    if name.ends_with("CRS84") {
        return Ok(Coordinates::Degrees);
    }
    let code = name.contains("EPSG").then(|| name.rsplit(':').next()).flatten().and_then(|code| code.parse().ok());
    let code: u32 = code.ok_or_else(|| format!("its crs \"{name}\" is no EPSG code"))?;
    Crs::from_epsg(code).map(|crs| Coordinates::Named(Box::new(crs))).map_err(|error| error.to_string())
}

/// What to type where the four numbers of an area stand between other marks than commas; else nothing.
#[must_use]
pub fn with_commas(area: &str) -> String {
    let numbers = area.split([',', ';', ' ', '/', '|', '\t']).filter(|part| !part.is_empty());
    let numbers: Vec<&str> = numbers.collect();
    let are_numbers = numbers.iter().all(|part| part.parse().is_ok_and(f64::is_finite));
    if numbers.len() == 4 && are_numbers {
        format!("; if it is X0,Y0,X1,Y1, type --area {}", numbers.join(","))
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::output::tests::scratch;

    fn of(text: &str, epsg: Option<u32>) -> Result<Vec<[f64; 2]>, String> {
        all(text, epsg).map(|polygons| polygons[0].outer.clone())
    }

    fn all(text: &str, epsg: Option<u32>) -> Result<Vec<Polygon>, String> {
        let path = scratch(&format!("geojson-{}", text.len())).join("area.geojson");
        std::fs::write(&path, text).expect("written");
        polygons(&path, epsg.map(System::Epsg)).map_err(|error| error.to_string())
    }

    const RING: &str = "[[[14.1,47.1],[14.2,47.1],[14.2,47.2],[14.1,47.1]]]";

    #[test]
    fn degrees_become_the_models_grid_and_local_metres_stay() {
        let polygon = format!(r#"{{"type":"Polygon","coordinates":{RING}}}"#);
        let feature =
            format!(r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","geometry":{polygon}}}]}}"#);
        let grid = of(&feature, Some(31287)).expect("Austria");
        // pyproj: Transformer.from_crs(4326, 31287, always_xy=True).transform(14.1, 47.1), which may take another shift of
        // datum.
        assert!((grid[0][0] - 458_235.66).hypot(grid[0][1] - 355_886.30) < 5.0, "{grid:?}");
        assert_eq!(of(&polygon, None).expect("local")[2], [14.2, 47.2]);
        assert_eq!(of(&polygon, Some(4326)).expect("degrees").len(), 4);
        let named = r#"{"type":"Polygon","crs":{"properties":{"name":"urn:ogc:def:crs:EPSG::31287"}},"coordinates":[[[1,2],[3,4],[5,0]]]}"#;
        assert_eq!(of(named, Some(31287)).expect("its own"), [[1.0, 2.0], [3.0, 4.0], [5.0, 0.0]]);
    }

    #[test]
    fn numbers_in_the_wrong_order_are_known() {
        let ring = "[[[47.1,14.1],[47.1,14.2],[47.2,14.2],[47.1,14.1]]]";
        let path = scratch("geojson-swapped").join("area.geojson");
        std::fs::write(&path, format!(r#"{{"type":"Polygon","coordinates":{ring}}}"#)).expect("written");
        let is_near = |[x, y]: [f64; 2]| (x - 458_235.0).hypot(y - 355_886.0) < 20_000.0;
        assert!(swapped(&path, Some(System::Epsg(31287)), is_near).contains("longitude first"));
        assert_eq!(swapped(&path, Some(System::Epsg(31287)), |_| false), "");
        assert_eq!(swapped(&path, None, |_| true), "", "local metres have no order to be wrong in");
        let far =
            of(r#"{"type":"Polygon","coordinates":[[[-37.8,144.9],[1,2],[3,4]]]}"#, Some(32755)).expect_err("swapped");
        assert!(far.contains("longitude comes first"), "{far}");
    }

    #[test]
    fn several_polygons_and_holes_are_told() {
        let several = all(r#"{"type":"MultiPolygon","coordinates":[[[[1,2]]],[[[3,4]],[[5,6]]]]}"#, None);
        let polygon = |x, y, holes| Polygon { outer: vec![[x, y]], holes };
        assert_eq!(several, Ok(vec![polygon(1.0, 2.0, 0), polygon(3.0, 4.0, 1)]));
    }

    #[test]
    fn what_is_no_polygon_is_refused_in_words() {
        for (text, says) in [
            ("{", "no JSON"),
            (r#"{"type":"Point","coordinates":[1,2]}"#, "no polygon"),
            (r#"{"type":"Rhombus"}"#, "Rhombus"),
            (r#"{"type":"Polygon"}"#, "has no coordinates"),
            (r#"{"type":"Polygon","coordinates":[[[1,"a"]]]}"#, "is no place"),
            (r#"{"type":"Polygon","coordinates":[[[500000,400000],[1,2],[3,4]]]}"#, "needs a member crs"),
            (
                r#"{"type":"Polygon","crs":{"properties":{"name":"EPSG:99999"}},"coordinates":[[[1,2],[3,4],[5,0]]]}"#,
                "99999",
            ),
        ] {
            let error = of(text, Some(31287)).expect_err(text);
            assert!(error.contains(says) || says.contains("needs") && error.contains("need a member"), "{error}");
        }
    }
}
