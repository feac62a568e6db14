//! The reference system of an ASCII grid: well-known text in a file beside it.
//!
//! Either the text names an EPSG code at its root, or it is ESRI's kind, which names none: then the geographic system is known
//! by ESRI's name for it and the projection by its parameters.

use std::fs;
use std::path::Path;

use crate::crs::System;
use crate::crs::system::Projection;
use crate::error::InputError;
use crate::io::raster::HeightDatum;

use super::wkt::Node;

/// Largest text that is read; real ones have a thousand bytes.
const BYTES_MAX: u64 = 1 << 16;

/// ESRI's names of geographic systems in use, with the EPSG codes PROJ 9.5 gives for them.
const GEOGRAPHIC: [(&str, u32); 16] = [
    ("GCS_WGS_1984", 4326),
    ("GCS_ETRS_1989", 4258),
    ("GCS_North_American_1983", 4269),
    ("GCS_North_American_1983_CSRS", 4617),
    ("GCS_MGI", 4312),
    ("GCS_Deutsches_Hauptdreiecksnetz", 4314),
    ("GCS_CH1903", 4149),
    ("GCS_CH1903+", 4150),
    ("GCS_RGF_1993", 4171),
    ("GCS_OSGB_1936", 4277),
    ("GCS_SWEREF99", 4619),
    ("GCS_Slovenia_1996", 4765),
    ("GCS_GDA_1994", 4283),
    ("GCS_NZGD_2000", 4167),
    ("GCS_JGD_2000", 4612),
    ("GCS_SIRGAS_2000", 4674),
];

/// Names of projections.
const PROJECTIONS: [(&str, Projection); 4] = [
    ("Transverse_Mercator", Projection::TransverseMercator),
    ("Gauss_Kruger", Projection::TransverseMercator),
    ("Lambert_Conformal_Conic", Projection::LambertConic2Sp),
    ("Lambert_Conformal_Conic_2SP", Projection::LambertConic2Sp),
];

/// Names of parameters, each with the one in projection strings.
const PARAMETERS: [(&str, &str); 7] = [
    ("False_Easting", "x_0"),
    ("False_Northing", "y_0"),
    ("Central_Meridian", "lon_0"),
    ("Latitude_Of_Origin", "lat_0"),
    ("Scale_Factor", "k"),
    ("Standard_Parallel_1", "lat_1"),
    ("Standard_Parallel_2", "lat_2"),
];

/// Keywords of compound and of vertical systems, in WKT 1, ESRI's and WKT 2.
const COMPOUND: [(&str, ()); 2] = [("COMPD_CS", ()), ("COMPOUNDCRS", ())];
const VERTICAL: [(&str, ()); 4] = [("VERT_CS", ()), ("VERTCS", ()), ("VERTCRS", ()), ("VERTICALCRS", ())];

/// Radians a degree, as precisely as files print it.
const DEGREE_RAD: f64 = 0.017_453_292_519_943_3;

/// What a `.prj` file says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compound {
    /// The horizontal one.
    pub horizontal: System,
    /// Metres of a unit of height; 1 where it names no vertical system.
    pub height_unit_m: f64,
    /// What heights are above.
    pub height_datum: HeightDatum,
}

/// The system by the `.prj` file beside a grid; `None` where there is no such file.
///
/// # Errors
/// The file cannot be read, or is not understood.
pub(super) fn beside(grid: &Path) -> Result<Option<Compound>, InputError> {
    let mut beside = ["prj", "PRJ"].map(|extension| grid.with_extension(extension)).into_iter();
    let Some(path) = beside.find(|path| path.is_file()) else {
        return Ok(None);
    };
    let refuse = |why: &str| InputError::new(format!("cannot use reference system {}: {why}", path.display()));
    if fs::metadata(&path).is_ok_and(|file| file.len() > BYTES_MAX) {
        return Err(refuse(&format!("it has more than {BYTES_MAX} bytes")));
    }
    let bytes = fs::read(&path).map_err(|error| refuse(&error.to_string()))?;
    compound(&String::from_utf8_lossy(&bytes)).map(Some).map_err(|why| refuse(&why))
}

