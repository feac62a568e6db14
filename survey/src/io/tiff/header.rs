//! A TIFF file opened: what its first picture is and where its strips or tiles lie; no sample is read yet.

use std::io::{ErrorKind, Read, Seek};
use std::path::{Path, PathBuf};

use tiff::decoder::{Decoder, Limits, ifd::Value};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError, TiffResult};

use crate::error::InputError;

/// Why a sample type is refused.
pub(super) const NO_SAMPLE_TYPE: &str = "its sample type is none of u8, u16, i16, u32, i32, f32 and f64";

/// The tag of GDAL's metadata, by GDAL's documentation of its GeoTIFF driver.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// Tags of the georeference, uninterpreted; absent ones are `None`.
#[derive(Debug, Default)]
pub(crate) struct GeoTags {
    pub pixel_scale: Option<Vec<f64>>,
    pub tiepoints: Option<Vec<f64>>,
    pub transformation: Option<Vec<f64>>,
    pub keys: Option<Vec<u16>>,
    pub key_doubles: Option<Vec<f64>>,
    pub nodata: Option<String>,
    /// GDAL's own, XML.
    pub metadata: Option<String>,
}

/// The first picture of an opened TIFF file.
pub(crate) struct TiffFile<R: Read + Seek> {
    pub cols: u32,
    pub rows: u32,
    pub bands: usize,
    /// Bands that lie apart from each other (planar configuration), else 1.
    pub planes: usize,
    pub colour: ColorType,
    pub geo: GeoTags,
    pub(super) decoder: Decoder<R>,
    pub(super) path: PathBuf,
}

/// Whether the bytes begin like a TIFF or BigTIFF file.
pub(crate) fn is_tiff(bytes: &[u8]) -> bool {
    matches!(bytes.get(..4), Some(b"II\x2a\0" | b"MM\0\x2a" | b"II\x2b\0" | b"MM\0\x2b"))
}

/// The decoder's complaint about a file.
pub(super) fn broken(path: &Path, error: &TiffError) -> InputError {
    let why = match error {
        TiffError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => "it is cut off".to_owned(),
        error => error.to_string(),
    };
    InputError::new(format!("cannot read {} as TIFF: {why}", path.display()))
}

/// Compressions that are not read, by the names that GDAL gives them; codes from libtiff's `tiff.h`.
const COMPRESSIONS: [(u16, &str); 6] = [
    (50_000, "ZSTD"),
    (50_001, "WebP"),
    (34_887, "LERC"),
    (34_925, "LZMA"),
    (34_712, "JPEG 2000"),
    (50_002, "JPEG XL"),
];

/// Refuses a compression that is not read, with the command that changes it.
fn compression<R: Read + Seek>(decoder: &mut Decoder<R>, path: &Path) -> Result<(), InputError> {
    let code = decoder.find_tag(Tag::Compression).map_err(|error| broken(path, &error))?;
    let code = code.and_then(|code| code.into_u16().ok()).unwrap_or(1);
    let Some((_, name)) = COMPRESSIONS.iter().find(|(known, _)| *known == code) else { return Ok(()) };
    let path = path.display();
    Err(InputError::new(format!(
        "{path} is compressed by {name}, which is not read: gdal_translate -co COMPRESS=DEFLATE {path} OUT.tif"
    )))
}

