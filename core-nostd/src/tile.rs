//! The reference tile: an orthophoto at the resolution of matching, and where it lies on the ground.
//!
//! A tile is a grid of its coordinate reference system, row 0 grid north. On board no map projection is computed: the
//! tile carries a second-order polynomial between geographic WGS84 coordinates around its centre and grid metres,
//! fitted on the ground against the full projection and its datum shift. Over a few kilometres it is good to
//! millimetres, and its residual is checked where the tile is made. The grid's north is not true north: the tile
//! carries its convergence, and headings are turned by it before anything else.
//! An [`Elevation`] beside it says how high the ground is.
use crate::elevation::Elevation;
pub use crate::frames::Local;
use crate::image::View;
use crate::units::{Metres, Radians};

/// Why a tile was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TileError {
    /// The pixels are fewer than the size says, or the size is zero.
    Size,
    /// A resolution, scale or coefficient is not a usable number.
    Georeference,
    /// The posts of its elevation model are not usable, or do not cover it.
    Elevation,
}

/// A WGS84 position in 1e-7 degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Geographic {
    /// Latitude, 1e-7 degrees, north positive.
    pub lat_e7: i32,
    /// Longitude, 1e-7 degrees, east positive.
    pub lon_e7: i32,
}

impl Geographic {
    /// Whether there is such a place: latitude within 90 degrees, longitude within 180.
    pub fn is_possible(self) -> bool {
        (-900_000_000..=900_000_000).contains(&self.lat_e7) && (-1_800_000_000..=1_800_000_000).contains(&self.lon_e7)
    }
}

/// Where a tile lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeference {
    /// EPSG code of the grid.
    pub epsg: u32,
    /// The tile's centre.
    pub centre: Geographic,
    /// East in metres as a polynomial of (q, p) = (longitude, latitude) from the centre in 1e-2 degrees, coefficients
    /// of q, p, q², qp, p².
    pub east: [f32; 5],
    /// North, the same.
    pub north: [f32; 5],
    /// Grid convergence: grid heading = true heading − convergence.
    pub convergence: Radians,
    /// Grid metres in a metre on the ground.
    pub point_scale: f32,
}

/// Units of the polynomial's arguments in 1e-7 degrees.
const ARGUMENT_E7: f32 = 1e5;

impl Georeference {
    /// Whether every number is usable.
    pub fn is_sound(&self) -> bool {
        let determinant = self.east[0] * self.north[1] - self.east[1] * self.north[0];
        self.east.iter().chain(&self.north).all(|c| c.is_finite())
            && determinant.abs() > 1.0
            && self.convergence.0.is_finite()
            && (0.9..1.1).contains(&self.point_scale)
            && (-900_000_000..=900_000_000).contains(&self.centre.lat_e7)
    }

    /// Grid metres from the tile's centre. `None` more than half a degree away, where the polynomial ends.
    pub fn local(&self, position: Geographic) -> Option<Local> {
        let (q, p) = self.arguments(position)?;
        Some(Local { east_m: polynomial(&self.east, q, p), north_m: polynomial(&self.north, q, p) })
    }

    /// The geographic position of a local one: the polynomial inverted by Newton's method. Three steps reach single
    /// precision, 1 cm at 10 km; the fourth is a margin.
    pub fn geographic(&self, local: Local) -> Geographic {
        let (mut q, mut p) = (0.0f32, 0.0f32);
        for _ in 0..4 {
            let de = local.east_m - polynomial(&self.east, q, p);
            let dn = local.north_m - polynomial(&self.north, q, p);
            let (eq, ep) = slope(&self.east, q, p);
            let (nq, np) = slope(&self.north, q, p);
            let determinant = eq * np - ep * nq;
            q += (de * np - dn * ep) / determinant;
            p += (dn * eq - de * nq) / determinant;
        }
        let offset = |argument: f32| crate::math::round(argument * ARGUMENT_E7) as i32;
        Geographic {
            lat_e7: self.centre.lat_e7.saturating_add(offset(p)),
            lon_e7: wrapped_longitude(self.centre.lon_e7 as i64 + offset(q) as i64),
        }
    }

