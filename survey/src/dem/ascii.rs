//! ESRI ASCII grids: a header of keys and values, then heights from the north west, row by row.
//!
//! Format: ESRI's, as its documentation states it (`ncols`, `nrows`, `xllcorner` or `xllcenter`, `yllcorner` or `yllcenter`,
//! `cellsize`, `NODATA_value`), and GDAL's `dx` and `dy` in the place of `cellsize`. Keys come in any order and case,
//! heights may wrap over lines.

use std::io::BufRead;

use crate::io::raster::{GeoTransform, is_known};
use crate::io::tiff::{Part, Put};

use super::tokens::Tokens;

/// Most posts that a file may have: 2^40, which as text fills terabytes.
const POSTS_MAX: u64 = 1 << 40;

/// What stands for an unknown height where the header does not say.
const NODATA_DEFAULT: f64 = -9999.0;

/// Keys of the header, in lower case.
const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

/// What stands before the heights.
#[derive(Debug, Clone)]
pub(super) struct Header {
    pub cols: usize,
    pub rows: usize,
    pub geo: GeoTransform,
    nodata: f64,
}

impl PartialEq for Header {
    /// NaN may stand for an unknown height, and is not equal to itself.
    fn eq(&self, other: &Self) -> bool {
        (self.cols, self.rows, self.geo) == (other.cols, other.rows, other.geo)
            && self.nodata.total_cmp(&other.nodata).is_eq()
    }
}

/// Whether a file that starts like this is an ASCII grid: its first word is a key.
pub(super) fn is_ascii_grid(start: &[u8]) -> bool {
    let text = start.trim_ascii_start();
    let word = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    KEYS.iter().any(|key| word.eq_ignore_ascii_case(key.as_bytes()))
}

impl Header {
    /// Reads the header and stops before the first height.
    pub fn read<R: BufRead>(tokens: &mut Tokens<R>) -> Result<Self, String> {
        let mut keys = Keys([const { None }; KEYS.len()]);
        while let Some(word) = tokens.peek()? {
            if number(word).is_some() {
                break;
            }
            let Some(index) = KEYS.iter().position(|key| word.eq_ignore_ascii_case(key)) else {
                let sentence = format!("\"{word}\" is neither a key of the header nor a number");
                return Err(format!("line {}: {sentence}", tokens.word_line()));
            };
            tokens.next()?;
            let value = tokens.next()?.unwrap_or_default().to_owned();
            let at = |why: &str| format!("line {}: {} {why}", tokens.word_line(), KEYS[index]);
            if keys.0[index].is_some() {
                return Err(at("is given twice"));
            }
            let any_number = KEYS[index] == "nodata_value";
            match value.parse::<f64>() {
                Ok(value) if value.is_finite() || any_number => {}
                _ => return Err(at(&format!("is \"{value}\", which is not a number"))),
            }
            keys.0[index] = Some((value, tokens.word_line()));
        }
        keys.header()
    }

    /// Hands the heights of `part`, which lies inside the grid, to `put`, rows from the top; unknown ones as they are in the
    /// file. Those outside `part` are counted but not looked at. `tokens` stands before the first height.
    pub fn heights<R: BufRead>(&self, tokens: &mut Tokens<R>, part: &Part, put: &mut Put) -> Result<(), String> {
        let (cols, rows) = (self.cols as u64, self.rows as u64);
        let mut before = 0;
        let mut skip = |tokens: &mut Tokens<R>, count: u64| {
            let skipped = tokens.skip(count)?;
            before += skipped;
            if skipped == count { Ok(()) } else { Err(self.too_few(before, tokens.word_line())) }
        };
        skip(tokens, part.rows.start as u64 * cols)?;
        let mut heights = Vec::new();
        for row in part.rows.clone() {
            skip(tokens, part.cols.start as u64)?;
            heights.clear();
            for col in part.cols.clone() {
                let Some(word) = tokens.next()? else {
                    return Err(self.too_few(row as u64 * cols + col as u64, tokens.word_line()));
                };
                let Some(height) = number(word) else {
                    let sentence = format!("\"{word}\" is not a number");
                    return Err(format!("line {}: {sentence}", tokens.word_line()));
                };
                if self.is_beyond(height) {
                    let sentence = format!(
                        "the height {word} is beyond the range of numbers: if it stands for posts without a height, NODATA_value {word} in its \
                         header says so"
                    );
                    return Err(format!("line {}: {sentence}", tokens.word_line()));
                }
                heights.push(height);
            }
            skip(tokens, cols - part.cols.end as u64)?;
            put(row, part.cols.start, &heights);
        }
        skip(tokens, (rows - part.rows.end as u64) * cols)?;
        if tokens.next()?.is_some() {
            return Err(format!("line {}: there are more heights than {cols} x {rows}", tokens.word_line()));
        }
        Ok(())
    }

