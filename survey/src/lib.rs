//! Preparation on the ground: what a flight needs before the shutter opens, read once and checked once.
//!
//! Everything here runs on the host, in `f64`, with the standard library. It reads the outside world (pictures,
//! georeferenced rasters, coordinate reference systems, camera files) into plain data and refuses what it cannot
//! read for certain. The principles:
//!
//! 1. Bad input is an [`InputError`]: one sentence that says what is wrong and where. Nothing here panics on input.
//! 2. A doubtful datum, unit or georeference is refused, never guessed: a wrong one is a silent wrong fix.
//! 3. Pixel centres are integers, row 0 is north (or forward), columns run east (or right).
//! 4. An output file appears whole or not at all.

pub mod adjust;
pub mod calibrate;
pub mod camera_file;
pub mod crs;
pub mod dem;
pub mod error;
pub mod io;
pub mod logs;
pub mod misspelt;
pub mod plan;
pub mod smooth;

pub use camera_file::{CameraFile, Distortion, Head};
pub use crs::Crs;
pub use dem::{Dem, DemFile, Frame};
pub use error::InputError;
pub use io::data::shared_data;
pub use io::output::write_file;
pub use io::picture::{Bands, Picture, read_bands, read_grey, write_grey_png, write_rgb_png};
pub use io::raster::{GeoTransform, Raster, SampleType};
