//! `plumbline smooth`: columns of a log, fitted one by one, as a table, a summary and a picture.

mod picture;

use plumbline_survey::error::InputError;
use plumbline_survey::io::table::Table;
use plumbline_survey::logs::units::{Angles, Times, Unit};
use plumbline_survey::logs::{self, File, Log};
use plumbline_survey::smooth::{
    Epochs, Estimate, Fields, Fit, Options, Recorded, Samples, SmoothError, read_instants, smooth, turn_of,
    turned_over, unwrap_turns,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// What to fit, and how.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The log, CSV or of a flight.
    pub file: &'a Path,
    /// The message of a flight log.
    pub message: Option<&'a str>,
    /// Its column of time; of a flight log its clock unless given.
    pub time: Option<&'a str>,
    /// Its columns that are fitted; of a flight log all that change unless given.
    pub columns: &'a [String],
    /// Those of them that are angles, to be unwrapped: in degrees, or in radians where they are counted over as these are.
    pub angles: &'a [String],
    /// Its column of weights.
    pub weights: Option<&'a str>,
    /// A file of instants at which the curves are wanted; at the log's own unless given.
    pub at: Option<&'a Path>,
    /// Order, smoothing factor, limits.
    pub options: Options,
}

/// The fitted columns.
#[derive(Debug)]
pub struct Smoothed {
    time: String,
    columns: Vec<String>,
    samples: Samples,
    notes: Vec<String>,
    fits: Vec<Fit>,
    /// Where the curves are wanted, if not at the samples.
    instants: Option<Vec<f64>>,
}

/// What the fit of a column says about itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Smoothing factor, without unit.
    pub alpha: f64,
    /// Effective number of parameters, tr H.
    pub edf: f64,
    /// Standard deviation of a sample with weight 1, in the column's unit; null where the samples do not tell their noise.
    pub sigma0: Option<f64>,
    /// n V'PV / (n - tr H)².
    pub gcv: f64,
    /// Whether GCV found its minimum at an end of its range.
    pub alpha_at_bound: bool,
    /// Mean of the curve.
    pub constant: f64,
    /// Straight line through the curve: value at time 0, change in a second.
    pub line: [f64; 2],
    /// Times of the samples that the outlier gate left out.
    pub rejected_s: Vec<f64>,
    /// Begin and end of gaps longer than usual that were bridged since they were allowed.
    pub gaps_s: Vec<[f64; 2]>,
}

impl Smoothed {
    /// Reads the log and fits.
    ///
    /// # Errors
    /// Columns that are named twice or are not there, a log that cannot be read, samples that cannot be fitted, instants
    /// outside the log.
    pub fn of(wanted: &Wanted<'_>) -> Result<Self, InputError> {
        let Recorded { mut samples, time, columns, degrees, notes } = read(wanted)?;
        let order = wanted.options.order;
        if samples.t_s.len() <= order.differences() {
            return Err(samples.error_at(&SmoothError::TooFew { samples: samples.t_s.len(), order }, None));
        }
        let epochs = Epochs::new(samples.t_s.clone()).map_err(|error| samples.error_at(&error, None))?;
        let mut fits = Vec::new();
        for (index, column) in columns.iter().enumerate() {
            let over = turned_over(&samples.channels[index]);
            let is_degrees = degrees.contains(column);
            if wanted.angles.contains(column) || (is_degrees && over.is_some()) {
                let turn = if is_degrees { 360.0 } else { turn_of(&samples.channels[index]) };
                let unwrapped = unwrap_turns(&mut samples.channels[index], turn);
                unwrapped.map_err(|error| samples.error_at(&error, Some(column)))?;
            } else if let Some(error) = over {
                return Err(samples.error_at(&error, Some(column)));
            }
            let fit = smooth(&epochs, &samples.channels[index], &samples.weights, &wanted.options);
            fits.push(fit.map_err(|error| samples.error_at(&error, Some(column)))?);
        }
        let instants = wanted.at.map(|path| instants(path, &time, &fits)).transpose()?;
        Ok(Smoothed { time, columns, samples, notes, fits, instants })
    }

