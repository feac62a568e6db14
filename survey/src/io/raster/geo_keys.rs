//! The GeoKey directory of a GeoTIFF.
//!
//! Source: OGC GeoTIFF 1.1 (19-008r4), section 7 and annex B. Key numbers are those of the standard.

use crate::io::tiff::GeoTags;

pub(super) const MODEL_TYPE: u16 = 1024;
pub(super) const RASTER_TYPE: u16 = 1025;
pub(super) const GEODETIC_CRS: u16 = 2048;
pub(super) const ANGULAR_UNITS: u16 = 2054;
pub(super) const PROJECTED_CRS: u16 = 3072;
pub(super) const PROJECTION: u16 = 3074;
pub(super) const PROJECTION_METHOD: u16 = 3075;
pub(super) const LINEAR_UNITS: u16 = 3076;
pub(super) const VERTICAL_CRS: u16 = 4096;
pub(super) const VERTICAL_DATUM: u16 = 4098;
pub(super) const VERTICAL_UNITS: u16 = 4099;

pub(super) const MODEL_PROJECTED: u16 = 1;
pub(super) const MODEL_GEOGRAPHIC: u16 = 2;
pub(super) const MODEL_GEOCENTRIC: u16 = 3;
pub(super) const RASTER_PIXEL_IS_AREA: u16 = 1;
const RASTER_PIXEL_IS_POINT: u16 = 2;
pub(super) const USER_DEFINED: u16 = 32767;
pub(super) const METRE: u16 = 9001;
pub(super) const DEGREE: u16 = 9102;

/// Tag number of the double parameters: where a key's value is a double.
pub(super) const DOUBLES_TAG: u16 = 34736;

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

    /// The geodetic system below a projected one, where it has a code.
    pub fn base_epsg(&self) -> Option<u16> {
        self.short(GEODETIC_CRS).filter(|code| *code != USER_DEFINED)
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

    #[test]
    fn malformed_directories_are_refused() {
        for keys in [vec![1, 1], vec![1, 1, 0, 2, 1024, 0, 1, 1], vec![1, 1, 0, 1, 3078, 34736, 1, 9]] {
            let tags = GeoTags { keys: Some(keys), ..GeoTags::default() };
            assert!(GeoKeys::read(&tags).is_err());
        }
    }
}
