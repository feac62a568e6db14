//! The reference system that a file's keys name or spell out, and the unit of its heights.

use crate::crs::System;

use super::geo_keys::{
    ANGULAR_UNITS, DEGREE, GEODETIC_CRS, GeoKeys, LINEAR_UNITS, METRE, MODEL_GEOCENTRIC, MODEL_GEOGRAPHIC,
    MODEL_PROJECTED, MODEL_TYPE, PROJECTED_CRS, USER_DEFINED, VERTICAL_CRS, VERTICAL_DATUM, VERTICAL_UNITS,
};
use super::metadata::item;
use super::user_defined;
use crate::io::shell::names;
use std::ops::RangeInclusive;
use std::path::Path;

/// Why a georeference is not read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Unread {
    /// Its coordinates are in another unit of length, which has this EPSG code.
    NotInMetres(u16),
    /// Anything else, in words.
    Other(String),
}

impl From<String> for Unread {
    fn from(why: String) -> Self {
        Unread::Other(why)
    }
}

impl From<&str> for Unread {
    fn from(why: &str) -> Self {
        Unread::Other(why.to_owned())
    }
}

impl Unread {
    /// In words, with the command that makes a file that is where another unit is to blame; interpolated as `gdalwarp -r` names it.
    pub(crate) fn says(&self, path: &Path, interpolation: &str) -> String {
        match self {
            Unread::NotInMetres(unit) => format!(
                "its coordinates are not in metres (EPSG unit {unit}): gdalwarp -t_srs EPSG:CODE -r {interpolation} {} puts it onto a grid in \
                 metres, EPSG:326ZZ of UTM zone ZZ north",
                names(path, "metres")
            ),
            Unread::Other(why) => why.clone(),
        }
    }
}

/// What heights are above, by what a file says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightDatum {
    /// It says nothing of it.
    Unsaid,
    /// An ellipsoid, which the sea is not.
    Ellipsoid,
    /// The zero of a vertical system, by its EPSG code if it has one.
    System(Option<u32>),
}

/// Units of length by their EPSG codes, in metres: metre, international foot, US survey foot.
const UNITS_M: [(u16, f64); 3] = [(METRE, 1.0), (9002, 0.3048), (9003, 1200.0 / 3937.0)];
/// Systems of heights in feet by their EPSG codes: NGVD29, NAVD88 and mean sea level in US survey feet; the three of the Cayman
/// Islands, mean sea level and NAVD88 in international ones; Poolbeg in British feet of 1936. All others are in metres. A test
/// compares this list and the next with the EPSG dataset (v11.022).
const IN_FEET_M: [(u16, f64); 9] = [
    (5702, 1200.0 / 3937.0),
    (6360, 1200.0 / 3937.0),
    (8052, 1200.0 / 3937.0),
    (6130, 0.3048),
    (6131, 0.3048),
    (6132, 0.3048),
    (8050, 0.3048),
    (8228, 0.3048),
    (5754, 0.304_800_749_1),
];
/// Codes that vertical systems have in the EPSG dataset (v11.022), from the least to the greatest; between them horizontal
/// ones have codes too.
const VERTICAL_CODES: RangeInclusive<u16> = 3855..=20036;
/// Systems of depths, which count downwards.
#[rustfmt::skip]
const DEPTHS: [u16; 52] = [
    5336, 5612, 5614, 5706, 5715, 5734, 5739, 5789, 5831, 5861, 5862, 5863, 5864, 5865, 5866, 5867, 5873, 6357,
    6358, 6359, 7976, 8051, 8053, 8358, 8378, 8897, 9287, 9288, 9672, 10150, 10151, 10349, 10364, 10370, 10371,
    10372, 10373, 10374, 10375, 10376, 10377, 10378, 10379, 10547, 10548, 10549, 10550, 10551, 10552, 10649, 10650,
    10678,
];
/// What stands for an ellipsoid in the key of the vertical system, where no system of heights has these codes: GeoTIFF 1.0's own codes of
/// heights above one (annex 6.3.4.1), WGS 84 in three dimensions, and EPSG's codes of ellipsoids.
const ELLIPSOIDS: [RangeInclusive<u16>; 3] = [5001..=5033, 4979..=4979, 7001..=7059];
/// In the key of the vertical datum: datums that are named by an ellipsoid (the same annex).
const ELLIPSOID_DATUMS: RangeInclusive<u16> = 6001..=6035;
/// Names of units of height that GDAL writes, in lower case.
const NAMES_M: [(&str, f64); 10] = [
    ("m", 1.0),
    ("metre", 1.0),
    ("metres", 1.0),
    ("meter", 1.0),
    ("meters", 1.0),
    ("ft", 0.3048),
    ("foot", 0.3048),
    ("feet", 0.3048),
    ("us survey foot", 1200.0 / 3937.0),
    ("us-ft", 1200.0 / 3937.0),
];

