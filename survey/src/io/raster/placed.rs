//! Where a picture lies, by its header alone.

use std::io::Read;
use std::path::Path;

use crate::crs::System;
use crate::error::InputError;
use crate::io::input::{open, unreadable};
use crate::io::tiff::{TiffFile, is_tiff};

use super::{GeoTransform, Georeference};

/// Bytes that tell a TIFF.
const START_BYTES: u64 = 64;

/// The place of a georeferenced picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Columns and rows.
    pub size: (usize, usize),
    /// From pixels to the world and back.
    pub geo: GeoTransform,
    /// The horizontal system; `None` where the file names none.
    pub crs: Option<System>,
    /// Value that stands for "nothing known here".
    pub nodata: Option<f32>,
}

impl Placed {
    /// Reads the header of a file; `None` where it is no TIFF, or one without a georeference.
    ///
    /// # Errors
    /// The file is missing or broken, or its georeference is one that [`super::Raster::read`] refuses.
    pub fn read(path: &Path) -> Result<Option<Self>, InputError> {
        let mut start = Vec::new();
        let (mut file, len) = open(path)?;
        file.by_ref().take(START_BYTES).read_to_end(&mut start).map_err(|error| unreadable(path, error))?;
        if !is_tiff(&start) {
            return Ok(None);
        }
        let (file, _) = open(path)?;
        let TiffFile { cols, rows, geo: tags, .. } = TiffFile::open(std::io::BufReader::new(file), len, path)?;
        if tags.pixel_scale.is_none() && tags.transformation.is_none() {
            return Ok(None);
        }
        let refuse = |why: String| InputError::new(format!("cannot use raster {}: {why}", path.display()));
        let Georeference { geo, crs, nodata, .. } =
            Georeference::read(&tags).map_err(|why| refuse(why.says(path, "cubic")))?;
        Ok(Some(Placed { size: (cols as usize, rows as usize), geo, crs, nodata }))
    }
}
