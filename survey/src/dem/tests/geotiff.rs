//! Synthetic GeoTIFFs of every layout, and how much of them is read.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use super::synthetic::{Layout, PLAIN, geotiff, geotiff_with};
use super::*;
use crate::io::output::tests::scratch;
use crate::io::tiff::{Part, TiffFile};

/// Synthetic heights, none a whole number, and different everywhere.
fn height(col: usize, row: usize, band: usize) -> f32 {
    300.25 + 1.5 * col as f32 - 0.125 * row as f32 + 1000.0 * band as f32 + ((col * row) % 7) as f32 / 3.0
}

fn float(col: usize, row: usize, band: usize) -> Vec<u8> {
    height(col, row, band).to_ne_bytes().to_vec()
}

#[test]
fn strips_and_tiles_of_every_compression_are_read() {
    let path = scratch("dem-layouts").join("a.tif");
    for compression in [1, 5, 8, 32773] {
        for chunk in [(0, 1), (0, 4), (0, 29), (0, 1000), (16, 16), (48, 32)] {
            for bands in [1, 3] {
                let layout = Layout { compression, chunk, bands, ..PLAIN };
                std::fs::write(&path, geotiff(&layout, float)).expect("written");
                let file = compare_with_raster(&path);
                assert_eq!(file.bounds(), [1000.0, 2000.0 - 28.0 * 3.0, 1072.0, 2000.0]);
                compare(&file, |col, row| Some(height(col, row, 0)));
            }
        }
    }
}

#[test]
fn every_sample_type_is_read() {
    let path = scratch("dem-types").join("a.tif");
    // No more than a byte holds.
    let value = |col: usize, row: usize| 3 * col as i32 + 5 * row as i32;
    for compression in [1, 8] {
        let cases: [(_, &dyn Fn(i32) -> Vec<u8>); 7] = [
            ((1, 1), &|v| vec![v as u8]),
            ((1, 2), &|v| (v.unsigned_abs() as u16).to_ne_bytes().to_vec()),
            ((2, 2), &|v| (v as i16 - 120).to_ne_bytes().to_vec()),
            ((1, 4), &|v| v.unsigned_abs().to_ne_bytes().to_vec()),
            ((2, 4), &|v| (v - 120).to_ne_bytes().to_vec()),
            ((3, 4), &|v| (v as f32 / 8.0).to_ne_bytes().to_vec()),
            ((3, 8), &|v| (f64::from(v) / 3.0).to_ne_bytes().to_vec()),
        ];
        for (sample, bytes) in cases {
            let layout = Layout { compression, sample, bands: 2, chunk: (16, 16), ..PLAIN };
            let made = geotiff(&layout, |col, row, band| bytes(value(col, row) + band as i32));
            std::fs::write(&path, made).expect("written");
            compare_with_raster(&path);
        }
    }
    let layout = Layout { sample: (2, 1), ..PLAIN };
    std::fs::write(&path, geotiff(&layout, |_, _, _| vec![0])).expect("written");
    let (file, ..) = DemFile::header(&path).expect("its header is in order");
    let error = file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect_err("signed bytes").to_string();
    assert!(error.contains("sample type"), "{error}");
}

#[test]
fn heights_in_feet_become_metres() {
    let path = scratch("dem-feet").join("a.tif");
    for compression in [1, 8] {
        let layout = Layout { compression, height_unit: Some(9002), nodata: Some("300.25"), ..PLAIN };
        std::fs::write(&path, geotiff(&layout, float)).expect("written");
        let file = DemFile::open(&path).expect("a model");
        let dem = file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect("a window");
        assert!(dem.at(0, 28).is_nan(), "the no-data value is in the file's unit");
        let (found, feet) = (dem.at(5, 27), f64::from(height(5, 1, 0)));
        assert!((found - 0.3048 * feet).abs() < 1e-9, "{found} m are not {feet} ft");
    }
}

