//! Where the next frame is searched: around the navigation's position, around the place that matches know where that is another,
//! and far around when the position has been lost.
//!
//! A navigation may take a while to believe fixes that are far from its own position, and comes there in a jump. Dead
//! reckoning from the last match needs its velocity alone: jumps of its position do not move what is found.

use super::{Refusal, Situation};
use crate::budget::REACQUIRE_PX;
use crate::math::ceil;
use crate::navigation::reckoning::DeadReckoning;
use crate::navigation::tracks::{Sighting, Tracks, drift_m};
use crate::tile::Local;
use nalgebra::Matrix2;

/// Consecutive frames that were matched and not accepted after which the position counts as lost: from then on each frame that is
/// not found as usual is searched over ±[`REACQUIRE_PX`] as well, until one is found. Over good ground one frame in fifty is not
/// accepted; over a lake or changed ground many are in a row, and each costs a long search.
pub const LOST_AFTER: u8 = 3;
/// After so many of them the first match is confirmed by another before it counts: a wrong one has had as many chances.
const DOUBTED_AFTER: u8 = 5;
/// Frames in which a match that is to be confirmed must be found again; it is no fix before. Two of a hundred good frames are
/// not accepted, so of two in a row one is.
const CONFIRMED_WITHIN: u8 = 2;
/// Oldest match that may still be confirmed, microseconds. In a turn the velocity of an autopilot without fixes was off by up to
/// 5 m/s within three seconds: in two of them that is as far as a usual search reaches.
const AGE_MAX_US: i32 = 2_000_000;
/// Share of the usual search within which the navigation counts as being where matches have found the vehicle. Chosen.
const NEAR: f32 = 0.5;
/// Far searches are made around centres of a grid, ring by ring around the prediction, out to so many metres. Chosen: what a consumer
/// inertial navigation drifts within some minutes.
const SWEEP_M: f32 = 1000.0;
/// Rings at most: over 1 m a pixel eight reach as far, and take a minute and three quarters at four frames a second.
const RINGS_MAX: f32 = 8.0;
/// Rings of each lap, and centres of all of them and once more the first one's.
const LAPS: [u16; 6] = [0, 0, 1, 2, 4, 8];
const STEPS_MAX: u16 = 2 + 9 + 25 + 81 + 289 + 1;
/// Between these centres, pixels: searches overlap by an eighth, so that what is found at a border lies within another.
const SPACING_PX: f32 = 1.75 * REACQUIRE_PX as f32;

/// Columns and rows of the centre of a far search after so many: twice the middle, since a search of reduced pictures finds two of three
/// that are there; all of one ring, then from the middle on all of two, of four, of eight, since most are lost nearby. Nothing beyond the last.
fn swept(step: u16, rings: u16) -> Option<(i16, i16)> {
    let mut left = step;
    for lap in LAPS.map(|lap| lap.min(rings)) {
        let count = (2 * lap + 1) * (2 * lap + 1);
        if left < count {
            return Some(on_spiral(left));
        }
        left -= count;
        if lap == rings {
            break;
        }
    }
    None
}

/// Columns and rows of the place that a spiral out of the middle of a grid comes to after so many steps, ring by ring.
fn on_spiral(step: u16) -> (i16, i16) {
    let mut ring = 0;
    while (2 * ring + 1) * (2 * ring + 1) <= i32::from(step) {
        ring += 1;
    }
    if ring == 0 {
        return (0, 0);
    }
    // Each ring has four sides of twice its number.
    let (side, along) = (2 * ring, i32::from(step) - (2 * ring - 1) * (2 * ring - 1));
    let (col, row) = if along < side {
        (ring, along - ring + 1)
    } else if along < 2 * side {
        (ring - 1 - (along - side), ring)
    } else if along < 3 * side {
        (-ring, ring - 1 - (along - 2 * side))
    } else {
        (along - 3 * side - ring + 1, -ring)
    };
    (col as i16, row as i16)
}