/// The horizontal system, `None` where the file names none. Units other than metres and degrees,
/// and systems that are not certain, are refused.
pub(super) fn horizontal(keys: &GeoKeys) -> Result<Option<System>, Unread> {
    match keys.short(MODEL_TYPE) {
        Some(MODEL_PROJECTED) => {
            unit_is(keys, LINEAR_UNITS, METRE, "metres")?;
            match keys.short(PROJECTED_CRS) {
                Some(USER_DEFINED) | None => Ok(Some(user_defined::read(keys)?)),
                Some(code) => Ok(Some(System::Epsg(u32::from(code)))),
            }
        }
        Some(MODEL_GEOGRAPHIC) => {
            unit_is(keys, ANGULAR_UNITS, DEGREE, "degrees")?;
            match keys.short(GEODETIC_CRS) {
                Some(USER_DEFINED) | None => {
                    Err("its geographic reference system has no EPSG code: gdalwarp -t_srs EPSG:4326 IN OUT.tif gives it one".into())
                }
                Some(code) => Ok(Some(System::Epsg(u32::from(code)))),
            }
        }
        Some(MODEL_GEOCENTRIC) => Err("its coordinates are geocentric".into()),
        _ if keys.short(PROJECTED_CRS).is_some() || keys.short(GEODETIC_CRS).is_some() => {
            Err("it names a reference system but not whether it is projected".into())
        }
        _ => {
            unit_is(keys, LINEAR_UNITS, METRE, "metres")?;
            Ok(None)
        }
    }
}

fn unit_is(keys: &GeoKeys, key: u16, wanted: u16, unit: &str) -> Result<(), Unread> {
    match keys.short(key) {
        Some(code) if code != wanted && wanted == METRE => Err(Unread::NotInMetres(code)),
        Some(code) if code != wanted => Err(format!("its coordinates are not in {unit} (EPSG unit {code})").into()),
        _ => Ok(()),
    }
}

/// Metres of a unit of height. Three entries may name it: the key of the unit, the vertical system (key 4096), and GDAL's own
/// metadata (`UNITTYPE`), in which GDAL keeps it where the file has no vertical system. All that do have to agree; metres
/// where none does: GDAL writes a user-defined unit where it has lost the name.
pub(super) fn height_unit_m(keys: &GeoKeys, metadata: Option<&str>) -> Result<f64, String> {
    let listed =
        |list: &[(u16, f64)], code: u16| list.iter().find(|(known, _)| *known == code).map(|(_, metres)| *metres);
    let by_key = keys.short(VERTICAL_UNITS).filter(|code| *code != USER_DEFINED).map(|code| {
        listed(&UNITS_M, code)
            .ok_or_else(|| format!("its heights are in EPSG unit {code}, which is neither metres nor feet"))
    });
    let by_system = keys.short(VERTICAL_CRS).filter(|code| *code != USER_DEFINED);
    let by_system = by_system.map(|code| match DEPTHS.binary_search(&code) {
        Ok(_) => Err(format!("its heights are depths (EPSG:{code})")),
        Err(_) => Ok(listed(&IN_FEET_M, code).unwrap_or(1.0)),
    });
    let by_name = metadata.and_then(|metadata| item(metadata, "unittype", 0)).map(|name| {
        let known = NAMES_M.iter().find(|(known, _)| name.eq_ignore_ascii_case(known)).map(|(_, metres)| *metres);
        known.ok_or_else(|| format!("its heights are in \"{name}\", which is neither metres nor feet"))
    });
    let stated: Vec<f64> = [by_key, by_system, by_name].into_iter().flatten().collect::<Result<_, _>>()?;
    let unit_m = stated.first().copied().unwrap_or(1.0);
    // The two feet differ by 2e-6: files round them.
    match stated.iter().find(|other| (*other / unit_m - 1.0).abs() > 1e-5) {
        Some(other) => Err(format!("it says two units of height, of {unit_m} m and of {other} m")),
        None => Ok(unit_m),
    }
}

