//! Candidate positions of the vehicle (tracks), and which of them counts: a multiple-hypothesis test of matches.
//!
//! A wrong match is mostly far off: repetitive or changed ground puts it anywhere in the search. So each track is propagated by the
//! velocity, and a match updates the track whose gate it lies in, or starts a new one. A track's votes are the number of key frames that
//! supported it less the number that supported others. Matches over the same ground vote once, since they are wrong alike (adjacent parcels
//! of 40 m agree for ever); ground is told apart by the path flown, not by the matches. A match is accepted if its track has at least
//! [`VOTES_MIN`] and more than every other.
//!
//! A vehicle that hovers gathers no votes: if its first track is wrong, it has no fix until that is dropped.

use super::protection::larger_sigma_m;
use super::reckoning::{JUMP_ONSET_US, Moment, displacement_m};
use crate::math::{hypot, ln, sin_cos, sqrt};
use crate::tile::Local;
use crate::units::Micros;
use core::cmp::Ordering;
use heapless::Vec;
use nalgebra::{Matrix2, Vector2};

/// Number of tracks. Chosen: the one that counts, one that contradicts it, and one more.
const TRACKS: usize = 3;
/// Most votes of a track. Each new key frame moves one vote, so that three overrule it. Chosen: with a footprint of 140 m and 25 m/s that
/// takes some ten seconds.
pub const VOTES_MAX: u8 = 4;
/// A match is accepted if its track has as many votes: those of the first track, and one key frame more than any contradiction.
pub const VOTES_MIN: u8 = 2;
/// Gate: largest squared Mahalanobis distance of a match from its track, two degrees of freedom; normal errors are beyond once in 100,000.
pub const GATE: f32 = 23.0;
/// Share of the footprint's smaller side between two key frames. Chosen: a quarter of the ground is seen twice.
const KEY_FRAME_DISTANCE: f32 = 0.75;
/// Share of it by which a track that was contradicted has to move for a jump. Chosen: a wrong match is 3 pixels off, of 35.
const MOVED_SHARE: f32 = 0.1;
/// Least sigma of the reported velocity, each axis, m/s: with it the gate holds the largest error that was seen of an autopilot without
/// fixes in a turn, 5 m/s on both axes.
const VELOCITY_SIGMA_M_PER_S: f32 = 1.5;
/// Longest time between two frames over which tracks are propagated, microseconds: half a circle at 20 degrees a second, up to which
/// [`TURN_SHARE`] is valid.
const STEP_MAX_US: i32 = 9_000_000;
/// Largest error of the mean of two velocities, as a share of their difference, in turns of up to half a circle.
const TURN_SHARE: f32 = 0.35;
/// A track is doubtful if its gate covers this share of the search: it would take in chance matches.
const DOUBTFUL_SHARE: f32 = 0.5;
/// A match within this share of the search counts for a doubtful track nevertheless. Chosen: one in twenty chance matches is there.
const NEAR_SHARE: f32 = 0.25;

/// Time without fixes after a match that contradicts those before, microseconds: one that the directions confirm is wrong once in 23,000
/// times, so that rather the attitude is off and swings through the expected one. Chosen: four frames.
const CONTRADICTED_US: i32 = 1_000_000;

/// A match as a measurement of the position.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Nadir, in the tile's frame, metres.
    pub nadir: Local,
    /// Its covariance, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Covariance without the tilt's drift, which neighbouring frames have in common.
    pub white: Matrix2<f32>,
    /// Smaller side of the footprint, metres.
    pub side_m: f32,
    /// Heading, clockwise from grid north, radians.
    pub heading_rad: f32,
}

/// One hypothesis of the position.
#[derive(Clone, Copy, Debug)]
struct Track {
    /// Nadir at the newest frame.
    nadir: Local,
    /// Covariance of its newest match.
    covariance: Matrix2<f32>,
    /// Dead reckoning error since, one sigma of each axis, metres.
    drift_m: f32,
    /// Dead-reckoned positions at its last key frame, and at the last one that voted against it.
    counted_at: Local,
    doubted_at: Local,
    votes: u8,
    begun: Start,
}

