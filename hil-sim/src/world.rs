//! The ground of a flight, procedural or from an orthophoto: what it looks like and how high it is.
//!
//! World frame everywhere in here: `east_m` and `north_m` are grid coordinates of the ground's own reference system (its
//! EPSG code), `up_m` is the height. A direction or a point is `[east, north, up]`. Data in, data out: files are read
//! elsewhere, this module takes rasters that are already in memory.

mod grid;
mod ground;
mod mirror;
mod procedural;
pub mod reference;
mod surface;
mod swell;
pub mod tile;
mod weather;

pub use grid::{Bounds, Grid};
pub use ground::{Ground, GroundError};
pub use procedural::{PROCEDURAL_PLACE, draped, procedural, procedural_around, procedural_as};
pub use weather::{Moment, Weather};
