//! Files of elevation models: the header first, then as much of the heights as is asked for.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::crs::System;
use crate::error::InputError;
use crate::io::input::{BOM, by_gdal, in_utf16, open, unreadable};
use crate::io::raster::{
    GeoTransform, Georeference, HeightDatum, Posts, Scaling, check_elevation, for_people, is_known, vertical_unit_m,
};
use crate::io::shell::{names, quoted};
use crate::io::tiff::{Part, SAMPLES_MAX, TiffFile, is_tiff};

use super::ascii::{Header, is_ascii_grid};
use super::tokens::Tokens;
use super::{Dem, Frame, ROUNDING, prj};

/// Bytes of a file that are looked at to tell what it is.
const START_BYTES: u64 = 64;

/// An elevation model on disk, of which only the header is in memory: a GeoTIFF of one band or an ESRI ASCII grid.
///
/// Heights become metres; a vertical datum is not interpreted.
#[derive(Debug, Clone)]
pub struct DemFile {
    path: PathBuf,
    cols: usize,
    rows: usize,
    geo: GeoTransform,
    system: Option<System>,
    height_unit_m: f64,
    scaling: Scaling,
    has_heights: bool,
    is_unit_stated: bool,
    height_datum: HeightDatum,
    kind: Kind,
}

/// How the heights are stored.
#[derive(Debug, Clone, PartialEq)]
enum Kind {
    GeoTiff { nodata: Option<f32> },
    Ascii(Header),
}

