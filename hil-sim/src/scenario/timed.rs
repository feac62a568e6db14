//! Faults that begin and end: what fails, how, how far and when.
//!
//! In a scenario each is a `[[fault]]`; `UNIT.TYPE=VALUE@FROM..TO` says it in a word, in seconds of the simulated time.

mod kinds;
#[cfg(test)]
mod tests;

pub use kinds::{KINDS, Kind, Value, What};

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Latest second that may be named.
const SECONDS_MAX: f64 = 1e9;

/// One fault and when it is there: from its first second to before its last one.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "Table", into = "Table")]
pub struct Fault {
    /// What fails, and how.
    pub what: What,
    /// How far, in the unit of its kind; 0 of one without a value.
    pub value: f64,
    /// Its begin, seconds of the simulated time: the sensors begin at 0, the frames at 3.
    pub from_s: f64,
    /// Its end; that of the flight without one.
    pub to_s: Option<f64>,
}

/// `[[fault]]`.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Table {
    unit: String,
    #[serde(rename = "type")]
    kind: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    #[serde(default)]
    from_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to_s: Option<f64>,
}

impl TryFrom<Table> for Fault {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        let kind = Kind::named(&table.unit, &table.kind)?;
        let (from_s, to_s) = (table.from_s, table.to_s);
        let fault = Fault { what: kind.what, value: kind.checked(table.value)?, from_s, to_s };
        for second in [Some(from_s), to_s].into_iter().flatten() {
            if !(0.0..=SECONDS_MAX).contains(&second) {
                return Err(format!("the fault {fault} names a second that is not between 0 and {SECONDS_MAX}"));
            }
        }
        match to_s {
            Some(to_s) if to_s <= from_s => Err(format!("the fault {fault} does not end after its begin")),
            _ => Ok(fault),
        }
    }
}

impl From<Fault> for Table {
    fn from(fault: Fault) -> Self {
        let kind = fault.what.kind();
        Table {
            unit: kind.map_or("", |kind| kind.unit).to_owned(),
            kind: kind.map_or("", |kind| kind.name).to_owned(),
            value: kind.and_then(|kind| kind.value).map(|_| fault.value),
            from_s: fault.from_s,
            to_s: fault.to_s,
        }
    }
}

impl FromStr for Fault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |what: &str, text: &str| {
            let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| format!("{what} {text:?} is no number; a fault is UNIT.TYPE[=VALUE][@FROM..[TO]]"))
        };
        let (what, interval) = text.split_once('@').map_or((text, None), |(what, at)| (what, Some(at)));
        let (name, value) = what.split_once('=').map_or((what, None), |(name, value)| (name, Some(value)));
        let Some((unit, kind)) = name.trim().split_once('.') else {
            return Err("there is no point between unit and type; a fault is UNIT.TYPE[=VALUE][@FROM..[TO]]".into());
        };
        let (mut from_s, mut to_s) = (0.0, None);
        if let Some(interval) = interval {
            let Some((from, to)) = interval.split_once("..") else {
                return Err(format!("@{interval} lacks the .. between two seconds; it is @FROM..TO or @FROM.."));
            };
            from_s = number("the second", from)?;
            to_s = if to.trim().is_empty() { None } else { Some(number("the second", to)?) };
        }
        let value = value.map(|value| number("the value", value)).transpose()?;
        Table { unit: unit.into(), kind: kind.into(), value, from_s, to_s }.try_into()
    }
}

impl fmt::Display for Fault {
    /// In a word, as [`Fault::from_str`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(kind) = self.what.kind() else { return Ok(()) };
        write!(f, "{}.{}", kind.unit, kind.name)?;
        if kind.value.is_some() {
            write!(f, "={}", self.value)?;
        }
        write!(f, "@{}..", self.from_s)?;
        self.to_s.map_or(Ok(()), |to_s| write!(f, "{to_s}"))
    }
}

impl Fault {
    /// Its first microsecond.
    #[must_use]
    pub fn from_us(&self) -> u64 {
        (1e6 * self.from_s).round() as u64
    }

    /// The microsecond after its last one.
    #[must_use]
    pub fn to_us(&self) -> u64 {
        self.to_s.map_or(u64::MAX, |to_s| (1e6 * to_s).round() as u64)
    }

    /// Whether it is there at an instant.
    #[must_use]
    pub fn is_at(&self, at_us: u64) -> bool {
        (self.from_us()..self.to_us()).contains(&at_us)
    }
}

/// All faults of a flight.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(transparent)]
pub struct FaultList(Vec<Fault>);

impl FaultList {
    /// Every one, in the order in which they were given.
    #[must_use]
    pub fn all(&self) -> &[Fault] {
        &self.0
    }

    /// One more.
    pub fn push(&mut self, fault: Fault) {
        self.0.push(fault);
    }

    /// Those of a kind, at any time.
    pub fn of(&self, what: What) -> impl Iterator<Item = &Fault> {
        self.0.iter().filter(move |fault| fault.what == what)
    }

    /// Those of a kind that are there at an instant.
    pub fn at(&self, what: What, at_us: u64) -> impl Iterator<Item = &Fault> {
        self.of(what).filter(move |fault| fault.is_at(at_us))
    }

    /// Whether there is one of a kind at an instant.
    #[must_use]
    pub fn is(&self, what: What, at_us: u64) -> bool {
        self.at(what, at_us).next().is_some()
    }

    /// The values of a kind at an instant, added.
    #[must_use]
    pub fn sum(&self, what: What, at_us: u64) -> f64 {
        self.at(what, at_us).map(|fault| fault.value).sum()
    }

    /// The values of a kind at an instant, multiplied.
    #[must_use]
    pub fn product(&self, what: What, at_us: u64) -> f64 {
        self.at(what, at_us).map(|fault| fault.value).product()
    }
}

impl FromIterator<Fault> for FaultList {
    fn from_iter<I: IntoIterator<Item = Fault>>(faults: I) -> Self {
        FaultList(faults.into_iter().collect())
    }
}