impl<R: Read + Seek> TiffFile<R> {
    /// Reads the header of a file of `file_len` bytes; `path` is for the error's sentence only.
    ///
    /// # Errors
    /// The header is broken; the picture is empty, in colours other than grey or RGB, of samples that are not whole
    /// bytes; a strip or tile does not lie inside the file, or there is none where one should be.
    pub fn open(reader: R, file_len: u64, path: &Path) -> Result<Self, InputError> {
        let broken = |error| broken(path, &error);
        let refuse = |why: &str| Err(refusal(path, why));
        // A tag's values take up to 32 bytes each in memory and at least one in the file.
        let memory = usize::try_from(file_len).unwrap_or(usize::MAX).saturating_mul(32);
        let mut decoder = Decoder::new(reader).map_err(broken)?.with_limits(limits(memory));

        compression(&mut decoder, path)?;
        let (cols, rows) = decoder.dimensions().map_err(broken)?;
        let colour = decoder.colortype().map_err(broken)?;
        let bands = match colour {
            ColorType::Gray(_)
            | ColorType::GrayA(_)
            | ColorType::RGB(_)
            | ColorType::RGBA(_)
            | ColorType::YCbCr(8)
            | ColorType::Multiband { .. } => usize::from(colour.num_samples()),
            other => return refuse(&format!("its colours {other:?} are neither grey nor RGB")),
        };
        if !matches!(colour.bit_depth(), 8 | 16 | 32 | 64) {
            return refuse(&format!("samples of {} bits are not read", colour.bit_depth()));
        }
        if cols == 0 || rows == 0 || bands == 0 {
            return refuse(&format!("it is empty ({cols} x {rows})"));
        }
        let planes = decoder.image_buffer_layout().map_err(broken)?.planes;
        // The decoder prints a line of its own about a text that is too long.
        if decoder.image_ifd().find_entry(Tag::GdalNodata).is_some_and(|text| text.count() > file_len) {
            return refuse("it is cut short");
        }
        let geo = geo_tags(&mut decoder).map_err(broken)?;
        match chunks(&mut decoder, file_len).map_err(broken)? {
            Chunks::Whole => {}
            Chunks::Absent => return refuse("some of its strips or tiles are left out"),
            Chunks::Beyond => return refuse("it is cut short"),
        }
        Ok(Self { cols, rows, bands, planes, colour, geo, decoder, path: path.to_owned() })
    }

    /// The reader with another limit on the bytes that it decodes at a time.
    pub(super) fn with_memory(mut self, bytes: usize) -> Self {
        self.decoder = self.decoder.with_limits(limits(bytes));
        self
    }

    /// Why this file is not read.
    pub(super) fn refuse(&self, why: &str) -> InputError {
        refusal(&self.path, why)
    }
}

fn refusal(path: &Path, why: &str) -> InputError {
    InputError::new(format!("cannot read {} as TIFF: {why}", path.display()))
}

fn limits(bytes: usize) -> Limits {
    let mut limits = Limits::unlimited();
    limits.decoding_buffer_size = bytes;
    limits
}

/// Where the strips or tiles of a file lie.
enum Chunks {
    /// All inside it.
    Whole,
    /// One is not there at all: a sparse file.
    Absent,
    /// One ends behind the file. Some decompressors fill up what is missing in silence.
    Beyond,
}

fn chunks<R: Read + Seek>(decoder: &mut Decoder<R>, file_len: u64) -> TiffResult<Chunks> {
    for (offsets, lengths) in [(Tag::StripOffsets, Tag::StripByteCounts), (Tag::TileOffsets, Tag::TileByteCounts)] {
        let (Some(offsets), Some(lengths)) = (decoder.find_tag(offsets)?, decoder.find_tag(lengths)?) else {
            continue;
        };
        let (offsets, lengths) = (offsets.into_u64_vec()?, lengths.into_u64_vec()?);
        if lengths.contains(&0) {
            return Ok(Chunks::Absent);
        }
        let mut ends = offsets.iter().zip(&lengths).map(|(offset, length)| offset.checked_add(*length));
        return Ok(if ends.all(|end| end.is_some_and(|end| end <= file_len)) { Chunks::Whole } else { Chunks::Beyond });
    }
    Ok(Chunks::Whole)
}

fn geo_tags<R: Read + Seek>(decoder: &mut Decoder<R>) -> TiffResult<GeoTags> {
    let mut doubles =
        |tag| -> TiffResult<Option<Vec<f64>>> { decoder.find_tag(tag)?.map(Value::into_f64_vec).transpose() };
    Ok(GeoTags {
        pixel_scale: doubles(Tag::ModelPixelScaleTag)?,
        tiepoints: doubles(Tag::ModelTiepointTag)?,
        transformation: doubles(Tag::ModelTransformationTag)?,
        key_doubles: doubles(Tag::GeoDoubleParamsTag)?,
        keys: decoder.find_tag(Tag::GeoKeyDirectoryTag)?.map(Value::into_u16_vec).transpose()?,
        metadata: decoder.find_tag(GDAL_METADATA)?.and_then(|text| text.into_string().ok()),
        nodata: decoder.find_tag(Tag::GdalNodata)?.map(Value::into_string).transpose()?,
    })
}
