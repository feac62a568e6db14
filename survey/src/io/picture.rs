//! Pictures in memory: camera frames, patches, tiles and masks as files hold them; grey but for those of several bands.

use std::io::Cursor;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, ImageReader};

use crate::error::InputError;
use crate::io::input;
use crate::io::output::write_file;
use crate::io::tiff::{SAMPLES_MAX, Samples, is_tiff, read_tiff};

/// An 8-bit grey picture, origin top left, rows one after the other: `pixels[row * cols + col]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Grey values, `cols * rows` of them.
    pub pixels: Vec<u8>,
}

/// An 8-bit picture of one band (grey) or three (RGB), each band a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bands(pub Vec<Picture>);

impl Bands {
    /// (columns, rows).
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.0.first().map_or((0, 0), |band| (band.cols, band.rows))
    }

    /// Its grey: the only band, or luma as of [`read_grey`].
    #[must_use]
    pub fn grey(&self) -> Picture {
        let (cols, rows) = self.size();
        let pixels = match self.0.as_slice() {
            [red, green, blue] => {
                let pixels = red.pixels.iter().zip(&green.pixels).zip(&blue.pixels);
                pixels.map(|((r, g), b)| rounded(weighted(*r, *g, *b), 1000)).collect()
            }
            bands => bands.first().map_or_else(Vec::new, |band| band.pixels.clone()),
        };
        Picture { cols, rows, pixels }
    }
}

/// Reads a PNG, TIFF or JPEG picture of 8 or 16 bits, grey or RGB, as 8-bit grey.
///
/// RGB becomes luma by ITU-R BT.601 (0.299 R + 0.587 G + 0.114 B); 16 bits are divided by 257, which takes 65535 to
/// 255; both are rounded once, half up. An alpha band is not looked at. Pixels are taken as stored: an
/// orientation tag of EXIF turns nothing, for the frame's row 0 is the sensor's.
///
/// # Errors
/// The file is missing, broken, cut short, empty, none of the three formats, or of another sample type.
pub fn read_grey(path: &Path) -> Result<Picture, InputError> {
    let Decoded { cols, rows, bands, samples } = decode(path)?;
    let pixels = match samples {
        Depth::Eight(samples) => grey_from_8(&samples, bands),
        Depth::Sixteen(samples) => grey_from_16(&samples, bands),
    };
    Ok(Picture { cols, rows, pixels })
}

/// Reads a picture with its colours: one band of a grey picture, three of a colour picture, without alpha.
///
/// # Errors
/// As [`read_grey`].
pub fn read_bands(path: &Path) -> Result<Bands, InputError> {
    let Decoded { cols, rows, bands, samples } = decode(path)?;
    let colours = if bands < 3 { 1 } else { 3 };
    let band = |band: usize| match &samples {
        Depth::Eight(samples) => samples.chunks_exact(bands).map(|pixel| pixel[band]).collect(),
        Depth::Sixteen(samples) => {
            samples.chunks_exact(bands).map(|pixel| rounded(u32::from(pixel[band]), 257)).collect()
        }
    };
    Ok(Bands((0..colours).map(|index| Picture { cols, rows, pixels: band(index) }).collect()))
}

/// A picture as its file has it.
struct Decoded {
    cols: usize,
    rows: usize,
    /// Interleaved by pixel: grey, grey and alpha, RGB, RGB and alpha.
    bands: usize,
    samples: Depth,
}

/// Samples of 8 or 16 bits.
enum Depth {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

fn decode(path: &Path) -> Result<Decoded, InputError> {
    let bytes = input::picture(path, "a PNG, TIFF or JPEG file", |start| {
        is_tiff(start) || matches!(image::guess_format(start), Ok(ImageFormat::Png | ImageFormat::Jpeg))
    })?;
    if !is_tiff(&bytes) {
        return read_png_or_jpeg(&bytes)
            .map_err(|why| InputError::new(format!("cannot read picture {}: {why}", path.display())));
    }
    let picture = read_tiff(&bytes, path)?;
    let samples = match (picture.samples, picture.bands) {
        (Samples::U8(samples), 1..=4) => Depth::Eight(samples),
        (Samples::U16(samples), 1..=4) => Depth::Sixteen(samples),
        _ => {
            return Err(InputError::new(format!("{} is not a picture of 8 or 16 bits, grey or RGB", path.display())));
        }
    };
    Ok(Decoded { cols: picture.cols, rows: picture.rows, bands: picture.bands, samples })
}

/// Writes an 8-bit grey PNG. The same picture gives the same bytes. See [`write_file`] for how it comes to disk.
///
/// # Errors
/// The picture is empty or its pixels are not `cols * rows`, or the file cannot be written.
pub fn write_grey_png(path: &Path, picture: &Picture) -> Result<(), InputError> {
    let (cols, rows) = (picture.cols, picture.rows);
    write_png(path, cols, rows, &picture.pixels, ExtendedColorType::L8, 1)
}

/// Writes an 8-bit RGB PNG: `rgb[(row * cols + col) * 3 + band]`. As [`write_grey_png`] in all else.
///
/// # Errors
/// The picture is empty or its samples are not `3 * cols * rows`, or the file cannot be written.
pub fn write_rgb_png(path: &Path, cols: usize, rows: usize, rgb: &[u8]) -> Result<(), InputError> {
    write_png(path, cols, rows, rgb, ExtendedColorType::Rgb8, 3)
}

fn write_png(
    path: &Path,
    cols: usize,
    rows: usize,
    samples: &[u8],
    colour: ExtendedColorType,
    bands: usize,
) -> Result<(), InputError> {
    let refuse = |why: String| InputError::new(format!("cannot write picture {}: {why}", path.display()));
    let wanted = cols.checked_mul(rows).and_then(|count| count.checked_mul(bands));
    let (Ok(width), Ok(height)) = (u32::try_from(cols), u32::try_from(rows)) else {
        return Err(refuse(format!("{cols} x {rows} is too large")));
    };
    if samples.is_empty() || wanted != Some(samples.len()) {
        return Err(refuse(format!("{} samples do not make {cols} x {rows} pixels of {bands} bands", samples.len())));
    }
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive)
        .write_image(samples, width, height, colour)
        .map_err(|error| refuse(error.to_string()))?;
    write_file(path, &png)
}

