//! Part of the first band of a TIFF file, from the strips or tiles that hold it and no others.
//!
//! A compressed strip or tile has to be decoded as a whole. Uncompressed ones are read by rows, as some software puts a
//! whole picture into one strip.

use std::io::{Read, Seek};
use std::ops::Range;

use tiff::decoder::{DecodingResult, DecodingSampleType};
use tiff::tags::{ByteOrder, Tag};
use tiff::{ColorType, TiffResult};

use crate::error::InputError;

use super::NO_SAMPLE_TYPE;
use super::header::{TiffFile, broken};

/// Most bytes that a compressed strip or tile, or one row of an uncompressed one, may have.
pub(super) const CHUNK_BYTES_MAX: usize = 1 << 30;

/// Bytes of an uncompressed strip or tile that are read at a time, at least a row.
const BLOCK_BYTES: usize = 1 << 20;

/// Takes (row, first column, samples that follow it in that row), counted in the whole picture.
pub(crate) type Put<'a> = dyn FnMut(usize, usize, &[f64]) + 'a;

/// Columns and rows of a picture, neither of them empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Part {
    pub cols: Range<usize>,
    pub rows: Range<usize>,
}

impl<R: Read + Seek> TiffFile<R> {
    /// Hands the first band of `part`, which lies inside the picture, to `put`: each sample once, rows from the top, in a
    /// row of tiles tile by tile.
    ///
    /// # Errors
    /// The samples are broken, cut short or of another type; a strip or tile is too large.
    pub fn first_band(self, part: &Part, put: &mut Put) -> Result<(), InputError> {
        if let ColorType::YCbCr(_) = self.colour {
            return Err(self.refuse("its first band is the luma of a colour picture"));
        }
        let mut file = self.with_memory(CHUNK_BYTES_MAX);
        let plain = file.plain().map_err(|error| broken(&file.path, &error))?;
        let (chunk_cols, chunk_rows) = file.decoder.chunk_dimensions();
        let (chunk_cols, chunk_rows) = (chunk_cols as usize, chunk_rows as usize);
        let across = (file.cols as usize).div_ceil(chunk_cols);
        for down in part.rows.start / chunk_rows..part.rows.end.div_ceil(chunk_rows) {
            for right in part.cols.start / chunk_cols..part.cols.end.div_ceil(chunk_cols) {
                let chunk = Chunk { index: down * across + right, row: down * chunk_rows, col: right * chunk_cols };
                let wanted = Part {
                    cols: part.cols.start.max(chunk.col)..part.cols.end.min(chunk.col + chunk_cols),
                    rows: part.rows.start.max(chunk.row)..part.rows.end.min(chunk.row + chunk_rows),
                };
                match &plain {
                    Some(plain) => file.read_plain(plain, &chunk, chunk_cols, &wanted, put)?,
                    None => file.read_decoded(&chunk, &wanted, put)?,
                }
            }
        }
        Ok(())
    }

    /// How samples lie in the file, if they lie there as they are.
    fn plain(&mut self) -> TiffResult<Option<Plain>> {
        let decoder = &mut self.decoder;
        let mut number = |tag, default: u16| TiffResult::Ok(decoder.find_tag_unsigned(tag)?.unwrap_or(default));
        let uncompressed = number(Tag::Compression, 1)? == 1 && number(Tag::Predictor, 1)? == 1;
        let black_is_zero = number(Tag::PhotometricInterpretation, 1)? != 0;
        let samples = if self.planes > 1 { 1 } else { number(Tag::SamplesPerPixel, 1)? };
        let sample_type = decoder.image_buffer_layout()?.sample_type;
        let (true, true, Some(sample_type)) = (uncompressed, black_is_zero, sample_type) else {
            return Ok(None);
        };
        let offsets = match decoder.find_tag(Tag::StripOffsets)? {
            Some(offsets) => offsets,
            None => decoder.get_tag(Tag::TileOffsets)?,
        };
        Ok(Some(Plain {
            offsets: offsets.into_u64_vec()?,
            pixel_bytes: usize::from(samples) * usize::from(self.colour.bit_depth() / 8),
            sample_type,
            little_endian: decoder.byte_order() == ByteOrder::LittleEndian,
        }))
    }

