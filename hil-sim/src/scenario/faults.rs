//! The tables of what goes wrong.

use serde::Deserialize;

/// From which second of the flight to which, the latter no more.
pub type Seconds = [f64; 2];

/// What the attitude sensor does wrong, and when. None of it unless given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AttitudeFaults {
    /// It is silent.
    pub gap_s: Option<Seconds>,
    /// It hangs: its last value goes on, with fresh stamps.
    pub stuck_s: Option<Seconds>,
    /// Its stamps run backwards from the first of these seconds.
    pub backwards_s: Option<Seconds>,
    /// Its values are no numbers.
    pub nan_s: Option<Seconds>,
}

/// What goes wrong on the link, all in percent. See [`crate::fault`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LinkFaults {
    /// Share of all bits that arrive flipped. A message has some 300 bits.
    pub bit_error_percent: f64,
    /// Share of the messages of which the end, or all, is missing.
    pub cut_percent: f64,
    /// Share of the messages before which one of an unknown kind arrives.
    pub unknown_percent: f64,
}