#[test]
fn samples_with_a_scale_and_an_offset_become_heights() {
    let path = scratch("dem-scaled").join("a.tif");
    let item = |role: &str, value: &str| format!("<Item name=\"X\" sample=\"0\" role=\"{role}\">{value}</Item>");
    let metadata = format!("<GDALMetadata>{}{}</GDALMetadata>", item("offset", "100"), item("scale", "0.1"));
    for compression in [1, 8] {
        let layout = Layout { compression, nodata: Some("300.25"), height_unit: Some(9002), ..PLAIN };
        std::fs::write(&path, geotiff_with(&layout, Some(&metadata), float)).expect("written");
        let file = DemFile::open(&path).expect("a model");
        let dem = file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect("a window");
        assert!(dem.at(0, 28).is_nan(), "no-data is a sample");
        let (found, sample) = (dem.at(5, 27), f64::from(height(5, 1, 0)));
        assert!((found - 0.3048 * (0.1 * sample + 100.0)).abs() < 1e-9, "{found} m of the sample {sample}");
        let raster = Raster::read(&path).expect("a raster");
        assert_eq!(raster.scalings, [crate::io::raster::Scaling { scale: 0.1, offset: 100.0 }]);
    }
    let zero = metadata.replace("0.1", "0");
    std::fs::write(&path, geotiff_with(&PLAIN, Some(&zero), float)).expect("written");
    let error = DemFile::open(&path).expect_err("no heights").to_string();
    assert!(error.contains("scale of its band 1 is 0"), "{error}");
}

#[test]
fn big_endian_samples_are_read() {
    let path = scratch("dem-endian").join("a.tif");
    let little = geotiff(&PLAIN, float);
    // The same file with every number turned, those of the directory by their types.
    std::fs::write(&path, big_endian(&little)).expect("written");
    compare(&compare_with_raster(&path), |col, row| Some(height(col, row, 0)));
}

/// A little-endian TIFF of 4-byte samples as a big-endian one.
fn big_endian(little: &[u8]) -> Vec<u8> {
    let mut big = little.to_vec();
    let short = |at: usize| usize::from(u16::from_le_bytes([little[at], little[at + 1]]));
    let long = |at: usize| u32::from_le_bytes([little[at], little[at + 1], little[at + 2], little[at + 3]]) as usize;
    big[..2].copy_from_slice(b"MM");
    let directory = long(4);
    big[2..4].reverse();
    big[4..8].reverse();
    big[directory..directory + 2].reverse();
    let mut end_of_samples = directory;
    for entry in (0..short(directory)).map(|index| directory + 2 + 12 * index) {
        let (kind, count) = (short(entry + 2), long(entry + 4));
        let size = [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8][kind];
        let at = if size * count > 4 { long(entry + 8) } else { entry + 8 };
        big[at..at + size * count].chunks_exact_mut(size).for_each(<[u8]>::reverse);
        if at != entry + 8 {
            end_of_samples = end_of_samples.min(at);
            big[entry + 8..entry + 12].reverse();
        }
        big[entry..entry + 2].reverse();
        big[entry + 2..entry + 4].reverse();
        big[entry + 4..entry + 8].reverse();
    }
    big[8..end_of_samples].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    big
}

#[test]
fn unknown_heights_are_known_as_such() {
    let path = scratch("dem-nodata").join("a.tif");
    let holes = |col: usize, row: usize| (col + row).is_multiple_of(5);
    for (nodata, hole) in [
        (Some("-3.4028234663852886e+38"), f32::MIN),
        (Some("-9999"), -9999.0),
        (Some("nan"), f32::NAN),
        (None, f32::NAN),
        (None, f32::NEG_INFINITY),
    ] {
        for compression in [1, 8] {
            let layout = Layout { nodata, compression, ..PLAIN };
            let value = |col, row| if holes(col, row) { hole } else { height(col, row, 0) };
            std::fs::write(&path, geotiff(&layout, |col, row, _| value(col, row).to_ne_bytes().to_vec()))
                .expect("written");
            let file = compare_with_raster(&path);
            compare(&file, |col, row| (!holes(col, row)).then(|| height(col, row, 0)));
        }
    }
    let layout = Layout { nodata: Some("-32768"), sample: (2, 2), ..PLAIN };
    let value = |col, row| if holes(col, row) { i16::MIN } else { row as i16 };
    std::fs::write(&path, geotiff(&layout, |col, row, _| value(col, row).to_ne_bytes().to_vec())).expect("written");
    compare(&compare_with_raster(&path), |col, row| (!holes(col, row)).then_some(row as f32));
}

#[test]
fn files_without_a_system_are_local_metres() {
    let path = scratch("dem-local").join("a.tif");
    std::fs::write(&path, geotiff(&Layout { epsg: None, ..PLAIN }, float)).expect("written");
    let file = compare_with_raster(&path);
    assert_eq!(file.system(), None);
    assert!(matches!(frame_of(&file), Frame::Local));
}

#[test]
fn a_file_that_changes_is_refused() {
    let path = scratch("dem-changes").join("a.tif");
    std::fs::write(&path, geotiff(&PLAIN, float)).expect("written");
    let file = DemFile::open(&path).expect("a model");
    std::fs::write(&path, geotiff(&Layout { cols: 36, ..PLAIN }, float)).expect("written");
    let error = file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}).expect_err("changed").to_string();
    assert!(error.contains("changed"), "{error}");
}

