//! The observations file: `station,head,point,x_px,y_px`, x right and y up from the frame's centre.

use super::block::Block;
use crate::adjust::rig::Observation;
use crate::error::InputError;
use crate::io::table::{Table, text_of};
use std::collections::HashMap;
use std::path::Path;

/// Columns of the file.
const HEADER: [&str; 5] = ["station", "head", "point", "x_px", "y_px"];
/// An image coordinate beyond it belongs to no frame.
const IMAGE_MAX_PX: f64 = 65_535.0;

/// Observations, each with the line it stands in.
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    /// In the file's order.
    pub seen: Vec<Observation>,
    /// Line of each, from 1.
    pub lines: Vec<usize>,
    /// What messages call the file.
    pub name: String,
}

impl Observations {
    /// Reads the observations of a block.
    ///
    /// # Errors
    /// The file cannot be read; otherwise as [`Self::parse`].
    pub fn read(path: &Path, block: &Block) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::parse(&text, &name, block)
    }

    /// Reads observations from text; `name` is what errors call it.
    ///
    /// # Errors
    /// Another header; a row with too few or too many fields, with what is no index of the block or no finite number, or
    /// one that stands there a second time.
    pub fn parse(text: &str, name: &str, block: &Block) -> Result<Self, InputError> {
        let refuse = |sentence: String| Err(InputError::new(format!("{name}{sentence}")));
        let table = Table::parse(text, name.to_owned())?;
        if table.header != HEADER {
            return refuse(format!(": the first line is not {}", HEADER.join(",")));
        }
        let mut observations = Observations { seen: Vec::new(), lines: Vec::new(), name: name.to_owned() };
        let mut first: HashMap<(usize, usize, usize), usize> = HashMap::new();
        for (row, (line, fields)) in table.rows.iter().enumerate() {
            let line = *line;
            let index = |k: usize, count: usize, what: &str| -> Result<usize, InputError> {
                match fields[k].parse::<usize>() {
                    Ok(number) if number < count => Ok(number),
                    Ok(number) => Err(InputError::new(format!(
                        "{name}, line {line}: {what} {number}, but the block has {count}, counted from 0"
                    ))),
                    Err(_) => Err(table.wrong(row, k, "no index from 0")),
                }
            };
            let image = |k: usize| -> Result<f64, InputError> {
                let value = fields[k].parse::<f64>().ok().filter(|value| value.abs() <= IMAGE_MAX_PX);
                value.ok_or_else(|| table.wrong(row, k, "no image coordinate"))
            };
            let seen = Observation {
                station: index(0, block.stations.len(), "station")?,
                head: index(1, block.heads.len(), "head")?,
                point: index(2, block.points.len(), "point")?,
                image_px: [image(3)?, image(4)?],
            };
            if let Some(before) = first.insert((seen.station, seen.head, seen.point), line) {
                return refuse(format!(
                    ", line {line}: point {} at station {}, head {} stands in line {before} already",
                    seen.point, seen.station, seen.head
                ));
            }
            observations.seen.push(seen);
            observations.lines.push(line);
        }
        if observations.seen.is_empty() {
            return refuse(" holds no observation".to_owned());
        }
        Ok(observations)
    }
}
