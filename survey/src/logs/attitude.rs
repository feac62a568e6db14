//! The vehicle's attitude over time: out of a flight log by what its autopilot calls it, or out of a table by its columns.
//!
//! Roll right wing down, pitch nose up, yaw clockwise from north. Quaternions turn vectors of the body (forward, right, down) into
//! north, east, down, the real part first, as PX4 and MAVLink have them.

mod fields;
mod forward;
mod table;

use super::{File, Kind, Log, Series, Source, open};
use crate::error::InputError;
use fields::Fields;
use forward::Forward;
use std::path::Path;

/// An instant and the attitude at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Seconds of the log's clock.
    pub t_s: f64,
    /// Right wing down.
    pub roll_rad: f64,
    /// Nose up, within ±π/2 where it comes of a quaternion.
    pub pitch_rad: f64,
    /// Clockwise from north.
    pub yaw_rad: f64,
}

/// A recorded attitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Attitude {
    /// What messages call the file.
    pub name: String,
    /// Finite, strictly forward in time.
    pub samples: Vec<Sample>,
    /// What a user has to know: which message it is, what was left out.
    pub notes: Vec<String>,
}

/// A message that says the attitude, and the fields in which it does so in the versions there are of it.
type Said = (&'static str, &'static [Fields]);

const QUATERNION: Fields = Fields::Quaternion(["q[0]", "q[1]", "q[2]", "q[3]"]);
const RADIANS: Fields = Fields::Radians(["roll", "pitch", "yaw"]);
const DEGREES: Fields = Fields::Degrees(["Roll", "Pitch", "Yaw"]);

/// The messages of each format, the best ones first: what the autopilot flew by, then what a filter or a simulator says. Before PX4
/// 1.6, vehicle_attitude had angles too, or instead of a quaternion.
const ULOG: [Said; 3] = [
    ("vehicle_attitude", &[QUATERNION, RADIANS]),
    ("estimator_attitude", &[QUATERNION]),
    ("vehicle_attitude_groundtruth", &[QUATERNION, RADIANS]),
];
const DATAFLASH: [Said; 5] =
    [("ATT", &[DEGREES]), ("XKF1", &[DEGREES]), ("NKF1", &[DEGREES]), ("AHR2", &[DEGREES]), ("SIM", &[DEGREES])];
/// Both are of one estimate: that is taken which was sent more often.
const TELEMETRY: [Said; 2] =
    [("ATTITUDE", &[RADIANS]), ("ATTITUDE_QUATERNION", &[Fields::Quaternion(["q1", "q2", "q3", "q4"])])];

impl Attitude {
    /// Reads a table (CSV), a ULog, a DataFlash or a telemetry log.
    ///
    /// # Errors
    /// As [`Attitude::of_table`] and [`Attitude::of_log`], or when the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let name = path.display().to_string();
        match open(path)? {
            File::Text(text) => Self::of_table(&text, &name),
            File::Log(kind, bytes) => {
                let is_said = |message: &str| said(kind).iter().any(|(name, _)| *name == message);
                Self::of_log(&Log::read(&name, kind, &bytes, &is_said)?)
            }
        }
    }

    /// Of a table with a column of time (`t_s`, `t_ms`, `t_us`, or `timestamp` in microseconds) and the angles (`roll_deg`,
    /// `pitch_deg`, `yaw_deg`, or `_rad`) or a quaternion (`qw`, `qx`, `qy`, `qz`, or `q[0]` to `q[3]`).
    ///
    /// # Errors
    /// One sentence with the line and what is wrong there: a missing column, a value that is not a finite number, time that
    /// does not go forward; numbers that are of another unit than their column says.
    pub fn of_table(text: &str, name: &str) -> Result<Self, InputError> {
        table::read(text, name)
    }

    /// Of a log in which at least the messages that say the attitude were read.
    ///
    /// # Errors
    /// There is none of them; time that goes back by more than a second, as when the autopilot boots anew; no sample that is an
    /// attitude.
    pub fn of_log(log: &Log) -> Result<Self, InputError> {
        let candidates = said(log.kind);
        let Some((source, series, fields)) = best(log, candidates) else {
            let wanted: Vec<&str> = candidates.iter().map(|(name, _)| *name).collect();
            return Err(InputError::new(format!(
                "{}: the {} log has no attitude ({}), only {}",
                log.name,
                log.kind,
                wanted.join(", "),
                log.messages()
            )));
        };
        let rows = fields.rows(series).unwrap_or_default();
        let mut forward = Forward::default();
        for (&t_s, angles) in series.t_s.iter().zip(rows) {
            forward.take(t_s, angles).map_err(|why| InputError::new(format!("{}, {source}: {why}", log.name)))?;
        }
        let Forward { samples, .. } = &forward;
        let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
            return Err(InputError::new(format!(
                "{}: none of {} samples of {source} is an attitude",
                log.name, series.samples
            )));
        };
        let mut notes = log.notes.clone();
        notes.push(format!(
            "{}: {} log, {} attitudes of {source}, {:.3} s to {:.3} s{}",
            log.name,
            log.kind,
            samples.len(),
            first.t_s,
            last.t_s,
            forward.left_out()
        ));
        Ok(Attitude { name: log.name.clone(), samples: forward.samples, notes })
    }
}

fn said(kind: Kind) -> &'static [Said] {
    match kind {
        Kind::ULog => &ULOG,
        Kind::DataFlash => &DATAFLASH,
        Kind::Telemetry => &TELEMETRY,
    }
}

/// What of a log says the attitude best, and in which fields.
fn best<'a>(log: &'a Log, candidates: &'a [Said]) -> Option<(&'a Source, &'a Series, Fields)> {
    let of = |(name, versions): &'a Said| {
        let mut sources = log.sources(name);
        sources.find_map(|(source, series)| {
            let fields = versions.iter().find(|fields| fields.rows(series).is_some())?;
            Some((source, series, *fields))
        })
    };
    let mut found = candidates.iter().filter_map(of);
    match log.kind {
        Kind::Telemetry => found.max_by_key(|(_, series, _)| series.samples),
        Kind::ULog | Kind::DataFlash => found.next(),
    }
}
