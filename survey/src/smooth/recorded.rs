//! Samples of a message of a flight log.

use super::Samples;
use crate::error::InputError;
use crate::logs::{Log, Series, no_reboot};

/// Name of the time in seconds of the log's clock, beside the message's own columns.
pub const LOG_TIME: &str = "t_s";
/// Fields that say when a sample is of, and in which unit they count: no channels unless asked for.
const TIMES: [(&str, &str); 7] = [
    ("timestamp", "microseconds"),
    ("timestamp_sample", "microseconds"),
    ("TimeUS", "microseconds"),
    ("TimeMS", "milliseconds"),
    ("time_usec", "microseconds"),
    ("time_boot_ms", "milliseconds"),
    ("time_unix_usec", "microseconds"),
];

/// Which of a message's fields are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'a> {
    /// That of time; [`LOG_TIME`] unless given.
    pub time: Option<&'a str>,
    /// The channels; all that change unless given.
    pub columns: &'a [String],
    /// Of weights.
    pub weights: Option<&'a str>,
}

/// Samples of a log, with what was left to it to choose.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The samples.
    pub samples: Samples,
    /// Name of their time.
    pub time: String,
    /// Names of their channels.
    pub columns: Vec<String>,
    /// Those of them that are angles in degrees, where the log says so.
    pub degrees: Vec<String>,
    /// What a user has to know.
    pub notes: Vec<String>,
}

impl Recorded {
    /// The samples of a message of `log`, which was read with it, that are finite in all wanted fields and later than the one
    /// before.
    ///
    /// # Errors
    /// No such message or field, with those that there are; time that goes back by more than a second; no sample.
    pub fn read(log: &Log, message: &str, wanted: &Fields<'_>) -> Result<Self, InputError> {
        let (source, series) = log.series(message)?;
        let name = format!("{}, {source}", log.name);
        let time = wanted.time.unwrap_or(LOG_TIME);
        let columns = match wanted.columns {
            [] => changing(series),
            columns => columns.to_vec(),
        };
        let column = |wanted: &str| match series.column(wanted) {
            Some(values) => Ok(values),
            None if wanted == LOG_TIME => Ok(series.t_s.clone()),
            None => Err(InputError::new(format!("{name} has no number {wanted}, only {}", series.columns.join(", ")))),
        };
        let t = column(time)?;
        let mut channels = columns.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?;
        let weights = wanted.weights.map_or_else(|| Ok(vec![1.0; t.len()]), column)?;
        let is_finite = |row: usize| [&t, &weights].into_iter().chain(&channels).all(|values| values[row].is_finite());
        let finite: Vec<usize> = (0..t.len()).filter(|row| is_finite(*row)).collect();
        let kept = forward(&name, &finite, &t, &series.t_s)?;
        if kept.is_empty() {
            return Err(InputError::new(format!(
                "{name}: no sample has a finite number in each of {}",
                columns.join(", ")
            )));
        }
        let notes = notes(log, &name, time, [t.len() - finite.len(), finite.len() - kept.len()]);
        let of_kept = |values: &Vec<f64>| kept.iter().map(|row| values[*row]).collect::<Vec<f64>>();
        channels.iter_mut().for_each(|channel| *channel = of_kept(channel));
        let numbers = kept.iter().map(|row| row + 1).collect();
        let samples = Samples::of_log(name, of_kept(&t), channels, of_kept(&weights), numbers);
        let degrees = columns.iter().filter(|column| series.degrees.contains(column)).cloned().collect();
        Ok(Recorded { samples, time: time.to_owned(), columns, degrees, notes })
    }
}

/// The columns that are not constant, nor a time.
fn changing(series: &Series) -> Vec<String> {
    let is_time = |name: &str| TIMES.iter().any(|(time, _)| *time == name);
    let changes =
        |name: &str| series.column(name).is_some_and(|values| values.windows(2).any(|pair| pair[0] != pair[1]));
    series.columns.iter().filter(|name| !is_time(name) && changes(name)).cloned().collect()
}

/// Those of the rows that are later than the one before.
fn forward(name: &str, rows: &[usize], t: &[f64], t_s: &[f64]) -> Result<Vec<usize>, InputError> {
    let mut kept: Vec<usize> = Vec::with_capacity(rows.len());
    for &row in rows {
        if let Some(&before) = kept.last() {
            let refused = |why| InputError::new(format!("{name}, sample {}: {why}", row + 1));
            no_reboot(t_s[before], t_s[row]).map_err(refused)?;
            if t[row] <= t[before] {
                continue;
            }
        }
        kept.push(row);
    }
    Ok(kept)
}

fn notes(log: &Log, name: &str, time: &str, [missing, late]: [usize; 2]) -> Vec<String> {
    let mut notes = log.notes.clone();
    if missing > 0 {
        notes.push(format!("{name}: {missing} samples that are not finite were left out"));
    }
    if late > 0 {
        notes.push(format!("{name}: {late} samples that are not later than the one before were left out"));
    }
    if let Some((_, unit)) = TIMES.iter().find(|(known, _)| *known == time) {
        notes.push(format!("{name}: {time} counts {unit}, and rates are by this unit; without --time it is seconds"));
    }
    notes
}