/// A match that another one has to confirm before it counts.
#[derive(Clone, Copy, Debug)]
struct Found {
    reckoning: DeadReckoning,
    /// Frames that have not found it again.
    missed: u8,
    /// Only the highest on a search's border: no match yet.
    is_on_border: bool,
}

impl Found {
    fn new(situation: &Situation, nadir: Local, is_on_border: bool) -> Self {
        Found { reckoning: DeadReckoning::new(situation.moment(), nadir), missed: 0, is_on_border }
    }

    /// Whether a match lies where this one has come to, which was as certain as that is: frames a moment apart are alike.
    fn agrees(&self, sighting: &Sighting, sigma_m_per_s: f32) -> bool {
        let drift_m = drift_m(sigma_m_per_s, self.reckoning.age_us());
        sighting.agrees((self.reckoning.local(), sighting.covariance), drift_m)
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

/// What a usual search is, and what is known beside the situation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Usual {
    /// How far it reaches, metres.
    pub reach_m: f32,
    /// The navigation's position may well lie beyond that.
    pub is_in_doubt: bool,
    /// Metres a pixel.
    pub px_m: f32,
    /// The tile reaches as far from its centre, east and north, metres.
    pub tile_m: [f32; 2],
    /// Of the velocity, each axis, m/s.
    pub sigma_m_per_s: f32,
    /// One sigma of the navigation's position, each axis: nearer a first match is where it was expected.
    pub prior_m: f32,
}

/// Where the vehicle is taken to be: while the navigation is there, and not in doubt, that is what is believed.
fn centre(tracks: &Tracks, situation: &Situation, usual: &Usual) -> Local {
    let predicted = situation.prediction.local;
    let is_there = |place: &Local| !usual.is_in_doubt && place.off_m(predicted) <= NEAR * usual.reach_m;
    tracks.place().filter(|place| !is_there(place)).unwrap_or(predicted)
}

/// What the last frames' searches came to.
#[derive(Clone, Debug, Default)]
pub(super) struct Whereabouts {
    /// Frames since the last accepted one that were not accepted, [`DOUBTED_AFTER`] at most.
    missed: u8,
    /// Which centre the next far search has.
    sweep: u16,
    found: Option<Found>,
}

impl Whereabouts {
    /// The search for the next frame. One that is far comes behind it, where it finds nothing: [`Whereabouts::far`].
    pub(super) fn search(&mut self, tracks: &mut Tracks, situation: &Situation, usual: &Usual) -> Search {
        let Usual { reach_m, sigma_m_per_s, .. } = *usual;
        tracks.propagate(situation.moment(), sigma_m_per_s, reach_m);
        let carried =
            |found: Found| Some(Found { reckoning: found.reckoning.to(situation.moment(), AGE_MAX_US)?, ..found });
        self.found = self.found.and_then(carried);
        if let Some(found) = self.found {
            return Search { at: found.reckoning.local(), is_far: false };
        }
        Search { at: centre(tracks, situation, usual), is_far: false }
    }

    /// The far search that is due behind a usual one that has come to nothing, where the position has been lost or may be anywhere.
    pub(super) fn far(&mut self, tracks: &Tracks, situation: &Situation, usual: &Usual) -> Option<Search> {
        let is_due =
            self.found.is_none() && (self.missed >= LOST_AFTER || usual.is_in_doubt && tracks.place().is_none());
        is_due.then(|| Search { at: self.far_from(centre(tracks, situation, usual), usual), is_far: true })
    }

