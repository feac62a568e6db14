//! The first picture of a TIFF file as typed samples, with the tags a georeference is made of.
//!
//! Strips (chunky and planar) and tiles (chunky), deflate, LZW, PackBits and JPEG, classic and BigTIFF, as the crate `tiff`
//! has them. Further pictures of the file (overviews, masks) are not looked at.

use std::io::Cursor;
use std::path::Path;

use tiff::ColorType;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits, ifd::Value};
use tiff::tags::Tag;

use crate::error::InputError;

/// Most samples (columns x rows x bands) that are read: 2 GiB as `f32`. A header that claims more is refused.
pub(crate) const SAMPLES_MAX: u64 = 1 << 29;

/// Samples in the type of the file.
#[derive(Debug)]
pub(crate) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    I16(Vec<i16>),
    U32(Vec<u32>),
    I32(Vec<i32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Tags of the georeference, uninterpreted; absent ones are `None`.
#[derive(Debug, Default)]
pub(crate) struct GeoTags {
    pub pixel_scale: Option<Vec<f64>>,
    pub tiepoints: Option<Vec<f64>>,
    pub transformation: Option<Vec<f64>>,
    pub keys: Option<Vec<u16>>,
    pub key_doubles: Option<Vec<f64>>,
    pub nodata: Option<String>,
}

/// A decoded TIFF picture, samples interleaved by pixel: `samples[(row * cols + col) * bands + band]`.
#[derive(Debug)]
pub(crate) struct TiffImage {
    pub cols: usize,
    pub rows: usize,
    pub bands: usize,
    pub samples: Samples,
    pub geo: GeoTags,
}

/// Whether the bytes begin like a TIFF or BigTIFF file.
pub(crate) fn is_tiff(bytes: &[u8]) -> bool {
    matches!(bytes.get(..4), Some(b"II\x2a\0" | b"MM\0\x2a" | b"II\x2b\0" | b"MM\0\x2b"))
}

/// Decodes the first picture of a TIFF file that is in memory; `path` is for the error's sentence only.
pub(crate) fn read_tiff(bytes: &[u8], path: &Path) -> Result<TiffImage, InputError> {
    let broken = |error: tiff::TiffError| InputError::new(format!("cannot read {} as TIFF: {error}", path.display()));
    let refuse = |why: String| Err(InputError::new(format!("cannot read {} as TIFF: {why}", path.display())));
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    // A tag's values take up to 32 bytes each in memory and at least one in the file.
    let mut limits = Limits::default();
    limits.decoding_buffer_size = bytes.len().saturating_mul(32);
    decoder = decoder.with_limits(limits);

    let (cols, rows) = decoder.dimensions().map_err(broken)?;
    let colour = decoder.colortype().map_err(broken)?;
    let bands = match colour {
        ColorType::Gray(_)
        | ColorType::GrayA(_)
        | ColorType::RGB(_)
        | ColorType::RGBA(_)
        | ColorType::YCbCr(8)
        | ColorType::Multiband { .. } => usize::from(colour.num_samples()),
        other => return refuse(format!("its colours {other:?} are neither grey nor RGB")),
    };
    if !matches!(colour.bit_depth(), 8 | 16 | 32 | 64) {
        return refuse(format!("samples of {} bits are not read", colour.bit_depth()));
    }
    let count = u128::from(cols) * u128::from(rows) * bands as u128;
    if count == 0 {
        return refuse(format!("it is empty ({cols} x {rows})"));
    }
    if count > u128::from(SAMPLES_MAX) {
        return refuse(format!("{cols} x {rows} x {bands} samples are more than {SAMPLES_MAX}"));
    }
    let layout = decoder.image_buffer_layout().map_err(broken)?;
    if layout.planes > 1 && decoder.get_chunk_type() == ChunkType::Tile {
        // The decoder loses count at the edge tiles of the second plane.
        return refuse("tiles of one band each (planar configuration) are not read, only strips are".into());
    }
    let geo = geo_tags(&mut decoder).map_err(broken)?;
    if !chunks_lie_inside(&mut decoder, bytes.len() as u64).map_err(broken)? {
        return refuse("it is cut short".into());
    }

    let mut limits = Limits::default();
    limits.decoding_buffer_size = usize::MAX; // bounded by SAMPLES_MAX above
    limits.intermediate_buffer_size = usize::MAX;
    decoder = decoder.with_limits(limits);
    let mut decoded = DecodingResult::U8(Vec::new());
    decoder.read_image_to_buffer(&mut decoded).map_err(broken)?;
    let size = Size { pixels: cols as usize * rows as usize, bands, planes: layout.planes };
    let samples = match decoded {
        DecodingResult::U8(v) => size.interleaved(v).map(Samples::U8),
        DecodingResult::U16(v) => size.interleaved(v).map(Samples::U16),
        DecodingResult::I16(v) => size.interleaved(v).map(Samples::I16),
        DecodingResult::U32(v) => size.interleaved(v).map(Samples::U32),
        DecodingResult::I32(v) => size.interleaved(v).map(Samples::I32),
        DecodingResult::F32(v) => size.interleaved(v).map(Samples::F32),
        DecodingResult::F64(v) => size.interleaved(v).map(Samples::F64),
        _ => {
            return refuse("its sample type is none of u8, u16, i16, u32, i32, f32 and f64".into());
        }
    };
    let Some(mut samples) = samples else {
        return refuse("its picture has fewer samples than its header says".into());
    };
    if let (ColorType::YCbCr(_), Samples::U8(values)) = (colour, &mut samples) {
        values.chunks_exact_mut(3).for_each(rgb_from_ycbcr);
    }
    Ok(TiffImage { cols: cols as usize, rows: rows as usize, bands, samples, geo })
}

/// How decoded samples lie in memory.
struct Size {
    pixels: usize,
    bands: usize,
    planes: usize,
}

impl Size {
    /// Samples interleaved by pixel; `None` where their number does not fit.
    fn interleaved<T: Copy>(&self, samples: Vec<T>) -> Option<Vec<T>> {
        if samples.len() != self.pixels * self.bands {
            return None;
        }
        if self.planes == 1 {
            return Some(samples);
        }
        let planes: Vec<&[T]> = samples.chunks_exact(self.pixels).collect();
        Some((0..self.pixels).flat_map(|pixel| planes.iter().map(move |plane| plane[pixel])).collect())
    }
}

/// JPEG's full-range YCbCr (ITU-R BT.601) to RGB, in place.
fn rgb_from_ycbcr(pixel: &mut [u8]) {
    let [y, cb, cr] = [0, 1, 2].map(|band| f32::from(pixel[band]));
    let (cb, cr) = (cb - 128.0, cr - 128.0);
    let rgb = [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb];
    for (band, value) in pixel.iter_mut().zip(rgb) {
        *band = value.round().clamp(0.0, 255.0) as u8;
    }
}

type MemoryDecoder<'a> = Decoder<Cursor<&'a [u8]>>;

/// Whether every strip or tile ends inside the file. Some decompressors fill up what is missing in silence.
fn chunks_lie_inside(decoder: &mut MemoryDecoder<'_>, file_len: u64) -> tiff::TiffResult<bool> {
    for (offsets, lengths) in [(Tag::StripOffsets, Tag::StripByteCounts), (Tag::TileOffsets, Tag::TileByteCounts)] {
        let (Some(offsets), Some(lengths)) = (decoder.find_tag(offsets)?, decoder.find_tag(lengths)?) else {
            continue;
        };
        let (offsets, lengths) = (offsets.into_u64_vec()?, lengths.into_u64_vec()?);
        return Ok(offsets
            .iter()
            .zip(&lengths)
            .all(|(&offset, &length)| length > 0 && offset.checked_add(length).is_some_and(|end| end <= file_len)));
    }
    Ok(true)
}

fn geo_tags(decoder: &mut MemoryDecoder<'_>) -> tiff::TiffResult<GeoTags> {
    let mut doubles =
        |tag| -> tiff::TiffResult<Option<Vec<f64>>> { decoder.find_tag(tag)?.map(Value::into_f64_vec).transpose() };
    Ok(GeoTags {
        pixel_scale: doubles(Tag::ModelPixelScaleTag)?,
        tiepoints: doubles(Tag::ModelTiepointTag)?,
        transformation: doubles(Tag::ModelTransformationTag)?,
        key_doubles: doubles(Tag::GeoDoubleParamsTag)?,
        keys: decoder.find_tag(Tag::GeoKeyDirectoryTag)?.map(Value::into_u16_vec).transpose()?,
        nodata: decoder.find_tag(Tag::GdalNodata)?.map(Value::into_string).transpose()?,
    })
}
