//! Which log a file is: by its first bytes, whatever its name.

use super::{dataflash, telemetry, ulog};
use std::fmt;

/// A log's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// PX4's, `.ulg`.
    ULog,
    /// ArduPilot's, `.bin`.
    DataFlash,
    /// MAVLink messages as a ground station received them, `.tlog`.
    Telemetry,
}

impl Kind {
    /// The format of a file that begins, and goes on, as its logs do.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let kinds = [
            (Kind::ULog, ulog::is_log as fn(&[u8]) -> bool),
            (Kind::DataFlash, dataflash::is_log),
            (Kind::Telemetry, telemetry::is_log),
        ];
        kinds.into_iter().find(|(_, is_log)| is_log(bytes)).map(|(kind, _)| kind)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::ULog => "ULog",
            Kind::DataFlash => "DataFlash",
            Kind::Telemetry => "telemetry",
        })
    }
}
