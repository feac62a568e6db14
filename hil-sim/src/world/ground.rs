//! The ground: grey value and height at every point, and where a line of sight meets it.

use super::grid::{Bounds, Grid};
use super::mirror::Mirror;
use super::surface::Surface;
use std::fmt;
use std::sync::Arc;

/// A piece of land: an orthophoto (grey albedo, 0 to 255) on a height surface.
///
/// Between albedo pixels the value is Catmull-Rom, clamped to 0..255: a smooth function, so it does not matter whether the
/// pixel of the orthophoto is finer or coarser than the frame's ground sample distance. Heights are bilinear; without a
/// surface the ground is flat at height 0. A clone shares its rasters.
#[derive(Clone, Debug)]
pub struct Ground {
    albedo: Arc<Grid>,
    surface: Option<Arc<Surface>>,
    epsg: u32,
    /// Where the rasters are one field of a larger ground.
    mirror: Option<Mirror>,
}

/// Why rasters do not make a ground. `what` is "albedo" or "surface".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroundError {
    /// Fewer than two columns or rows.
    TooSmall {
        /// Which raster.
        what: &'static str,
    },
    /// The number of values is not columns times rows.
    WrongLength {
        /// Which raster.
        what: &'static str,
        /// Columns times rows.
        expected: usize,
        /// Values that came.
        found: usize,
    },
    /// Step or origin is not finite, or the step is not positive.
    BadGeometry {
        /// Which raster.
        what: &'static str,
    },
    /// A height is unknown (NaN) or infinite: a line of sight could not be followed there.
    HeightNotFinite {
        /// Column of the first such value.
        col: usize,
        /// Its row.
        row: usize,
    },
}

impl fmt::Display for GroundError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            GroundError::TooSmall { what } => write!(f, "the {what} raster needs at least 2 columns and 2 rows"),
            GroundError::WrongLength { what, expected, found } => {
                write!(f, "the {what} raster has {found} values where its size asks for {expected}")
            }
            GroundError::BadGeometry { what } => {
                write!(f, "the {what} raster needs a finite origin and a positive pixel size")
            }
            GroundError::HeightNotFinite { col, row } => {
                write!(f, "the surface raster has no height at column {col}, row {row}")
            }
        }
    }
}

impl std::error::Error for GroundError {}

fn check(grid: &Grid, what: &'static str) -> Result<(), GroundError> {
    if grid.cols < 2 || grid.rows < 2 {
        return Err(GroundError::TooSmall { what });
    }
    let expected = grid.cols.saturating_mul(grid.rows);
    if grid.data.len() != expected {
        return Err(GroundError::WrongLength { what, expected, found: grid.data.len() });
    }
    let finite = grid.west_m.is_finite() && grid.north_m.is_finite() && grid.step_m.is_finite();
    if !finite || grid.step_m <= 0.0 {
        return Err(GroundError::BadGeometry { what });
    }
    Ok(())
}

impl Ground {
    /// Puts an orthophoto on a surface. Both are in the reference system `epsg`; they need not have the same pixels.
    /// NaN in the albedo means "not photographed"; the surface must be known everywhere.
    pub fn new(albedo: Grid, surface: Option<Grid>, epsg: u32) -> Result<Self, GroundError> {
        check(&albedo, "albedo")?;
        Ground { albedo: Arc::new(albedo), surface: None, epsg, mirror: None }.with_surface(surface)
    }

    /// For rasters made here, whose sizes and heights are right by construction.
    pub(super) fn from_checked(albedo: Grid, surface: Grid, epsg: u32) -> Self {
        Ground { albedo: Arc::new(albedo), surface: Some(Arc::new(Surface::new(surface))), epsg, mirror: None }
    }

    /// This picture on another surface, or flat at height 0.
    pub fn with_surface(mut self, surface: Option<Grid>) -> Result<Self, GroundError> {
        self.surface = match surface {
            None => None,
            Some(grid) => {
                check(&grid, "surface")?;
                if let Some(i) = grid.data.iter().position(|h| !h.is_finite()) {
                    return Err(GroundError::HeightNotFinite { col: i % grid.cols, row: i / grid.cols });
                }
                Some(Arc::new(Surface::new(grid)))
            }
        };
        Ok(self)
    }

    /// A square of `side_m` around `centre` of the system `epsg`: this ground in its middle, and its mirror images beside each
    /// other all around. The rasters are shared.
    pub(super) fn mirrored(self, epsg: u32, centre: [f64; 2], side_m: f64) -> Self {
        let mirror = Mirror::new(self.albedo.bounds(), centre, side_m);
        Ground { epsg, mirror: Some(mirror), ..self }
    }

    /// EPSG code of the horizontal coordinates.
    pub fn epsg(&self) -> u32 {
        self.epsg
    }

    /// The albedo raster.
    pub fn albedo_grid(&self) -> &Grid {
        &self.albedo
    }

    /// The surface raster, if the ground is not flat.
    pub fn surface_grid(&self) -> Option<&Grid> {
        self.surface.as_ref().map(|surface| surface.grid())
    }

    /// Where the albedo is defined: the rectangle between the outermost pixel centres.
    pub fn bounds(&self) -> Bounds {
        self.mirror.as_ref().map_or_else(|| self.albedo.bounds(), Mirror::bounds)
    }

