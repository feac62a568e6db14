//! The EPSG code of a projected system that a GeoTIFF spells out instead of naming.
//!
//! Some software writes code 32767 and the projection's parameters. Where the geodetic base has a code, and the list of
//! EPSG systems holds one on that base with the same projection and parameters, that is the system. Anything else is
//! refused. The two projections handled are the ones of national and zone grids.

use crate::crs::lookup::code_of;

use super::geo_keys::GeoKeys;

const PROJECTION_METHOD: u16 = 3075;
const TRANSVERSE_MERCATOR: u16 = 1;
const LAMBERT_CONIC_2SP: u16 = 8;

/// GeoKeys of one method, each with the parameter's name in a projection string and its default.
type Parameters = [(&'static str, u16)];

const TRANSVERSE_MERCATOR_KEYS: &Parameters =
    &[("lon_0", 3080), ("lat_0", 3081), ("x_0", 3082), ("y_0", 3083), ("k", 3092)];
const LAMBERT_KEYS: &Parameters =
    &[("lat_1", 3078), ("lat_2", 3079), ("lon_0", 3084), ("lat_0", 3085), ("x_0", 3086), ("y_0", 3087)];

/// Lowest EPSG code of the system with these keys' base, projection and parameters.
pub(super) fn epsg(keys: &GeoKeys) -> Result<u32, String> {
    let unknown = || unknown(central_meridian(keys));
    let base = keys.base_epsg().ok_or_else(unknown)?;
    let (method, parameters) = match keys.short(PROJECTION_METHOD) {
        Some(TRANSVERSE_MERCATOR) => ("tmerc", TRANSVERSE_MERCATOR_KEYS),
        Some(LAMBERT_CONIC_2SP) => ("lcc", LAMBERT_KEYS),
        _ => return Err(unknown()),
    };
    let wanted = parameters
        .iter()
        .map(|(name, key)| keys.double(*key).map(|value| (*name, value)))
        .collect::<Option<Vec<_>>>()
        .ok_or_else(unknown)?;
    code_of(u32::from(base), method, &wanted).ok_or_else(unknown)
}

/// That of the projection, degrees east of Greenwich, where it has one.
fn central_meridian(keys: &GeoKeys) -> Option<f64> {
    keys.double(3080).or_else(|| keys.double(3084)).filter(|degrees| degrees.abs() <= 180.0)
}

/// What is wrong and the command that mends it: to the UTM zone of the central meridian.
fn unknown(meridian_deg: Option<f64>) -> String {
    let zone =
        meridian_deg.map_or("ZZ".to_owned(), |degrees| format!("{:02}", ((degrees + 180.0) / 6.0) as u8 % 60 + 1));
    let mends =
        format!("gdalwarp -t_srs EPSG:326{zone} IN OUT.tif puts it on one, EPSG:327{zone} south of the equator");
    let whose = if meridian_deg.is_none() { " (ZZ: its UTM zone)" } else { "" };
    format!("its projected reference system is user-defined and matches no EPSG system: {mends}{whose}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tiff::GeoTags;

    /// Keys of a user-defined projected system on a base, with a method and its parameters.
    fn keys(base: u16, method: u16, parameters: &[(u16, f64)]) -> GeoKeys {
        let mut directory =
            vec![1, 1, 0, 2 + parameters.len() as u16, 2048, 0, 1, base, PROJECTION_METHOD, 0, 1, method];
        for (index, (key, _)) in parameters.iter().enumerate() {
            directory.extend([*key, 34736, 1, index as u16]);
        }
        let tags = GeoTags {
            keys: Some(directory),
            key_doubles: Some(parameters.iter().map(|(_, value)| *value).collect()),
            ..GeoTags::default()
        };
        GeoKeys::read(&tags).expect("well-formed")
    }

    const GK_EAST: [(u16, f64); 5] =
        [(3080, 16.333_333_333_3), (3081, 0.0), (3082, 0.0), (3083, -5_000_000.0), (3092, 1.0)];

    #[test]
    fn what_mends_an_unknown_system_names_its_zone() {
        let lo_25 = [(3080, 25.0), (3081, 0.0), (3082, 0.0), (3083, 0.0), (3092, 1.0)];
        let said = epsg(&keys(4326, 1, &lo_25)).expect_err("it has no code");
        assert!(said.contains("EPSG:32635 IN OUT.tif") && said.contains("EPSG:32735 south"), "{said}");
        let said = epsg(&keys(4326, 9, &[])).expect_err("another projection");
        assert!(said.contains("EPSG:326ZZ") && said.ends_with("(ZZ: its UTM zone)"), "{said}");
    }

    #[test]
    fn systems_are_found_by_their_parameters() {
        assert_eq!(epsg(&keys(4312, 1, &GK_EAST)), Ok(31256));
        let utm_33_south = [(3080, 15.0), (3081, 0.0), (3082, 5e5), (3083, 1e7), (3092, 0.9996)];
        assert_eq!(epsg(&keys(4326, 1, &utm_33_south)), Ok(32733));
        for parallels in [[46.0, 49.0], [49.0, 46.0]] {
            let lambert = [
                (3078, parallels[0]),
                (3079, parallels[1]),
                (3084, 13.333_333_333),
                (3085, 47.5),
                (3086, 4e5),
                (3087, 4e5),
            ];
            assert_eq!(epsg(&keys(4312, 8, &lambert)), Ok(31287));
            // The same cone on another datum is another system.
            assert_eq!(epsg(&keys(4258, 8, &lambert)), Ok(3416));
            assert!(epsg(&keys(4277, 8, &lambert)).is_err());
        }
    }

    #[test]
    fn what_matches_nothing_is_refused() {
        assert!(epsg(&keys(32767, 1, &GK_EAST)).is_err(), "no base");
        assert!(epsg(&keys(4312, 11, &GK_EAST)).is_err(), "another method");
        assert!(epsg(&keys(4312, 1, &GK_EAST[..4])).is_err(), "a parameter is missing");
        for index in 0..GK_EAST.len() {
            let mut moved = GK_EAST;
            moved[index].1 += 1e-3;
            assert!(epsg(&keys(4312, 1, &moved)).is_err(), "parameter {index} differs");
        }
    }
}
