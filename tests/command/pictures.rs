//! Picture files of every kind the command reads.

use image::ExtendedColorType;
use plumbline_tests::seeded::Random;
use plumbline_tests::textures::{Ground, Picture, Placement};
use std::fs::File;
use std::path::Path;
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

/// A picture of the one ground that all tests look at, its centre at `centre` (columns right, rows down, pixels).
pub fn texture(size: (u16, u16), centre: (f64, f64)) -> Picture {
    Ground::new(7, 40.0, 4.0).picture(size, Placement { centre, ..Placement::default() }, 0.0, &mut Random::new(1))
}

/// A picture of ground that is nowhere near.
pub fn elsewhere(size: (u16, u16)) -> Picture {
    Ground::new(8, 40.0, 4.0).picture(size, Placement::default(), 0.0, &mut Random::new(1))
}

/// One grey everywhere.
pub fn flat(size: (u16, u16), grey: u8) -> Picture {
    Picture { pixels: vec![grey; usize::from(size.0) * usize::from(size.1)], size }
}

/// Three equal bands.
fn rgb(picture: &Picture) -> Vec<u8> {
    picture.pixels.iter().flat_map(|&grey| [grey; 3]).collect()
}

/// 255 becomes 65535.
fn deep(samples: &[u8]) -> Vec<u16> {
    samples.iter().map(|&sample| u16::from(sample) * 257).collect()
}

fn png(path: &Path, picture: &Picture, samples: &[u8], colour: ExtendedColorType) {
    let (cols, rows) = picture.size;
    image::save_buffer(path, samples, cols.into(), rows.into(), colour).expect("written");
}

/// Sixteen bits as the encoder takes them.
fn native(samples: &[u16]) -> Vec<u8> {
    samples.iter().flat_map(|sample| sample.to_ne_bytes()).collect()
}

pub fn grey_8_png(path: &Path, picture: &Picture) {
    png(path, picture, &picture.pixels, ExtendedColorType::L8);
}

pub fn grey_16_png(path: &Path, picture: &Picture) {
    png(path, picture, &native(&deep(&picture.pixels)), ExtendedColorType::L16);
}

pub fn rgb_8_png(path: &Path, picture: &Picture) {
    png(path, picture, &rgb(picture), ExtendedColorType::Rgb8);
}

pub fn rgb_16_png(path: &Path, picture: &Picture) {
    png(path, picture, &native(&deep(&rgb(picture))), ExtendedColorType::Rgb16);
}

fn tiff<C: colortype::ColorType>(path: &Path, picture: &Picture, samples: &[C::Inner])
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let (cols, rows) = picture.size;
    let mut encoder = TiffEncoder::new(File::create(path).expect("created")).expect("an encoder");
    encoder.write_image::<C>(cols.into(), rows.into(), samples).expect("written");
}

pub fn grey_8_tiff(path: &Path, picture: &Picture) {
    tiff::<colortype::Gray8>(path, picture, &picture.pixels);
}

pub fn grey_16_tiff(path: &Path, picture: &Picture) {
    tiff::<colortype::Gray16>(path, picture, &deep(&picture.pixels));
}

pub fn rgb_8_tiff(path: &Path, picture: &Picture) {
    tiff::<colortype::RGB8>(path, picture, &rgb(picture));
}

pub fn rgb_16_tiff(path: &Path, picture: &Picture) {
    tiff::<colortype::RGB16>(path, picture, &deep(&rgb(picture)));
}

/// Writes a picture in one format.
pub type Writer = fn(&Path, &Picture);

/// Every format the contract names: file name and writer. All hold the same greys.
pub const FORMATS: [(&str, Writer); 8] = [
    ("grey8.png", grey_8_png),
    ("grey16.png", grey_16_png),
    ("rgb8.png", rgb_8_png),
    ("rgb16.png", rgb_16_png),
    ("grey8.tif", grey_8_tiff),
    ("grey16.tif", grey_16_tiff),
    ("rgb8.tif", rgb_8_tiff),
    ("rgb16.tif", rgb_16_tiff),
];

/// What a GeoTIFF says about its reference system.
#[derive(Debug, Clone, Copy)]
pub enum Crs {
    /// Nothing.
    Unnamed,
    /// A projected system, EPSG code.
    Projected(u16),
    /// A geographic one.
    Geographic(u16),
}

/// Writes a GeoTIFF of 8-bit grey, its north-west corner at (500000, 5330000), `step` units a pixel.
pub fn geotiff(path: &Path, picture: &Picture, step: f64, crs: Crs) {
    let (cols, rows) = picture.size;
    let mut encoder = TiffEncoder::new(File::create(path).expect("created")).expect("an encoder");
    let mut image = encoder.new_image::<colortype::Gray8>(cols.into(), rows.into()).expect("a picture");
    let tags = image.encoder();
    // Version 1.1.0 and the number of keys; then per key its number, where its value is (0 = here), count, value.
    let keys: Option<[u16; 12]> = match crs {
        Crs::Unnamed => None,
        Crs::Projected(code) => Some([1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, code]),
        Crs::Geographic(code) => Some([1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, code]),
    };
    let (west, north) = if let Crs::Geographic(_) = crs { (15.0, 48.0) } else { (500_000.0, 5_330_000.0) };
    tags.write_tag(Tag::ModelPixelScaleTag, &[step, step, 0.0][..]).expect("scale");
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, west, north, 0.0][..]).expect("tie point");
    if let Some(keys) = keys {
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).expect("keys");
    }
    image.write_data(&picture.pixels).expect("written");
}

/// Writes an elevation model of 40 x 40 posts of 50 m on UTM 33 that [`geotiff`]'s pictures of up to 1.3 km lie on, with more GeoKeys and
/// with the scale and the offset of heights in the tags of its place.
pub fn heights(path: &Path, more: &[(u16, u16)], [scale, offset]: [f64; 2], height: impl Fn(usize, usize) -> f32) {
    let mut encoder = TiffEncoder::new(File::create(path).expect("created")).expect("an encoder");
    let mut image = encoder.new_image::<colortype::Gray32Float>(40, 40).expect("a raster");
    let tags = image.encoder();
    let keys = [&[(1024, 1), (3072, 32633)], more].concat();
    let head = [1, 1, 0, u16::try_from(keys.len()).expect("few")];
    let keys: Vec<u16> = head.into_iter().chain(keys.into_iter().flat_map(|(key, value)| [key, 0, 1, value])).collect();
    tags.write_tag(Tag::ModelPixelScaleTag, &[50.0, 50.0, scale][..]).expect("scale");
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 499_650.0, 5_330_350.0, offset][..]).expect("tie point");
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).expect("keys");
    let samples: Vec<f32> = (0..1600).map(|index| height(index % 40, index / 40)).collect();
    image.write_data(&samples).expect("written");
}
