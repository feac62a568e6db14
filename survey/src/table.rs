//! Tables from CSV files: a header, then a row a line, with the line kept for messages.

use crate::error::InputError;
use std::path::Path;

/// A file's rows, each with its line, and the names of its columns.
pub(crate) struct Table<'a> {
    /// What messages call the file.
    pub(crate) name: String,
    pub(crate) header: Vec<&'a str>,
    /// Line, counted from 1, and fields.
    pub(crate) rows: Vec<(usize, Vec<&'a str>)>,
}

impl<'a> Table<'a> {
    pub(crate) fn parse(text: &'a str, name: String) -> Result<Self, InputError> {
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
    pub(crate) fn column(&self, wanted: &str) -> Result<usize, InputError> {
        let mut places = self.header.iter().enumerate().filter(|(_, name)| **name == wanted).map(|(place, _)| place);
        match (places.next(), places.next()) {
            (Some(place), None) => Ok(place),
            (Some(_), Some(_)) => Err(InputError::new(format!("{}: more than one column {wanted}", self.name))),
            (None, _) => {
                Err(InputError::new(format!("{} has no column {wanted}, only {}", self.name, self.header.join(", "))))
            }
        }
    }

    pub(crate) fn number(&self, row: usize, place: usize) -> Result<f64, InputError> {
        let (line, fields) = &self.rows[row];
        match fields[place].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(InputError::new(format!(
                "{}, line {line}: {} = \"{}\" is not a finite number",
                self.name, self.header[place], fields[place]
            ))),
        }
    }

    pub(crate) fn numbers(&self, place: usize) -> Result<Vec<f64>, InputError> {
        (0..self.rows.len()).map(|row| self.number(row, place)).collect()
    }
}

/// A file's text, and what messages call the file.
pub(crate) fn text_of(path: &Path) -> Result<(String, String), InputError> {
    let name = path.display().to_string();
    let text =
        std::fs::read_to_string(path).map_err(|error| InputError::new(format!("cannot read {name}: {error}")))?;
    Ok((text, name))
}