/// Metres of a unit of heights of a vertical system, by its EPSG code.
///
/// # Errors
/// Why it is none of heights above the sea.
pub fn vertical_unit_m(epsg: u16) -> Result<f64, String> {
    if ELLIPSOIDS.iter().any(|codes| codes.contains(&epsg)) {
        return Err("it is an ellipsoid, and heights above the sea are needed, which plan --geoid FILE makes of heights above an ellipsoid".into());
    }
    if DEPTHS.binary_search(&epsg).is_ok() {
        return Err("its heights are depths".into());
    }
    if !VERTICAL_CODES.contains(&epsg) || crs_definitions::from_code(epsg).is_some() {
        return Err("it is no vertical system; 5773 is that of EGM96 heights, 3855 that of EGM2008 heights".into());
    }
    Ok(IN_FEET_M.iter().find(|(known, _)| *known == epsg).map_or(1.0, |(_, metres)| *metres))
}

/// Whether a unit or a system of heights is named.
pub(super) fn names_heights(keys: &GeoKeys, metadata: Option<&str>) -> bool {
    [VERTICAL_CRS, VERTICAL_UNITS].iter().any(|key| keys.short(*key).is_some())
        || metadata.is_some_and(|metadata| item(metadata, "unittype", 0).is_some())
}

/// What heights are above. A system that is user-defined and has no datum is one whose name was lost.
pub(super) fn height_datum(keys: &GeoKeys) -> HeightDatum {
    match (keys.short(VERTICAL_CRS), keys.short(VERTICAL_DATUM)) {
        _ if is_ellipsoidal(keys) => HeightDatum::Ellipsoid,
        (Some(code), _) if code != USER_DEFINED => HeightDatum::System(Some(u32::from(code))),
        (_, Some(datum)) if datum != USER_DEFINED => HeightDatum::System(None),
        _ => HeightDatum::Unsaid,
    }
}

/// Whether heights are said to be above an ellipsoid instead of above the sea.
fn is_ellipsoidal(keys: &GeoKeys) -> bool {
    let is_of = |key: u16, codes: &[RangeInclusive<u16>]| {
        keys.short(key).is_some_and(|code| codes.iter().any(|codes| codes.contains(&code)))
    };
    let is_in_space = keys.short(MODEL_TYPE) == Some(MODEL_GEOGRAPHIC) && is_of(GEODETIC_CRS, &[4979..=4979]);
    is_in_space || is_of(VERTICAL_CRS, &ELLIPSOIDS) || is_of(VERTICAL_DATUM, &[ELLIPSOID_DATUMS])
}

#[cfg(test)]
mod tests {
    use super::super::geo_keys::tests::short_keys;
    use super::*;
    use crate::io::tiff::GeoTags;

    fn keys(entries: &[(u16, u16)]) -> GeoKeys {
        GeoKeys::read(&short_keys(entries)).expect("well-formed")
    }

    #[test]
    fn codes_are_read_by_model_type() {
        assert_eq!(horizontal(&keys(&[(1024, 1), (3072, 31256)])), Ok(Some(System::Epsg(31256))));
        assert_eq!(horizontal(&keys(&[(1024, 2), (2048, 4326)])), Ok(Some(System::Epsg(4326))));
        // A projected file also names its base: that is not its system.
        assert_eq!(horizontal(&keys(&[(1024, 1), (2048, 4312), (3072, 31256)])), Ok(Some(System::Epsg(31256))));
        assert_eq!(horizontal(&keys(&[])), Ok(None));
        assert_eq!(horizontal(&GeoKeys::read(&GeoTags::default()).expect("none")), Ok(None));
    }

