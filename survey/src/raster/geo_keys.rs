//! The GeoKey directory of a GeoTIFF: which reference system, which units, what a pixel is.
//!
//! Source: OGC GeoTIFF 1.1 (19-008r4), section 7 and annex B. Key numbers are those of the standard.

use crate::tiff_image::GeoTags;

use super::user_defined;

pub(super) const MODEL_TYPE: u16 = 1024;
pub(super) const RASTER_TYPE: u16 = 1025;
pub(super) const GEODETIC_CRS: u16 = 2048;
pub(super) const ANGULAR_UNITS: u16 = 2054;
pub(super) const PROJECTED_CRS: u16 = 3072;
pub(super) const LINEAR_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;

pub(super) const MODEL_PROJECTED: u16 = 1;
pub(super) const MODEL_GEOGRAPHIC: u16 = 2;
const MODEL_GEOCENTRIC: u16 = 3;
pub(super) const RASTER_PIXEL_IS_AREA: u16 = 1;
const RASTER_PIXEL_IS_POINT: u16 = 2;
const USER_DEFINED: u16 = 32767;
pub(super) const METRE: u16 = 9001;
pub(super) const DEGREE: u16 = 9102;

/// Tag number of the double parameters: where a key's value is a double.
const DOUBLES_TAG: u16 = 34736;

/// The keys of one file: short values and double values by key number.
#[derive(Debug, Default)]
pub(super) struct GeoKeys {
    shorts: Vec<(u16, u16)>,
    doubles: Vec<(u16, f64)>,
}

impl GeoKeys {
    /// Reads the directory; a file without one has no keys.
    pub fn read(tags: &GeoTags) -> Result<Self, String> {
        let Some(directory) = tags.keys.as_deref() else {
            return Ok(Self::default());
        };
        let malformed = || String::from("its GeoKey directory is malformed");
        let [_, _, _, count, entries @ ..] = directory else {
            return Err(malformed());
        };
        if entries.len() < 4 * usize::from(*count) {
            return Err(malformed());
        }
        let mut keys = Self::default();
        for entry in entries.chunks_exact(4).take(usize::from(*count)) {
            let [key, location, _, value] = *entry else {
                return Err(malformed());
            };
            if location == 0 {
                keys.shorts.push((key, value));
            } else if location == DOUBLES_TAG {
                let doubles = tags.key_doubles.as_deref().unwrap_or_default();
                let double = doubles.get(usize::from(value)).ok_or_else(malformed)?;
                keys.doubles.push((key, *double));
            } // else a text, which only people read
        }
        Ok(keys)
    }

    pub fn short(&self, key: u16) -> Option<u16> {
        self.shorts.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
    }

    pub fn double(&self, key: u16) -> Option<f64> {
        self.doubles.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
    }

    /// Whether raster coordinates count pixel centres instead of corners.
    pub fn pixel_is_point(&self) -> bool {
        self.short(RASTER_TYPE) == Some(RASTER_PIXEL_IS_POINT)
    }

    /// EPSG code of the horizontal system, `None` where the file names none. Units other than metres and degrees,
    /// and systems that cannot be told for certain, are refused.
    pub fn epsg(&self) -> Result<Option<u32>, String> {
        self.unit_is(VERTICAL_UNITS, METRE, "heights", "metres")?;
        match self.short(MODEL_TYPE) {
            Some(MODEL_PROJECTED) => {
                self.unit_is(LINEAR_UNITS, METRE, "coordinates", "metres")?;
                match self.short(PROJECTED_CRS) {
                    Some(USER_DEFINED) | None => user_defined::epsg(self).map(Some),
                    Some(code) => Ok(Some(u32::from(code))),
                }
            }
            Some(MODEL_GEOGRAPHIC) => {
                self.unit_is(ANGULAR_UNITS, DEGREE, "coordinates", "degrees")?;
                match self.short(GEODETIC_CRS) {
                    Some(USER_DEFINED) | None => Err("its geographic reference system has no EPSG code".into()),
                    Some(code) => Ok(Some(u32::from(code))),
                }
            }
            Some(MODEL_GEOCENTRIC) => Err("its coordinates are geocentric".into()),
            _ if self.short(PROJECTED_CRS).is_some() || self.short(GEODETIC_CRS).is_some() => {
                Err("it names a reference system but not whether it is projected".into())
            }
            _ => {
                self.unit_is(LINEAR_UNITS, METRE, "coordinates", "metres")?;
                Ok(None)
            }
        }
    }

    /// The geodetic system below a projected one, where it has a code.
    pub fn base_epsg(&self) -> Option<u16> {
        self.short(GEODETIC_CRS).filter(|code| *code != USER_DEFINED)
    }

    fn unit_is(&self, key: u16, wanted: u16, what: &str, unit: &str) -> Result<(), String> {
        match self.short(key) {
            Some(code) if code != wanted => Err(format!("its {what} are not in {unit} (EPSG unit {code})")),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Keys with short values only, as a directory holds them.
    pub fn short_keys(entries: &[(u16, u16)]) -> GeoTags {
        let mut directory = vec![1, 1, 0, entries.len() as u16];
        for (key, value) in entries {
            directory.extend([*key, 0, 1, *value]);
        }
        GeoTags { keys: Some(directory), ..GeoTags::default() }
    }

    fn epsg(entries: &[(u16, u16)]) -> Result<Option<u32>, String> {
        GeoKeys::read(&short_keys(entries))?.epsg()
    }

    #[test]
    fn codes_are_read_by_model_type() {
        assert_eq!(epsg(&[(1024, 1), (3072, 31256)]), Ok(Some(31256)));
        assert_eq!(epsg(&[(1024, 2), (2048, 4326)]), Ok(Some(4326)));
        // A projected file also names its base: that is not its system.
        assert_eq!(epsg(&[(1024, 1), (2048, 4312), (3072, 31256)]), Ok(Some(31256)));
        assert_eq!(epsg(&[]), Ok(None));
        assert_eq!(GeoKeys::read(&GeoTags::default()).expect("none").epsg(), Ok(None));
    }

    #[test]
    fn doubtful_systems_and_units_are_refused() {
        for entries in [
            &[(1024, 3)][..],                          // geocentric
            &[(3072, 31256)],                          // no model type
            &[(1024, 2), (2048, 32767)],               // user-defined geographic
            &[(1024, 2)],                              // geographic without code
            &[(1024, 1)],                              // projected without code
            &[(1024, 1), (3072, 2263), (3076, 9003)],  // US survey feet
            &[(1024, 2), (2048, 4807), (2054, 9105)],  // grads
            &[(1024, 1), (3072, 26914), (4099, 9003)], // heights in feet
            &[(3076, 9002)],                           // local feet
        ] {
            assert!(epsg(entries).is_err(), "{entries:?}");
        }
    }

    #[test]
    fn malformed_directories_are_refused() {
        for keys in [vec![1, 1], vec![1, 1, 0, 2, 1024, 0, 1, 1], vec![1, 1, 0, 1, 3078, 34736, 1, 9]] {
            let tags = GeoTags { keys: Some(keys), ..GeoTags::default() };
            assert!(GeoKeys::read(&tags).is_err());
        }
    }
}
