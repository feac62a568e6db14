//! Files read and written: pictures, georeferenced rasters, tables, and output that appears whole or not at all.
//!
//! Uses `crs`, since a raster's tags may spell a reference system out; is used by everything that works on what was read.

pub mod data;
pub mod geojson;
pub mod input;
pub(crate) mod json;
pub mod output;
pub mod picture;
pub mod raster;
pub mod shell;
pub mod table;
pub(crate) mod tiff;
