//! Synthetic GeoTIFFs, in every layout a decoder has to read.

use std::io::Cursor;

use tiff::encoder::TiffEncoder;
use tiff::encoder::compression::{
    CompressionAlgorithm, Compressor, Deflate, DeflateLevel, Lzw, Packbits, Uncompressed,
};
use tiff::tags::Tag;

/// How a synthetic file is laid out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub cols: usize,
    pub rows: usize,
    /// Columns (tiles; 0 for strips) and rows of a strip or tile.
    pub chunk: (usize, usize),
    pub bands: usize,
    /// TIFF's number: 1 none, 5 LZW, 8 deflate, 32773 PackBits.
    pub compression: u16,
    /// TIFF's sample format: 1 unsigned, 2 signed, 3 float; and its bytes.
    pub sample: (u16, usize),
    pub nodata: Option<&'static str>,
    pub epsg: Option<u16>,
    /// EPSG code of the unit of heights.
    pub height_unit: Option<u16>,
}

pub(super) const PLAIN: Layout = Layout {
    cols: 37,
    rows: 29,
    chunk: (0, 4),
    bands: 1,
    compression: 1,
    sample: (3, 4),
    nodata: None,
    epsg: Some(32633),
    height_unit: None,
};

/// A GeoTIFF whose north-western post is at (1000, 2000), posts every 2 m east and 3 m north. `sample` gives the bytes of
/// (column, row, band).
pub(super) fn geotiff(layout: &Layout, sample: impl Fn(usize, usize, usize) -> Vec<u8>) -> Vec<u8> {
    geotiff_with(layout, None, sample)
}

/// [`geotiff`] with a text of GDAL's metadata.
pub(super) fn geotiff_with(
    layout: &Layout,
    metadata: Option<&str>,
    sample: impl Fn(usize, usize, usize) -> Vec<u8>,
) -> Vec<u8> {
    let Layout { cols, rows, bands, .. } = *layout;
    let tiled = layout.chunk.0 > 0;
    let (width, height) = if tiled { layout.chunk } else { (cols, layout.chunk.1) };
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("encoder");
    let mut directory = encoder.image_directory().expect("directory");
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    for top in (0..rows).step_by(height) {
        for left in (0..cols).step_by(width) {
            let mut bytes = Vec::new();
            let last = if tiled { top + height } else { (top + height).min(rows) };
            for row in top..last {
                for col in left..left + width {
                    for band in 0..bands {
                        // Tiles reach beyond the picture.
                        bytes.extend(sample(col.min(cols - 1), row.min(rows - 1), band));
                    }
                }
            }
            let stored = compressed(layout.compression, &bytes);
            offsets.push(directory.write_data(&stored[..]).expect("data") as u32);
            lengths.push(stored.len() as u32);
        }
    }
    let mut tag = |tag, values: &[u16]| directory.write_tag(tag, values).expect("tag");
    tag(Tag::Compression, &[layout.compression]);
    tag(Tag::PhotometricInterpretation, &[1]);
    tag(Tag::SamplesPerPixel, &[bands as u16]);
    tag(Tag::PlanarConfiguration, &[1]);
    tag(Tag::ImageWidth, &[cols as u16]);
    tag(Tag::ImageLength, &[rows as u16]);
    tag(Tag::BitsPerSample, &vec![8 * layout.sample.1 as u16; bands]);
    tag(Tag::SampleFormat, &vec![layout.sample.0; bands]);
    tag(Tag::GeoKeyDirectoryTag, &geo_keys(layout));
    if tiled {
        tag(Tag::TileWidth, &[width as u16]);
        tag(Tag::TileLength, &[height as u16]);
        directory.write_tag(Tag::TileOffsets, &offsets[..]).expect("offsets");
        directory.write_tag(Tag::TileByteCounts, &lengths[..]).expect("lengths");
    } else {
        tag(Tag::RowsPerStrip, &[height as u16]);
        directory.write_tag(Tag::StripOffsets, &offsets[..]).expect("offsets");
        directory.write_tag(Tag::StripByteCounts, &lengths[..]).expect("lengths");
    }
    directory.write_tag(Tag::ModelPixelScaleTag, &[2.0, 3.0, 0.0][..]).expect("scale");
    directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 1000.0, 2000.0, 0.0][..]).expect("tie");
    if let Some(text) = layout.nodata {
        directory.write_tag(Tag::GdalNodata, text).expect("nodata");
    }
    if let Some(text) = metadata {
        directory.write_tag(Tag::Unknown(42112), text).expect("metadata");
    }
    directory.finish().expect("directory");
    file.into_inner()
}

/// GeoTIFF's directory of keys: kind of the model, pixels are areas, the reference system, the unit of heights.
fn geo_keys(layout: &Layout) -> Vec<u16> {
    let mut keys = match layout.epsg {
        Some(4326) => vec![1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4326],
        Some(code) => vec![1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 2, 3072, 0, 1, code],
        None => vec![1, 1, 0, 1, 1025, 0, 1, 2],
    };
    if let Some(unit) = layout.height_unit {
        keys[3] += 1;
        keys.extend([4099, 0, 1, unit]);
    }
    keys
}

fn compressed(method: u16, bytes: &[u8]) -> Vec<u8> {
    let mut compressor = match method {
        5 => Compressor::Lzw(Lzw),
        8 => Compressor::Deflate(Deflate::with_level(DeflateLevel::Fast)),
        32773 => Compressor::Packbits(Packbits),
        _ => Compressor::Uncompressed(Uncompressed),
    };
    let mut stored = Vec::new();
    compressor.write_to(&mut stored, bytes).expect("compressed");
    stored
}
