//! What a raster is good for: a model of heights, or a picture. Each taken for the other would be flown as if nothing were wrong.

use std::path::Path;

use super::{SampleType, quoted};
use crate::error::InputError;

/// Lowest ground that a model may have, metres. Chosen: below the shore of the Dead Sea, the lowest land, at some -440 m, and far above the
/// numbers by which files say that they know nothing (-9999, -32768, -3.4e38).
pub const LOWEST_M: f64 = -450.0;
/// Highest ground, metres. Chosen: above the 8,849 m of Mount Everest, and below the numbers that stand for nothing (9999, 32767).
pub const HIGHEST_M: f64 = 9000.0;
/// From here on a number is told with an exponent, as more digits than these no model of heights has.
const LONG: f64 = 1e12;

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

/// Refuses what is no orthophoto: floating-point, signed and 32-bit samples, which heights and other measured values have.
///
/// # Errors
/// One sentence with the command that makes a picture that is taken.
pub fn check_picture(path: &Path, sample_type: SampleType) -> Result<(), InputError> {
    let what = match sample_type {
        SampleType::U8 | SampleType::U16 => return Ok(()),
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

/// Refuses heights that no land has: they are other numbers, mostly those that stand for no data in a file that does not say so. `heights`
/// are the file's, in units of `unit_m`, NaN where unknown; `place` says where the one of an index is.
///
/// # Errors
/// One sentence with the number, its place and what makes it unknown.
pub fn check_heights(
    path: &Path,
    heights: impl IntoIterator<Item = f64>,
    unit_m: f64,
    place: impl FnOnce(usize) -> (f64, f64),
    is_ascii: bool,
) -> Result<(), InputError> {
    let is_none = |height: f64| height * unit_m < LOWEST_M || height * unit_m > HIGHEST_M;
    let Some((index, height)) = heights.into_iter().enumerate().find(|(_, height)| is_none(*height)) else {
        return Ok(());
    };
    let (name, (x, y)) = (quoted(&path.display().to_string()), place(index));
    let said = if height.abs() < LONG { format!("{height}") } else { format!("{height:e}") };
    let against = if height < 0.0 {
        format!("lower than any land, {LOWEST_M}")
    } else {
        format!("higher than any land, {HIGHEST_M}")
    };
    let remedy = if is_ascii {
        format!("a line NODATA_value {said} in its header says so")
    } else {
        format!("gdal_edit.py -a_nodata {said} {name} says so")
    };
    Err(InputError::new(format!(
        "{}: the height {said} at x {}, y {} is {against} m: if it stands for posts without a height, {remedy}",
        path.display(),
        for_people(x),
        for_people(y)
    )))
}

/// A coordinate as people read it: centimetres, or 1e-7 degrees, which are as long.
#[must_use]
pub fn for_people(coordinate: f64) -> f64 {
    let per_unit = if coordinate.abs() <= 360.0 { 1e7 } else { 100.0 };
    let rounded = (coordinate * per_unit).round() / per_unit;
    if rounded.is_finite() { rounded } else { coordinate }
}

/// The file's name and one for what is made of it, as words of a shell's line.
fn names(path: &Path, suffix: &str) -> String {
    let made = format!("{}_{suffix}.tif", path.with_extension("").display());
    format!("{} {}", quoted(&path.display().to_string()), quoted(&made))
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
            assert!(check_picture(path, sample).is_ok());
        }
        for sample in [SampleType::I16, SampleType::U32, SampleType::I32, SampleType::F32, SampleType::F64] {
            let said = check_picture(path, sample).expect_err("no picture").to_string();
            assert!(said.contains("gdal_translate -ot Byte -scale 'my map.tif' 'my map_byte.tif'"), "{said}");
        }
    }

    #[test]
    fn numbers_that_stand_for_nothing_are_no_heights() {
        let path = Path::new("dem.tif");
        let check = |height: f64, unit_m: f64, is_ascii| {
            let heights = [f64::NAN, 100.0, height];
            check_heights(path, heights, unit_m, |index| (600_000.0 + index as f64, 5.0), is_ascii)
        };
        // The shore of the Dead Sea and Mount Everest, in metres and in feet.
        for (height, unit_m) in [(-440.0, 1.0), (8849.0, 1.0), (-1443.0, 0.3048), (29_032.0, 0.3048), (0.0, 1.0)] {
            assert!(check(height, unit_m, false).is_ok(), "{height}");
        }
        let lowest = f64::from(f32::MIN);
        for (height, said) in
            [(-9999.0, "-9999 "), (-32_768.0, "-32768 "), (lowest, "-3.4028234663852886e38 "), (32_767.0, "32767 ")]
        {
            let error = check(height, 1.0, false).expect_err("refused").to_string();
            assert!(error.contains(&format!("-a_nodata {said}dem.tif")) && error.contains("x 600002, y 5 "), "{error}");
        }
        assert!(check(-9999.0, 1.0, true).expect_err("refused").to_string().contains("NODATA_value -9999"));
        assert_eq!([for_people(48.203_703_703_703_7), for_people(600_000.123_456)], [48.203_703_7, 600_000.12]);
    }
}
