//! Live flights: the firmware in the loop with a real autopilot, which flies in its own simulator at its own speed.
//!
//! Two connections to one vehicle. What the firmware and the autopilot say to each other passes through unchanged
//! ([`connection`]). On the other one the truth is asked for ([`messages`], [`approach`]): where the vehicle really was and when
//! ([`truth`]), how late its estimated attitude is ([`shift`]), and what time it is there ([`clock`]). From these come the
//! exposures, and the frames that a camera would have taken ([`frames`]); [`flight`] has it all happen in time, and
//! [`navigation`] compares what the autopilot believes with the truth. [`report`] is what is told of it. At a [`desk`] the first connection is
//! all there is.

pub mod approach;
pub mod clock;
pub mod connection;
pub mod desk;
pub mod flight;
pub mod frames;
pub mod messages;
pub mod navigation;
pub mod report;
pub mod shift;
pub mod truth;

use crate::link::LinkError;
use plumbline_survey::error::InputError;
use std::fmt;

/// Why there is no live flight.
#[derive(Debug)]
pub enum LiveError {
    /// Something the user can mend: nobody there, no simulator, a stream that is denied.
    Input(InputError),
    /// Work that failed.
    Lost(String),
    /// A connection ended.
    Closed(String),
    /// Somebody wanted it to end.
    Interrupted,
}

impl fmt::Display for LiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LiveError::Input(error) => error.fmt(f),
            LiveError::Lost(why) => f.write_str(why),
            LiveError::Closed(which) => write!(f, "{which}: the connection was closed"),
            LiveError::Interrupted => f.write_str("the flight was interrupted before it began"),
        }
    }
}

impl std::error::Error for LiveError {}

impl From<InputError> for LiveError {
    fn from(error: InputError) -> Self {
        LiveError::Input(error)
    }
}

impl From<LinkError> for LiveError {
    fn from(error: LinkError) -> Self {
        match error {
            LinkError::Input(error) => LiveError::Input(error),
            LinkError::Interrupted => LiveError::Interrupted,
            LinkError::Lost(_) => LiveError::Lost(error.to_string()),
        }
    }
}
