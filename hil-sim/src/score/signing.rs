//! What was refused for its signature.

use plumbline_firmware::wire::telemetry::SigningReport;
use serde::Serialize;

/// Messages that were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Signing {
    /// By the firmware: not signed.
    pub unsigned: u32,
    /// By the firmware: signed with another key, or changed on their way.
    pub wrong: u32,
    /// By the firmware: not newer than the last of their stream.
    pub replayed: u32,
    /// By the firmware: the first of their stream, and more than a minute behind its time.
    pub late: u32,
    /// By the firmware: of a stream that it had no room for.
    pub crowded: u32,
    /// By the autopilot, for any of these reasons; null in a live flight, where it is not known.
    pub by_autopilot: Option<u64>,
}

impl From<(SigningReport, Option<u64>)> for Signing {
    fn from((report, by_autopilot): (SigningReport, Option<u64>)) -> Self {
        let SigningReport { unsigned, wrong, replayed, late, crowded } = report;
        Signing { unsigned, wrong, replayed, late, crowded, by_autopilot }
    }
}
