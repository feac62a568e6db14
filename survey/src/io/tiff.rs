//! The first picture of a TIFF file as typed samples, with the tags a georeference is made of.
//!
//! Strips and tiles, chunky and planar, deflate, LZW, PackBits and JPEG, classic and BigTIFF, as the crate `tiff`
//! has them. Further pictures of the file (overviews, masks) are not looked at. A file is opened in one way
//! (`header`), then decoded whole from memory, here, or a part of its first band from disk (`window`).

mod header;
mod planes;
mod window;

use std::io::{Cursor, Read, Seek};
use std::path::Path;

use tiff::ColorType;
use tiff::decoder::{ChunkType, DecodingResult};

use crate::error::InputError;

pub(crate) use header::{GeoTags, TiffFile, is_tiff};
use header::{NO_SAMPLE_TYPE, broken};
use window::CHUNK_BYTES_MAX;
pub(crate) use window::{Part, Put};

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

/// A decoded TIFF picture, samples interleaved by pixel: `samples[(row * cols + col) * bands + band]`.
#[derive(Debug)]
pub(crate) struct TiffImage {
    pub cols: usize,
    pub rows: usize,
    pub bands: usize,
    pub samples: Samples,
    pub geo: GeoTags,
}

/// Decodes the first picture of a TIFF file that is in memory; `path` is for the error's sentence only.
pub(crate) fn read_tiff(bytes: &[u8], path: &Path) -> Result<TiffImage, InputError> {
    let file = TiffFile::open(Cursor::new(bytes), bytes.len() as u64, path)?;
    let TiffFile { cols, rows, bands, .. } = file;
    let count = u128::from(cols) * u128::from(rows) * bands as u128;
    if count > u128::from(SAMPLES_MAX) {
        return Err(file.refuse(&format!("{cols} x {rows} x {bands} samples are more than {SAMPLES_MAX}")));
    }
    let has_tiled_planes = file.planes > 1 && file.decoder.get_chunk_type() == ChunkType::Tile;
    // The whole is bounded by SAMPLES_MAX above, but not a tile that reaches beyond the picture.
    let mut file = file.with_memory(if has_tiled_planes { CHUNK_BYTES_MAX } else { usize::MAX });
    let mut samples = if has_tiled_planes { file.tiled_planes()? } else { file.whole()? };
    if let (ColorType::YCbCr(_), Samples::U8(values)) = (file.colour, &mut samples) {
        values.chunks_exact_mut(3).for_each(rgb_from_ycbcr);
    }
    Ok(TiffImage { cols: cols as usize, rows: rows as usize, bands, samples, geo: file.geo })
}

impl<R: Read + Seek> TiffFile<R> {
    /// All bands as the decoder has them, interleaved by pixel.
    fn whole(&mut self) -> Result<Samples, InputError> {
        let mut decoded = DecodingResult::U8(Vec::new());
        self.decoder.read_image_to_buffer(&mut decoded).map_err(|error| broken(&self.path, &error))?;
        let size = Size { pixels: self.cols as usize * self.rows as usize, bands: self.bands, planes: self.planes };
        let samples = match decoded {
            DecodingResult::U8(v) => size.interleaved(v).map(Samples::U8),
            DecodingResult::U16(v) => size.interleaved(v).map(Samples::U16),
            DecodingResult::I16(v) => size.interleaved(v).map(Samples::I16),
            DecodingResult::U32(v) => size.interleaved(v).map(Samples::U32),
            DecodingResult::I32(v) => size.interleaved(v).map(Samples::I32),
            DecodingResult::F32(v) => size.interleaved(v).map(Samples::F32),
            DecodingResult::F64(v) => size.interleaved(v).map(Samples::F64),
            _ => return Err(self.refuse(NO_SAMPLE_TYPE)),
        };
        samples.ok_or_else(|| self.refuse("its picture has fewer samples than its header says"))
    }
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