impl DemFile {
    /// Reads the header of a file, which has to be that of a model: one band, no samples of 8 bits.
    ///
    /// Which kind it is, its bytes say, not its name. The reference system of an ASCII grid is that of the `.prj` file beside
    /// it, if there is one; that says the unit of heights too. A file without a reference system is in local metres.
    ///
    /// # Errors
    /// The file is missing, neither of the two kinds, broken; it has no georeference, one with a rotation or south up;
    /// its reference system is not certain; its units are not metres (degrees for a geographic system); it is no model, which is told with
    /// the command that makes one.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let (model, bands, is_of_8_bits) = Self::header(path)?;
        check_elevation(path, bands, is_of_8_bits)?;
        model.check_vertical()?;
        Ok(model)
    }

    /// The header, whatever it is the header of, with the number of bands, of which the first is read, and whether its samples have 8 bits.
    /// Errors as those of [`Self::open`].
    pub(super) fn header(path: &Path) -> Result<(Self, usize, bool), InputError> {
        let mut start = Vec::new();
        let (mut file, _) = open(path)?;
        file.by_ref().take(START_BYTES).read_to_end(&mut start).map_err(|error| unreadable(path, error))?;
        let refuse = |why: String| refusal(path, &why);
        let (model, bands, is_of_8_bits) = if is_tiff(&start) {
            let tiff = open_tiff(path)?;
            let tags = Georeference::read(&tiff.geo).map_err(|why| refuse(why.says(path, "bilinear")))?;
            tags.placed_heights.map_or(Ok(()), |heights| Err(refuse(scaled(path, heights))))?;
            let model = Self {
                path: path.into(),
                cols: tiff.cols as usize,
                rows: tiff.rows as usize,
                geo: tags.geo,
                system: tags.crs,
                height_unit_m: tags.height_unit_m,
                scaling: tags.scaling,
                has_heights: tags.has_heights,
                is_unit_stated: tags.has_heights,
                height_datum: tags.height_datum,
                kind: Kind::GeoTiff { nodata: tags.nodata },
            };
            (model, tiff.bands, tiff.colour.bit_depth() == 8)
        } else if is_ascii_grid(start.strip_prefix(BOM).unwrap_or(&start)) {
            let (header, _) = open_ascii(path)?;
            let Header { cols, rows, geo, .. } = header;
            let beside = prj::beside(path)?;
            let height_datum = beside.map_or(HeightDatum::Unsaid, |said| said.height_datum);
            let model = Self {
                path: path.into(),
                cols,
                rows,
                geo,
                system: beside.map(|said| said.horizontal),
                height_unit_m: beside.map_or(1.0, |said| said.height_unit_m),
                scaling: Scaling::NONE,
                // An ASCII grid is no picture's format.
                has_heights: true,
                is_unit_stated: height_datum != HeightDatum::Unsaid,
                height_datum,
                kind: Kind::Ascii(header),
            };
            (model, 1, false)
        } else if let Some(error) = in_utf16(path, &start) {
            return Err(error);
        } else {
            return Err(refuse(format!("it is neither a GeoTIFF nor an ESRI ASCII grid{}", by_gdal(path, &start))));
        };
        if model.bounds().iter().any(|bound| !bound.is_finite()) {
            return Err(refuse("its bounds are not finite".into()));
        }
        Ok((model, bands, is_of_8_bits))
    }

    /// Refuses a horizontal system, and any other number, in the place of a vertical one.
    fn check_vertical(&self) -> Result<(), InputError> {
        let HeightDatum::System(Some(code)) = self.height_datum else { return Ok(()) };
        let Some(why) = u16::try_from(code).ok().and_then(|code| vertical_unit_m(code).err()) else { return Ok(()) };
        let horizontal = match self.system {
            Some(System::Epsg(epsg)) => epsg.to_string(),
            _ => "CODE".to_owned(),
        };
        Err(self.refuse(&format!(
            "its heights are said to be in EPSG:{code}, but {why}: gdal_translate -a_srs EPSG:{horizontal}+5773 {} says so",
            names(&self.path, "vertical")
        )))
    }

    /// Where the file is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// (columns, rows).
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.cols, self.rows)
    }

    /// What its heights are above, as far as it says so.
    #[must_use]
    pub fn height_datum(&self) -> HeightDatum {
        self.height_datum
    }

    /// Whether it says in which unit its heights are: by a unit, a vertical system or a scale.
    #[must_use]
    pub fn is_unit_stated(&self) -> bool {
        self.is_unit_stated
    }

    /// From its columns and rows to its x and y.
    #[must_use]
    pub fn geo(&self) -> &GeoTransform {
        &self.geo
    }

    /// Its outermost posts (centres of pixels): x0, y0, x1, y1 in its own x and y.
    #[must_use]
    pub fn bounds(&self) -> [f64; 4] {
        let (x1, y0) = self.geo.world_from_pixel((self.cols - 1) as f64, (self.rows - 1) as f64);
        [self.geo.x0, y0, x1, self.geo.y0]
    }

    /// Its reference system; `None` where it names none (local metres).
    #[must_use]
    pub fn system(&self) -> Option<System> {
        self.system
    }

    /// Refuses samples of a part that are no heights.
    fn check(&self, samples: &[f64], part: &Part, step_m: [f64; 2]) -> Result<(), InputError> {
        let cols = part.cols.len();
        let place = |index: usize| {
            let (col, row) = (part.cols.start + index % cols, part.rows.end - 1 - index / cols);
            self.geo.world_from_pixel(col as f64, row as f64)
        };
        let has_nodata = match &self.kind {
            Kind::GeoTiff { nodata } => nodata.is_some(),
            // Every one has such a number; whether it is used the posts say.
            Kind::Ascii(_) => samples.iter().any(|sample| sample.is_nan()),
        };
        let posts = Posts {
            path: &self.path,
            samples,
            cols,
            step_m,
            scaling: self.scaling,
            unit_m: self.height_unit_m,
            has_nodata,
            are_declared_heights: self.has_heights,
            is_ascii: matches!(self.kind, Kind::Ascii(_)),
            place: &place,
        };
        posts.check()
    }

    /// Reads the posts within `bounds_m` (x0, y0, x1, y1 in working metres) and one beyond on each side, as far as there are
    /// any. `progress` is called with the rows read and all rows.
    ///
    /// Memory is that of the heights, eight bytes a post, and of one strip or tile. Of a GeoTIFF the strips or tiles that
    /// hold the window are read and no others. An ASCII grid is read to its end, without a look at what lies outside.
    ///
    /// # Errors
    /// The bounds are not finite, upside down or beside the model; the frame is one of another system; the window has
    /// more than 2^29 posts; the heights are broken, cut short or too many, or such as no land has; the file has changed since it was opened.
    pub fn window(
        &self,
        frame: &Frame,
        bounds_m: [f64; 4],
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Dem, InputError> {
        if frame.system() != self.system {
            return Err(self.refuse("it is not in the system of the working coordinates"));
        }
        let part = self.part(frame, bounds_m)?;
        let (cols, rows) = (part.cols.len(), part.rows.len());
        let [west_m, south_m] = {
            let (x, y) = self.geo.world_from_pixel(part.cols.start as f64, (part.rows.end - 1) as f64);
            frame.metres([x, y])
        };
        let step_m = match frame {
            Frame::Local | Frame::Grid(_) => [self.geo.step_x, self.geo.step_y],
            Frame::Degrees { m_per_deg, .. } => [self.geo.step_x * m_per_deg[0], self.geo.step_y * m_per_deg[1]],
        };
        // Every post is written once. Zeros take no memory before.
        let mut dem = Dem { cols, rows, west_m, south_m, step_m, heights: vec![0.0; cols * rows] };
        let mut done = 0;
        let mut put = |row: usize, col: usize, heights: &[f64], is_known: &dyn Fn(f64) -> bool| {
            let first = (part.rows.end - 1 - row) * cols + (col - part.cols.start);
            for (post, &height) in dem.heights[first..].iter_mut().zip(heights) {
                *post = if is_known(height) { height } else { f64::NAN };
            }
            if col + heights.len() == part.cols.end {
                done += 1;
                progress(done, rows as u64);
            }
        };
        match &self.kind {
            Kind::GeoTiff { nodata } => {
                let tiff = open_tiff(&self.path)?;
                if (tiff.cols as usize, tiff.rows as usize) != self.size() {
                    return Err(self.has_changed());
                }
                // The no-data value is rounded as the samples of most models are.
                let known = |height| is_known(height as f32, *nodata);
                tiff.first_band(&part, &mut |row, col, heights| put(row, col, heights, &known))?;
            }
            Kind::Ascii(header) => {
                let (found, mut tokens) = open_ascii(&self.path)?;
                if found != *header {
                    return Err(self.has_changed());
                }
                let known = |height| header.is_known(height);
                header
                    .heights(&mut tokens, &part, &mut |row, col, heights| put(row, col, heights, &known))
                    .map_err(|why| self.refuse(&why))?;
            }
        }
        self.check(&dem.heights, &part, step_m)?;
        dem.heights.iter_mut().for_each(|height| *height = self.scaling.value(*height) * self.height_unit_m);
        Ok(dem)
    }

    /// Columns and rows of the file that a window has.
    fn part(&self, frame: &Frame, bounds_m: [f64; 4]) -> Result<Part, InputError> {
        let [x0, y0, x1, y1] = bounds_m;
        if bounds_m.iter().any(|bound| !bound.is_finite()) || x0 > x1 || y0 > y1 {
            return Err(self.refuse(&format!("{x0},{y0},{x1},{y1} are no bounds of an area")));
        }
        let ([west, south], [east, north]) = (frame.world([x0, y0]), frame.world([x1, y1]));
        let (left, bottom) = self.geo.pixel_from_world(west, south);
        let (right, top) = self.geo.pixel_from_world(east, north);
        let (Some(cols), Some(rows)) = (posts(left, right, self.cols), posts(top, bottom, self.rows)) else {
            return Err(self.outside(frame, [x0, y0, x1, y1]));
        };
        if cols.len() as u64 * rows.len() as u64 > SAMPLES_MAX {
            let size = format!("{} x {}", cols.len(), rows.len());
            return Err(self.refuse(&format!("the area takes {size} posts, more than {SAMPLES_MAX}")));
        }
        Ok(Part { cols, rows })
    }

    /// Why nothing of working metres is read, in its own coordinates: of a model in degrees nobody knows working metres.
    fn outside(&self, frame: &Frame, [x0, y0, x1, y1]: [f64; 4]) -> InputError {
        let ([west, south], [east, north]) = (frame.world([x0, y0]), frame.world([x1, y1]));
        let listed = |bounds: [f64; 4]| bounds.map(|bound| for_people(bound).to_string()).join(",");
        let system = match (self.system, frame) {
            (Some(system), Frame::Degrees { .. }) => format!(" in {system}, longitude first"),
            (Some(system), _) => format!(" in {system}"),
            (None, _) => String::new(),
        };
        let (area, model) = (listed([west, south, east, north]), listed(self.bounds()));
        self.refuse(&format!("the area {area} lies outside it, which has {model}{system}"))
    }

    fn refuse(&self, why: &str) -> InputError {
        refusal(&self.path, why)
    }

    fn has_changed(&self) -> InputError {
        self.refuse("it has changed since it was opened")
    }
}

