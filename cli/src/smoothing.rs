//! `plumbline smooth`: columns of a log, fitted one by one, as a table, a summary and a picture.

mod picture;

use plumbline_survey::error::InputError;
use plumbline_survey::smooth::{
    Epochs, Estimate, Fit, Options, Samples, SmoothError, read_instants, smooth, turned_over, unwrap_degrees,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// What to fit, and how.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The log, CSV.
    pub file: &'a Path,
    /// Its column of time.
    pub time: &'a str,
    /// Its columns that are fitted.
    pub columns: &'a [String],
    /// Those of them that are angles in degrees, to be unwrapped.
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
        check_names(wanted)?;
        let columns: Vec<&str> = wanted.columns.iter().map(String::as_str).collect();
        let mut samples = Samples::read(wanted.file, wanted.time, &columns, wanted.weights)?;
        let order = wanted.options.order;
        if samples.t_s.len() <= order.differences() {
            return Err(samples.error_at(&SmoothError::TooFew { samples: samples.t_s.len(), order }, None));
        }
        let epochs = Epochs::new(samples.t_s.clone()).map_err(|error| samples.error_at(&error, None))?;
        let mut fits = Vec::new();
        for (index, column) in wanted.columns.iter().enumerate() {
            if wanted.angles.contains(column) {
                unwrap_degrees(&mut samples.channels[index]).map_err(|error| samples.error_at(&error, Some(column)))?;
            } else if let Some(error) = turned_over(&samples.channels[index]) {
                return Err(samples.error_at(&error, Some(column)));
            }
            let fit = smooth(&epochs, &samples.channels[index], &samples.weights, &wanted.options);
            fits.push(fit.map_err(|error| samples.error_at(&error, Some(column)))?);
        }
        let instants = wanted.at.map(|path| instants(path, wanted.time, &fits)).transpose()?;
        Ok(Smoothed { time: wanted.time.to_owned(), columns: wanted.columns.to_vec(), samples, fits, instants })
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

    /// What a reader has to know whatever else is printed: gaps that were bridged, columns whose noise is not known.
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

    /// Gaps that were bridged.
    fn bridged(&self) -> Vec<String> {
        let Some(fit) = self.fits.first() else { return Vec::new() };
        let sentence = |gap: &plumbline_survey::smooth::Gap| {
            format!("gap of {:.3} s bridged, {} s to {} s", gap.length_s(), gap.from_s, gap.to_s)
        };
        fit.gaps.iter().map(sentence).collect()
    }
}

/// Names that make sense together.
fn check_names(wanted: &Wanted<'_>) -> Result<(), InputError> {
    let refuse = |what: String| Err(InputError::new(what));
    let suffixes = ["", "_rate", "_sigma"];
    let mut out = vec![wanted.time.to_owned()];
    for name in wanted.columns.iter().flat_map(|column| suffixes.map(|suffix| format!("{column}{suffix}"))) {
        if out.contains(&name) {
            return refuse(format!("--columns: two columns of the result would be called {name}"));
        }
        out.push(name);
    }
    match wanted.angles.iter().find(|angle| !wanted.columns.contains(angle)) {
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
