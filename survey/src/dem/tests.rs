//! Models in memory, and windows of files against what the raster reader has of them.

mod ascii;
mod geotiff;
mod synthetic;
mod mutations;

use crate::crs::System;
use std::path::{Path, PathBuf};

use super::*;
use crate::error::InputError;
use crate::io::data;
use crate::io::raster::Raster;

/// Posts of a file in its own x and y, as far as a window with these first and last columns and rows (from the north).
fn bounds_of(file: &DemFile, [left, top, right, bottom]: [usize; 4]) -> [f64; 4] {
    let ((cols, rows), [x0, y0, x1, y1]) = (file.size(), file.bounds());
    let x = |col: usize| x0 + (x1 - x0) * col as f64 / (cols - 1).max(1) as f64;
    let y = |row: usize| y1 - (y1 - y0) * row as f64 / (rows - 1).max(1) as f64;
    [x(left), y(bottom), x(right), y(top)]
}

/// The frame of a file about its centre.
fn frame_of(file: &DemFile) -> Frame {
    let [x0, y0, x1, y1] = file.bounds();
    Frame::new(file.system(), [(x0 + x1) / 2.0, (y0 + y1) / 2.0]).expect("a frame")
}

/// The window that holds these first and last columns and rows (from the north), and one more on each side.
fn window(file: &DemFile, [left, top, right, bottom]: [usize; 4]) -> Dem {
    let frame = frame_of(file);
    // A tenth of a step inside, so that one beyond is the same whatever the rounding.
    let ((cols, rows), [x0, y0, x1, y1]) = (file.size(), bounds_of(file, [left, top, right, bottom]));
    let [whole_x0, whole_y0, whole_x1, whole_y1] = file.bounds();
    let [inside_x, inside_y] = [(whole_x1 - whole_x0) / (10 * cols) as f64, (whole_y1 - whole_y0) / (10 * rows) as f64];
    let inside = |low: f64, high: f64, by: f64| if low < high { (low - by, high + by) } else { (low, high) };
    let ((x0, x1), (y0, y1)) = (inside(x0, x1, inside_x), inside(y0, y1, inside_y));
    let ([x0, y0], [x1, y1]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
    let mut steps = Vec::new();
    let dem = file.window(&frame, [x0, y0, x1, y1], &mut |done, total| steps.push((done, total))).expect("a window");
    let wanted: Vec<_> = (1..=dem.rows as u64).map(|done| (done, dem.rows as u64)).collect();
    assert_eq!(steps, wanted, "progress");
    dem
}

/// Windows to try on a file: whole, at each border and corner, inside, one post.
fn windows((cols, rows): (usize, usize)) -> Vec<[usize; 4]> {
    let (right, bottom) = (cols - 1, rows - 1);
    let (middle_x, middle_y) = (right / 2, bottom / 2);
    vec![
        [0, 0, right, bottom],
        [0, 0, middle_x, middle_y],
        [middle_x, 0, right, middle_y],
        [0, middle_y, middle_x, bottom],
        [middle_x, middle_y, right, bottom],
        [right / 3, bottom / 3, middle_x, middle_y],
        [0, 0, 0, bottom],
        [right, 0, right, bottom],
        [0, 0, right, 0],
        [0, bottom, right, bottom],
        [middle_x, middle_y, middle_x, middle_y],
        [right, bottom, right, bottom],
    ]
}

/// Compares windows of a file with heights by column and row from the north.
fn compare(file: &DemFile, height: impl Fn(usize, usize) -> Option<f32>) {
    let (cols, rows) = file.size();
    let frame = frame_of(file);
    for [left, top, right, bottom] in windows((cols, rows)) {
        let dem = window(file, [left, top, right, bottom]);
        let (west, east) = (left.saturating_sub(1), (right + 1).min(cols - 1));
        let (north, south) = (top.saturating_sub(1), (bottom + 1).min(rows - 1));
        assert_eq!((dem.cols, dem.rows), (east - west + 1, south - north + 1), "{:?} {left} {top}", file.path());
        let [x0, y0, x1, y1] = bounds_of(file, [west, north, east, south]);
        let ([x0, y0], [x1, y1]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
        for (found, wanted) in dem.bounds().iter().zip([x0, y0, x1, y1]) {
            assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
        }
        for row in 0..dem.rows {
            for col in 0..dem.cols {
                let (found, wanted) = (dem.at(col, row), height(west + col, south - row));
                let same = wanted.map_or(found.is_nan(), |wanted| wanted.to_bits() == (found as f32).to_bits());
                assert!(same, "{:?} ({col}, {row}): {found} {wanted:?}", file.path());
            }
        }
    }
}

/// Compares windows of a GeoTIFF with the raster reader's samples of its first band.
fn compare_with_raster(path: &Path) -> DemFile {
    let (file, raster) = (DemFile::header(path).expect("a header").0, Raster::read(path).expect("a raster"));
    assert_eq!((file.size(), file.system()), ((raster.cols, raster.rows), raster.crs));
    assert_eq!(file.bounds()[..2], <[f64; 2]>::from(raster.geo.world_from_pixel(0.0, (raster.rows - 1) as f64)));
    compare(&file, |col, row| raster.sample(col, row, 0));
    file
}

/// A shared elevation model, or one visible line and `None`.
fn real(name: &str) -> Option<PathBuf> {
    data::for_test("elevation models", &format!("dem/{name}"))
}

#[test]
fn real_models_are_what_the_raster_reader_reads() {
    for (name, size, epsg) in [
        ("austria_dhm_10m_west.tif", (505, 734), 31287),
        ("jacksboro_3arcsec.tif", (403, 344), 4326),
        ("vienna_dgm_1m.tif", (520, 520), 31256),
    ] {
        let Some(path) = real(name) else { continue };
        let file = compare_with_raster(&path);
        assert_eq!((file.size(), file.system()), (size, Some(System::Epsg(epsg))), "{name}");
    }
}

#[test]
fn a_model_in_degrees_has_the_cells_of_the_reference() {
    // 3 seconds of arc at the middle of the Tennessee model.
    let Some(path) = real("jacksboro_3arcsec.tif") else { return };
    let file = DemFile::open(&path).expect("a model");
    let dem = window(&file, [0, 0, 402, 343]);
    // The reference has degrees of 111.32 km times the cosine and 111.133 km, the mean of all latitudes; the ellipsoid's are
    // 0.12 % longer and 0.15 % shorter here.
    assert!((dem.step_m[0] - 74.4844).abs() < 0.1 && (dem.step_m[1] - 92.6108).abs() < 0.14, "{:?}", dem.step_m);
    let (low, high) = dem.heights.iter().fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(*z), high.max(*z)));
    assert_eq!((low, high), (236.0, 1076.0));
}