    /// Grey value 0 to 255 seen from straight above. None outside the raster and next to a pixel without value.
    pub fn albedo(&self, east_m: f64, north_m: f64) -> Option<f64> {
        let [east_m, north_m] = match &self.mirror {
            Some(mirror) => mirror.folded(east_m, north_m)?,
            None => [east_m, north_m],
        };
        let (col, row) = self.albedo.pixel(east_m, north_m);
        if !self.albedo.covers(col, row) {
            return None;
        }
        let value = self.albedo.catmull_rom(col, row);
        (!value.is_nan()).then(|| value.clamp(0.0, 255.0))
    }

    /// Four of [`Ground::albedo`] at once, NaN where there is none.
    #[inline]
    pub(crate) fn four_albedos(&self, east_m: [f64; 4], north_m: [f64; 4]) -> [f64; 4] {
        if self.mirror.is_none() {
            let grid = &self.albedo;
            let cols = east_m.map(|east_m| (east_m - grid.west_m) / grid.step_m);
            let rows = north_m.map(|north_m| (grid.north_m - north_m) / grid.step_m);
            if let Some(values) = grid.four_catmull_rom(cols, rows) {
                return values.map(|value| value.clamp(0.0, 255.0));
            }
        }
        std::array::from_fn(|i| self.albedo(east_m[i], north_m[i]).unwrap_or(f64::NAN))
    }

    /// Height, metres: bilinear; beyond the surface raster that of its nearest border point; 0 without a surface.
    pub fn height(&self, east_m: f64, north_m: f64) -> f64 {
        let [east_m, north_m] =
            self.mirror.as_ref().and_then(|mirror| mirror.folded(east_m, north_m)).unwrap_or([east_m, north_m]);
        self.surface.as_ref().map_or(0.0, |surface| surface.height(east_m, north_m))
    }

    /// First point where the ray from `origin` along `direction` (`[east, north, up]`, any length) meets the ground.
    ///
    /// Exact: on the flat ground one division, on a surface the root of a quadratic in the bilinear cell that is hit.
    /// None if the ray misses, if it leaves the surface raster first, or if it starts below the ground.
    pub fn intersect(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 3]> {
        let along = self.along(origin, direction)?;
        Some(std::array::from_fn(|axis| origin[axis] + along * direction[axis]))
    }

    /// As [`Ground::intersect`] for rays beside each other from one place: how far along each, NaN where it meets nothing.
    pub(crate) fn intersect_all(&self, origin: [f64; 3], directions: &[[f64; 3]], along: &mut [f64]) {
        match (&self.surface, &self.mirror) {
            (Some(surface), None) => surface.intersect_all(origin, directions, along),
            _ => {
                for (direction, along) in directions.iter().zip(along) {
                    *along = self.along(origin, *direction).unwrap_or(f64::NAN);
                }
            }
        }
    }

    fn along(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
        match (&self.surface, &self.mirror) {
            (Some(surface), Some(mirror)) => mirror.along(origin, direction, |o, d| surface.intersect(o, d)),
            (Some(surface), None) => surface.intersect(origin, direction),
            (None, _) => {
                let along = -origin[2] / direction[2];
                (origin[2] >= 0.0 && along >= 0.0 && along.is_finite()).then_some(along)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(data: Vec<f32>) -> Grid {
        Grid { cols: 3, rows: 3, west_m: 10.0, north_m: 20.0, step_m: 1.0, data }
    }

    #[test]
    fn flat_ground_is_met_exactly() {
        let ground = Ground::new(grid(vec![7.0; 9]), None, 32633).unwrap();
        assert_eq!(ground.intersect([10.0, 20.0, 100.0], [0.5, -0.25, -1.0]), Some([60.0, -5.0, 0.0]));
        assert_eq!(ground.intersect([10.0, 20.0, 100.0], [0.5, 0.0, 1.0]), None);
        assert_eq!(ground.intersect([10.0, 20.0, 100.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(ground.intersect([10.0, 20.0, -1.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(ground.height(11.0, 19.0), 0.0);
    }

    #[test]
    fn albedo_ends_at_the_outer_pixel_centres_and_at_unknown_pixels() {
        let ground = Ground::new(grid(vec![7.0; 9]), None, 32633).unwrap();
        assert_eq!(ground.albedo(10.0, 20.0), Some(7.0));
        assert_eq!(ground.albedo(12.0, 18.0), Some(7.0));
        assert_eq!(ground.albedo(12.001, 19.0), None);
        let mut holed = vec![7.0; 9];
        holed[8] = f32::NAN;
        assert_eq!(Ground::new(grid(holed), None, 32633).unwrap().albedo(11.5, 18.5), None);
    }

    #[test]
    fn bad_rasters_are_refused_with_a_sentence() {
        let message = |albedo: Grid, surface| Ground::new(albedo, surface, 32633).unwrap_err().to_string();
        assert!(message(grid(vec![0.0; 8]), None).contains("8 values"));
        assert!(message(Grid { cols: 1, ..grid(vec![0.0; 3]) }, None).contains("2 columns"));
        assert!(message(Grid { step_m: 0.0, ..grid(vec![0.0; 9]) }, None).contains("pixel size"));
        let mut holed = vec![0.0; 9];
        holed[5] = f32::NAN;
        assert!(message(grid(vec![0.0; 9]), Some(grid(holed))).contains("column 2, row 1"));
    }
}
