//! Pictures: every kind that is read, what is refused, and the way to disk and back.

use std::fs;
use std::path::PathBuf;

use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};
use tiff::encoder::{Compression, TiffEncoder, colortype};
use tiff::tags::Tag;

use super::*;
use crate::io::output::tests::scratch;

/// Grey of pure red, green, blue and white: 0.299, 0.587, 0.114 and 1 times 255, rounded.
const COLOURS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
const COLOURS_GREY: [u8; 4] = [76, 150, 29, 255];

/// 16-bit values about the rounding points of a division by 257, and what they become.
const DEEP: [u16; 6] = [0, 128, 129, 385, 386, 65535];
const DEEP_GREY: [u8; 6] = [0, 0, 1, 1, 2, 255];

fn wide(colours: &[[u8; 3]]) -> Vec<u16> {
    colours.iter().flatten().map(|&value| u16::from(value) * 257).collect()
}

fn grey_of(path: &Path) -> Vec<u8> {
    read_grey(path).expect("readable").pixels
}

#[test]
fn png_of_8_and_16_bits_grey_and_colour_with_and_without_alpha() {
    let folder = scratch("picture-png");
    let path = folder.join("a.png");
    ImageBuffer::<Rgb<u8>, _>::from_raw(4, 1, COLOURS.concat()).expect("rgb").save(&path).expect("saved");
    assert_eq!(grey_of(&path), COLOURS_GREY);
    let rgba: Vec<u8> = COLOURS.iter().flat_map(|[r, g, b]| [*r, *g, *b, 9]).collect();
    ImageBuffer::<Rgba<u8>, _>::from_raw(4, 1, rgba).expect("rgba").save(&path).expect("saved");
    assert_eq!(grey_of(&path), COLOURS_GREY);
    ImageBuffer::<LumaA<u8>, _>::from_raw(2, 1, vec![7, 0, 200, 255]).expect("la").save(&path).expect("saved");
    assert_eq!(grey_of(&path), [7, 200]);
    ImageBuffer::<Luma<u16>, _>::from_raw(6, 1, DEEP.to_vec()).expect("l16").save(&path).expect("saved");
    assert_eq!(grey_of(&path), DEEP_GREY);
    ImageBuffer::<Rgb<u16>, _>::from_raw(4, 1, wide(&COLOURS)).expect("rgb16").save(&path).expect("saved");
    assert_eq!(grey_of(&path), COLOURS_GREY);
}

/// A TIFF file of one picture.
fn tiff<C: colortype::ColorType>(cols: u32, rows: u32, samples: &[C::Inner], compression: Compression) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("encoder").with_compression(compression);
    encoder.write_image::<C>(cols, rows, samples).expect("encoded");
    file.into_inner()
}

#[test]
fn tiff_of_8_and_16_bits_grey_and_colour() {
    let path = scratch("picture-tiff").join("a.tif");
    let read = |bytes: Vec<u8>| {
        fs::write(&path, bytes).expect("written");
        read_grey(&path).expect("readable")
    };
    for compression in [Compression::Uncompressed, Compression::Lzw, Compression::Deflate(Default::default())] {
        assert_eq!(read(tiff::<colortype::Gray8>(2, 1, &[3, 250], compression)).pixels, [3, 250]);
        assert_eq!(read(tiff::<colortype::RGB8>(4, 1, &COLOURS.concat(), compression)).pixels, COLOURS_GREY);
        assert_eq!(read(tiff::<colortype::RGB16>(4, 1, &wide(&COLOURS), compression)).pixels, COLOURS_GREY);
        let deep = read(tiff::<colortype::Gray16>(3, 2, &DEEP, compression));
        assert_eq!(deep, Picture { cols: 3, rows: 2, pixels: DEEP_GREY.to_vec() });
    }
}

/// Side of a tile, pixels.
const TILE: u32 = 16;

