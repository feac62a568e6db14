//! Samples over time: from a table (CSV: a header, then a row a sample), or from a log.

use super::SmoothError;
use crate::error::InputError;
use crate::io::table::{Table, text_of};
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
    /// What a sample is called: a line of a table, a sample of a log.
    place: &'static str,
    /// Its number there.
    numbers: Vec<usize>,
}

impl Samples {
    /// Of a message of a log; `name` is what messages call it, `numbers` say which of its samples they are, from 1.
    pub(super) fn of_log(
        name: String,
        t_s: Vec<f64>,
        channels: Vec<Vec<f64>>,
        weights: Vec<f64>,
        numbers: Vec<usize>,
    ) -> Self {
        Samples { t_s, channels, weights, name, place: "sample", numbers }
    }

    /// As [`Samples::of_table`], of a file.
    ///
    /// # Errors
    /// As [`Samples::of_table`]; the file cannot be read, a row is too short or too long.
    pub fn read(path: &Path, time: &str, columns: &[&str], weights: Option<&str>) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::of_table(&Table::parse(&text, name)?, time, columns, weights)
    }

    /// Reads `columns` over the column `time`, with the weights of a column where one is named. A field may be empty
    /// where its weight is 0.
    ///
    /// # Errors
    /// A column is missing or there twice, a field is not a finite number.
    pub fn of_table(
        table: &Table<'_>,
        time: &str,
        columns: &[&str],
        weights: Option<&str>,
    ) -> Result<Self, InputError> {
        let names: Vec<&str> = [time].iter().chain(columns).copied().chain(weights).collect();
        let places = table.found(&names, |name, wanted| name == wanted)?;
        let t_s = table.numbers(places[0])?;
        let weights = match weights {
            Some(_) => table.numbers(places[columns.len() + 1])?,
            None => vec![1.0; table.rows.len()],
        };
        let mut channels = Vec::new();
        for &index in &places[1..=columns.len()] {
            let value = |row: usize| {
                let missing = weights[row] == 0.0 && table.rows[row].1[index].is_empty();
                if missing { Ok(f64::NAN) } else { table.number(row, index) }
            };
            channels.push((0..table.rows.len()).map(value).collect::<Result<_, _>>()?);
        }
        let numbers = table.rows.iter().map(|(line, _)| *line).collect();
        Ok(Samples { t_s, channels, weights, name: table.name.clone(), place: "line", numbers })
    }

    /// An error about these samples: the file, the column where it is one's own, the line.
    #[must_use]
    pub fn error_at(&self, error: &SmoothError, column: Option<&str>) -> InputError {
        let column = column.map(|column| format!(", column {column}")).unwrap_or_default();
        let place_of = |sample: usize| {
            self.numbers.get(sample).map_or_else(String::new, |number| format!("{} {number}", self.place))
        };
        InputError::new(format!("{}{column}: {}", self.name, error.sentence(&place_of)))
    }
}

/// Instants at which a curve is wanted: the column `time`, or the only column whatever its name.
///
/// # Errors
/// As [`Samples::read`]; no instant at all.
pub fn read_instants(path: &Path, time: &str) -> Result<Vec<f64>, InputError> {
    let (text, name) = text_of(path)?;
    let table = Table::parse(&text, name)?;
    let column =
        if table.header.len() == 1 && table.header[0].parse::<f64>().is_err() { 0 } else { table.column(time)? };
    let instants = table.numbers(column)?;
    if instants.is_empty() {
        return Err(InputError::new(format!("{} holds no time", table.name)));
    }
    Ok(instants)
}