    fn read_plain(
        &mut self,
        plain: &Plain,
        chunk: &Chunk,
        chunk_cols: usize,
        wanted: &Part,
        put: &mut Put,
    ) -> Result<(), InputError> {
        let row_bytes = chunk_cols.saturating_mul(plain.pixel_bytes);
        let Some(&offset) = plain.offsets.get(chunk.index) else {
            return Err(self.refuse("it has fewer strips or tiles than its size asks for"));
        };
        if row_bytes > CHUNK_BYTES_MAX {
            return Err(self.refuse(&format!("rows of {row_bytes} bytes are not read")));
        }
        let at_once = (BLOCK_BYTES / row_bytes).max(1);
        let columns =
            (wanted.cols.start - chunk.col) * plain.pixel_bytes..(wanted.cols.end - chunk.col) * plain.pixel_bytes;
        let (mut bytes, mut samples) = (Vec::new(), Vec::new());
        for first in wanted.rows.clone().step_by(at_once) {
            let count = at_once.min(wanted.rows.end - first);
            bytes.resize(count * row_bytes, 0);
            let start = offset + (first - chunk.row) as u64 * row_bytes as u64;
            self.decoder
                .goto_offset_u64(start)
                .and_then(|()| self.decoder.inner().read_exact(&mut bytes))
                .map_err(|error| broken(&self.path, &error.into()))?;
            for (row, bytes) in bytes.chunks_exact(row_bytes).enumerate() {
                samples.clear();
                if !plain.floats(&bytes[columns.clone()], &mut samples) {
                    return Err(self.refuse(NO_SAMPLE_TYPE));
                }
                put(first + row, wanted.cols.start, &samples);
            }
        }
        Ok(())
    }

    fn read_decoded(&mut self, chunk: &Chunk, wanted: &Part, put: &mut Put) -> Result<(), InputError> {
        let broken = |error| broken(&self.path, &error);
        let index = u32::try_from(chunk.index).map_err(|error| broken(error.into()))?;
        let decoded = self.decoder.read_chunk(index).map_err(broken)?;
        let (width, _) = self.decoder.chunk_data_dimensions(index);
        let bands = if self.planes > 1 { 1 } else { self.bands };
        let run = Run { chunk, wanted, width: width as usize, bands };
        let whole = match decoded {
            DecodingResult::U8(v) => run.convert(&v, f64::from, put),
            DecodingResult::U16(v) => run.convert(&v, f64::from, put),
            DecodingResult::I16(v) => run.convert(&v, f64::from, put),
            DecodingResult::U32(v) => run.convert(&v, f64::from, put),
            DecodingResult::I32(v) => run.convert(&v, f64::from, put),
            DecodingResult::F32(v) => run.convert(&v, f64::from, put),
            DecodingResult::F64(v) => run.convert(&v, |x| x, put),
            _ => return Err(self.refuse(NO_SAMPLE_TYPE)),
        };
        whole.ok_or_else(|| self.refuse("a strip or tile has fewer samples than its header says"))
    }
}

/// A strip or tile of the first band: its number and its first row and column.
struct Chunk {
    index: usize,
    row: usize,
    col: usize,
}

/// How the samples of a decoded strip or tile lie, and which are wanted.
struct Run<'a> {
    chunk: &'a Chunk,
    wanted: &'a Part,
    /// Columns of the strip or tile, those beyond the picture left out.
    width: usize,
    /// Samples a pixel.
    bands: usize,
}

impl Run<'_> {
    /// Hands out the wanted samples, bands interleaved, by row; `None` where there are too few.
    fn each<T>(&self, samples: &[T], mut take: impl FnMut(usize, &[T])) -> Option<()> {
        for row in self.wanted.rows.clone() {
            let line = (row - self.chunk.row) * self.width;
            let [start, end] = [self.wanted.cols.start, self.wanted.cols.end].map(|col| line + col - self.chunk.col);
            take(row, samples.get(start * self.bands..end * self.bands)?);
        }
        Some(())
    }

    fn convert<T: Copy>(&self, samples: &[T], float: impl Fn(T) -> f64, put: &mut Put) -> Option<()> {
        let mut floats = Vec::new();
        self.each(samples, |row, run| {
            floats.clear();
            floats.extend(run.iter().step_by(self.bands).map(|&sample| float(sample)));
            put(row, self.wanted.cols.start, &floats);
        })
    }
}

/// Samples that lie in the file as they are.
struct Plain {
    /// Of the strips or tiles.
    offsets: Vec<u64>,
    /// From a sample of the first band to the next.
    pixel_bytes: usize,
    sample_type: DecodingSampleType,
    little_endian: bool,
}

impl Plain {
    /// Appends the first sample of each pixel; false where their type is not read.
    fn floats(&self, bytes: &[u8], floats: &mut Vec<f64>) -> bool {
        let pixels = bytes.chunks_exact(self.pixel_bytes);
        macro_rules! extend {
            ($type:ty) => {
                floats.extend(pixels.filter_map(|pixel| pixel.first_chunk()).map(|&sample| {
                    if self.little_endian {
                        <$type>::from_le_bytes(sample) as f64
                    } else {
                        <$type>::from_be_bytes(sample) as f64
                    }
                }))
            };
        }
        match self.sample_type {
            DecodingSampleType::U8 => extend!(u8),
            DecodingSampleType::U16 => extend!(u16),
            DecodingSampleType::I16 => extend!(i16),
            DecodingSampleType::U32 => extend!(u32),
            DecodingSampleType::I32 => extend!(i32),
            DecodingSampleType::F32 => extend!(f32),
            DecodingSampleType::F64 => extend!(f64),
            _ => return false,
        }
        true
    }
}