/// The system of a well-known text, or why there is none. A vertical system stands beside the horizontal one in a compound, as
/// GDAL writes it, or behind it, as ESRI does.
fn compound(text: &str) -> Result<Compound, String> {
    let nodes = Node::read(text).ok_or("it is not well-known text")?;
    let parts: Vec<&Node> = match nodes.as_slice() {
        [compound] if listed(&COMPOUND, compound.keyword).is_some() => compound.nodes().collect(),
        nodes => nodes.iter().collect(),
    };
    let (vertical, horizontal): (Vec<&Node>, Vec<&Node>) = parts
        .into_iter()
        .filter(|part| !is_authority(part))
        .partition(|part| listed(&VERTICAL, part.keyword).is_some());
    match (horizontal.as_slice(), vertical.as_slice()) {
        ([one], _) if listed(&COMPOUND, one.keyword).is_some() => Err("it has a system beside a compound one".into()),
        ([one], []) => {
            Ok(Compound { horizontal: system_of(one)?, height_unit_m: 1.0, height_datum: HeightDatum::Unsaid })
        }
        ([one], [vertical]) => Ok(Compound {
            horizontal: system_of(one)?,
            height_unit_m: height_unit_m(vertical)?,
            height_datum: height_datum(vertical),
        }),
        _ => Err("it is not one horizontal and at most one vertical system".into()),
    }
}

/// Metres of a vertical system's unit; in WKT 2 its axis may have it.
fn height_unit_m(vertical: &Node) -> Result<f64, String> {
    let axis_down = |axis: &Node| axis.text(1).is_some_and(|direction| direction.eq_ignore_ascii_case("down"));
    let esri_down = |parameter: &Node| parameter.text(0) == Some("Direction") && parameter.number(1) == Some(-1.0);
    if vertical.children("AXIS").any(axis_down) || vertical.children("PARAMETER").any(esri_down) {
        return Err("its heights are depths".into());
    }
    let unit = |node: &Node| ["UNIT", "LENGTHUNIT"].iter().find_map(|unit| node.child(unit)?.number(1));
    let unit_m = unit(vertical).or_else(|| vertical.child("AXIS").and_then(unit));
    unit_m.filter(|unit_m| *unit_m > 0.0 && unit_m.is_finite()).ok_or_else(|| "its vertical system has no unit".into())
}

/// What heights are above. ESRI's text of heights above an ellipsoid has a DATUM, that of others a VDATUM.
fn height_datum(vertical: &Node) -> HeightDatum {
    let is_esris = vertical.keyword.eq_ignore_ascii_case("VERTCS");
    if is_esris && vertical.child("DATUM").is_some() {
        return HeightDatum::Ellipsoid;
    }
    HeightDatum::System(authority(vertical))
}

/// A horizontal system, or why there is none.
fn system_of(root: &Node) -> Result<System, String> {
    if let Some(code) = authority(root) {
        return Ok(System::Epsg(code));
    }
    match root.keyword.to_ascii_uppercase().as_str() {
        "GEOGCS" => geographic(root).map(System::Epsg),
        "PROJCS" => projected(root),
        other => Err(format!("it is a {other} without an EPSG code")),
    }
}

/// The code a node has of its own, as WKT 1 or WKT 2 writes it.
fn authority(node: &Node) -> Option<u32> {
    let mut named = node.nodes().filter(|node| is_authority(node));
    let code = named.find(|authority| authority.text(0).is_some_and(|name| name.eq_ignore_ascii_case("EPSG")))?;
    code.text(1)?.parse().ok()
}

fn is_authority(node: &Node) -> bool {
    node.keyword.eq_ignore_ascii_case("AUTHORITY") || node.keyword.eq_ignore_ascii_case("ID")
}

fn geographic(node: &Node) -> Result<u32, String> {
    if let Some(code) = authority(node) {
        return Ok(code);
    }
    let unit = node.child("UNIT").and_then(|unit| unit.number(1));
    let meridian = node.child("PRIMEM").and_then(|meridian| meridian.number(1));
    if unit.is_none_or(|unit| (unit - DEGREE_RAD).abs() > 1e-12) || meridian != Some(0.0) {
        return Err("its geographic system is not in degrees from Greenwich".into());
    }
    let name = node.text(0).unwrap_or_default();
    listed(&GEOGRAPHIC, name).ok_or_else(|| format!("its geographic system \"{name}\" is not known"))
}

