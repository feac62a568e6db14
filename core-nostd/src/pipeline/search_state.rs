//! Centre of the search for the next frame: the navigation's position, or the track's where that is elsewhere; and wide
//! searches (reacquisition) while the position is lost.
//!
//! An autopilot may take a while to accept fixes far from its own position, and then jumps there. Dead reckoning from
//! the last match uses its velocity only, so jumps of its position do not matter.

use super::{Refusal, Situation};
use crate::budget::REACQUIRE_PX;
use crate::math::ceil;
use crate::navigation::reckoning::DeadReckoning;
use crate::navigation::tracks::{Sighting, Tracks, drift_m};
use crate::tile::Local;
use nalgebra::Matrix2;

/// Consecutive frames without an accepted match after which the position counts as lost: from then on each frame
/// without a match in the usual search is searched over ±[`REACQUIRE_PX`] as well, until one is matched. Over good
/// ground one frame in fifty is not accepted; over a lake or changed ground many are in a row, and each costs a wide
/// search.
pub const LOST_AFTER: u8 = 3;
/// After so many the first match has to be confirmed by another: a wrong one has had as many chances.
const DOUBTED_AFTER: u8 = 5;
/// Frames within which an unconfirmed match must be found again; it is no fix before. Two of a hundred good frames are
/// not accepted, so one of two in a row nearly always is.
const CONFIRMED_WITHIN: u8 = 2;
/// Oldest match that may still be confirmed, microseconds. In a turn the velocity of an autopilot without fixes was off
/// by up to 5 m/s within three seconds: in two of them that is as far as a usual search reaches.
const AGE_MAX_US: i32 = 2_000_000;
/// Share of the usual search radius within which the navigation's position agrees with the track. Chosen.
const AGREES_SHARE: f32 = 0.5;
/// Wide searches are made around the points of a grid, ring by ring around the prediction, out to this distance,
/// metres. Chosen: the drift of a consumer inertial navigation within some minutes.
const SWEEP_M: f32 = 1000.0;
/// Most rings: over 1 m a pixel eight reach as far, and take a minute and three quarters at four frames a second.
const RINGS_MAX: f32 = 8.0;
/// Number of rings of each lap, and total number of points: all laps, and the first one's once more.
const LAPS: [u16; 6] = [0, 0, 1, 2, 4, 8];
const STEPS_MAX: u16 = 2 + 9 + 25 + 81 + 289 + 1;
/// Grid spacing, pixels: searches overlap by an eighth, so that a peak on a border lies within another search.
const SPACING_PX: f32 = 1.75 * REACQUIRE_PX as f32;

/// Grid column and row of a wide search: twice the middle, since a coarse search finds two of three; all of one ring,
/// then from the middle on all of two, of four, of eight, since most positions are lost nearby. `None` after the last.
fn grid_point(step: u16, rings: u16) -> Option<(i16, i16)> {
    let mut left = step;
    for lap in LAPS.map(|lap| lap.min(rings)) {
        let count = (2 * lap + 1) * (2 * lap + 1);
        if left < count {
            return Some(spiral(left));
        }
        left -= count;
        if lap == rings {
            break;
        }
    }
    None
}

/// Column and row after so many steps of a spiral from the middle of a grid, ring by ring.
fn spiral(step: u16) -> (i16, i16) {
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

/// A match that has to be confirmed by another, propagated by dead reckoning.
#[derive(Clone, Copy, Debug)]
struct UnconfirmedMatch {
    reckoning: DeadReckoning,
    /// Frames that have not found it again.
    missed: u8,
    /// A peak on the border of a search: no match yet.
    is_on_border: bool,
}

impl UnconfirmedMatch {
    fn new(situation: &Situation, nadir: Local, is_on_border: bool) -> Self {
        UnconfirmedMatch { reckoning: DeadReckoning::new(situation.moment(), nadir), missed: 0, is_on_border }
    }

    /// Whether a match agrees with this one. Both have the same covariance: frames a moment apart are alike.
    fn agrees(&self, sighting: &Sighting, sigma_m_per_s: f32) -> bool {
        let drift_m = drift_m(sigma_m_per_s, self.reckoning.age_us());
        sighting.agrees((self.reckoning.local(), sighting.covariance), drift_m)
    }
}

/// A search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Expected nadir, the centre.
    pub at: Local,
    /// Over ±[`REACQUIRE_PX`] instead of the configured radius.
    pub is_far: bool,
}