/// Displacement of a track from the previous leader at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// East and north, metres.
    pub by_m: [f32; 2],
    /// Heading of the vehicle at the start, clockwise from grid north, radians.
    pub heading_rad: f32,
}

impl Displacement {
    /// The displacement, metres east and north, had it turned with the vehicle to such a heading.
    pub fn turned_to(&self, heading_rad: f32) -> [f32; 2] {
        let (sin, cos) = sin_cos(heading_rad - self.heading_rad);
        let [east, north] = self.by_m;
        [east * cos + north * sin, north * cos - east * sin]
    }
}

/// Start of a track.
#[derive(Clone, Copy, Debug)]
struct Start {
    at: Micros,
    displacement: Option<Displacement>,
}

impl Track {
    fn new(sighting: &Sighting, dead_reckoned: Local, votes: u8, begun: Start) -> Self {
        let Sighting { nadir, covariance, .. } = *sighting;
        Track { nadir, covariance, drift_m: 0.0, counted_at: dead_reckoned, doubted_at: dead_reckoned, votes, begun }
    }

    /// A vote against it, once a key frame.
    fn doubt(&mut self, dead_reckoned: Local, fresh_m: f32) {
        if self.doubted_at.off_m(dead_reckoned) >= fresh_m {
            (self.votes, self.doubted_at) = (self.votes.saturating_sub(1), dead_reckoned);
        }
    }
}

/// Squared Mahalanobis distance of a match from a track, and the logarithm of the determinant; infinite for invalid numbers.
fn mahalanobis(place: Local, covariance: Matrix2<f32>, drift_m: f32, sighting: &Sighting) -> (f32, f32) {
    let both = covariance + sighting.covariance + Matrix2::identity() * (drift_m * drift_m);
    let by = Vector2::from(place.to(sighting.nadir));
    let squared = both.try_inverse().map_or(f32::INFINITY, |inverse| (by.transpose() * inverse * by)[(0, 0)]);
    let spread = both.determinant();
    if squared >= 0.0 && spread > 0.0 { (squared, ln(spread)) } else { (f32::INFINITY, 0.0) }
}

impl Sighting {
    /// Whether it is within [`GATE`] of a position with its covariance and a further sigma, each axis, metres.
    pub fn agrees(&self, (place, covariance): (Local, Matrix2<f32>), drift_m: f32) -> bool {
        mahalanobis(place, covariance, drift_m, self).0 <= GATE
    }

    fn displacement_from(&self, from: Local) -> Displacement {
        Displacement { by_m: from.to(self.nadir), heading_rad: self.heading_rad }
    }

    fn is_finite(&self) -> bool {
        self.nadir.east_m.is_finite() && self.nadir.north_m.is_finite() && self.covariance.iter().all(|c| c.is_finite())
    }
}

/// Dead reckoning error after `age_us`, one sigma of each axis, metres. `sigma_m_per_s`: of the velocity.
pub fn drift_m(sigma_m_per_s: f32, age_us: i32) -> f32 {
    sigma_m_per_s.max(VELOCITY_SIGMA_M_PER_S) * age_us as f32 * 1e-6
}

/// All tracks.
#[derive(Clone, Debug)]
pub struct Tracks {
    tracks: Vec<Track, TRACKS, u8>,
    /// The newest frame, and the dead-reckoned position there from an arbitrary origin.
    moment: Moment,
    dead_reckoned: Local,
    /// Whether there has been a track before.
    was_known: bool,
    /// Position and instant of the last leader, and the displacement of the track that overruled it with the newest match.
    last_leader: Option<Local>,
    last_leader_at: Micros,
    overruled: Option<Displacement>,
    /// Instant of the last match that contradicted those before.
    contradicted_at: Option<Micros>,
}

impl Default for Tracks {
    fn default() -> Self {
        Tracks::new()
    }
}

