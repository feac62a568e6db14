//! Tiles of one band each (planar configuration), which GDAL writes where a picture's bands are kept apart.
//!
//! The decoder reads a whole picture of them wrongly: it takes the last row of tiles of each band but the first for one inside the picture. A single
//! tile it reads rightly.

use std::io::{Read, Seek};

use tiff::decoder::DecodingResult;

use super::Samples;
use super::header::{NO_SAMPLE_TYPE, TiffFile, broken};
use crate::error::InputError;

/// Where the samples of a tile belong.
struct Tile {
    /// Its band, first column and first row, and the rows of it that are in the picture.
    band: usize,
    left: usize,
    top: usize,
    rows: usize,
    /// Columns that were decoded, those beyond the picture left out.
    width: usize,
    /// Columns and bands of the picture.
    cols: usize,
    bands: usize,
}

impl Tile {
    /// Puts its samples into those of the picture, which are interleaved by pixel; `None` where it has too few.
    fn put<T: Copy>(&self, tile: &[T], picture: &mut [T]) -> Option<()> {
        for row in 0..self.rows {
            let from = tile.get(row * self.width..(row + 1) * self.width)?;
            let start = ((self.top + row) * self.cols + self.left) * self.bands + self.band;
            let to = picture.get_mut(start..)?.iter_mut().step_by(self.bands);
            to.zip(from).for_each(|(to, from)| *to = *from);
        }
        Some(())
    }
}

impl<R: Read + Seek> TiffFile<R> {
    /// All bands, interleaved by pixel.
    ///
    /// # Errors
    /// Tiles that are broken, missing, too short or of another type.
    pub fn tiled_planes(&mut self) -> Result<Samples, InputError> {
        let (cols, rows, bands) = (self.cols as usize, self.rows as usize, self.bands);
        let (chunk_cols, chunk_rows) = self.decoder.chunk_dimensions();
        let (chunk_cols, chunk_rows) = (chunk_cols as usize, chunk_rows as usize);
        let (across, down) = (cols.div_ceil(chunk_cols), rows.div_ceil(chunk_rows));
        let mut samples = None;
        for index in 0..bands * across * down {
            let (band, place) = (index / (across * down), index % (across * down));
            let (left, top) = (place % across * chunk_cols, place / across * chunk_rows);
            let number = u32::try_from(index).map_err(|error| broken(&self.path, &error.into()))?;
            let decoded = self.decoder.read_chunk(number).map_err(|error| broken(&self.path, &error))?;
            let width = chunk_cols.min(cols - left);
            let tile = Tile { band, left, top, rows: chunk_rows.min(rows - top), width, cols, bands };
            let picture = match samples.take() {
                Some(picture) => picture,
                None => zeros_like(&decoded, cols * rows * bands).ok_or_else(|| self.refuse(NO_SAMPLE_TYPE))?,
            };
            let put = put(&tile, &decoded, picture);
            samples = Some(put.ok_or_else(|| self.refuse("a tile has fewer samples than its header says"))?);
        }
        samples.ok_or_else(|| self.refuse("it has no tiles"))
    }
}

macro_rules! of_each_type {
    ($($kind:ident),*) => {
        fn zeros_like(decoded: &DecodingResult, count: usize) -> Option<Samples> {
            match decoded {
                $(DecodingResult::$kind(_) => Some(Samples::$kind(vec![Default::default(); count])),)*
                _ => None,
            }
        }

        /// The picture with a tile; `None` where that is too short or of another type.
        fn put(tile: &Tile, decoded: &DecodingResult, mut picture: Samples) -> Option<Samples> {
            match (decoded, &mut picture) {
                $((DecodingResult::$kind(from), Samples::$kind(to)) => tile.put(from, to)?,)*
                _ => return None,
            }
            Some(picture)
        }
    };
}
of_each_type!(U8, U16, I16, U32, I32, F32, F64);
