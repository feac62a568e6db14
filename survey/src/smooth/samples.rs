//! Samples from a CSV file: a header, then a row a sample.

use super::SmoothError;
use crate::error::InputError;
use std::path::Path;

/// Channels over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// Times, in the file's order.
    pub t_s: Vec<f64>,
    /// The values of each wanted column, in the wanted order; NaN where the weight is 0 and the field is empty.
    pub channels: Vec<Vec<f64>>,
    /// 1 unless a column of weights was asked for.
    pub weights: Vec<f64>,
    /// What messages call the file.
    name: String,
    /// Line of each sample.
    lines: Vec<usize>,
}

/// A file's rows, each with its line, and the names of its columns.
struct Table<'a> {
    name: String,
    header: Vec<&'a str>,
    rows: Vec<(usize, Vec<&'a str>)>,
}

impl<'a> Table<'a> {
    fn parse(text: &'a str, name: String) -> Result<Self, InputError> {
        let fields = |line: &'a str| line.split(',').map(str::trim).collect::<Vec<_>>();
        let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        let mut lines = lines.by_ref().filter(|(_, line)| !line.trim().is_empty());
        let Some((_, header)) = lines.next() else {
            return Err(InputError::new(format!("{name} is empty")));
        };
        let header = fields(header);
        let rows: Vec<_> = lines.map(|(index, line)| (index + 1, fields(line))).collect();
        if let Some((line, row)) = rows.iter().find(|(_, row)| row.len() != header.len()) {
            return Err(InputError::new(format!(
                "{name}, line {line}: {} fields, but the header has {}",
                row.len(),
                header.len()
            )));
        }
        Ok(Table { name, header, rows })
    }

    /// Place of the one column of that name.
    fn column(&self, wanted: &str) -> Result<usize, InputError> {
        let mut places = self.header.iter().enumerate().filter(|(_, name)| **name == wanted).map(|(place, _)| place);
        match (places.next(), places.next()) {
            (Some(place), None) => Ok(place),
            (Some(_), Some(_)) => Err(InputError::new(format!("{}: more than one column {wanted}", self.name))),
            (None, _) => {
                Err(InputError::new(format!("{} has no column {wanted}, only {}", self.name, self.header.join(", "))))
            }
        }
    }

    fn number(&self, row: usize, place: usize) -> Result<f64, InputError> {
        let (line, fields) = &self.rows[row];
        match fields[place].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(InputError::new(format!(
                "{}, line {line}: {} = \"{}\" is not a finite number",
                self.name, self.header[place], fields[place]
            ))),
        }
    }

    fn numbers(&self, place: usize) -> Result<Vec<f64>, InputError> {
        (0..self.rows.len()).map(|row| self.number(row, place)).collect()
    }
}

fn text_of(path: &Path) -> Result<(String, String), InputError> {
    let name = path.display().to_string();
    let text =
        std::fs::read_to_string(path).map_err(|error| InputError::new(format!("cannot read {name}: {error}")))?;
    Ok((text, name))
}

impl Samples {
    /// Reads `columns` over the column `time`, with the weights of a column where one is named. A field may be empty
    /// where its weight is 0.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing or there twice, a row is too short or too long, a field is not a
    /// finite number.
    pub fn read(path: &Path, time: &str, columns: &[&str], weights: Option<&str>) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        let table = Table::parse(&text, name)?;
        let t_s = table.numbers(table.column(time)?)?;
        let weights = match weights {
            Some(column) => table.numbers(table.column(column)?)?,
            None => vec![1.0; table.rows.len()],
        };
        let mut channels = Vec::new();
        for column in columns {
            let place = table.column(column)?;
            let value = |row: usize| {
                let missing = weights[row] == 0.0 && table.rows[row].1[place].is_empty();
                if missing { Ok(f64::NAN) } else { table.number(row, place) }
            };
            channels.push((0..table.rows.len()).map(value).collect::<Result<_, _>>()?);
        }
        let lines = table.rows.iter().map(|(line, _)| *line).collect();
        Ok(Samples { t_s, channels, weights, name: table.name, lines })
    }

    /// An error about these samples: the file, the column where it is one's own, the line.
    #[must_use]
    pub fn told(&self, error: &SmoothError, column: Option<&str>) -> InputError {
        let column = column.map(|column| format!(", column {column}")).unwrap_or_default();
        let place = |sample: usize| self.lines.get(sample).map_or_else(String::new, |line| format!("line {line}"));
        InputError::new(format!("{}{column}: {}", self.name, error.sentence(&place)))
    }
}

/// Instants at which a curve is wanted: the column `time`, or the only column whatever its name.
///
/// # Errors
/// As [`Samples::read`]; no instant at all.
pub fn read_instants(path: &Path, time: &str) -> Result<Vec<f64>, InputError> {
    let (text, name) = text_of(path)?;
    let table = Table::parse(&text, name)?;
    let place =
        if table.header.len() == 1 && table.header[0].parse::<f64>().is_err() { 0 } else { table.column(time)? };
    let instants = table.numbers(place)?;
    if instants.is_empty() {
        return Err(InputError::new(format!("{} holds no time", table.name)));
    }
    Ok(instants)
}