/// The posts from position `first` to position `last` and one beyond on each side, of `count`; `None` if both are on the
/// same side of them all.
fn posts(first: f64, last: f64, count: usize) -> Option<Range<usize>> {
    let end = (count - 1) as f64;
    if last < -ROUNDING || first > end + ROUNDING {
        return None;
    }
    // Clamped first, so that the casts are exact.
    let (start, stop) = ((first - ROUNDING).ceil() - 1.0, (last + ROUNDING).floor() + 1.0);
    let (start, stop) = (start.clamp(0.0, end), stop.clamp(0.0, end));
    Some(start as usize..stop as usize + 1)
}

/// What to type where heights have a scale on which programs do not agree whether to apply it.
fn scaled(path: &Path, [scale, offset]: [f64; 2]) -> String {
    let (from, to) = (quoted(&path.display().to_string()), format!("{}_scaled.tif", path.with_extension("").display()));
    format!(
        "its pixel scale and tie point say that heights are {scale} times its samples and {offset} more, which is not applied: \
         gdal_calc.py -A {from} --calc='{scale}*A.astype(float)+({offset})' --type=Float64 --outfile={} applies it",
        quoted(&to)
    )
}

fn refusal(path: &Path, why: &str) -> InputError {
    InputError::new(format!("cannot use elevation model {}: {why}", path.display()))
}

fn open_tiff(path: &Path) -> Result<TiffFile<impl Read + Seek>, InputError> {
    let (file, length) = open(path)?;
    TiffFile::open(BufReader::new(file), length, path)
}

/// The header of an ASCII grid, and the words that follow it.
fn open_ascii(path: &Path) -> Result<(Header, Tokens<BufReader<File>>), InputError> {
    let (file, _) = open(path)?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    if reader.fill_buf().map_err(|error| unreadable(path, error))?.starts_with(BOM) {
        reader.consume(BOM.len());
    }
    let mut tokens = Tokens::new(reader);
    let header = Header::read(&mut tokens).map_err(|why| refusal(path, &why))?;
    Ok((header, tokens))
}
