//! The samples of one message, as a table of numbers.

use std::collections::BTreeMap;
use std::fmt;

/// Which of several that say a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Instance {
    /// There cannot be several.
    Only,
    /// Of a ULog topic; of a DataFlash message the value of its field whose unit is "#".
    Number(i64),
    /// The telemetry's sender: its system and component.
    Component(u32, u8),
}

impl fmt::Display for Instance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Instance::Only => Ok(()),
            Instance::Number(number) => write!(f, "{number}"),
            Instance::Component(system, component) => write!(f, "{system}.{component}"),
        }
    }
}

/// A message and who says it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    /// The message's name.
    pub message: String,
    /// Who says it.
    pub instance: Instance,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.instance {
            Instance::Only => f.write_str(&self.message),
            instance => write!(f, "{}:{instance}", self.message),
        }
    }
}

/// What one source said, in the order of the log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Names of the fields that are numbers, those of arrays one by one.
    pub columns: Vec<String>,
    /// Seconds of the log's clock.
    pub t_s: Vec<f64>,
    /// Samples, counted even where they were not wanted.
    pub samples: usize,
    /// Those of them that are angles in degrees, where the log says so.
    pub degrees: Vec<String>,
    /// Row by row, in the log's own units.
    values: Vec<f64>,
}

impl Series {
    /// Values of a column; `None` where there is none of that name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let column = self.columns.iter().position(|known| known == name)?;
        Some(self.values.iter().skip(column).step_by(self.columns.len()).copied().collect())
    }
}

/// What a reader hands its records to.
pub(super) struct Gather<'a> {
    wanted: &'a dyn Fn(&str) -> bool,
    pub found: BTreeMap<Source, Series>,
}

impl<'a> Gather<'a> {
    pub fn new(wanted: &'a dyn Fn(&str) -> bool) -> Self {
        Gather { wanted, found: BTreeMap::new() }
    }

    /// Whether the samples of a message are wanted.
    pub fn wants(&self, message: &str) -> bool {
        (self.wanted)(message)
    }

    /// Counts a sample that is not wanted.
    pub fn count(&mut self, source: Source) {
        self.found.entry(source).or_default().samples += 1;
    }

    /// The log says that these columns of a message that is wanted are angles in degrees.
    pub fn degrees(&mut self, source: &Source, columns: &[String]) {
        if self.wants(&source.message) {
            let series = self.found.entry(source.clone()).or_default();
            if series.degrees != columns {
                series.degrees = columns.to_vec();
            }
        }
    }

    /// Takes a sample where its message is wanted, and else counts it. `row` says its time, and its numbers in the order of
    /// `columns`; a sample with other columns than those before is left out.
    pub fn add(&mut self, source: Source, columns: &[String], row: impl FnOnce() -> (f64, Vec<f64>)) {
        let is_wanted = self.wants(&source.message);
        let series = self.found.entry(source).or_default();
        series.samples += 1;
        if !is_wanted {
            return;
        }
        if series.columns.is_empty() {
            series.columns = columns.to_vec();
        }
        if series.columns == columns {
            let (t_s, values) = row();
            series.t_s.push(t_s);
            series.values.extend(values);
        }
    }
}
