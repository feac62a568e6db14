//! The autopilot at the other end of the link: what it is asked for, and how it takes a fix.
//!
//! Nothing here waits, sends or reads a clock: the application tells what arrived and asks, on each beat, what is to be sent.
//! [`exchange`] knows the time requests that are not answered yet, [`requests`] has the streams that the application lives on
//! sent at the rates that it wants, [`wanted`] has the parameters that it must be set to and [`parameters`] asks for them,
//! [`fixes`] makes of a match the fix that is sent, [`watch`] sees whether there are any, [`sources`] has the autopilot use them,
//! [`start`] stands in for its position, [`readiness`] says what is missing.

pub mod exchange;
pub mod fixes;
pub mod parameters;
pub mod readiness;
pub mod requests;
pub mod sources;
pub mod start;
pub mod wanted;
pub mod watch;

use crate::wire::incoming::{AutopilotKind, Heartbeat};
use plumbline_core::units::Ticks;

/// An autopilot whose heartbeat is older than this is not there: three of them lost, ticks.
const SILENT_TICKS: u32 = 3_500_000;

/// What its heartbeat says, and when it was heard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Presence {
    newest: Option<(Ticks, Heartbeat)>,
}

impl Presence {
    /// A heartbeat at `now`.
    pub fn heard(&mut self, heartbeat: Heartbeat, now: Ticks) {
        self.newest = Some((now, heartbeat));
    }

    /// To be called ten times a second: an autopilot that has been silent for too long is forgotten.
    pub fn keep(&mut self, now: Ticks) {
        self.newest = self.newest.filter(|(at, _)| now.0.wrapping_sub(at.0) <= SILENT_TICKS);
    }

    /// Whether it is there.
    pub fn is_there(&self) -> bool {
        self.newest.is_some()
    }

    /// Whose software it is, as far as it is there.
    pub fn kind(&self) -> AutopilotKind {
        self.newest.map_or(AutopilotKind::Other, |(_, heartbeat)| heartbeat.kind)
    }
}
