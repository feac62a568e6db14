//! Heights by places on a grid that need not be the model's own.

use super::{Dem, DemFile, Doubt, Frame};
use crate::crs::{Crs, System};
use crate::error::InputError;

/// A model over an area of a grid.
#[derive(Debug, Clone)]
pub struct Heights {
    grid: Option<Crs>,
    /// The model's system, where that is another one.
    other: Option<Crs>,
    frame: Frame,
    dem: Dem,
    range_m: Option<[f64; 2]>,
    is_unit_stated: bool,
}

impl Heights {
    /// Reads as much of a file as lies over an area of a grid: x0, y0, x1, y1. A model without a reference system is taken to be on
    /// the grid, and so is every one where the grid has none.
    ///
    /// # Errors
    /// One sentence, with the file's name, where the file cannot be read or does not lie there.
    pub fn over(file: &DemFile, grid: Option<&Crs>, [x0, y0, x1, y1]: [f64; 4]) -> Result<Self, InputError> {
        let named = |error: InputError| InputError::new(format!("{}: {error}", file.path().display()));
        let is_other = |system: &System| grid.is_some_and(|grid| *system != grid.system());
        let other = file.system().filter(is_other).map(Crs::new).transpose().map_err(named)?;
        let grid = grid.cloned();
        let centre = in_file(grid.as_ref(), other.as_ref(), [0.5 * (x0 + x1), 0.5 * (y0 + y1)]).map_err(named)?;
        let frame = Frame::new(file.system(), centre).map_err(named)?;
        let mut wanted = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        // Grids are turned against each other: the borders' middles count too.
        for [u, v] in [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 0.5], [1.0, 0.5], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0]] {
            let place = [x0 + u * (x1 - x0), y0 + v * (y1 - y0)];
            let [x, y] = frame.metres(in_file(grid.as_ref(), other.as_ref(), place).map_err(named)?);
            wanted = [wanted[0].min(x), wanted[1].min(y), wanted[2].max(x), wanted[3].max(y)];
        }
        let dem = file.window(&frame, wanted, &mut |_, _| {})?;
        let range_m = dem.range_m();
        Ok(Heights { grid, other, frame, dem, range_m, is_unit_stated: file.is_unit_stated() })
    }

    /// The height of a place on the grid; `None` where nothing is known.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> Option<f64> {
        let [x, y] = self.frame.metres(in_file(self.grid.as_ref(), self.other.as_ref(), [x, y]).ok()?);
        self.dem.height(x, y)
    }

    /// Metres between posts, the smaller of both axes.
    #[must_use]
    pub fn step_m(&self) -> f64 {
        self.dem.step_m[0].min(self.dem.step_m[1])
    }

    /// Lowest and highest known height; `None` where nothing is known.
    #[must_use]
    pub fn range_m(&self) -> Option<[f64; 2]> {
        self.range_m
    }

    /// What speaks against the heights there. On a grid that nobody knows the place of, a height of 0 may be anywhere.
    #[must_use]
    pub fn doubt(&self) -> Option<Doubt> {
        let is_known = self.grid.is_some();
        self.dem.doubt(self.is_unit_stated).filter(|doubt| is_known || *doubt != Doubt::ZeroThroughout)
    }
}

/// A place on the grid, in the model's own x and y.
fn in_file(grid: Option<&Crs>, other: Option<&Crs>, [x, y]: [f64; 2]) -> Result<[f64; 2], InputError> {
    match (grid, other) {
        (Some(grid), Some(other)) => {
            let (lat_deg, lon_deg) = grid.to_wgs84(x, y)?;
            other.from_wgs84(lat_deg, lon_deg).map(|(x, y)| [x, y])
        }
        _ => Ok([x, y]),
    }
}
