//! Reference tiles: laid over a ground, georeferenced, ready for flash.

pub mod area;
pub mod elevation;
mod georeference;

use crate::world::reference::{Radiometry, reference_tile_counted};
use crate::world::{Bounds, Ground};
use plumbline_core::tile::{Geographic, Georeference};
use plumbline_core::units::Radians;
use plumbline_firmware::stores::tiles::TileHead;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;

/// Most columns or rows of a tile.
pub const SIDE_MAX: f64 = 65_535.0;

/// Where whole cells lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Western border of the first column, metres.
    pub west_m: f64,
    /// Northern border of the first row, metres.
    pub north_m: f64,
    /// Whole columns; may be below zero where nothing is covered.
    pub cols: f64,
    /// Whole rows, likewise.
    pub rows: f64,
    /// Side of a cell, metres.
    pub resolution_m: f64,
}

impl Frame {
    /// The whole cells of `wanted` that lie within `reference`, from its north-western corner.
    pub fn within(reference: &Ground, wanted: &Bounds, resolution_m: f64) -> Self {
        let bounds = reference.bounds();
        let west_m = wanted.west_m.max(bounds.west_m);
        let east_m = wanted.east_m.min(bounds.east_m);
        let north_m = wanted.north_m.min(bounds.north_m);
        let south_m = wanted.south_m.max(bounds.south_m);
        let count = |length: f64| (length / resolution_m).floor();
        Frame { west_m, north_m, cols: count(east_m - west_m), rows: count(north_m - south_m), resolution_m }
    }

    /// Cells.
    pub fn area(&self) -> f64 {
        self.cols * self.rows
    }
}

/// A reference tile and where it lies.
#[derive(Clone, Debug)]
pub struct Tile {
    /// East coordinate of the centres of column 0, metres.
    pub west_m: f64,
    /// North coordinate of the centres of row 0, metres.
    pub north_m: f64,
    /// Columns.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// Side of a pixel, grid metres.
    pub resolution_m: f64,
    /// Row-major, row 0 north.
    pub pixels: Vec<u8>,
    /// Pixels of which the reference knows nothing, wholly or in part: they are 0.
    pub unknown: usize,
}

impl Tile {
    /// The picture of `reference` in `frame`, whose cells lie within it.
    pub fn lay(reference: &Ground, frame: &Frame, radiometry: &Radiometry) -> Self {
        let r = frame.resolution_m;
        let (west_m, north_m) = (frame.west_m + 0.5 * r, frame.north_m - 0.5 * r);
        let (cols, rows) = (frame.cols as usize, frame.rows as usize);
        let (pixels, unknown) = reference_tile_counted(reference, west_m, north_m, cols, rows, r, radiometry);
        Tile { west_m, north_m, cols, rows, resolution_m: r, pixels, unknown }
    }

    /// Grid coordinates of its centre.
    pub fn centre(&self) -> [f64; 2] {
        let half = |count: usize| 0.5 * (count as f64 - 1.0) * self.resolution_m;
        [self.west_m + half(self.cols), self.north_m - half(self.rows)]
    }

    /// What its store says beside the pixels.
    ///
    /// # Errors
    /// A grid without an EPSG code, a place that it cannot express, or a tile too large for its georeference.
    pub fn head(&self, crs: &Crs) -> Result<TileHead, InputError> {
        let centre = self.centre();
        let size_m = self.cols.max(self.rows) as f64 * self.resolution_m;
        let fit = georeference::fit(crs, centre, 0.5 * size_m)?;
        let (lat_e7, lon_e7) = fit.centre_e7;
        Ok(TileHead {
            size: (self.cols as u16, self.rows as u16),
            resolution_m: self.resolution_m as f32,
            georeference: Georeference {
                epsg: crs.system().epsg()?,
                centre: Geographic { lat_e7, lon_e7 },
                east: fit.east,
                north: fit.north,
                convergence: Radians(crs.convergence_rad(centre[0], centre[1])? as f32),
                point_scale: crs.point_scale(centre[0], centre[1])? as f32,
            },
            posts: None,
        })
    }
}
