//! Heights of the geoid above the WGS 84 ellipsoid, from the grids that people have of EGM96, EGM2008 and national geoids.
//!
//! A height above the ellipsoid less the geoid's is one above mean sea level. Three formats are read, of each only the part around a place:
//! GTX (NOAA's VDatum and PROJ up to version 6: a header of 40 bytes, then floats from the south west, big-endian), PGM of GeographicLib
//! (<https://geographiclib.sourceforge.io/C++/doc/geoid.html>: samples of 16 bits from the north west at 0 degrees east, with offset and scale
//! as comments) and GeoTIFF in degrees, as PROJ's data have them.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::{Dem, DemFile, Frame, range_of};
use crate::error::InputError;
use crate::io::input::{open, unreadable};
use crate::io::tiff::is_tiff;

/// Beyond these no geoid lies above or below the ellipsoid, metres. EGM2008 has -107 to 86.
const HEIGHT_MAX_M: f64 = 120.0;
/// What stands for no data in GTX, and how exactly.
const GTX_NODATA: [f64; 2] = [-88.8888, 1e-4];
const GTX_HEADER_BYTES: usize = 40;
/// Bytes in which the header of a PGM file ends; real ones have half a thousand.
const PGM_HEADER_BYTES: u64 = 4096;
/// Most posts along a side that are read: 21 degrees of a grid of 1 minute.
const SIDE_MAX: i64 = 1300;

/// The geoid around a place.
#[derive(Debug, Clone)]
pub struct Geoid {
    /// Longitude as x and latitude as y, degrees.
    heights: Dem,
    /// How it was named.
    name: String,
    /// Least and greatest height over the area.
    range_m: [f64; 2],
}

/// Where the posts of a file lie, and how they are stored.
struct Grid {
    cols: i64,
    rows: i64,
    west_deg: f64,
    south_deg: f64,
    step_deg: [f64; 2],
    /// Where the posts begin.
    first_byte: u64,
    kind: Kind,
}

/// How posts are stored.
#[derive(Clone, Copy)]
enum Kind {
    Gtx,
    Pgm { offset_m: f64, scale_m: f64 },
}

impl Geoid {
    /// Reads the part over an area: west, south, east, north in degrees.
    ///
    /// # Errors
    /// The file cannot be read, is none of the three kinds, ends early, does not cover the area, has no data there or numbers that no geoid has.
    pub fn over(path: &Path, area_deg: [f64; 4]) -> Result<Self, InputError> {
        let refuse = |why: &str| InputError::new(format!("cannot use geoid {}: {why}", path.display()));
        let mut start = Vec::new();
        let (mut file, length) = open(path)?;
        file.by_ref().take(PGM_HEADER_BYTES).read_to_end(&mut start).map_err(|error| unreadable(path, error))?;
        let is_gtx = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gtx"));
        let heights = if is_tiff(&start) {
            of_geotiff(path, area_deg)?
        } else {
            let grid = if start.starts_with(b"P5") { Grid::of_pgm(&start) } else { Grid::of_gtx(&start, is_gtx) };
            let grid = grid.map_err(refuse)?;
            if length < grid.first_byte + grid.cols as u64 * grid.rows as u64 * grid.kind.bytes() {
                return Err(refuse("it ends early"));
            }
            grid.part(&mut file, area_deg).map_err(|error| unreadable(path, error))?.ok_or_else(|| outside(path))?
        };
        if heights.heights.iter().any(|height| !height.is_finite()) {
            return Err(refuse("it has posts without a height there"));
        }
        if let Some(height) = heights.heights.iter().find(|height| height.abs() > HEIGHT_MAX_M) {
            return Err(refuse(&format!(
                "it has {height} m there, and no geoid is more than {HEIGHT_MAX_M} m from the ellipsoid: is it an elevation model?"
            )));
        }
        let mut geoid = Geoid { heights, name: path.display().to_string(), range_m: [0.0; 2] };
        geoid.range_m = geoid.range_over(area_deg).ok_or_else(|| outside(path))?;
        Ok(geoid)
    }