fn projected(root: &Node) -> Result<System, String> {
    if root.child("UNIT").and_then(|unit| unit.number(1)) != Some(1.0) {
        return Err("its coordinates are not in metres".into());
    }
    let base = geographic(root.child("GEOGCS").ok_or("it has no geographic system")?)?;
    let name = root.child("PROJECTION").and_then(|projection| projection.text(0)).unwrap_or_default();
    let projection = listed(&PROJECTIONS, name).ok_or_else(|| format!("its projection \"{name}\" is not known"))?;
    let mut parameters = Vec::new();
    for parameter in root.children("PARAMETER") {
        let name = parameter.text(0).unwrap_or_default();
        match (listed(&PARAMETERS, name), parameter.number(1)) {
            (Some(key), Some(value)) => parameters.push((key, value)),
            _ => return Err(format!("its parameter \"{name}\" is not known")),
        }
    }
    let needed = projection.parameters();
    let same = needed.iter().all(|key| parameters.iter().filter(|(name, _)| name == key).count() == 1);
    if !same || parameters.len() != needed.len() {
        return Err(format!("its projection \"{name}\" has not the parameters it should have"));
    }
    System::spelt_out(base, projection, |wanted| {
        parameters.iter().find(|(known, _)| *known == wanted).map(|(_, value)| *value)
    })
}