impl Tracks {
    /// Without tracks.
    pub const fn new() -> Self {
        let origin = Local { east_m: 0.0, north_m: 0.0 };
        let moment = Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] };
        Tracks {
            tracks: Vec::new(),
            moment,
            dead_reckoned: origin,
            was_known: false,
            last_leader: None,
            last_leader_at: Micros(0),
            overruled: None,
            contradicted_at: None,
        }
    }

    /// Propagates all tracks to a frame; drops those whose dead reckoning error exceeds `reach_m`. `sigma_m_per_s`: of the velocity, each
    /// axis.
    pub fn propagate(&mut self, moment: Moment, sigma_m_per_s: f32, reach_m: f32) {
        let before = core::mem::replace(&mut self.moment, moment);
        let step_us = moment.at.since(before.at);
        if !(0..=STEP_MAX_US).contains(&step_us) {
            // At such a frame rate only the navigation's position is left.
            self.tracks.clear();
            (self.was_known, self.last_leader) = (false, None);
        }
        let way = displacement_m(before, moment);
        let [east, north] = moment.velocity_m_per_s;
        let turned = hypot(east - before.velocity_m_per_s[0], north - before.velocity_m_per_s[1]);
        let drift_m = drift_m(sigma_m_per_s, step_us) + TURN_SHARE * turned * step_us as f32 * 1e-6;
        self.dead_reckoned = self.dead_reckoned.moved(way);
        self.last_leader = self.last_leader.map(|previous| previous.moved(way));
        self.overruled = None;
        self.tracks.retain_mut(|track| {
            track.nadir = track.nadir.moved(way);
            track.drift_m += drift_m;
            track.drift_m <= reach_m
        });
    }

    /// Position of the track that counts, if one does.
    pub fn place(&self) -> Option<Local> {
        self.leader().map(|leader| leader.nadir)
    }

    fn leader(&self) -> Option<&Track> {
        let (index, leader) = self.tracks.iter().enumerate().max_by_key(|(_, track)| track.votes)?;
        let is_beaten = |(other, track): (usize, &Track)| other != index && track.votes >= leader.votes;
        let counts = leader.votes >= VOTES_MIN && !self.tracks.iter().enumerate().any(is_beaten);
        counts.then_some(leader)
    }

    /// Positions of the other tracks, each with its larger sigma, metres.
    pub fn others(&self) -> impl Iterator<Item = (Local, f32)> + '_ {
        let counts = self.place();
        let others = self.tracks.iter().filter(move |track| counts != Some(track.nadir));
        others.map(|track| (track.nadir, hypot(larger_sigma_m(&track.covariance), track.drift_m)))
    }

    /// Notes that a match of the newest frame contradicts those before.
    pub fn contradicted(&mut self) {
        self.contradicted_at = Some(self.moment.at);
    }

    /// Whether none has done so lately.
    pub fn is_calm(&self) -> bool {
        self.contradicted_at.is_none_or(|at| !(0..CONTRADICTED_US).contains(&self.moment.at.since(at)))
    }

    /// Whether there is no track.
    pub fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// Whether another frame has to find a match again before it counts: the track's gate covers half of the search and the match is not
    /// near it, or the track has been dropped.
    pub fn is_doubtful(&self, nadir: Local, reach_m: f32) -> bool {
        let reaches = |leader: &Track| sqrt(GATE) * leader.drift_m > DOUBTFUL_SHARE * reach_m;
        let is_off = |leader: &Track| leader.nadir.off_m(nadir) > NEAR_SHARE * reach_m;
        if self.tracks.is_empty() {
            self.was_known
        } else {
            self.leader().is_some_and(|leader| reaches(leader) && is_off(leader))
        }
    }

    /// Displacement, at its start, of the track that has overruled the previous leader with the newest match. Later the velocity's error
    /// would be in it.
    pub fn overruled(&self) -> Option<Displacement> {
        self.overruled
    }

    /// Starts over from a match that was found twice, or where the navigation expected it.
    pub fn begin(&mut self, sighting: &Sighting) {
        (self.was_known, self.last_leader, self.last_leader_at) = (true, Some(sighting.nadir), self.moment.at);
        self.tracks.clear();
        // There is room.
        let begun = Start { at: self.moment.at, displacement: None };
        let _ = self.tracks.push(Track::new(sighting, self.dead_reckoned, VOTES_MIN, begun));
    }

    /// Start of the track that a match belongs to, or of a new one. If the track started before the last leader counted, its displacement
    /// at the start is not used: it may be the same one, which takes in a distant match after a gap.
    fn begun(&self, own: Option<&Track>, sighting: &Sighting) -> Start {
        let at = own.map_or(self.moment.at, |own| own.begun.at);
        let is_beginning = self.moment.at.since(at) < JUMP_ONSET_US || self.last_leader_at.since(at) >= 0;
        let known = own.and_then(|own| own.begun.displacement).filter(|_| !is_beginning);
        Start {
            at,
            displacement: known.or_else(|| self.last_leader.map(|previous| sighting.displacement_from(previous))),
        }
    }

    /// Removes one.
    fn remove(&mut self, index: usize) -> Option<Track> {
        let track = self.tracks.get(index).copied()?;
        let mut at = 0..;
        self.tracks.retain(|_| at.next() != Some(index));
        Some(track)
    }

    /// Updates the tracks by a match of the newest frame; there must be one. Whether the match is accepted.
    pub fn matched(&mut self, sighting: &Sighting) -> bool {
        if !sighting.is_finite() {
            return false;
        }
        let (dead_reckoned, fresh_m) = (self.dead_reckoned, KEY_FRAME_DISTANCE * sighting.side_m);
        let offs = self.tracks.iter().map(|track| mahalanobis(track.nadir, track.covariance, track.drift_m, sighting));
        // The most likely track: squared distance plus logarithm of the determinant.
        let likely = offs.enumerate().filter(|(_, (squared, _))| *squared <= GATE);
        let nearest = likely.min_by(|(_, one), (_, other)| (one.0 + one.1).total_cmp(&(other.0 + other.1)));
        let counted = self.place();
        let own = nearest.and_then(|(index, _)| self.remove(index));
        let is_news = own.is_none_or(|own| counted != Some(own.nadir));
        let counted_at = own.map(|own| own.counted_at);
        let is_fresh = counted_at.is_none_or(|at| at.off_m(dead_reckoned) >= fresh_m);
        let begun = self.begun(own.as_ref(), sighting);
        let own = own.unwrap_or(Track::new(sighting, dead_reckoned, 0, begun));
        let (counted_at, votes) = if is_fresh { (dead_reckoned, own.votes + 1) } else { (own.counted_at, own.votes) };
        let votes = votes.min(VOTES_MAX);
        let own = Track { counted_at, doubted_at: own.doubted_at, ..Track::new(sighting, dead_reckoned, votes, begun) };
        // Tracks within the gate of this one are merged into it.
        self.tracks.retain(|track| !sighting.agrees((track.nadir, track.covariance), 0.0));
        self.tracks.iter_mut().for_each(|track| track.doubt(dead_reckoned, fresh_m));
        self.tracks.retain(|track| track.votes > 0);
        if self.tracks.is_full() {
            let worth = |track: &Track| (track.votes, -track.drift_m);
            let less = |one: &Track, other: &Track| worth(one).partial_cmp(&worth(other)).unwrap_or(Ordering::Equal);
            let least = self.tracks.iter().enumerate().min_by(|(_, one), (_, other)| less(one, other));
            least.map(|(index, _)| index).and_then(|index| self.remove(index));
        }
        // There is room.
        let _ = self.tracks.push(own);
        let counts = self.place() == Some(sighting.nadir);
        if counts {
            let led_at = core::mem::replace(&mut self.last_leader_at, self.moment.at);
            let was_contradicted = self.contradicted_at.is_some_and(|at| at.since(led_at) > 0);
            let previous = self.last_leader.replace(sighting.nadir);
            // A displacement that the velocity's error may explain counts only after a contradiction.
            let has_moved =
                |previous: &Local| was_contradicted && sighting.nadir.off_m(*previous) > MOVED_SHARE * sighting.side_m;
            let displacement = |previous: Local| sighting.displacement_from(previous);
            self.overruled = match is_news {
                true => previous.map(|previous| begun.displacement.unwrap_or(displacement(previous))),
                false => previous.filter(has_moved).map(displacement),
            };
        }
        counts
    }
}

#[cfg(test)]
mod tests;