    /// Least and greatest height over an area, of its corners and of the posts in it; `None` where it is not covered.
    fn range_over(&self, [west, south, east, north]: [f64; 4]) -> Option<[f64; 2]> {
        let corners = [[south, west], [south, east], [north, west], [north, east]];
        let mut all = corners.map(|[lat, lon]| self.height_m(lat, lon)).into_iter().collect::<Option<Vec<f64>>>()?;
        let Dem { cols, west_m, south_m, step_m: [dx, dy], ref heights, .. } = self.heights;
        for (index, height) in heights.iter().enumerate() {
            let (lon, lat) = (west_m + dx * (index % cols) as f64, south_m + dy * (index / cols) as f64);
            if (south..=north).contains(&lat)
                && [0.0, 360.0, -360.0].iter().any(|turn| (west..=east).contains(&(lon + turn)))
            {
                all.push(*height);
            }
        }
        range_of(all.into_iter())
    }

    /// Its height above the ellipsoid, bilinear between posts; `None` outside the part that was read.
    #[must_use]
    pub fn height_m(&self, lat_deg: f64, lon_deg: f64) -> Option<f64> {
        [0.0, 360.0, -360.0].into_iter().find_map(|turn| self.heights.height(lon_deg + turn, lat_deg))
    }

    /// Its least and greatest height over the area that it was read for.
    #[must_use]
    pub fn range_m(&self) -> [f64; 2] {
        self.range_m
    }

    /// How it was named.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

fn outside(path: &Path) -> InputError {
    InputError::new(format!("cannot use geoid {}: it does not cover the plan", path.display()))
}

/// The part of a GeoTIFF in degrees.
fn of_geotiff(path: &Path, [west, south, east, north]: [f64; 4]) -> Result<Dem, InputError> {
    let file = DemFile::open(path)?;
    let [first, _, last, _] = file.bounds();
    let turn = [0.0, 360.0, -360.0].into_iter().find(|turn| west + turn >= first && east + turn <= last);
    let turn = turn.ok_or_else(|| outside(path))?;
    let frame = Frame::new(file.system(), [0.5 * (west + east) + turn, 0.5 * (south + north)])?;
    if !matches!(frame, Frame::Degrees { .. }) {
        return Err(InputError::new(format!("cannot use geoid {}: it is not in degrees", path.display())));
    }
    let ([x0, y0], [x1, y1]) = (frame.metres([west + turn, south]), frame.metres([east + turn, north]));
    let part = file.window(&frame, [x0, y0, x1, y1], &mut |_, _| {})?;
    let [west_m, south_m] = frame.world([part.west_m, part.south_m]);
    Ok(Dem { west_m, south_m, step_m: [file.geo().step_x, file.geo().step_y], ..part })
}

impl Grid {
    fn of_gtx(start: &[u8], is_named_so: bool) -> Result<Self, &'static str> {
        const NONE: &str = "it is no GTX file, no PGM file of GeographicLib and no GeoTIFF";
        let header = start.get(..GTX_HEADER_BYTES).filter(|_| is_named_so).ok_or(NONE)?;
        let double = |at: usize| header[at..at + 8].try_into().map(f64::from_be_bytes).unwrap_or(f64::NAN);
        let count = |at: usize| header[at..at + 4].try_into().map_or(0, i32::from_be_bytes);
        let grid = Grid {
            south_deg: double(0),
            west_deg: double(8),
            step_deg: [double(24), double(16)],
            rows: i64::from(count(32)),
            cols: i64::from(count(36)),
            first_byte: GTX_HEADER_BYTES as u64,
            kind: Kind::Gtx,
        };
        if grid.is_on_earth() { Ok(grid) } else { Err("its header is none of a GTX file") }
    }