#[test]
fn absurd_sizes_and_missing_tiles_are_refused() {
    let path = scratch("dem-absurd").join("a.tif");
    let entry = |bytes: &[u8], tag: u16| {
        let directory = u32::from_ne_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
        let mut entries = (directory + 2..bytes.len() - 12).step_by(12);
        entries.find(|&at| u16::from_ne_bytes([bytes[at], bytes[at + 1]]) == tag).expect("a tag")
    };
    // A tag of one 32-bit value.
    let set = |bytes: &mut [u8], tag: u16, value: u32| {
        let at = entry(bytes, tag);
        bytes[at + 2..at + 4].copy_from_slice(&4_u16.to_ne_bytes());
        bytes[at + 8..at + 12].copy_from_slice(&value.to_ne_bytes());
    };
    let (width, length, rows_per_strip, pixel, planar) = (256, 257, 278, 277, 284);
    for changes in [
        &[(width, u32::MAX)][..],
        &[(length, u32::MAX)],
        &[(length, u32::MAX), (rows_per_strip, u32::MAX)],
        &[(width, u32::MAX), (length, u32::MAX), (rows_per_strip, u32::MAX)],
        // 2^31 strips of 2 bands are 2^32, which is 0 in 32 bits.
        &[(length, 1 << 31), (rows_per_strip, 1), (pixel, 2), (planar, 2)],
    ] {
        let mut bytes = geotiff(&Layout { chunk: (0, 29), ..PLAIN }, float);
        changes.iter().for_each(|(tag, value)| set(&mut bytes, *tag, *value));
        std::fs::write(&path, &bytes).expect("written");
        let read = DemFile::open(&path).and_then(|file| file.window(&frame_of(&file), file.bounds(), &mut |_, _| {}));
        assert!(read.is_err(), "{changes:?}");
    }
    let mut bytes = geotiff(&Layout { chunk: (0, 29), ..PLAIN }, float);
    set(&mut bytes, 279, 0);
    std::fs::write(&path, &bytes).expect("written");
    let error = DemFile::open(&path).expect_err("sparse").to_string();
    assert!(error.contains("left out"), "{error}");
}

/// A reader that counts what is read through it.
struct Counting<'a> {
    file: Cursor<&'a [u8]>,
    bytes: &'a std::cell::Cell<u64>,
}

impl Read for Counting<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.bytes.set(self.bytes.get() + count as u64);
        Ok(count)
    }
}

impl Seek for Counting<'_> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(to)
    }
}

#[test]
fn a_window_costs_the_strips_or_tiles_it_touches() {
    // 1200 x 1200 heights are 5.76 MB; the window is 50 x 50 of them in a corner of four tiles.
    let part = Part { cols: 500..550, rows: 500..550 };
    let noise = |col: usize, row: usize| ((col * 7919 + row * 104_729) % 65_521) as f32;
    for (compression, chunk, most) in [
        (1, (256, 256), 4 * 12 * 1024 + 4 * 38 * 1024), // rows 500 to 511 of two tiles, 512 to 549 of two more
        (1, (0, 1200), 50 * 4800),                      // 50 rows of the one strip
        (1, (0, 10), 50 * 4800),
        (8, (256, 256), 4 * (256 * 1024 + 32 * 1024)), // four tiles, each with what the inflater reads ahead
        (8, (0, 10), 5 * (48_000 + 32 * 1024)),
    ] {
        let layout = Layout { cols: 1200, rows: 1200, chunk, compression, ..PLAIN };
        let file = geotiff(&layout, |col, row, _| noise(col, row).to_ne_bytes().to_vec());
        let bytes = std::cell::Cell::new(0);
        let reader = Counting { file: Cursor::new(&file), bytes: &bytes };
        let tiff = TiffFile::open(reader, file.len() as u64, Path::new("synthetic")).expect("a file");
        let header = bytes.get();
        let mut found = 0;
        let mut take = |row: usize, col: usize, heights: &[f64]| {
            found += heights.len();
            assert!(heights.iter().enumerate().all(|(index, height)| *height == f64::from(noise(col + index, row))));
        };
        tiff.first_band(&part, &mut take).expect("read");
        let read = bytes.get() - header;
        assert_eq!(found, 50 * 50);
        // The list of strips or tiles is read again.
        assert!(read <= most + 10_000, "{compression} {chunk:?}: {read} of {} bytes, {most} expected", file.len());
    }
}
