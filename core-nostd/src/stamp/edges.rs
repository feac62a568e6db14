//! The shutter's edges as they are latched, debounced.
//!
//! Polarity alone distinguishes opening from closing. A driver that took the edge before for the opening one stamped
//! half a frame interval off as soon as one edge was lost (PX4's camera capture of 2017).

use super::settings::{Polarity, ShutterSettings};
use crate::units::Ticks;
use heapless::Deque;

/// An edge as the timer latched it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Edge {
    /// Its latched tick.
    pub at: Ticks,
    /// Its polarity.
    pub polarity: Polarity,
}

/// Why an edge was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EdgeError {
    /// It is older than the one before.
    Backwards,
    /// It is identical to the one before.
    Repeated,
    /// It follows another edge within the hold-off.
    Bounce,
}

/// Edges kept. Chosen between two, those of the one exposure that a frame belongs to, and as many as a bouncing line could
/// fill within [`MEMORY_TICKS`]: those of eight exposures, of which some have no frame or are strays.
const EDGES_MAX: usize = 16;
/// Edges older than this belong to no frame still to come: half a second of the longest exposure and a second of the
/// longest readout, with a margin of half a second.
const MEMORY_TICKS: i32 = 2_000_000;

/// An accepted edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    latched: Ticks,
    pub(super) opens: bool,
    /// A closing edge followed so soon that it may be a stray pulse. It counts in a pair of the right length, but not
    /// alone.
    pub(super) is_doubtful: bool,
}

impl Kept {
    /// Instant of the shutter: the latch less its fixed delay.
    pub(super) fn at(&self, settings: &ShutterSettings) -> Ticks {
        Ticks(self.latched.0.wrapping_sub(settings.delay_us(self.opens) as u32))
    }
}

/// The edges not yet associated with a frame, oldest first.
#[derive(Debug, Default)]
pub struct Edges {
    pub(super) kept: Deque<Kept, EDGES_MAX>,
    newest: Option<Edge>,
    /// Arrival of the newest frame.
    pub(super) arrival: Option<Ticks>,
}

impl Edges {
    /// None yet.
    pub const fn new() -> Self {
        Edges { kept: Deque::new(), newest: None, arrival: None }
    }

    /// Takes an edge; if the ring is full, the oldest is dropped. Of an edge and its bounces the first counts. After an
    /// opening edge that is followed by a closing one within the hold-off, a third that opens again shows that both
    /// were bounces of the first; without it the two were a stray pulse.
    ///
    /// # Errors
    /// [`EdgeError`]. An edge that is not wired is ignored without one.
    pub fn push(&mut self, edge: Edge, settings: &ShutterSettings) -> Result<(), EdgeError> {
        if let Some(newest) = self.newest {
            let since = edge.at.since(newest.at);
            if since < 0 {
                return Err(EdgeError::Backwards);
            }
            if since == 0 && edge.polarity == newest.polarity {
                return Err(EdgeError::Repeated);
            }
        }
        self.newest = Some(edge);
        let opens = edge.polarity == settings.opens_on;
        if !settings.wired.has(opens) {
            return Ok(());
        }
        if let Some(last) = self.kept.back_mut()
            && edge.at.since(last.latched) < settings.hold_off_us as i32
        {
            if last.opens {
                last.is_doubtful = !opens;
            }
            return Err(EdgeError::Bounce);
        }
        if self.kept.is_full() {
            self.kept.pop_front();
        }
        // The ring is not full now: the push cannot fail.
        let _ = self.kept.push_back(Kept { latched: edge.at, opens, is_doubtful: false });
        Ok(())
    }

    /// Drops edges that are too old to be compared across a wrap of the timer.
    pub fn forget(&mut self, now: Ticks) {
        let is_old = |at: Ticks| now.since(at) > MEMORY_TICKS;
        while self.kept.front().is_some_and(|edge| is_old(edge.latched)) {
            self.kept.pop_front();
        }
        self.newest = self.newest.filter(|edge| !is_old(edge.at));
        self.arrival = self.arrival.filter(|at| !is_old(*at));
    }

    /// Drops the edges up to `until`, compared with their delays subtracted.
    pub(super) fn drop_until(&mut self, until: Ticks, settings: &ShutterSettings) {
        while self.kept.front().is_some_and(|edge| edge.at(settings).since(until) <= 0) {
            self.kept.pop_front();
        }
    }
}