/// A PNG or JPEG file in memory, or why not.
fn read_png_or_jpeg(bytes: &[u8]) -> Result<Decoded, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    let whole = match reader.format() {
        Some(ImageFormat::Png) => png_is_whole(bytes),
        Some(ImageFormat::Jpeg) => jpeg_is_whole(bytes),
        _ => return Err("it is not a PNG, TIFF or JPEG file".into()),
    };
    if !whole {
        return Err("it is cut short".into());
    }
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(2 * SAMPLES_MAX);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| error.to_string())?;
    let (cols, rows) = (decoded.width() as usize, decoded.height() as usize);
    if cols == 0 || rows == 0 {
        return Err(format!("it is empty ({cols} x {rows})"));
    }
    let (bands, samples) = match decoded {
        DynamicImage::ImageLuma8(p) => (1, Depth::Eight(p.into_raw())),
        DynamicImage::ImageLumaA8(p) => (2, Depth::Eight(p.into_raw())),
        DynamicImage::ImageRgb8(p) => (3, Depth::Eight(p.into_raw())),
        DynamicImage::ImageRgba8(p) => (4, Depth::Eight(p.into_raw())),
        DynamicImage::ImageLuma16(p) => (1, Depth::Sixteen(p.into_raw())),
        DynamicImage::ImageLumaA16(p) => (2, Depth::Sixteen(p.into_raw())),
        DynamicImage::ImageRgb16(p) => (3, Depth::Sixteen(p.into_raw())),
        DynamicImage::ImageRgba16(p) => (4, Depth::Sixteen(p.into_raw())),
        _ => return Err("it is not a picture of 8 or 16 bits, grey or RGB".into()),
    };
    Ok(Decoded { cols, rows, bands, samples })
}

/// Whether a PNG file has its last chunk. The decoder stops at the last pixel and would not miss it.
fn png_is_whole(bytes: &[u8]) -> bool {
    const END: &[u8] = b"IEND\xae\x42\x60\x82";
    bytes.windows(END.len()).rev().any(|window| window == END)
}

/// Whether the last scan of a JPEG file has an end of image behind it. The decoder paints a missing rest grey.
///
/// Inside a scan 0xFF is always followed by 0x00 or a restart marker, so neither pattern occurs there by chance.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    let last_scan = bytes.windows(2).rposition(|pair| pair == [0xFF, 0xDA]);
    last_scan.is_some_and(|start| bytes[start..].windows(2).any(|pair| pair == [0xFF, 0xD9]))
}

/// Luma weights of BT.601 in thousandths.
const LUMA: [u32; 3] = [299, 587, 114];

/// Grey of 8-bit samples interleaved by pixel: one or two bands are grey (and alpha), three or four RGB (and alpha).
fn grey_from_8(samples: &[u8], bands: usize) -> Vec<u8> {
    samples
        .chunks_exact(bands)
        .map(|pixel| match pixel {
            [r, g, b, ..] => rounded(weighted(*r, *g, *b), 1000),
            [grey, ..] => *grey,
            [] => 0,
        })
        .collect()
}

/// As [`grey_from_8`] for 16 bits: 65535 / 255 = 257 steps a grey value, one rounding for luma and scale.
fn grey_from_16(samples: &[u16], bands: usize) -> Vec<u8> {
    samples
        .chunks_exact(bands)
        .map(|pixel| match pixel {
            [r, g, b, ..] => rounded(weighted(*r, *g, *b), 257_000),
            [grey, ..] => rounded(u32::from(*grey), 257),
            [] => 0,
        })
        .collect()
}

fn weighted(r: impl Into<u32>, g: impl Into<u32>, b: impl Into<u32>) -> u32 {
    LUMA[0] * r.into() + LUMA[1] * g.into() + LUMA[2] * b.into()
}

/// Quotient rounded half up; at most 255 for the sums above.
fn rounded(sum: u32, divisor: u32) -> u8 {
    ((sum + divisor / 2) / divisor) as u8
}

#[cfg(test)]
mod tests;
