//! Rasters: every sample type, and the real files against values read with another library.

use std::io::Cursor;
use std::path::PathBuf;

use tiff::encoder::{TiffEncoder, TiffValue, colortype};
use tiff::tags::Tag;

use super::*;
use crate::io::data;
use crate::io::output::tests::scratch;

/// A GeoTIFF of 2 x 2 pixels of 0.5 m, top left corner at (1000, 2000), EPSG:32633.
fn geotiff<C: colortype::ColorType>(samples: &[C::Inner], nodata: Option<&str>) -> Vec<u8>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("encoder");
    let mut image = encoder.new_image::<C>(2, 2).expect("image");
    let tags = image.encoder();
    let directory: &[u16] = &[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633];
    tags.write_tag(Tag::ModelPixelScaleTag, &[0.5, 0.5, 0.0][..]).expect("scale");
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 1000.0, 2000.0, 0.0][..]).expect("tie");
    tags.write_tag(Tag::GeoKeyDirectoryTag, directory).expect("keys");
    if let Some(text) = nodata {
        tags.write_tag(Tag::GdalNodata, text).expect("nodata");
    }
    image.write_data(samples).expect("data");
    file.into_inner()
}

fn read(name: &str, bytes: &[u8]) -> Result<Raster, InputError> {
    let path = scratch(name).join("a.tif");
    std::fs::write(&path, bytes).expect("written");
    Raster::read(&path)
}

#[test]
fn all_sample_types_are_read() {
    let cases: [(Vec<u8>, SampleType, [f32; 4]); 7] = [
        (geotiff::<colortype::Gray8>(&[0, 1, 200, 255], None), SampleType::U8, [0.0, 1.0, 200.0, 255.0]),
        (geotiff::<colortype::Gray16>(&[0, 257, 2570, 65535], None), SampleType::U16, [0.0, 257.0, 2570.0, 65535.0]),
        (geotiff::<colortype::GrayI16>(&[-5, 0, 7, 32767], None), SampleType::I16, [-5.0, 0.0, 7.0, 32767.0]),
        (geotiff::<colortype::Gray32>(&[0, 1, 2, 1 << 31], None), SampleType::U32, [0.0, 1.0, 2.0, 2_147_483_648.0]),
        (geotiff::<colortype::GrayI32>(&[-9, 1, 2, 3], None), SampleType::I32, [-9.0, 1.0, 2.0, 3.0]),
        (geotiff::<colortype::Gray32Float>(&[-0.5, 1.5, 2.0, 3.0], None), SampleType::F32, [-0.5, 1.5, 2.0, 3.0]),
        (geotiff::<colortype::Gray64Float>(&[-0.5, 1.5, 0.1, 3.0], None), SampleType::F64, [-0.5, 1.5, 0.1, 3.0]),
    ];
    for (bytes, sample_type, wanted) in cases {
        let raster = read("raster-types", &bytes).expect("readable");
        assert_eq!((raster.cols, raster.rows, raster.bands), (2, 2, 1));
        assert_eq!((raster.sample_type, raster.crs), (sample_type, Some(System::Epsg(32633))));
        assert_eq!(raster.data, wanted);
        assert_eq!(raster.geo.world_from_pixel(0.0, 0.0), (1000.25, 1999.75));
    }
}

#[test]
fn grey_is_luma_and_16_bits_are_scaled() {
    let deep = read("raster-grey", &geotiff::<colortype::Gray16>(&[0, 257, 2570, 65535], None)).expect("grey");
    for (found, wanted) in deep.grey().iter().zip([0.0, 1.0, 10.0, 255.0]) {
        assert!((found - wanted).abs() < 1e-4, "{found} {wanted}");
    }
    let rgb = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]].concat();
    let colours = read("raster-luma", &geotiff::<colortype::RGB8>(&rgb, None)).expect("rgb");
    for (found, wanted) in colours.grey().iter().zip([76.245, 149.685, 29.07, 255.0]) {
        assert!((found - wanted).abs() < 1e-3, "{found} {wanted}");
    }
}

#[test]
fn no_data_is_no_sample() {
    let bytes = geotiff::<colortype::Gray32Float>(&[-9999.0, f32::NAN, 2.0, f32::MIN], Some("-9999 "));
    let raster = read("raster-nodata", &bytes).expect("readable");
    assert_eq!(raster.nodata, Some(-9999.0));
    assert_eq!(raster.sample(0, 0, 0), None);
    assert_eq!(raster.sample(1, 0, 0), None);
    assert_eq!(raster.sample(0, 1, 0), Some(2.0));
    assert_eq!((raster.sample(2, 0, 0), raster.sample(0, 2, 0), raster.sample(0, 0, 1)), (None, None, None));
    // GDAL writes the lowest f32 in more digits than an f32 has.
    let bytes = geotiff::<colortype::Gray32Float>(&[f32::MIN, 1.0, 2.0, 3.0], Some("-3.4028234663852886e+38"));
    assert_eq!(read("raster-lowest", &bytes).expect("readable").sample(0, 0, 0), None);
    let bytes = geotiff::<colortype::Gray8>(&[0, 1, 2, 3], Some("none"));
    assert!(read("raster-no-number", &bytes).is_err());
}

