//! Georeferenced rasters: orthophotos and digital elevation models from GeoTIFF.

mod fill;
mod geo_keys;
mod geo_transform;
mod heights;
mod kind;
mod metadata;
mod metric;
mod placed;
mod posts;
mod rough;
mod system;
mod user_defined;
mod write;

use std::path::Path;

use crate::crs::System;
use crate::error::InputError;
use crate::io::input;
use crate::io::tiff::{GeoTags, Samples, is_tiff, read_tiff};

pub use geo_transform::GeoTransform;
pub use kind::{check_elevation, check_picture, for_people};
pub use metadata::Scaling;
pub use metric::{check_metres, check_metric, check_square, is_web_mercator, utm_zone};
pub use placed::Placed;
pub use posts::Posts;
pub use system::{HeightDatum, vertical_unit_m};
pub use write::{Band, geotiff_bytes, grey_geotiff_bytes};

/// The sample type a raster had in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleType {
    /// Unsigned, 8 bits.
    U8,
    /// Unsigned, 16 bits.
    U16,
    /// Signed, 16 bits.
    I16,
    /// Unsigned, 32 bits.
    U32,
    /// Signed, 32 bits.
    I32,
    /// IEEE float, 32 bits.
    F32,
    /// IEEE float, 64 bits.
    F64,
}

/// A georeferenced raster, north up, all bands in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Columns, eastward.
    pub cols: usize,
    /// Rows, southward.
    pub rows: usize,
    /// Bands, at least one.
    pub bands: usize,
    /// Samples interleaved by pixel: `data[(row * cols + col) * bands + band]`, in the file's units. From 32 and
    /// 64-bit files they are rounded to `f32`: at 4000 m that is 0.25 mm.
    pub data: Vec<f32>,
    /// Value that stands for "nothing known here" in every band, rounded as the samples are.
    pub nodata: Option<f32>,
    /// From pixels to the world and back.
    pub geo: GeoTransform,
    /// The horizontal reference system; `None` where the file names none at all (local metres).
    pub crs: Option<System>,
    /// Metres of a unit of height, where the samples are heights: 1 unless the file says otherwise.
    pub height_unit_m: f64,
    /// Whether the file says that its samples are heights: a unit of heights, a vertical system, a scale.
    pub has_heights: bool,
    /// Of each band, how its samples become its values: [`Scaling::NONE`] unless the file says otherwise.
    pub scalings: Vec<Scaling>,
    /// Sample type in the file.
    pub sample_type: SampleType,
}

impl Raster {
    /// Reads the first picture of a GeoTIFF.
    ///
    /// The georeference is `ModelPixelScale` with one `ModelTiepoint`, or `ModelTransformation`; both kinds of pixel
    /// reference (area and point) are heeded. A reference system that the file spells out instead of naming (key 32767)
    /// is looked up by its parameters, and stays user-defined where the EPSG list has none with them. Samples stay in the file's units; a vertical datum is not interpreted.
    ///
    /// # Errors
    /// The file is missing, broken, cut short, no GeoTIFF; it has no georeference, one with a rotation or south up; its
    /// reference system is not certain, or user-defined in a way that nothing can be converted by; its units are not
    /// metres (degrees for a geographic system); its no-data tag is not a number.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let bytes = input::picture(path, "a TIFF file", is_tiff)?;
        let refuse = |why: String| InputError::new(format!("cannot use raster {}: {why}", path.display()));
        let picture = read_tiff(&bytes, path)?;
        drop(bytes);
        let Georeference { geo, crs, nodata, height_unit_m, has_heights, .. } =
            Georeference::read(&picture.geo).map_err(|why| refuse(why.says(path, "cubic")))?;
        let scaling = |band: usize| Scaling::of_band(picture.geo.metadata.as_deref(), band);
        let scalings = (0..picture.bands).map(scaling).collect::<Result<_, _>>().map_err(refuse)?;
        let (data, sample_type) = floats(picture.samples);
        Ok(Self {
            cols: picture.cols,
            rows: picture.rows,
            bands: picture.bands,
            data,
            nodata,
            geo,
            crs,
            height_unit_m,
            has_heights,
            scalings,
            sample_type,
        })
    }

    /// The sample of one band (from 0), or `None` outside the raster, where it is no data, or not finite.
    #[must_use]
    pub fn sample(&self, col: usize, row: usize, band: usize) -> Option<f32> {
        if col >= self.cols || row >= self.rows || band >= self.bands {
            return None;
        }
        let value = *self.data.get((row * self.cols + col) * self.bands + band)?;
        is_known(value, self.nodata).then_some(value)
    }

    /// Grey values, row by row: luma (BT.601) of the bands 1 to 3 where there are three, else band 1. Unsigned 16-bit
    /// samples are scaled to 0..255, all others are left as they are. No-data is not looked at.
    #[must_use]
    pub fn grey(&self) -> Vec<f32> {
        let scale = match self.sample_type {
            SampleType::U16 => 1.0 / 257.0,
            _ => 1.0,
        };
        self.data
            .chunks_exact(self.bands)
            .map(|pixel| match pixel {
                [r, g, b, ..] => (0.299 * r + 0.587 * g + 0.114 * b) * scale,
                [grey, ..] => grey * scale,
                [] => 0.0,
            })
            .collect()
    }
}

