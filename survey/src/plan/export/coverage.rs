//! `coverage.tif`: what the photos know of each cell of the area, a band a quantity.

use super::Outputs;
use crate::error::InputError;
use crate::io::raster::{Band, GeoTransform, geotiff_bytes};
use crate::plan::cells::Known;

/// Outside the area, and where a standard deviation is not determined.
const NODATA: f32 = -9999.0;

/// A band's description, and its value of a cell.
type Quantity = (&'static str, fn(&Known) -> Option<f64>);

const QUANTITIES: [Quantity; 4] = [
    ("photos that see the cell", |known| Some(f64::from(known.photos))),
    ("most photos of one strip that see the cell", |known| Some(f64::from(known.in_strip))),
    ("horizontal standard deviation, metres", |known| known.sd_m.map(|sd| sd[0])),
    ("height standard deviation, metres", |known| known.sd_m.map(|sd| sd[1])),
];

impl Outputs<'_> {
    /// The file, in the elevation model's reference system.
    pub(super) fn coverage(&self) -> Result<Vec<u8>, InputError> {
        let cells = &self.planned.cells;
        let world = |col: f64, row: f64| {
            let metres = [cells.west_m + col * cells.step_m, cells.south_m + row * cells.step_m];
            self.place.frame().world(metres)
        };
        let [x0, y0] = world(0.0, cells.rows as f64 - 1.0);
        let [x1, y1] = world(1.0, cells.rows as f64 - 2.0);
        let geo = GeoTransform { x0, y0, step_x: x1 - x0, step_y: y0 - y1 };
        let bands = QUANTITIES.map(|(_, of)| {
            let mut samples = vec![NODATA; cells.cols * cells.rows];
            for (cell, known) in cells.inside.iter().zip(&self.planned.known) {
                // The cells' rows run north, a raster's south.
                let index = (cells.rows - 1 - cell.row) * cells.cols + cell.col;
                samples[index] = of(known).map_or(NODATA, |value| value as f32);
            }
            samples
        });
        let described: Vec<Band<'_>> =
            QUANTITIES.iter().zip(&bands).map(|((description, _), samples)| Band { description, samples }).collect();
        geotiff_bytes(cells.cols, cells.rows, &described, &geo, self.place.frame().system(), NODATA)
    }
}