    #[test]
    fn doubtful_systems_and_units_are_refused() {
        for entries in [
            &[(1024, 3)][..],                         // geocentric
            &[(3072, 31256)],                         // no model type
            &[(1024, 2), (2048, 32767)],              // user-defined geographic
            &[(1024, 2)],                             // geographic without code
            &[(1024, 1)],                             // projected without code
            &[(1024, 1), (3072, 2263), (3076, 9003)], // US survey feet
            &[(1024, 2), (2048, 4807), (2054, 9105)], // grads
            &[(3076, 9002)],                          // local feet
        ] {
            assert!(horizontal(&keys(entries)).is_err(), "{entries:?}");
        }
    }

    /// Every vertical system of the EPSG dataset, as PROJ's copy of it has them.
    #[test]
    fn units_and_directions_of_vertical_systems_are_those_of_the_epsg_dataset() {
        let vectors = include_str!("../../../tests/vertical_epsg.csv");
        let rows = vectors.lines().filter(|line| !line.starts_with('#')).skip(1);
        let mut count = 0;
        for row in rows {
            let [code, unit_m, direction, ..] = row.split(',').collect::<Vec<_>>()[..] else { panic!("{row}") };
            assert!(!is_ellipsoidal(&keys(&[(4096, code.parse().expect("a code"))])), "{row}");
            let found = height_unit_m(&keys(&[(4096, code.parse().expect("a code"))]), None).ok();
            let given = vertical_unit_m(code.parse().expect("a code")).ok();
            assert_eq!(given, found, "{row}");
            let wanted = Some(unit_m.parse::<f64>().expect("a unit")).filter(|_| direction == "up");
            assert!(found.zip(wanted).map_or(found == wanted, |(a, b)| (a / b - 1.0).abs() < 1e-9), "{row}: {found:?}");
            count += 1;
        }
        assert_eq!(count, 291);
        for horizontal in [0, 4326, 25832, 32633, 31287] {
            assert!(vertical_unit_m(horizontal).is_err_and(|why| why.contains("no vertical system")), "{horizontal}");
        }
    }

    #[test]
    fn heights_above_an_ellipsoid_are_known() {
        for entries in [
            &[(4096, 5030)][..],
            &[(4096, 4979)],
            &[(4096, 7030)],
            &[(4096, 32767), (4098, 6030)],
            &[(1024, 2), (2048, 4979)],
        ] {
            assert!(is_ellipsoidal(&keys(entries)), "{entries:?}");
        }
        // Without a word, EGM96, EGM2008, the datum of EGM96.
        for entries in
            [&[][..], &[(1024, 2), (2048, 4326)], &[(4096, 5773)], &[(4096, 3855)], &[(4096, 32767), (4098, 5171)]]
        {
            assert!(!is_ellipsoidal(&keys(entries)), "{entries:?}");
        }
    }

    #[test]
    fn the_unit_of_heights_is_stated_by_key_system_or_metadata() {
        let us_foot = 1200.0 / 3937.0;
        let feet = "<GDALMetadata>\n  <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey foot</Item>\n</GDALMetadata>";
        let other = feet.replace("US survey foot", "dB");
        let second = feet.replace("sample=\"0\"", "sample=\"1\"");
        // EPSG:5703 is NAVD88 height, EPSG:6360 the same in US survey feet, EPSG:8228 in international ones.
        for (entries, metadata, wanted) in [
            (&[][..], None, 1.0),
            (&[(4099, 9001)], None, 1.0),
            (&[(4096, 32767), (4099, 32767)], None, 1.0),
            (&[(4096, 32767), (4099, 32767)], Some(feet), us_foot),
            (&[(4099, 9003)], None, us_foot),
            (&[(4096, 5703)], None, 1.0),
            (&[(4096, 6360)], None, us_foot),
            (&[(4096, 8228)], None, 0.3048),
            (&[(4096, 6360), (4099, 9003)], Some(feet), us_foot),
            (&[], Some(feet), us_foot),
            (&[], Some(&second), 1.0),
        ] {
            let found = height_unit_m(&keys(entries), metadata).expect("known");
            assert!((found / wanted - 1.0).abs() < 1e-9, "{entries:?} {metadata:?}: {found}");
        }
        for (entries, metadata) in [
            (&[(4099, 9014)][..], None),
            (&[(4096, 6360), (4099, 9001)], None),
            (&[(4099, 9001)], Some(feet)),
            (&[], Some(&other)),
        ] {
            assert!(height_unit_m(&keys(entries), metadata).is_err(), "{entries:?}");
        }
    }
}