/// What the tags of a GeoTIFF say of its pixels, whatever their number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Georeference {
    pub geo: GeoTransform,
    pub crs: Option<System>,
    pub nodata: Option<f32>,
    pub height_unit_m: f64,
    /// Of the first band.
    pub scaling: Scaling,
    /// Whether anything says that the samples are heights.
    pub has_heights: bool,
    pub height_datum: HeightDatum,
    /// Scale and offset of heights in the tags of its place, where they have any.
    pub placed_heights: Option<[f64; 2]>,
}

impl Georeference {
    pub fn read(tags: &GeoTags) -> Result<Self, system::Unread> {
        let keys = geo_keys::GeoKeys::read(tags)?;
        let geo = GeoTransform::from_tags(tags, keys.pixel_is_point())?;
        let crs = system::horizontal(&keys)?;
        let height_unit_m = system::height_unit_m(&keys, tags.metadata.as_deref())?;
        let scaling = Scaling::of_band(tags.metadata.as_deref(), 0)?;
        let nodata = match &tags.nodata {
            Some(text) => Some(number(text).ok_or_else(|| format!("its no-data value \"{text}\" is not a number"))?),
            None => None,
        };
        let has_heights = scaling != Scaling::NONE || system::names_heights(&keys, tags.metadata.as_deref());
        let height_datum = system::height_datum(&keys);
        let placed_heights = GeoTransform::heights_from_tags(tags);
        Ok(Self { geo, crs, nodata, height_unit_m, scaling, has_heights, height_datum, placed_heights })
    }
}

/// Whether a sample says something, with the value that stands for nothing rounded as the samples are.
pub(crate) fn is_known(value: f32, nodata: Option<f32>) -> bool {
    value.is_finite() && Some(value) != nodata
}

/// GDAL writes the no-data value as text, NUL-terminated, sometimes with blanks.
fn number(text: &str) -> Option<f32> {
    let value: f64 = text.trim_matches(['\0', ' ', '\n']).parse().ok()?;
    Some(value as f32)
}

fn floats(samples: Samples) -> (Vec<f32>, SampleType) {
    match samples {
        Samples::U8(v) => (v.into_iter().map(f32::from).collect(), SampleType::U8),
        Samples::U16(v) => (v.into_iter().map(f32::from).collect(), SampleType::U16),
        Samples::I16(v) => (v.into_iter().map(f32::from).collect(), SampleType::I16),
        Samples::U32(v) => (v.into_iter().map(|x| x as f32).collect(), SampleType::U32),
        Samples::I32(v) => (v.into_iter().map(|x| x as f32).collect(), SampleType::I32),
        Samples::F32(v) => (v, SampleType::F32),
        Samples::F64(v) => (v.into_iter().map(|x| x as f32).collect(), SampleType::F64),
    }
}

#[cfg(test)]
mod tests;