#[test]
fn files_without_a_georeference_are_refused() {
    let mut file = Cursor::new(Vec::new());
    TiffEncoder::new(&mut file).expect("encoder").write_image::<colortype::Gray8>(1, 1, &[0]).expect("written");
    let error = read("raster-plain", &file.into_inner()).expect_err("plain").to_string();
    assert!(error.contains("a.tif") && error.contains("no georeference"), "{error}");
    assert!(read("raster-text", b"ncols 4").is_err());
    assert!(Raster::read(Path::new("/nonexistent.tif")).is_err());
    let whole = geotiff::<colortype::Gray32Float>(&[0.0; 4], None);
    for length in 0..whole.len() {
        assert!(read("raster-cut", &whole[..length]).is_err(), "{length} of {}", whole.len());
    }
}

/// A real file, or one visible line and `None`.
fn real(name: &str) -> Option<PathBuf> {
    data::for_test("rasters", name)
}

/// What a real file holds: size, code, centre of its first pixel, and samples of band 1 at (col, row).
struct Real {
    name: &'static str,
    size: (usize, usize, usize),
    epsg: u32,
    first: (f64, f64),
    samples: [(usize, usize, f32); 3],
}

/// Values read with Python's tifffile (those of the JPEG-compressed Vienna orthophoto with Pillow, whose inverse cosine
/// transform rounds differently: up to 2 grey values).
const REAL: [Real; 5] = [
    Real {
        name: "dem/austria_dhm_10m_west.tif",
        size: (505, 734, 1),
        // Spelt out in the file, not named.
        epsg: 31287,
        first: (551_842.0 + 10.003_956_478_733_928 / 2.0, 433_466.0 - 10.004_087_193_460_49 / 2.0),
        samples: [(0, 0, 1102.267), (504, 733, 1174.4028), (168, 183, 881.0525)],
    },
    Real {
        name: "dem/jacksboro_3arcsec.tif",
        size: (403, 344, 1),
        epsg: 4326,
        first: (-84.413_75 + 1.0 / 2400.0, 36.732_916_666_666_67 - 1.0 / 2400.0),
        samples: [(0, 0, 483.0), (402, 343, 272.0), (134, 86, 521.0)],
    },
    Real {
        name: "dem/vienna_dgm_1m.tif",
        size: (520, 520, 1),
        epsg: 31256,
        first: (-1760.0, 338_810.0),
        samples: [(0, 0, 26.216), (519, 519, 34.158), (173, 130, 33.305)],
    },
    Real {
        name: "images/m_4709963_se_14_1_20090818.tif",
        size: (934, 724, 4),
        epsg: 26914,
        first: (485_902.5, 5_209_244.5),
        samples: [(0, 0, 148.0), (933, 723, 161.0), (311, 181, 115.0)],
    },
    Real {
        name: "images/vienna_ortho_2023_30cm.tif",
        size: (1667, 1667, 3),
        epsg: 31256,
        first: (-1750.0 + 0.299_940_011_997_600_45 / 2.0, 338_800.0 - 0.299_940_011_997_600_45 / 2.0),
        samples: [(0, 0, 149.0), (1666, 1666, 69.0), (555, 416, 218.0)],
    },
];

#[test]
fn real_files_hold_what_another_library_reads() {
    for wanted in REAL {
        let Some(path) = real(wanted.name) else { continue };
        let raster = Raster::read(&path).expect(wanted.name);
        assert_eq!((raster.cols, raster.rows, raster.bands), wanted.size, "{}", wanted.name);
        assert_eq!(raster.crs, Some(System::Epsg(wanted.epsg)), "{}", wanted.name);
        let (x, y) = raster.geo.world_from_pixel(0.0, 0.0);
        let miss = (x - wanted.first.0).hypot(y - wanted.first.1);
        assert!(miss < 1e-9, "{}: {miss}", wanted.name);
        let tolerance = if wanted.name.contains("ortho") { 2.0 } else { 0.0 };
        for (col, row, value) in wanted.samples {
            let found = raster.sample(col, row, 0).expect(wanted.name);
            assert!((found - value).abs() <= tolerance, "{} ({col}, {row}): {found}", wanted.name);
        }
    }
}
