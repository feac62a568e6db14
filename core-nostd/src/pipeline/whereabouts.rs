//! Where the next frame is searched: around the navigation's position, far around it when that has been lost, and where a far
//! search has found it until the navigation is there itself.
//!
//! A navigation may take a while to believe fixes that are far from its own position, and comes there in a jump. Dead
//! reckoning from the last match needs its velocity alone: jumps of its position do not move what is found.

use super::reckoning::Reckoning;
use super::{Refusal, Situation};
use crate::budget::REACQUIRE_PX;
use crate::tile::Local;

/// Consecutive frames that were matched and not accepted after which the position counts as lost: from then on every second
/// frame is searched over ±[`REACQUIRE_PX`], until one is found. Over good ground one frame in fifty is not accepted; over a lake or
/// changed ground many are in a row, and half of them cost a long search.
pub const LOST_AFTER: u8 = 5;
/// Frames in which a place that a far search has found must be found again; it is no fix before. Two of a hundred good frames are
/// not accepted, so of two in a row one is.
const CONFIRMED_WITHIN: u8 = 2;
/// Oldest match that is carried on, microseconds. In a turn the velocity of an autopilot without fixes was off by up to 5 m/s
/// within three seconds: in two of them that is as far as a usual search reaches.
const AGE_MAX_US: i32 = 2_000_000;
/// Share of the usual search within which the navigation counts as being where a far search has found it. Chosen.
const NEAR: f32 = 0.5;
/// Centres of far searches, one after the other, (columns, rows) of [`SPACING_PX`]: around the prediction, then on all sides.
const SWEEP: [(i8, i8); 9] = [(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];
/// Between these centres, pixels: searches overlap by an eighth, so that what is found at a border lies within another.
const SPACING_PX: f32 = 1.75 * REACQUIRE_PX as f32;

/// A place that was found.
#[derive(Clone, Copy, Debug)]
struct Found {
    reckoning: Reckoning,
    /// Frames that have not found it again, as long as none has.
    unconfirmed: Option<u8>,
}

impl Found {
    fn new(situation: &Situation, nadir: Local, unconfirmed: Option<u8>) -> Self {
        Found { reckoning: Reckoning::new(situation, nadir), unconfirmed }
    }
}

/// A search that is due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Where the nadir is looked for.
    pub at: Local,
    /// Over ±[`REACQUIRE_PX`], not as the settings say.
    pub is_far: bool,
}

/// What the last frames' searches came to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whereabouts {
    /// Frames since the last accepted one that were not accepted, [`LOST_AFTER`] at most.
    missed: u8,
    /// Which centre the next far search has.
    sweep: u8,
    found: Option<Found>,
}

impl Whereabouts {
    /// The search for the next frame. `near_m`: how far a usual one reaches. `is_in_doubt`: the position may well lie beyond that.
    /// `px_m`: metres a pixel.
    pub(super) fn search(&mut self, situation: &Situation, near_m: f32, is_in_doubt: bool, px_m: f32) -> Search {
        let is_lost = self.missed >= LOST_AFTER;
        // Once the navigation is there, and not in doubt, it is what is believed.
        let predicted = situation.prediction.local;
        let is_there = |found: &Found| {
            found.unconfirmed.is_none() && !is_in_doubt && found.reckoning.off_m(predicted) <= NEAR * near_m
        };
        let carried = |found: Found| Some(Found { reckoning: found.reckoning.to(situation, AGE_MAX_US)?, ..found });
        self.found = self.found.filter(|_| !is_lost).and_then(carried).filter(|found| !is_there(found));
        match self.found {
            Some(found) => Search { at: found.reckoning.local(), is_far: false },
            None if is_lost || is_in_doubt => {
                let (cols, rows) = SWEEP.get(self.sweep as usize).copied().unwrap_or_default();
                let (east_m, north_m) = (cols as f32 * SPACING_PX * px_m, rows as f32 * SPACING_PX * px_m);
                let at = Local { east_m: predicted.east_m + east_m, north_m: predicted.north_m + north_m };
                Search { at, is_far: true }
            }
            None => Search { at: predicted, is_far: false },
        }
    }

    /// A search has ended: with the nadir, or why not.
    ///
    /// # Errors
    /// [`Refusal::Unconfirmed`] for a nadir that the next frames must find again before it counts.
    pub(super) fn ended(
        &mut self,
        search: Search,
        situation: &Situation,
        nadir: Result<Local, Refusal>,
    ) -> Result<(), Refusal> {
        match (nadir, search.is_far) {
            (Ok(nadir), true) => {
                self.missed = 0;
                self.found = Some(Found::new(situation, nadir, Some(0)));
                return Err(Refusal::Unconfirmed);
            }
            (Ok(nadir), false) => {
                (self.missed, self.sweep) = (0, 0);
                self.found = self.found.map(|_| Found::new(situation, nadir, None));
            }
            // Nothing was seen: that search is still to come.
            (Err(Refusal::Featureless), true) => {}
            (Err(_), true) => self.next_far(),
            (Err(_), false) => self.missed_near(),
        }
        Ok(())
    }

    /// The next far search is made elsewhere, after one frame near the prediction.
    fn next_far(&mut self) {
        self.missed = LOST_AFTER - 1;
        self.sweep = (self.sweep + 1) % SWEEP.len() as u8;
    }

    fn missed_near(&mut self) {
        self.missed = (self.missed + 1).min(LOST_AFTER);
        let Some(found) = &mut self.found else { return };
        let Some(frames) = &mut found.unconfirmed else { return };
        *frames += 1;
        if *frames >= CONFIRMED_WITHIN {
            self.found = None;
            self.next_far();
        }
    }
}
