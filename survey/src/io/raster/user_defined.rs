//! A projected system that a GeoTIFF spells out instead of naming.
//!
//! Some software writes code 32767 and the projection's parameters. Where the geodetic base has a code and the projection is one of
//! the two of national and zone grids, that is enough to convert by. Anything else is refused.

use crate::crs::System;
use crate::crs::system::{Projection, UserDefined};

use super::geo_keys::{GeoKeys, PROJECTION_METHOD};

/// Codes of the projections' methods (GeoTIFF 1.1, key 3075).
const METHODS: [(u16, Projection); 2] = [(1, Projection::TransverseMercator), (8, Projection::LambertConic2Sp)];

/// Key of a parameter, by its name in projection strings.
fn key(projection: Projection, name: &str) -> Option<u16> {
    let keys: &[(&str, u16)] = match projection {
        Projection::TransverseMercator => {
            &[("lon_0", 3080), ("lat_0", 3081), ("x_0", 3082), ("y_0", 3083), ("k", 3092)]
        }
        Projection::LambertConic2Sp => {
            &[("lat_1", 3078), ("lat_2", 3079), ("lon_0", 3084), ("lat_0", 3085), ("x_0", 3086), ("y_0", 3087)]
        }
    };
    keys.iter().find(|(known, _)| *known == name).map(|(_, key)| *key)
}

/// The system with these keys' base, projection and parameters.
pub(super) fn read(keys: &GeoKeys) -> Result<System, String> {
    let refuse = |why: &str| {
        format!(
            "its projected reference system is user-defined, and {why}: gdalwarp -t_srs EPSG:326ZZ IN OUT.tif puts it on UTM zone ZZ, EPSG:327ZZ south of the equator"
        )
    };
    let base = keys.base_epsg().ok_or_else(|| refuse("its geographic base has no EPSG code"))?;
    let method = keys.short(PROJECTION_METHOD);
    let (_, projection) = METHODS
        .into_iter()
        .find(|(code, _)| Some(*code) == method)
        .ok_or_else(|| refuse("its projection is neither transverse Mercator nor Lambert's with two parallels"))?;
    System::spelt_out(u32::from(base), projection, |name| keys.double(key(projection, name)?))
        .map_err(|why| refuse(&why))
}

/// Code of a user-defined system's method.
pub(super) fn method(system: &UserDefined) -> Option<u16> {
    METHODS.iter().find(|(_, projection)| *projection == system.projection).map(|(code, _)| *code)
}

/// Keys of its parameters, each with the value.
pub(super) fn parameters(system: &UserDefined) -> Vec<(u16, f64)> {
    system.values().filter_map(|(name, value)| Some((key(system.projection, name)?, value))).collect()
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

    fn code(keys: &GeoKeys) -> Option<u32> {
        read(keys).ok()?.epsg().ok()
    }

    #[test]
    fn systems_are_found_by_their_parameters() {
        assert_eq!(code(&keys(4312, 1, &GK_EAST)), Some(31256));
        let utm_33_south = [(3080, 15.0), (3081, 0.0), (3082, 5e5), (3083, 1e7), (3092, 0.9996)];
        assert_eq!(code(&keys(4326, 1, &utm_33_south)), Some(32733));
        for parallels in [[46.0, 49.0], [49.0, 46.0]] {
            let lambert = [
                (3078, parallels[0]),
                (3079, parallels[1]),
                (3084, 13.333_333_333),
                (3085, 47.5),
                (3086, 4e5),
                (3087, 4e5),
            ];
            assert_eq!(code(&keys(4312, 8, &lambert)), Some(31287));
            // The same cone on another datum is another system, and on one more it has no code.
            assert_eq!(code(&keys(4258, 8, &lambert)), Some(3416));
            assert_eq!(code(&keys(4277, 8, &lambert)), None);
        }
    }

    #[test]
    fn what_has_no_code_stays_what_it_is() {
        for index in 0..GK_EAST.len() {
            let mut moved = GK_EAST;
            moved[index].1 += 1e-3;
            let found = read(&keys(4312, 1, &moved)).expect("a projection");
            assert!(found.epsg().is_err(), "parameter {index} differs");
            let System::UserDefined(system) = found else { unreachable!() };
            assert_eq!(method(&system), Some(1));
            assert_eq!(parameters(&system), moved);
        }
    }

    #[test]
    fn what_cannot_be_converted_by_is_refused() {
        assert!(read(&keys(32767, 1, &GK_EAST)).is_err(), "no base");
        assert!(read(&keys(4312, 11, &GK_EAST)).is_err(), "another method");
        assert!(read(&keys(4312, 1, &GK_EAST[..4])).is_err(), "a parameter is missing");
        let said = read(&keys(4267, 1, &GK_EAST)).expect_err("a datum that needs a grid file");
        assert!(said.contains("grid file") && said.contains("gdalwarp"), "{said}");
    }
}