/// Parameters of the usual search.
#[derive(Clone, Copy, Debug)]
pub(super) struct SearchParameters {
    /// Its radius, metres.
    pub reach_m: f32,
    /// The navigation's position may well lie beyond that.
    pub is_uncertain: bool,
    /// Metres a pixel.
    pub px_m: f32,
    /// Half the size of the tile, east and north, metres.
    pub tile_m: [f32; 2],
    /// Sigma of the velocity, each axis, m/s.
    pub sigma_m_per_s: f32,
    /// Sigma of the navigation's position, each axis, metres: the gate of a first match.
    pub prior_m: f32,
}

/// Centre of the usual search: the prediction if the navigation agrees with the track and is not uncertain, else the
/// track.
fn centre(tracks: &Tracks, situation: &Situation, parameters: &SearchParameters) -> Local {
    let predicted = situation.prediction.local;
    let is_there =
        |place: &Local| !parameters.is_uncertain && place.off_m(predicted) <= AGREES_SHARE * parameters.reach_m;
    tracks.place().filter(|place| !is_there(place)).unwrap_or(predicted)
}

/// State of the search over frames.
#[derive(Clone, Debug, Default)]
pub(super) struct SearchState {
    /// Frames since the last accepted one, at most [`DOUBTED_AFTER`].
    missed: u8,
    /// Step of the next wide search.
    sweep: u16,
    unconfirmed: Option<UnconfirmedMatch>,
}

impl SearchState {
    /// The usual search for the next frame. If it finds nothing, a wide one may follow: [`SearchState::far`].
    pub(super) fn search(
        &mut self,
        tracks: &mut Tracks,
        situation: &Situation,
        parameters: &SearchParameters,
    ) -> Search {
        let SearchParameters { reach_m, sigma_m_per_s, .. } = *parameters;
        tracks.propagate(situation.moment(), sigma_m_per_s, reach_m);
        let propagated = |unconfirmed: UnconfirmedMatch| {
            Some(UnconfirmedMatch {
                reckoning: unconfirmed.reckoning.to(situation.moment(), AGE_MAX_US)?,
                ..unconfirmed
            })
        };
        self.unconfirmed = self.unconfirmed.and_then(propagated);
        if let Some(unconfirmed) = self.unconfirmed {
            return Search { at: unconfirmed.reckoning.local(), is_far: false };
        }
        Search { at: centre(tracks, situation, parameters), is_far: false }
    }

    /// The wide search after a usual one without a match, if the position is lost or uncertain.
    pub(super) fn far(
        &mut self,
        tracks: &Tracks,
        situation: &Situation,
        parameters: &SearchParameters,
    ) -> Option<Search> {
        let is_due = self.unconfirmed.is_none()
            && (self.missed >= LOST_AFTER || parameters.is_uncertain && tracks.place().is_none());
        is_due.then(|| Search { at: self.far_from(centre(tracks, situation, parameters), parameters), is_far: true })
    }

    /// Centre of the next wide search around `centre` that lies on the tile.
    fn far_from(&mut self, centre: Local, parameters: &SearchParameters) -> Local {
        let spacing_m = SPACING_PX * parameters.px_m;
        let reach_m = REACQUIRE_PX as f32 * parameters.px_m;
        let rings = ceil((SWEEP_M - reach_m) / spacing_m).clamp(1.0, RINGS_MAX) as u16;
        for _ in 0..STEPS_MAX {
            let (cols, rows) = grid_point(self.sweep, rings).unwrap_or_else(|| {
                self.sweep = 0;
                (0, 0)
            });
            let at = centre.moved([f32::from(cols) * spacing_m, f32::from(rows) * spacing_m]);
            let [east_m, north_m] = parameters.tile_m.map(|half_m| half_m + 0.5 * reach_m);
            if at.east_m.abs() <= east_m && at.north_m.abs() <= north_m {
                return at;
            }
            self.sweep += 1;
        }
        centre
    }