/// A TIFF file of three bands of bytes in tiles of one band each, which GDAL writes where bands are kept apart: those at the right and at the bottom reach
/// beyond the picture. `length`: rows of a tile as its header has them.
fn planar(cols: u32, rows: u32, length: u32, colour: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("encoder");
    let mut directory = encoder.image_directory().expect("directory");
    let mut offsets = Vec::new();
    for band in 0..3 {
        for top in (0..rows).step_by(TILE as usize) {
            for left in (0..cols).step_by(TILE as usize) {
                let pixels = (top..top + TILE).flat_map(|row| (left..left + TILE).map(move |col| (col, row)));
                let within = |(col, row)| if col < cols && row < rows { colour(col, row)[band] } else { 99 };
                let samples: Vec<u8> = pixels.map(within).collect();
                offsets.push(directory.write_data(&samples[..]).expect("data") as u32);
            }
        }
    }
    let mut tag = |tag, values: &[u16]| directory.write_tag(tag, values).expect("tag");
    tag(Tag::ImageWidth, &[cols as u16]);
    tag(Tag::ImageLength, &[rows as u16]);
    tag(Tag::BitsPerSample, &[8, 8, 8]);
    tag(Tag::Compression, &[1]);
    tag(Tag::PhotometricInterpretation, &[2]);
    tag(Tag::SamplesPerPixel, &[3]);
    tag(Tag::PlanarConfiguration, &[2]);
    tag(Tag::TileWidth, &[TILE as u16]);
    directory.write_tag(Tag::TileLength, length).expect("length");
    let lengths = vec![TILE * TILE; offsets.len()];
    directory.write_tag(Tag::TileOffsets, &offsets[..]).expect("offsets");
    directory.write_tag(Tag::TileByteCounts, &lengths[..]).expect("lengths");
    directory.finish().expect("directory");
    file.into_inner()
}

#[test]
fn tiles_of_one_band_each() {
    let path = scratch("picture-planes").join("a.tif");
    let (cols, rows) = (TILE + 5, 2 * TILE + 3);
    let index = |col: u32, row: u32| ((3 * col + row) % 4) as usize;
    fs::write(&path, planar(cols, rows, TILE, |col, row| COLOURS[index(col, row)])).expect("written");
    let picture = read_grey(&path).expect("readable");
    let wanted: Vec<u8> = (0..rows).flat_map(|row| (0..cols).map(move |col| COLOURS_GREY[index(col, row)])).collect();
    assert_eq!((picture.cols, picture.rows, picture.pixels), (cols as usize, rows as usize, wanted));
    // A tile that is said to be much longer than the picture takes no memory for that.
    fs::write(&path, planar(TILE, 1, u32::MAX - 15, |_, _| [1, 2, 3])).expect("written");
    let error = read_grey(&path).expect_err("64 GiB").to_string();
    assert!(error.contains("a.tif"), "{error}");
}

/// A picture without repetition, so that no compressor can make it short.
fn noise(cols: usize, rows: usize) -> Picture {
    let mut state = 1_u32;
    let pixels = (0..cols * rows)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    Picture { cols, rows, pixels }
}