    /// Time, then value, rate and sigma of each column; a row an instant.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = self.time.clone();
        // Writing to a string cannot fail.
        for column in &self.columns {
            let _ = write!(text, ",{column},{column}_rate,{column}_sigma");
        }
        text.push('\n');
        let tells: Vec<bool> = self.fits.iter().map(Fit::tells_noise).collect();
        let mut row = |t_s: f64, estimates: &mut dyn Iterator<Item = Estimate>| {
            let _ = write!(text, "{t_s}");
            for (Estimate { value, rate, sigma }, tells) in estimates.zip(&tells) {
                let _ = write!(text, ",{value},{rate},");
                let _ = if *tells { write!(text, "{sigma}") } else { Ok(()) };
            }
            text.push('\n');
        };
        match &self.instants {
            None => {
                for (i, t_s) in self.samples.t_s.iter().enumerate() {
                    row(*t_s, &mut self.fits.iter().map(|fit| fit.at_sample(i)));
                }
            }
            // All were found to lie within the log when they were read.
            Some(instants) => {
                for t_s in instants {
                    row(*t_s, &mut self.fits.iter().filter_map(|fit| fit.at(*t_s).ok()));
                }
            }
        }
        text
    }

    /// The summary of each column by its name.
    #[must_use]
    pub fn summaries(&self) -> BTreeMap<&str, Summary> {
        let summary = |fit: &Fit| {
            let trend = fit.trend();
            Summary {
                alpha: fit.alpha,
                edf: fit.edf,
                sigma0: fit.tells_noise().then_some(fit.sigma0),
                gcv: fit.gcv,
                alpha_at_bound: fit.alpha_at_bound,
                constant: trend.constant,
                line: [trend.line.at_zero, trend.line.slope],
                rejected_s: fit.rejected.iter().map(|&i| self.samples.t_s[i]).collect(),
                gaps_s: fit.gaps.iter().map(|gap| [gap.from_s, gap.to_s]).collect(),
            }
        };
        self.columns.iter().map(String::as_str).zip(self.fits.iter().map(summary)).collect()
    }

    /// A line on each column for a person.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let line = |(column, fit): (&String, &Fit)| {
            let bound = if fit.alpha_at_bound { ", at the end of the range" } else { "" };
            let rejected = match fit.rejected.len() {
                0 => String::new(),
                count => format!(", {count} samples left out"),
            };
            let sigma0 = if fit.tells_noise() { format!("sigma0 {:.6}", fit.sigma0) } else { "no sigma".to_owned() };
            format!(
                "{column}: alpha {:.4e}{bound}, {:.2} parameters for {} samples, {sigma0}{rejected}",
                fit.alpha,
                fit.edf,
                self.samples.t_s.len()
            )
        };
        self.columns.iter().zip(&self.fits).map(line).collect()
    }

    /// What a reader has to know whatever else is printed: what of a log was left out, gaps that were bridged, columns whose noise is not known.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let silent = self.columns.iter().zip(&self.fits).filter(|(_, fit)| !fit.tells_noise());
        let silent = silent.map(|(column, fit)| {
            format!(
                "column {column}: GCV ends at its least alpha, {:.1e}: the samples do not tell their noise, and {column}_sigma is left \
                 empty; where the noise is known, give the --alpha at which sigma0 is that",
                fit.alpha
            )
        });
        silent.chain(self.bridged()).collect()
    }

    /// What of a log was left out, and gaps that were bridged.
    fn bridged(&self) -> Vec<String> {
        let Some(fit) = self.fits.first() else { return self.notes.clone() };
        let sentence = |gap: &plumbline_survey::smooth::Gap| {
            format!("gap of {:.3} s bridged, {} s to {} s", gap.length_s(), gap.from_s, gap.to_s)
        };
        self.notes.iter().cloned().chain(fit.gaps.iter().map(sentence)).collect()
    }
}

