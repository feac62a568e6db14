//! What the EPSG list says of a code, and whether that is enough to convert by.
//!
//! Each entry is a projection string and a well-known text. Both are read: the string holds the numbers, the text what
//! kind of system it is. Every key, projection, datum and unit must be one that is known to be handled; anything else is
//! refused, as the projection library passes over what it does not know.

use crs_definitions::from_code;

use crate::error::InputError;

use super::bases::TRUSTED;

/// Keys a projection string may have.
const KEYS: [&str; 24] = [
    "proj", "zone", "south", "lat_0", "lon_0", "lat_1", "lat_2", "lat_ts", "k", "k_0", "x_0", "y_0", "ellps", "a", "b",
    "rf", "datum", "towgs84", "units", "no_defs", "lonc", "alpha", "gamma", "no_uoff",
];

/// Conformal projections, and plain degrees.
const PROJECTIONS: [&str; 9] = ["longlat", "utm", "tmerc", "lcc", "stere", "sterea", "merc", "omerc", "somerc"];

/// An accepted entry of the EPSG list.
#[derive(Debug)]
pub(super) struct Definition {
    pub epsg: u32,
    pub name: &'static str,
    pub geographic: bool,
    /// EPSG code of the geographic system: its own, or the one a projected system stands on.
    pub base_epsg: Option<u32>,
    /// Name of the projection, `tmerc` also where the list has `utm`.
    pub projection: &'static str,
    /// The projection string as it goes to the library.
    pub proj4: &'static str,
    tokens: Tokens,
}

/// The keys and values of a projection string; a flag's value is empty.
#[derive(Debug)]
struct Tokens(Vec<(&'static str, &'static str)>);

impl Tokens {
    fn new(proj4: &'static str) -> Self {
        let token = |token: &'static str| {
            let token = token.trim_start_matches('+');
            token.split_once('=').unwrap_or((token, ""))
        };
        Tokens(proj4.split_whitespace().map(token).collect())
    }

    fn value(&self, key: &str) -> Option<&'static str> {
        self.0.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
    }

    fn projection(&self) -> &'static str {
        self.value("proj").unwrap_or("none")
    }

    /// Refuses what the projection library does not handle, or not as it is meant.
    fn check(&self, geographic: bool) -> Result<(), String> {
        let value = |key: &str| self.value(key);
        let projection = self.projection();
        let refuse = |why: &str| Err(why.to_owned());
        if value("pm").is_some() {
            return refuse("its longitudes do not count from Greenwich");
        }
        if value("nadgrids") == Some("@null") {
            return refuse("it is not conformal, its metre is not a ground metre");
        }
        if value("nadgrids").is_some() || value("datum") == Some("NAD27") {
            return refuse("its datum shift needs a grid file");
        }
        if !PROJECTIONS.contains(&projection) || geographic != (projection == "longlat") {
            return Err(format!("the projection {projection} is not handled"));
        }
        if !geographic && value("units") != Some("m") {
            return refuse("its coordinates are not in metres");
        }
        if let Some((key, _)) = self.0.iter().find(|(key, _)| !KEYS.contains(key)) {
            return Err(format!("its parameter {key} is not handled"));
        }
        if value("datum").is_some() == value("towgs84").is_some() {
            return refuse("the shift of its datum to WGS 84 is not known");
        }
        Ok(())
    }
}

/// Every code the EPSG list can hold.
pub(super) fn codes() -> impl Iterator<Item = u32> {
    0..=u32::from(u16::MAX)
}

impl Definition {
    /// Reads the entry of a code, or says why it cannot be converted by.
    pub fn read(epsg: u32) -> Result<Self, InputError> {
        let Some(entry) = u16::try_from(epsg).ok().and_then(from_code) else {
            return Err(InputError::new(format!("EPSG:{epsg} is not in the list of reference systems")));
        };
        let name = entry.wkt.split('"').nth(1).unwrap_or("unnamed");
        let refusal = |why: &str| InputError::new(format!("cannot use EPSG:{epsg} ({name}): {why}"));
        let refuse = |why: &str| Err(refusal(why));

        let geographic = entry.wkt.starts_with("GEOGCS[");
        if !geographic && !entry.wkt.starts_with("PROJCS[") {
            return refuse("it is not a projected or geographic system of two dimensions");
        }
        if name.ends_with("(deprecated)") {
            return refuse("the code is deprecated");
        }
        if geographic && !entry.wkt.contains("UNIT[\"degree\"") {
            return refuse("its angles are not in degrees");
        }
        let tokens = Tokens::new(entry.proj4);
        tokens.check(geographic).map_err(|why| refusal(&why))?;
        let base_epsg = if geographic { Some(epsg) } else { base_epsg(entry.wkt) };
        let trusted = base_epsg
            .and_then(|code| u16::try_from(code).ok())
            .is_some_and(|code| TRUSTED.binary_search(&code).is_ok());
        if !trusted {
            return refuse("the shift of its datum to WGS 84 is not known for certain");
        }
        let projection = match tokens.projection() {
            "utm" => "tmerc",
            other => other,
        };
        Ok(Self { epsg, name, geographic, base_epsg, projection, proj4: entry.proj4, tokens })
    }

    /// A projection parameter in degrees, metres or as a ratio; those of a UTM zone are computed.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let value = |key: &str| self.tokens.value(key);
        if let Some(zone) = value("zone") {
            let zone: f64 = zone.parse().ok()?;
            return match name {
                "lat_0" => Some(0.0),
                "lon_0" => Some(6.0 * zone - 183.0),
                "k" => Some(0.9996),
                "x_0" => Some(500_000.0),
                "y_0" if value("south").is_some() => Some(10_000_000.0),
                "y_0" => Some(0.0),
                _ => None,
            };
        }
        value(name)?.parse().ok()
    }
}

/// The last authority code before the projection is that of the geographic base.
fn base_epsg(wkt: &str) -> Option<u32> {
    let (base, _) = wkt.split_once(",PROJECTION[")?;
    let (_, code) = base.rsplit_once("AUTHORITY[\"EPSG\",\"")?;
    code.split('"').next()?.parse().ok()
}
