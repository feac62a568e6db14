//! Flight logs as autopilots and ground stations keep them: PX4's ULog, ArduPilot's DataFlash, MAVLink telemetry.
//!
//! `kind`: which of them a file is, by its content. `ulog`, `dataflash`, `telemetry`: each format's records. What is
//! damaged is passed over and counted, so that one bad sector does not cost a flight. `series`: the samples of one message,
//! in the log's own units. [`attitude`]: the vehicle's attitude over time, of a log or of a table. [`units`]: what numbers look like
//! whatever their columns say.

pub mod attitude;
mod damage;
mod dataflash;
mod kind;
mod series;
mod telemetry;
mod ulog;
pub mod units;

pub use kind::Kind;
pub use series::{Instance, Series, Source};

use crate::error::InputError;
use crate::io::input;
use series::Gather;
use std::collections::BTreeMap;
use std::path::Path;

/// First byte of the mark with which some programs begin a text in UTF-8.
const BOM: u8 = 0xef;
/// Farther back than this, in seconds, the clock was set anew. Nearer, messages overtook each other or came twice.
const BACK_S: f64 = 1.0;

/// What lies in a file that may be a log or a text.
#[derive(Debug)]
pub enum File {
    /// UTF-8.
    Text(String),
    /// A log, and its bytes.
    Log(Kind, Vec<u8>),
}

/// Refuses an instant that is long before the one of the sample before it, both in seconds of the log's clock.
///
/// # Errors
/// Time has gone back; what to do.
pub(crate) fn no_reboot(before_s: f64, t_s: f64) -> Result<(), String> {
    if t_s < before_s - BACK_S {
        return Err(format!(
            "time goes back from {before_s:.3} s to {t_s:.3} s, as when the autopilot boots anew: cut the log in two there"
        ));
    }
    Ok(())
}

/// Opens a file of samples, whatever it is called.
///
/// # Errors
/// As of any file; neither text nor a log.
pub fn open(path: &Path) -> Result<File, InputError> {
    let bytes = input::bytes(path)?;
    if let Some(kind) = Kind::of(&bytes) {
        return Ok(File::Log(kind, bytes));
    }
    input::in_utf16(path, &bytes).map_or(Ok(()), Err)?;
    let name = path.display();
    if bytes.contains(&0) || bytes.first().is_some_and(|first| !first.is_ascii() && *first != BOM) {
        return Err(InputError::new(format!(
            "cannot read {name}: it begins neither as a table (CSV) nor as a flight log: ULog (.ulg), DataFlash (.bin) or \
             MAVLink telemetry (.tlog)"
        )));
    }
    match String::from_utf8(bytes) {
        Ok(text) if text.starts_with("FMT,") => Err(InputError::new(format!(
            "{name} is a DataFlash log turned into text, and what is read is the binary one (.bin)"
        ))),
        Ok(text) => Ok(File::Text(text)),
        Err(error) => Err(InputError::because(format!("cannot read {name}"), error.utf8_error())),
    }
}

/// A log, read as far as it goes.
#[derive(Debug)]
pub struct Log {
    /// What messages call the file.
    pub name: String,
    /// Its format.
    pub kind: Kind,
    /// What a user has to know: what was passed over.
    pub notes: Vec<String>,
    found: BTreeMap<Source, Series>,
}

impl Log {
    /// Reads the samples of the messages that are `wanted`, and counts the others.
    ///
    /// # Errors
    /// A log without a single message, or whose definitions cannot be read.
    pub fn read(name: &str, kind: Kind, bytes: &[u8], wanted: &dyn Fn(&str) -> bool) -> Result<Self, InputError> {
        let mut gather = Gather::new(wanted);
        let read = match kind {
            Kind::ULog => ulog::read(bytes, &mut gather),
            Kind::DataFlash => Ok(dataflash::read(bytes, &mut gather)),
            Kind::Telemetry => Ok(telemetry::read(bytes, &mut gather)),
        };
        let damage = read.map_err(|why| InputError::new(format!("{name}: {why}")))?;
        let found = gather.found;
        if found.is_empty() {
            return Err(InputError::new(format!("{name}: the {kind} log holds no message, perhaps it was cut short")));
        }
        let notes = damage.sentence().map(|sentence| format!("{name}: {sentence}")).into_iter().collect();
        Ok(Log { name: name.to_owned(), kind, notes, found })
    }

    /// The samples of a message: `NAME`, whose first instance is taken, or `NAME:INSTANCE`.
    ///
    /// # Errors
    /// There is none, with those that there are.
    pub fn series(&self, asked: &str) -> Result<(&Source, &Series), InputError> {
        let is_asked = |source: &Source| source.message == asked || source.to_string() == asked;
        self.found
            .iter()
            .find(|(source, _)| is_asked(source))
            .ok_or_else(|| InputError::new(format!("{} has no message {asked}, only {}", self.name, self.messages())))
    }

    /// The sources of a message.
    pub fn sources<'a>(&'a self, message: &'a str) -> impl Iterator<Item = (&'a Source, &'a Series)> {
        self.found.iter().filter(move |(source, _)| source.message == message)
    }

    /// Names of the messages with any numbers in them, one list for people.
    #[must_use]
    pub fn messages(&self) -> String {
        let mut names: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for source in self.found.keys() {
            names.entry(&source.message).or_default().push(source.instance.to_string());
        }
        let names = names.iter().map(|(name, instances)| match instances.as_slice() {
            [_] => (*name).to_owned(),
            several => format!("{name} (:{})", several.join(", :")),
        });
        names.collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests;