    /// The next centre of a far search around another one that is on the tile.
    fn far_from(&mut self, centre: Local, usual: &Usual) -> Local {
        let spacing_m = SPACING_PX * usual.px_m;
        let reach_m = REACQUIRE_PX as f32 * usual.px_m;
        let rings = ceil((SWEEP_M - reach_m) / spacing_m).clamp(1.0, RINGS_MAX) as u16;
        for _ in 0..STEPS_MAX {
            let (cols, rows) = swept(self.sweep, rings).unwrap_or_else(|| {
                self.sweep = 0;
                (0, 0)
            });
            let at = centre.moved([f32::from(cols) * spacing_m, f32::from(rows) * spacing_m]);
            let [east_m, north_m] = usual.tile_m.map(|half_m| half_m + 0.5 * reach_m);
            if at.east_m.abs() <= east_m && at.north_m.abs() <= north_m {
                return at;
            }
            self.sweep += 1;
        }
        centre
    }

    /// A search has ended: with a match, or why not. `by_place`: the match counts since all frames together have decided for its place, not by
    /// itself, so that they have found it before.
    ///
    /// # Errors
    /// [`Refusal::Unconfirmed`] for a match that the next frames must find again before it counts, and
    /// [`Refusal::Contradicted`] for one that does not lie where the ones before have put the vehicle.
    pub(super) fn ended(
        &mut self,
        tracks: &mut Tracks,
        search: Search,
        situation: &Situation,
        usual: &Usual,
        (sighting, by_place): (Result<Sighting, Refusal>, bool),
    ) -> Result<(), Refusal> {
        match (sighting, search.is_far) {
            (Ok(sighting), true) => return self.unconfirmed(situation, &sighting),
            (Ok(sighting), false) => {
                self.seen(tracks, situation, usual, &sighting, by_place)?;
                (self.missed, self.sweep) = (0, 0);
            }
            (Err(_), true) => {
                self.in_vain();
                self.sweep = self.sweep.wrapping_add(1);
            }
            (Err(_), false) => self.in_vain(),
        }
        Ok(())
    }

    fn unconfirmed(&mut self, situation: &Situation, sighting: &Sighting) -> Result<(), Refusal> {
        self.found = Some(Found::new(situation, sighting.nadir, false));
        Err(Refusal::Unconfirmed)
    }

    /// The highest of a usual search lies on its border, and no place is known: the next one is made around it.
    pub(super) fn leads_to(&mut self, situation: &Situation, nadir: Local) {
        if self.missed < LOST_AFTER {
            self.found = self.found.or(Some(Found::new(situation, nadir, true)));
        }
    }

    /// A match where it was looked for.
    fn seen(
        &mut self,
        tracks: &mut Tracks,
        situation: &Situation,
        usual: &Usual,
        sighting: &Sighting,
        by_place: bool,
    ) -> Result<(), Refusal> {
        let is_alone = tracks.is_empty();
        let found = self.found.take();
        let agrees = |found: &Found| !found.is_on_border && found.agrees(sighting, usual.sigma_m_per_s);
        if situation.is_candidate && found.as_ref().is_some_and(agrees) {
            // Turn and scale are found as well: the next frame is rectified by the same, and this one has found it before.
            self.found = Some(Found::new(situation, sighting.nadir, false));
        }
        match found {
            _ if by_place && !situation.is_candidate && is_alone => {
                tracks.begin(sighting);
                return Ok(());
            }
            _ if by_place && !situation.is_candidate => {}
            Some(found) if !agrees(&found) => {
                return self.unconfirmed(situation, sighting);
            }
            Some(_) if is_alone => {
                tracks.begin(sighting);
                return Ok(());
            }
            Some(_) => {}
            // After so long, or so many in vain, what is found as well may be wrong.
            None if situation.is_candidate
                || tracks.is_doubtful(sighting.nadir, usual.reach_m)
                || is_alone && (usual.is_in_doubt || self.missed + 1 >= DOUBTED_AFTER) =>
            {
                return self.unconfirmed(situation, sighting);
            }
            None if is_alone => {
                if !sighting.agrees((situation.prediction.local, Matrix2::zeros()), usual.prior_m) {
                    return self.unconfirmed(situation, sighting);
                }
                tracks.begin(sighting);
                return Ok(());
            }
            None => {}
        }
        if tracks.matched(sighting) { Ok(()) } else { Err(Refusal::Contradicted) }
    }

