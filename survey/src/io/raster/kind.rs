//! What a raster is good for: a model of heights, or a picture. Each taken for the other would be flown as if nothing were wrong.

use std::path::Path;

use super::{SampleType, Scaling};
use crate::error::InputError;
use crate::io::shell::names;

/// Refuses what is no elevation model: several bands, of which nobody knows which one is the ground, and samples of 8 bits, which pictures have.
///
/// # Errors
/// One sentence with the command that makes a model that is taken.
pub fn check_elevation(path: &Path, bands: usize, is_of_8_bits: bool) -> Result<(), InputError> {
    let (name, [single, wide]) = (path.display(), ["band", "int16"].map(|suffix| names(path, suffix)));
    if bands != 1 {
        return Err(InputError::new(format!(
            "{name} has {bands} bands, as pictures have, and an elevation model has one: gdal_translate -b BAND {single} takes the one of the heights"
        )));
    }
    if is_of_8_bits {
        return Err(InputError::new(format!(
            "{name} has samples of 8 bits, as pictures have, and an elevation model has heights: if these are heights in metres, \
             gdal_translate -ot Int16 {wide} says so"
        )));
    }
    Ok(())
}

/// Refuses what is no orthophoto: floating-point, signed and 32-bit samples, which heights and other measured values have; and colours whose
/// scales or offsets differ, of which samples alone make no grey value. One scale for all makes the picture no other one.
///
/// # Errors
/// One sentence with the command that makes a picture that is taken.
pub fn check_picture(path: &Path, sample_type: SampleType, scalings: &[Scaling]) -> Result<(), InputError> {
    let mut colours = scalings.iter().take(3);
    let first = colours.next().copied().unwrap_or(Scaling::NONE);
    let what = match sample_type {
        SampleType::U8 | SampleType::U16 if first.scale > 0.0 && colours.all(|other| *other == first) => return Ok(()),
        SampleType::U8 | SampleType::U16 => {
            return Err(InputError::new(format!(
                "{} has bands of different or negative scales or offsets, so that its samples are no grey values: gdal_translate -ot Byte -scale {} \
                 makes a picture that is taken",
                path.display(),
                names(path, "byte")
            )));
        }
        SampleType::F32 | SampleType::F64 => "floating-point samples",
        SampleType::I16 | SampleType::I32 => "signed samples",
        SampleType::U32 => "samples of 32 bits",
    };
    Err(InputError::new(format!(
        "{} has {what}, as elevation models have, and an orthophoto has 8 or 16 bits without a sign: if it is a picture, \
         gdal_translate -ot Byte -scale {} makes one that is taken",
        path.display(),
        names(path, "byte")
    )))
}

/// A coordinate as people read it: centimetres, or 1e-7 degrees, which are as long.
#[must_use]
pub fn for_people(coordinate: f64) -> f64 {
    let per_unit = if coordinate.abs() <= 360.0 { 1e7 } else { 100.0 };
    let rounded = (coordinate * per_unit).round() / per_unit;
    if rounded.is_finite() { rounded } else { coordinate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_and_pictures_are_told_apart() {
        let path = Path::new("my map.tif");
        assert!(check_elevation(path, 1, false).is_ok());
        let said = check_elevation(path, 3, true).expect_err("bands").to_string();
        assert!(
            said.contains("3 bands") && said.contains("gdal_translate -b BAND 'my map.tif' 'my map_band.tif'"),
            "{said}"
        );
        let said = check_elevation(path, 1, true).expect_err("8 bits").to_string();
        assert!(said.contains("gdal_translate -ot Int16 'my map.tif' 'my map_int16.tif'"), "{said}");
        for sample in [SampleType::U8, SampleType::U16] {
            assert!(check_picture(path, sample, &[Scaling::NONE; 3]).is_ok());
        }
        for sample in [SampleType::I16, SampleType::U32, SampleType::I32, SampleType::F32, SampleType::F64] {
            let said = check_picture(path, sample, &[Scaling::NONE]).expect_err("no picture").to_string();
            assert!(said.contains("gdal_translate -ot Byte -scale 'my map.tif' 'my map_byte.tif'"), "{said}");
        }
    }

    #[test]
    fn colours_of_one_scale_are_a_picture_and_of_several_none() {
        let scaled = |scale: f64| Scaling { scale, offset: -0.1 };
        let check = |scalings: &[Scaling]| check_picture(Path::new("my map.tif"), SampleType::U16, scalings);
        for taken in [&[][..], &[scaled(1e-4)], &[scaled(1e-4), scaled(1e-4), scaled(1e-4), scaled(2.0)]] {
            assert_eq!(check(taken), Ok(()), "{taken:?}");
        }
        for refused in [&[scaled(-1.0)][..], &[scaled(1e-4), scaled(1e-4), scaled(2e-4)]] {
            let said = check(refused).expect_err("refused").to_string();
            assert!(said.contains("gdal_translate -ot Byte -scale 'my map.tif' 'my map_byte.tif'"), "{said}");
        }
    }

    #[test]
    fn coordinates_are_told_as_long_as_people_read_them() {
        assert_eq!([for_people(48.203_703_703_703_7), for_people(600_000.123_456)], [48.203_703_7, 600_000.12]);
    }
}