#[test]
fn heights_between_posts_are_bilinear() {
    // A product of x and y is what bilinear interpolation gives exactly.
    let plane = |x: f64, y: f64| 100.0 + 0.5 * x - 0.25 * y + 0.125 * x * y;
    let dem = Dem::from_fn((5, 4), [10.0, -20.0], [2.0, 4.0], plane);
    for (x, y) in [(10.0, -20.0), (18.0, -8.0), (11.0, -18.0), (13.5, -9.0), (18.0, -13.0), (12.0, -16.0)] {
        assert_eq!(dem.height(x, y), Some(plane(x, y)), "{x} {y}");
    }
    assert_eq!((dem.at(1, 2), dem.bounds()), (plane(12.0, -12.0), [10.0, -20.0, 18.0, -8.0]));
    for (x, y) in [(9.9, -15.0), (18.1, -15.0), (12.0, -20.1), (12.0, -7.9), (f64::NAN, -15.0), (12.0, f64::INFINITY)] {
        assert_eq!(dem.height(x, y), None, "{x} {y}");
    }
    assert!(dem.at(5, 0).is_nan() && dem.at(0, 4).is_nan() && dem.at(usize::MAX, usize::MAX).is_nan());
}

#[test]
fn a_height_is_known_where_all_posts_that_count_are() {
    let mut dem = Dem::from_fn((3, 3), [0.0, 0.0], [0.1, 0.1], |_, _| 7.0);
    dem.heights[4] = f64::NAN; // the middle
    assert_eq!((dem.height(0.1, 0.1), dem.height(0.05, 0.05), dem.height(0.15, 0.12)), (None, None, None));
    // Beside it, along the borders, and on posts whose coordinates are sums that do not come out.
    assert_eq!((dem.height(0.0, 0.1), dem.height(0.05, 0.0), dem.height(0.2, 0.15)), (Some(7.0), Some(7.0), Some(7.0)));
    let mut wide = Dem::from_fn((40, 2), [5_300_000.7, 0.0], [0.3, 1.0], |_, _| 7.0);
    wide.heights[20] = f64::NAN;
    for col in (0..40).filter(|col| *col != 20) {
        assert_eq!(wide.height(5_300_000.7 + f64::from(col) * 0.3, 0.0), Some(7.0), "{col}");
    }
}

#[test]
fn areas_that_are_none_or_beside_the_model_are_refused() {
    let Some(path) = real("vienna_dgm_1m.tif") else { return };
    let file = DemFile::open(&path).expect("a model");
    let (frame, [x0, y0, x1, y1]) = (frame_of(&file), file.bounds());
    let refused = |frame: &Frame, bounds| file.window(frame, bounds, &mut |_, _| {}).expect_err("refused").to_string();
    for bounds in [
        [x1 + 1.0, y0, x1 + 9.0, y1],
        [x0, y0 - 9.0, x1, y0 - 1.0],
        [x1, y0, x0, y1],
        [x0, y1, x1, y0],
        [f64::NAN, y0, x1, y1],
        [x0, y0, f64::INFINITY, y1],
    ] {
        let error = refused(&frame, bounds);
        assert!(error.contains("vienna_dgm_1m.tif") && error.contains("area"), "{error}");
    }
    assert!(refused(&Frame::Local, [x0, y0, x1, y1]).contains("system"));
    // Partly outside is what there is.
    let dem = file.window(&frame, [x0 - 1e6, y0 - 1e6, x0 + 1.5, y0 + 1.5], &mut |_, _| {}).expect("a window");
    assert_eq!((dem.cols, dem.rows, dem.west_m, dem.south_m), (3, 3, x0, y0));
    assert!(DemFile::open(Path::new("/nonexistent.tif")).is_err() && DemFile::open(Path::new("/")).is_err());
}