/// What a list has for a name, whatever the case.
fn listed<T: Copy>(list: &[(&str, T)], name: &str) -> Option<T> {
    list.iter().find(|(known, _)| name.eq_ignore_ascii_case(known)).map(|(_, value)| *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn epsg(text: &str) -> Result<u32, String> {
        compound(text)?.horizontal.epsg().map_err(|error| error.to_string())
    }

    const BASE: &str = "GEOGCS[\"GCS_MGI\",DATUM[\"D_MGI\",SPHEROID[\"Bessel_1841\",6377397.155,299.1528128]],\
        PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]";
    const LAMBERT: &str = "PROJECTION[\"Lambert_Conformal_Conic\"],PARAMETER[\"False_Easting\",400000.0],\
        PARAMETER[\"False_Northing\",400000.0],PARAMETER[\"Central_Meridian\",13.3333333333333],\
        PARAMETER[\"Standard_Parallel_1\",49.0],PARAMETER[\"Standard_Parallel_2\",46.0],\
        PARAMETER[\"Latitude_Of_Origin\",47.5]";
    const UTM: &str = "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"False_Easting\",500000.0],\
        PARAMETER[\"False_Northing\",10000000.0],PARAMETER[\"Central_Meridian\",15.0],PARAMETER[\"Scale_Factor\",0.9996],\
        PARAMETER[\"Latitude_Of_Origin\",0.0]";

    /// As pyproj 3.7's `CRS.from_epsg(31287).to_wkt("WKT1_ESRI")` writes it, here and in what follows.
    fn lambert() -> String {
        format!("PROJCS[\"MGI_Austria_Lambert\",{BASE},{LAMBERT},UNIT[\"Meter\",1.0]]")
    }

    fn utm_33_south() -> String {
        let base = BASE.replace("GCS_MGI", "GCS_WGS_1984").replace("D_MGI", "D_WGS_1984");
        format!("PROJCS[\"WGS_1984_UTM_Zone_33S\",{base},{UTM},UNIT[\"Meter\",1.0]]")
    }

    #[test]
    fn systems_are_told_by_code_or_parameters() {
        assert_eq!(epsg(&lambert()), Ok(31287));
        assert_eq!(epsg(&utm_33_south()), Ok(32733));
        assert_eq!(epsg(BASE), Ok(4312));
        // The root's code, not one of a part.
        let named = lambert().replace(
            "UNIT[\"Meter\",1.0]]",
            "UNIT[\"Meter\",1.0,AUTHORITY[\"EPSG\",\"9001\"]],AUTHORITY[\"EPSG\",\"31287\"]]",
        );
        assert_eq!(epsg(&named), Ok(31287));
        let unit = lambert().replace("UNIT[\"Meter\",1.0]", "UNIT[\"Meter\",1.0,AUTHORITY[\"EPSG\",\"9001\"]]");
        assert_eq!(epsg(&unit), Ok(31287));
        assert_eq!(epsg("PROJCRS[\"any\",BASEGEOGCRS[\"x\",ID[\"EPSG\",4326]],ID[\"EPSG\",32633]]"), Ok(32633));
        let esri = lambert().replace("UNIT[\"Meter\",1.0]", "UNIT[\"Meter\",1.0],AUTHORITY[\"ESRI\",\"102008\"]");
        assert_eq!(epsg(&esri), Ok(31287));
    }

    #[test]
    fn parameters_of_no_listed_system_make_a_user_defined_one() {
        for text in [lambert().replace("47.5", "47.6"), utm_33_south().replace("15.0", "15.5")] {
            assert!(matches!(compound(&text).map(|said| said.horizontal), Ok(System::UserDefined(_))), "{text}");
        }
    }

    /// The vertical systems as pyproj 3.7's `CRS.from_epsg(6360).to_wkt(...)` writes them.
    #[test]
    fn the_vertical_system_states_heights_in_feet() {
        const GDAL: &str = "VERT_CS[\"NAVD88 height (ftUS)\",VERT_DATUM[\"North American Vertical Datum 1988\",2005],\
            UNIT[\"US survey foot\",0.304800609601219],AXIS[\"Up\",UP],AUTHORITY[\"EPSG\",\"6360\"]]";
        const ESRI: &str = "VERTCS[\"NAVD_1988_Foot_US\",VDATUM[\"North_American_Vertical_Datum_1988\"],\
            PARAMETER[\"Vertical_Shift\",0.0],PARAMETER[\"Direction\",1.0],UNIT[\"Foot_US\",0.3048006096012192]]";
        let wanted =
            |height_unit_m, height_datum| Ok(Compound { horizontal: System::Epsg(32733), height_unit_m, height_datum });
        let named = HeightDatum::System(Some(6360));
        assert_eq!(compound(&utm_33_south()), wanted(1.0, HeightDatum::Unsaid));
        let esri = wanted(0.304_800_609_601_219_2, HeightDatum::System(None));
        assert_eq!(compound(&format!("{},{ESRI}", utm_33_south())), esri);
        let ellipsoid = "VERTCS[\"WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,298.257223563]],\
            PARAMETER[\"Vertical_Shift\",0.0],PARAMETER[\"Direction\",1.0],UNIT[\"Meter\",1.0]]";
        assert_eq!(compound(&format!("{},{ellipsoid}", utm_33_south())), wanted(1.0, HeightDatum::Ellipsoid));
        let both = format!("COMPD_CS[\"x\",{},{GDAL},AUTHORITY[\"EPSG\",\"9999\"]]", utm_33_south());
        assert_eq!(compound(&both), wanted(0.304_800_609_601_219, named));
        let metres = both.replace("\"US survey foot\",0.304800609601219", "\"metre\",1");
        assert_eq!(compound(&metres), wanted(1.0, named));
        assert!(compound(&both.replace("UNIT[\"US survey foot\",0.304800609601219],", "")).is_err());
        assert!(compound(&format!("{both},{ESRI}")).is_err());
        assert!(compound(&both.replace("\"Up\",UP", "\"Depth\",DOWN")).is_err());
        let depth = ESRI.replace("\"Direction\",1.0", "\"Direction\",-1.0");
        assert!(compound(&format!("{},{depth}", utm_33_south())).is_err());
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        let (text, utm) = (lambert(), utm_33_south());
        for (case, text) in [
            ("no tree", String::from("Projection UTM\nZone 33\nUnits METERS")),
            ("empty", String::new()),
            ("another kind", String::from("LOCAL_CS[\"x\",UNIT[\"metre\",1]]")),
            ("feet", text.replace("UNIT[\"Meter\",1.0]", "UNIT[\"Foot_US\",0.3048006096012192]")),
            ("no unit", text.replace(",UNIT[\"Meter\",1.0]", "")),
            ("datum", text.replace("GCS_MGI", "GCS_Monte_Mario")),
            ("grads", text.replace("0.0174532925199433", "0.01570796326794897")),
            ("Ferro", text.replace("PRIMEM[\"Greenwich\",0.0]", "PRIMEM[\"Ferro\",-17.6666666666667]")),
            ("projection", text.replace("Lambert_Conformal_Conic", "Albers")),
            ("parameter", text.replace("False_Easting", "Rotation")),
            ("missing parameter", text.replace(",PARAMETER[\"Latitude_Of_Origin\",47.5]", "")),
            ("no number", text.replace("47.5", "x")),
            ("twice", utm.replace("\"Latitude_Of_Origin\"", "\"Scale_Factor\"")),
        ] {
            assert!(epsg(&text).is_err(), "{case}");
        }
    }
}
