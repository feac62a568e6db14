//! `coverage.tif`, read back.

use super::{Scene, grid, local};
use crate::crs::System;
use crate::dem::Frame;
use crate::io::raster::Raster;
use crate::plan::place::Place;
use std::collections::BTreeMap;

#[test]
fn the_coverage_is_read_back_at_the_right_places() {
    let degrees =
        Place::new(Frame::new(Some(System::Epsg(4326)), [11.0, 48.0]).expect("a frame"), None).expect("a place");
    let scenes = [grid(), local(None), Scene { place: degrees, ..local(None) }];
    for (index, scene) in scenes.into_iter().enumerate() {
        Scene { is_triangle: true, ..scene }.outputs(|outputs| {
            let path = std::env::temp_dir().join(format!("plumbline-coverage-{}-{index}.tif", std::process::id()));
            let files: BTreeMap<&str, Vec<u8>> = outputs.files().expect("files").into_iter().collect();
            std::fs::write(&path, &files["coverage.tif"]).expect("written");
            let raster = Raster::read(&path).expect("readable");
            let _ = std::fs::remove_file(&path);
            let (cells, known) = (&outputs.planned.cells, &outputs.planned.known);
            assert_eq!((raster.cols, raster.rows, raster.bands), (cells.cols, cells.rows, 4));
            assert_eq!((raster.crs, raster.nodata), (outputs.place.frame().system(), Some(-9999.0)));
            let mut seen = 0;
            for (cell, known) in cells.inside.iter().zip(known) {
                let [x, y] = outputs.place.frame().world(cells.centre(cell.col, cell.row));
                let (col, row) = raster.geo.pixel_from_world(x, y);
                assert!((col - col.round()).abs() < 1e-4 && (row - row.round()).abs() < 1e-4, "{col} {row}");
                let sample = |band| raster.sample(col.round() as usize, row.round() as usize, band);
                assert_eq!((sample(0), sample(1)), (Some(known.photos as f32), Some(known.in_strip as f32)));
                assert_eq!([sample(2), sample(3)], [0, 1].map(|axis| known.sd_m.map(|sd| sd[axis] as f32)));
                seen += 1;
            }
            let valid = (0..raster.cols * raster.rows)
                .filter(|index| raster.sample(index % raster.cols, index / raster.cols, 0).is_some());
            assert_eq!(valid.count(), seen, "outside the triangle nothing is known");
            assert!(seen < raster.cols * raster.rows * 2 / 3, "{seen}");
        });
    }
}