    /// Takes the result of a search: a match, or why there is none. `by_place`: the match is accepted by the decision
    /// of several frames, which confirm it, not alone.
    ///
    /// # Errors
    /// [`Refusal::Unconfirmed`] for a match that the next frames must find again, and [`Refusal::Contradicted`] for one
    /// off the track that counts.
    pub(super) fn finish(
        &mut self,
        tracks: &mut Tracks,
        search: Search,
        situation: &Situation,
        parameters: &SearchParameters,
        (sighting, by_decision): (Result<Sighting, Refusal>, bool),
    ) -> Result<(), Refusal> {
        match (sighting, search.is_far) {
            (Ok(sighting), true) => return self.refuse_unconfirmed(situation, &sighting),
            (Ok(sighting), false) => {
                self.take(tracks, situation, parameters, &sighting, by_decision)?;
                (self.missed, self.sweep) = (0, 0);
            }
            (Err(_), true) => {
                self.count_miss();
                self.sweep = self.sweep.wrapping_add(1);
            }
            (Err(_), false) => self.count_miss(),
        }
        Ok(())
    }

    fn refuse_unconfirmed(&mut self, situation: &Situation, sighting: &Sighting) -> Result<(), Refusal> {
        self.unconfirmed = Some(UnconfirmedMatch::new(situation, sighting.nadir, false));
        Err(Refusal::Unconfirmed)
    }

    /// The peak of a usual search lies on its border, and there is no track: the next search is centred on it.
    pub(super) fn recentre(&mut self, situation: &Situation, nadir: Local) {
        if self.missed < LOST_AFTER {
            self.unconfirmed = self.unconfirmed.or(Some(UnconfirmedMatch::new(situation, nadir, true)));
        }
    }

    /// A match of a usual search.
    fn take(
        &mut self,
        tracks: &mut Tracks,
        situation: &Situation,
        parameters: &SearchParameters,
        sighting: &Sighting,
        by_decision: bool,
    ) -> Result<(), Refusal> {
        let is_alone = tracks.is_empty();
        let unconfirmed = self.unconfirmed.take();
        let agrees = |unconfirmed: &UnconfirmedMatch| {
            !unconfirmed.is_on_border && unconfirmed.agrees(sighting, parameters.sigma_m_per_s)
        };
        if situation.is_candidate && unconfirmed.as_ref().is_some_and(agrees) {
            // Rotation and scale are confirmed as well: the next frame is rectified with the same, and this match
            // confirms its.
            self.unconfirmed = Some(UnconfirmedMatch::new(situation, sighting.nadir, false));
        }
        match unconfirmed {
            _ if by_decision && !situation.is_candidate && is_alone => {
                tracks.begin(sighting);
                return Ok(());
            }
            _ if by_decision && !situation.is_candidate => {}
            Some(unconfirmed) if !agrees(&unconfirmed) => {
                return self.refuse_unconfirmed(situation, sighting);
            }
            Some(_) if is_alone => {
                tracks.begin(sighting);
                return Ok(());
            }
            Some(_) => {}
            // After so long a time, or so many frames without a match, a match in the usual search may be wrong as
            // well.
            None if situation.is_candidate
                || tracks.is_doubtful(sighting.nadir, parameters.reach_m)
                || is_alone && (parameters.is_uncertain || self.missed + 1 >= DOUBTED_AFTER) =>
            {
                return self.refuse_unconfirmed(situation, sighting);
            }
            None if is_alone => {
                if !sighting.agrees((situation.prediction.local, Matrix2::zeros()), parameters.prior_m) {
                    return self.refuse_unconfirmed(situation, sighting);
                }
                tracks.begin(sighting);
                return Ok(());
            }
            None => {}
        }
        if tracks.matched(sighting) { Ok(()) } else { Err(Refusal::Contradicted) }
    }