/// The samples of a table or of a flight log.
fn read(wanted: &Wanted<'_>) -> Result<Recorded, InputError> {
    let name = wanted.file.display().to_string();
    let text = match (logs::open(wanted.file)?, wanted.message) {
        (File::Text(text), None) => text,
        (File::Text(_), Some(_)) => {
            return Err(InputError::new(format!("{name} is a table (CSV), and --message is for flight logs")));
        }
        (File::Log(kind, bytes), Some(message)) => {
            let is_asked =
                |name: &str| message.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(':'));
            let log = Log::read(&name, kind, &bytes, &is_asked)?;
            let fields = Fields { time: wanted.time, columns: wanted.columns, weights: wanted.weights };
            let recorded = Recorded::read(&log, message, &fields)?;
            check_names(&recorded.time, &recorded.columns, wanted.angles)?;
            return Ok(recorded);
        }
        (File::Log(kind, bytes), None) => {
            let messages = Log::read(&name, kind, &bytes, &|_| false)?.messages();
            return Err(InputError::new(format!("{name} is a {kind} log: --message says which of {messages}")));
        }
    };
    let Some(time) = wanted.time.filter(|_| !wanted.columns.is_empty()) else {
        let header = Table::parse(&text, name.clone())?.header.join(",");
        return Err(InputError::new(format!("{name} is a table (CSV): --time and --columns say which of {header}")));
    };
    check_names(time, wanted.columns, wanted.angles)?;
    let columns: Vec<&str> = wanted.columns.iter().map(String::as_str).collect();
    let table = Table::parse(&text, name)?;
    let samples = Samples::of_table(&table, time, &columns, wanted.weights)?;
    let notes = doubts(&samples, &table, time, wanted)?;
    Ok(Recorded { samples, time: time.to_owned(), columns: wanted.columns.to_vec(), degrees: Vec::new(), notes })
}

/// What an attitude's times and angles look like that its columns do not say.
///
/// # Errors
/// Hundredths of a degree among those to which whole turns are to be added.
fn doubts(samples: &Samples, table: &Table<'_>, time: &str, wanted: &Wanted<'_>) -> Result<Vec<String>, InputError> {
    let name = &table.name;
    let is_place = |name: &str| name.starts_with("lat") || name.starts_with("lon");
    let in_degrees = |name: &String| name.ends_with("_deg") && !is_place(name);
    let is_plain = |name: &str| ["roll", "pitch", "yaw", "heading"].contains(&name.to_lowercase().as_str());
    let is_angle = |name: &String| in_degrees(name) || is_plain(name) || wanted.angles.contains(name);
    let angles: Vec<usize> = (0..wanted.columns.len()).filter(|at| is_angle(&wanted.columns[*at])).collect();
    let named: Vec<_> = angles.iter().map(|at| (&wanted.columns[*at][..], &samples.channels[*at][..])).collect();
    let places: Vec<usize> = named.iter().map(|(name, _)| table.column(name)).collect::<Result<_, _>>()?;
    let is_attitude = wanted.columns.iter().filter(|name| in_degrees(name)).count() > 1;
    let mut notes = Vec::new();
    if let Some(found) = Times::of(&samples.t_s, 1.0).filter(|_| is_attitude && time.ends_with("_s")) {
        notes.push(format!(
            "{name}: {time} goes in steps of {}, which look like {}: if so, since rates are by its unit, {}",
            found.step,
            found.unit,
            found.in_seconds(name, table.column(time)?)
        ));
    }
    // Those that are not called degrees may be radians.
    let may_be_radians = is_attitude && angles.iter().all(|index| in_degrees(&wanted.columns[*index]));
    if let Some(found) = Angles::of(&named).filter(|found| found.unit == Unit::Hundredths || may_be_radians) {
        let says = found.says(name, &places);
        if found.unit == Unit::Hundredths && !wanted.angles.is_empty() {
            return Err(InputError::new(says));
        }
        notes.push(says);
    }
    Ok(notes)
}

/// Names that make sense together.
fn check_names(time: &str, columns: &[String], angles: &[String]) -> Result<(), InputError> {
    let refuse = |what: String| Err(InputError::new(what));
    let suffixes = ["", "_rate", "_sigma"];
    let mut out = vec![time.to_owned()];
    for name in columns.iter().flat_map(|column| suffixes.map(|suffix| format!("{column}{suffix}"))) {
        if out.contains(&name) {
            return refuse(format!("--columns: two columns of the result would be called {name}"));
        }
        out.push(name);
    }
    match angles.iter().find(|angle| !columns.contains(angle)) {
        Some(angle) => refuse(format!("--angles: {angle} is not among --columns")),
        None => Ok(()),
    }
}

/// Instants from a file, all within the log.
fn instants(path: &Path, time: &str, fits: &[Fit]) -> Result<Vec<f64>, InputError> {
    let instants = read_instants(path, time)?;
    for t_s in &instants {
        for fit in fits {
            fit.value(*t_s).map_err(|error| InputError::new(format!("{}: {error}", path.display())))?;
        }
    }
    Ok(instants)
}