    fn arguments(&self, position: Geographic) -> Option<(f32, f32)> {
        let q = wrapped_longitude(position.lon_e7 as i64 - self.centre.lon_e7 as i64);
        let p = position.lat_e7.checked_sub(self.centre.lat_e7)?;
        let near = |e7: i32| e7.unsigned_abs() < 5_000_000;
        (near(q) && near(p)).then_some((q as f32 / ARGUMENT_E7, p as f32 / ARGUMENT_E7))
    }
}

fn polynomial(c: &[f32; 5], q: f32, p: f32) -> f32 {
    q * (c[0] + c[2] * q + c[3] * p) + p * (c[1] + c[4] * p)
}

fn slope(c: &[f32; 5], q: f32, p: f32) -> (f32, f32) {
    (c[0] + 2.0 * c[2] * q + c[3] * p, c[1] + c[3] * q + 2.0 * c[4] * p)
}

/// Longitude within ±180 degrees, right across the date line.
fn wrapped_longitude(lon_e7: i64) -> i32 {
    const TURN: i64 = 3_600_000_000;
    ((lon_e7 + TURN / 2).rem_euclid(TURN) - TURN / 2) as i32
}

/// A checked tile.
#[derive(Clone, Copy, Debug)]
pub struct Tile<'a> {
    view: View<'a>,
    size: (u16, u16),
    resolution: Metres,
    georeference: Georeference,
    elevation: Option<Elevation<'a>>,
}

impl<'a> Tile<'a> {
    /// Checks a tile of `size` (cols, rows) with pixels of `resolution` grid metres.
    ///
    /// # Errors
    /// [`TileError`].
    pub fn new(
        pixels: &'a [u8],
        size: (u16, u16),
        resolution: Metres,
        georeference: Georeference,
    ) -> Result<Self, TileError> {
        if size.0 == 0 || size.1 == 0 {
            return Err(TileError::Size);
        }
        let view = View::new(pixels, size).ok_or(TileError::Size)?;
        if !(resolution.0.is_finite() && resolution.0 > 0.0 && georeference.is_sound()) {
            return Err(TileError::Georeference);
        }
        Ok(Tile { view, size, resolution, georeference, elevation: None })
    }

    /// This tile with an elevation model, whose centre lies over its own.
    ///
    /// # Errors
    /// [`TileError::Elevation`] for one that does not reach the centres of its outermost pixels.
    pub fn with_elevation(self, elevation: Elevation<'a>) -> Result<Self, TileError> {
        let half = |count: u16| 0.5 * (count as f32 - 1.0) * self.resolution.0;
        if !elevation.posts().reach((half(self.size.0), half(self.size.1))) {
            return Err(TileError::Elevation);
        }
        Ok(Tile { elevation: Some(elevation), ..self })
    }

    /// Its elevation model, if it has one.
    pub fn elevation(&self) -> Option<&Elevation<'a>> {
        self.elevation.as_ref()
    }

    /// The picture.
    pub fn view(&self) -> &View<'a> {
        &self.view
    }

    /// (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Where it lies.
    pub fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    /// Grid metres a pixel.
    pub fn resolution(&self) -> Metres {
        self.resolution
    }

    /// Metres on the ground a pixel: what the frame is rectified to.
    pub(crate) fn ground_resolution(&self) -> Metres {
        Metres(self.resolution.0 / self.georeference.point_scale)
    }

    /// Pixel (col, row) of a local position, fractions included.
    pub fn pixel(&self, local: Local) -> (f32, f32) {
        crate::frames::pixel(
            local.east_m / self.resolution.0,
            local.north_m / self.resolution.0,
            self.size.0,
            self.size.1,
        )
    }

    /// Local position of pixel (`col`, `row`); the inverse of [`Tile::pixel`].
    pub fn local(&self, col: f32, row: f32) -> Local {
        let (m, n) = crate::frames::centred(col, row, self.size.0, self.size.1);
        Local { east_m: m * self.resolution.0, north_m: n * self.resolution.0 }
    }
}