#[test]
fn grey_goes_to_disk_and_back_and_the_bytes_repeat() {
    let folder = scratch("picture-write");
    let (one, two) = (folder.join("1.png"), folder.join("2.png"));
    let picture = noise(31, 17);
    write_grey_png(&one, &picture).expect("written");
    write_grey_png(&two, &picture).expect("written");
    assert_eq!(read_grey(&one).expect("readable"), picture);
    assert_eq!(fs::read(&one).expect("bytes"), fs::read(&two).expect("bytes"));
    write_rgb_png(&one, 4, 1, &COLOURS.concat()).expect("written");
    assert_eq!(grey_of(&one), COLOURS_GREY);
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_nothing() {
    let folder = scratch("picture-refused");
    let missing = folder.join("none").join("a.png");
    let error = write_grey_png(&missing, &noise(2, 2)).expect_err("no folder").to_string();
    assert!(error.contains("none"), "{error}");
    let path = folder.join("a.png");
    for (cols, rows, count) in [(2, 2, 3), (0, 0, 0), (0, 4, 0), (usize::MAX, 2, 4)] {
        let picture = Picture { cols, rows, pixels: vec![0; count] };
        assert!(write_grey_png(&path, &picture).is_err(), "{cols} x {rows}");
    }
    assert!(write_rgb_png(&path, 2, 2, &[0; 4]).is_err());
    assert_eq!(fs::read_dir(&folder).expect("listed").count(), 0);
}

/// The sentence for a file of these bytes.
fn refusal(path: &PathBuf, bytes: &[u8]) -> Option<String> {
    fs::write(path, bytes).expect("written");
    read_grey(path).err().map(|error| error.to_string())
}

#[test]
fn files_cut_short_are_refused_wherever_they_are_cut() {
    let folder = scratch("picture-cut");
    let picture = noise(40, 30);
    let png = folder.join("a.png");
    write_grey_png(&png, &picture).expect("written");
    let mut jpeg = Cursor::new(Vec::new());
    let grey = ImageBuffer::<Luma<u8>, _>::from_raw(40, 30, picture.pixels.clone()).expect("grey");
    grey.write_to(&mut jpeg, ImageFormat::Jpeg).expect("jpeg");
    let files = [
        fs::read(&png).expect("bytes"),
        jpeg.into_inner(),
        tiff::<colortype::Gray8>(40, 30, &picture.pixels, Compression::Uncompressed),
        tiff::<colortype::Gray8>(40, 30, &picture.pixels, Compression::Lzw),
        tiff::<colortype::Gray8>(40, 30, &picture.pixels, Compression::Deflate(Default::default())),
    ];
    let path = folder.join("cut");
    for bytes in files {
        assert_eq!(refusal(&path, &bytes), None);
        for length in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
            let sentence = refusal(&path, &bytes[..length]);
            assert!(sentence.is_some_and(|text| text.contains("cut")), "{length} of {}", bytes.len());
        }
    }
}

/// A decompressor that fills up what is missing would not notice, so the file's own account of its strips is checked.
#[test]
fn a_strip_that_ends_beyond_the_file_is_cut_short() {
    let path = scratch("picture-strip").join("a.tif");
    let mut bytes = tiff::<colortype::Gray8>(40, 30, &noise(40, 30).pixels, Compression::Uncompressed);
    // Directory entry of StripByteCounts (279): tag, type, a count of 1, then the value.
    let entry = bytes.windows(2).rposition(|tag| tag == 279_u16.to_le_bytes()).expect("the entry");
    assert_eq!(bytes[entry + 4..entry + 8], 1_u32.to_le_bytes());
    let beyond = bytes.len() as u32;
    bytes[entry + 8..entry + 12].copy_from_slice(&beyond.to_le_bytes());
    assert!(refusal(&path, &bytes).is_some_and(|text| text.contains("it is cut short")));
}

#[test]
fn what_is_no_picture_is_refused_with_its_path() {
    let folder = scratch("picture-broken");
    let path = folder.join("broken.png");
    let error = read_grey(&path).expect_err("missing").to_string();
    assert!(error.contains("broken.png"), "{error}");
    assert!(read_grey(&folder).is_err());
    for bytes in [&b""[..], b"no picture at all", b"\x89PNG\r\n\x1a\n", b"II\x2a\0\x08\0\0\0\0\0", b"BM123456"] {
        assert!(refusal(&path, bytes).is_some_and(|text| text.contains("broken.png")));
    }
    // A damaged byte in a PNG chunk is found by the chunk's own checksum.
    write_grey_png(&path, &noise(20, 20)).expect("written");
    let mut bytes = fs::read(&path).expect("bytes");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    assert!(refusal(&path, &bytes).is_some());
    let float = tiff::<colortype::Gray32Float>(1, 1, &[0.5], Compression::Uncompressed);
    assert!(refusal(&path, &float).is_some_and(|text| text.contains("8 or 16 bits")));
}