    fn of_pgm(start: &[u8]) -> Result<Self, &'static str> {
        const NONE: &str = "its header is none of GeographicLib's";
        // The header ends with the third number, the largest sample, and one byte of white space.
        let (mut numbers, mut comments, mut at) = (Vec::new(), Vec::new(), 2);
        while numbers.len() < 3 {
            let rest = start.get(at..).filter(|rest| !rest.is_empty()).ok_or(NONE)?;
            let length = |is: fn(u8) -> bool| rest.iter().position(|byte| is(*byte)).unwrap_or(rest.len());
            match rest[0] {
                b'#' => {
                    let line = length(|byte| byte == b'\n');
                    comments.push(String::from_utf8_lossy(&rest[..line]).into_owned());
                    at += line;
                }
                byte if byte.is_ascii_whitespace() => at += 1,
                _ => {
                    let word = length(|byte| byte.is_ascii_whitespace());
                    let text = std::str::from_utf8(&rest[..word]).map_err(|_| NONE)?;
                    numbers.push(text.parse::<i64>().map_err(|_| NONE)?);
                    at += word;
                }
            }
        }
        let said = |key: &str| {
            let mut words = comments.iter().map(|line| line.trim_start_matches('#').split_whitespace());
            let number = words.find_map(|mut words| (words.next() == Some(key)).then(|| words.next()?.parse().ok()));
            number.flatten().filter(|number: &f64| number.is_finite()).ok_or(NONE)
        };
        let (cols, rows) = (numbers[0], numbers[1]);
        if numbers[2] != 65_535 || cols < 2 || rows < 2 {
            return Err(NONE);
        }
        let kind = Kind::Pgm { offset_m: said("Offset")?, scale_m: said("Scale")? };
        let step_deg = [360.0 / cols as f64, 180.0 / (rows - 1) as f64];
        let grid = Grid { cols, rows, west_deg: 0.0, south_deg: -90.0, step_deg, first_byte: at as u64 + 1, kind };
        if grid.is_on_earth() { Ok(grid) } else { Err(NONE) }
    }

    fn is_on_earth(&self) -> bool {
        let [dx, dy] = self.step_deg;
        let is_step = |step: f64| step > 1e-4 && step < 90.0;
        let (width_deg, north_deg) = (self.cols as f64 * dx, self.south_deg + (self.rows - 1) as f64 * dy);
        is_step(dx)
            && is_step(dy)
            && self.cols > 1
            && self.rows > 1
            && self.west_deg.abs() <= 360.0
            && width_deg <= 360.0 + 2.0 * dx
            && self.south_deg >= -90.0 - dy
            && north_deg <= 90.0 + dy
    }

    /// The posts around an area; `None` where it is not covered. A grid all around the Earth has no end in the east.
    fn part(&self, file: &mut File, [west, south, east, north]: [f64; 4]) -> std::io::Result<Option<Dem>> {
        let [dx, dy] = self.step_deg;
        let is_around = (self.cols as f64 + 0.5) * dx >= 360.0;
        // Its last column may be its first once more.
        let period = if is_around { (360.0 / dx).round() as i64 } else { self.cols };
        let from_deg = (west - self.west_deg).rem_euclid(360.0);
        let (left, right) = ((from_deg / dx).floor() as i64, ((from_deg + east - west) / dx).floor() as i64 + 1);
        let row = |lat: f64| ((lat - self.south_deg) / dy).floor() as i64;
        let (bottom, top) = (row(south), row(north) + 1);
        let is_covered = bottom >= 0 && top < self.rows && (is_around || right < self.cols);
        if !is_covered || right - left > SIDE_MAX || top - bottom > SIDE_MAX {
            return Ok(None);
        }
        let mut heights = Vec::new();
        for row in bottom..=top {
            for col in left..=right {
                heights.push(self.post(file, col.rem_euclid(period), row)?);
            }
        }
        Ok(Some(Dem {
            cols: (right - left + 1) as usize,
            rows: (top - bottom + 1) as usize,
            west_m: west - from_deg + left as f64 * dx,
            south_m: self.south_deg + bottom as f64 * dy,
            step_m: self.step_deg,
            heights,
        }))
    }

    /// The post of a column and of a row from the south; NaN where there is no data.
    fn post(&self, file: &mut File, col: i64, row: i64) -> std::io::Result<f64> {
        let row = if matches!(self.kind, Kind::Pgm { .. }) { self.rows - 1 - row } else { row };
        let index = (row * self.cols + col) as u64;
        file.seek(SeekFrom::Start(self.first_byte + index * self.kind.bytes()))?;
        match self.kind {
            Kind::Gtx => {
                let mut bytes = [0; 4];
                file.read_exact(&mut bytes)?;
                let height_m = f64::from(f32::from_be_bytes(bytes));
                Ok(if (height_m - GTX_NODATA[0]).abs() < GTX_NODATA[1] { f64::NAN } else { height_m })
            }
            Kind::Pgm { offset_m, scale_m } => {
                let mut bytes = [0; 2];
                file.read_exact(&mut bytes)?;
                Ok(offset_m + scale_m * f64::from(u16::from_be_bytes(bytes)))
            }
        }
    }
}

impl Kind {
    /// Of a post.
    fn bytes(self) -> u64 {
        match self {
            Kind::Gtx => 4,
            Kind::Pgm { .. } => 2,
        }
    }
}

#[cfg(test)]
mod tests;