    /// Whether a match waits to be confirmed.
    pub(super) fn has_unconfirmed(&self) -> bool {
        self.unconfirmed.is_some()
    }

    fn count_miss(&mut self) {
        self.missed = (self.missed + 1).min(DOUBTED_AFTER);
        let Some(unconfirmed) = &mut self.unconfirmed else { return };
        unconfirmed.missed += 1;
        if unconfirmed.missed >= CONFIRMED_WITHIN {
            self.sweep = self.sweep.wrapping_add(u16::from(!unconfirmed.is_on_border));
            self.unconfirmed = None;
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

    const PARAMETERS: SearchParameters = SearchParameters {
        reach_m: 50.0,
        is_uncertain: false,
        px_m: 5.0,
        tile_m: [1000.0; 2],
        sigma_m_per_s: 0.5,
        prior_m: 8.0,
    };

    /// Results of frames twice a second that find the nadir so far east of the prediction; `None`: no match.
    fn ends(is_candidate: bool, east_m: &[Option<f32>]) -> Vec<Result<(), Refusal>> {
        let (mut search_state, mut tracks) = (SearchState::default(), Tracks::new());
        let level = Attitude { heading: Radians(0.0), pitch: Radians(0.0), roll: Radians(0.0) };
        let frame = |(number, east_m): (u64, &Option<f32>)| {
            let situation = Situation::exact(Micros(1_000_000 + 500_000 * number), level, (Radians(0.0), true), 100.0);
            let situation = Situation { is_candidate, ..situation };
            let search = search_state.search(&mut tracks, &situation, &PARAMETERS);
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
            search_state.finish(&mut tracks, search, &situation, &PARAMETERS, (found, true))
        };
        (0..).zip(east_m).map(frame).collect()
    }

    #[test]
    fn what_a_turn_among_several_finds_counts_as_long_as_the_frames_before_have_found_it() {
        let (found, unconfirmed) = (Some(1.0), Err(Refusal::Unconfirmed));
        assert_eq!(ends(true, &[found; 4]), [unconfirmed, Ok(()), Ok(()), Ok(())]);
        assert_eq!(ends(false, &[found; 2]), [Ok(()), Ok(())]);
        // After two frames without it, or with another position, it has to be found twice again.
        let lost = ends(true, &[found, found, None, None, found, found]);
        assert_eq!(lost[4..], [unconfirmed, Ok(())]);
        assert_eq!(ends(true, &[found, found, Some(30.0)])[2], unconfirmed);
    }

    #[test]
    fn a_spiral_comes_to_each_place_of_a_ring_before_the_next() {
        let mut seen = BTreeSet::new();
        for (ring, count) in [(0i16, 1u16), (1, 9), (2, 25), (8, 289)] {
            seen.extend((0..count).map(spiral));
            assert_eq!(seen.len(), usize::from(count));
            assert!(seen.iter().all(|(col, row)| col.abs() <= ring && row.abs() <= ring));
        }
    }

    #[test]
    fn the_middle_comes_again_before_the_outer_rings() {
        let middle = |rings| {
            (0..500).filter(move |step| grid_point(*step, rings) == Some((0, 0))).collect::<std::vec::Vec<u16>>()
        };
        assert_eq!(middle(8), [0, 1, 2, 11, 36, 117]);
        assert_eq!(middle(3), [0, 1, 2, 11, 36]);
        assert_eq!((grid_point(405, 8).is_some(), grid_point(406, 8)), (true, None));
        assert_eq!((grid_point(84, 3).is_some(), grid_point(85, 3)), (true, None));
    }
}