    /// Whether a match waits for another one to confirm it.
    pub(super) fn has_found(&self) -> bool {
        self.found.is_some()
    }

    fn in_vain(&mut self) {
        self.missed = (self.missed + 1).min(DOUBTED_AFTER);
        let Some(found) = &mut self.found else { return };
        found.missed += 1;
        if found.missed >= CONFIRMED_WITHIN {
            self.sweep = self.sweep.wrapping_add(u16::from(!found.is_on_border));
            self.found = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tilt::Attitude;
    use crate::units::{Micros, Radians};
    extern crate std;
    use std::collections::BTreeSet;
    use std::vec::Vec;

    const USUAL: Usual =
        Usual { reach_m: 50.0, is_in_doubt: false, px_m: 5.0, tile_m: [1000.0; 2], sigma_m_per_s: 0.5, prior_m: 8.0 };

    /// What becomes of frames twice a second that find the nadir so far east of where it is expected; `None`: nothing.
    fn ends(is_candidate: bool, east_m: &[Option<f32>]) -> Vec<Result<(), Refusal>> {
        let (mut whereabouts, mut tracks) = (Whereabouts::default(), Tracks::new());
        let level = Attitude { heading: Radians(0.0), pitch: Radians(0.0), roll: Radians(0.0) };
        let frame = |(number, east_m): (u64, &Option<f32>)| {
            let situation = Situation::exact(Micros(1_000_000 + 500_000 * number), level, (Radians(0.0), true), 100.0);
            let situation = Situation { is_candidate, ..situation };
            let search = whereabouts.search(&mut tracks, &situation, &USUAL);
            let covariance = Matrix2::identity();
            let nadir = |east_m| Local { east_m, north_m: 0.0 };
            let sighting = |east_m| Sighting {
                nadir: nadir(east_m),
                covariance,
                white: covariance,
                side_m: 150.0,
                heading_rad: 0.0,
            };
            let found = east_m.map(sighting).ok_or(Refusal::LowScore);
            whereabouts.ended(&mut tracks, search, &situation, &USUAL, (found, true))
        };
        (0..).zip(east_m).map(frame).collect()
    }

    #[test]
    fn what_a_turn_among_several_finds_counts_as_long_as_the_frames_before_have_found_it() {
        let (found, unconfirmed) = (Some(1.0), Err(Refusal::Unconfirmed));
        assert_eq!(ends(true, &[found; 4]), [unconfirmed, Ok(()), Ok(()), Ok(())]);
        assert_eq!(ends(false, &[found; 2]), [Ok(()), Ok(())]);
        // Two frames in vain, or another place, and it has to be found twice again.
        let lost = ends(true, &[found, found, None, None, found, found]);
        assert_eq!(lost[4..], [unconfirmed, Ok(())]);
        assert_eq!(ends(true, &[found, found, Some(30.0)])[2], unconfirmed);
    }

    #[test]
    fn a_spiral_comes_to_each_place_of_a_ring_before_the_next() {
        let mut seen = BTreeSet::new();
        for (ring, count) in [(0i16, 1u16), (1, 9), (2, 25), (8, 289)] {
            seen.extend((0..count).map(on_spiral));
            assert_eq!(seen.len(), usize::from(count));
            assert!(seen.iter().all(|(col, row)| col.abs() <= ring && row.abs() <= ring));
        }
    }

    #[test]
    fn the_middle_comes_again_before_the_outer_rings() {
        let middle =
            |rings| (0..500).filter(move |step| swept(*step, rings) == Some((0, 0))).collect::<std::vec::Vec<u16>>();
        assert_eq!(middle(8), [0, 1, 2, 11, 36, 117]);
        assert_eq!(middle(3), [0, 1, 2, 11, 36]);
        assert_eq!((swept(405, 8).is_some(), swept(406, 8)), (true, None));
        assert_eq!((swept(84, 3).is_some(), swept(85, 3)), (true, None));
    }
}