    /// Whether a height says something; single precision decides, in which both numbers may have been written.
    pub fn is_known(&self, height: f64) -> bool {
        is_known(height as f32, Some(self.nodata as f32))
    }

    /// Whether a height is beyond the range of numbers, and does not stand for nothing.
    fn is_beyond(&self, height: f64) -> bool {
        (height as f32).is_infinite() && height as f32 != self.nodata as f32
    }

    fn too_few(&self, count: u64, line: u64) -> String {
        format!("line {line}: it ends after {count} of {} x {} heights", self.cols, self.rows)
    }
}

/// A height. Numbers beyond the range of an `f64` are infinite.
fn number(word: &str) -> Option<f64> {
    word.parse().ok()
}

/// Values by key, with their lines; those that are there are numbers.
struct Keys([Option<(String, u64)>; KEYS.len()]);

impl Keys {
    fn get(&self, key: &str) -> Option<&(String, u64)> {
        self.0.iter().zip(KEYS).find(|(_, name)| *name == key).and_then(|(value, _)| value.as_ref())
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.get(key).and_then(|(value, _)| value.parse().ok())
    }

    fn header(&self) -> Result<Header, String> {
        let (cols, rows) = (self.count("ncols")?, self.count("nrows")?);
        match cols.checked_mul(rows) {
            Some(posts) if posts <= POSTS_MAX => {}
            _ => return Err(format!("line {}: {cols} x {rows} heights are too many", self.line("nrows"))),
        }
        let (step_x, step_y) = match (self.get("cellsize"), self.get("dx"), self.get("dy")) {
            (Some(_), None, None) => (self.step("cellsize")?, self.step("cellsize")?),
            (None, Some(_), Some(_)) => (self.step("dx")?, self.step("dy")?),
            (None, None, None) => return Err("its header has no cellsize".into()),
            _ => return Err("its header has to have either cellsize or dx and dy".into()),
        };
        let x0 = self.first("xllcorner", "xllcenter", step_x)?;
        let south = self.first("yllcorner", "yllcenter", step_y)?;
        let geo = GeoTransform { x0, y0: south + (rows - 1) as f64 * step_y, step_x, step_y };
        // As `number` reads heights, so that the same text is the same number.
        let nodata = match self.get("nodata_value") {
            Some((value, _)) => number(value).unwrap_or(f64::NAN),
            None => NODATA_DEFAULT,
        };
        Ok(Header { cols: cols as usize, rows: rows as usize, geo, nodata })
    }

    fn line(&self, key: &str) -> u64 {
        self.get(key).map_or(0, |(_, line)| *line)
    }

    fn count(&self, key: &str) -> Result<u64, String> {
        let Some((value, line)) = self.get(key) else { return Err(format!("its header has no {key}")) };
        match value.parse() {
            Ok(count) if (1..=POSTS_MAX).contains(&count) => Ok(count),
            _ => Err(format!("line {line}: {key} is {value}, which is no number of heights")),
        }
    }

    fn step(&self, key: &str) -> Result<f64, String> {
        match self.number(key) {
            Some(step) if step > 0.0 => Ok(step),
            _ => Err(format!("line {}: {key} is not above 0", self.line(key))),
        }
    }

    /// Coordinate of the first post along an axis, from that of its cell's corner or its own.
    fn first(&self, corner: &str, centre: &str, step: f64) -> Result<f64, String> {
        match (self.number(corner), self.number(centre)) {
            (Some(corner), None) => Ok(corner + step / 2.0),
            (None, Some(centre)) => Ok(centre),
            _ => Err(format!("its header has to have either {corner} or {centre}")),
        }
    }
}
