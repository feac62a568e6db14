//! Places where the vehicle may be, and which of them counts.
//!
//! A match that is wrong is mostly far off: a picture that repeats, or ground that has changed, puts it anywhere in the search. So
//! each place is carried on by the velocity, and a match belongs to the place that it lies at, or begins one of its own. What a place
//! is worth is the number of pieces of ground that have spoken for it less those that have spoken for others: matches over the same
//! ground count once, since whatever fools one of them fools them all (parcels of 40 m side by side agree for ever). A match is
//! believed where its place is worth more than every other and has been seen twice; the navigation's own position counts for one
//! at the start, and never again.
//!
//! One piece of ground for or against is the logarithm of how much more often right matches agree than wrong ones do, in units of
//! itself: places are hypotheses with equal steps of evidence, cut off at [`VOTES_MAX`] as memory is.

use super::reckoning::{Moment, way_m};
use crate::tile::Local;
use heapless::Vec;
use nalgebra::{Matrix2, Vector2};

/// Places at most.
const TRACKS: usize = 3;
/// Most that a place is worth: so many pieces of other ground, and one more, overrule it. Chosen: with a footprint of 140 m and
/// 25 m/s they take a quarter of a minute.
pub const VOTES_MAX: u8 = 4;
/// A match is believed where its place is worth as much.
pub const VOTES_MIN: u8 = 2;
/// A match belongs to a place within so many sigmas squared, of two degrees of freedom: normal errors lie beyond once in a hundred
/// thousand.
const GATE: f32 = 23.0;
/// Share of the smaller side of a footprint by which the next one has to lie beside it to be other ground.
const FRESH: f32 = 0.75;
/// Least sigma of a reported velocity, each axis, m/s: in a turn that of an autopilot without fixes was off by up to 5 m/s.
const VELOCITY_SIGMA_M_PER_S: f32 = 1.5;
/// Longest time between two frames over which places are carried on, microseconds: the velocity of both ends says no more.
const STEP_MAX_US: i32 = 10_000_000;

/// A match, as far as it concerns where the vehicle is.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Where it puts the nadir.
    pub nadir: Local,
    /// Covariance of that, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// Smaller side of the footprint, metres.
    pub side_m: f32,
}

/// A place.
#[derive(Clone, Copy, Debug)]
struct Track {
    /// Where it is now.
    nadir: Local,
    /// Covariance of the match that it rests on.
    covariance: Matrix2<f32>,
    /// What dead reckoning may be off since, one sigma of each axis, metres.
    drift_m: f32,
    /// The nadir over which it was counted last.
    counted_at: Local,
    votes: u8,
}

impl Track {
    fn new(sighting: &Sighting, votes: u8) -> Self {
        let Sighting { nadir, covariance, .. } = *sighting;
        Track { nadir, covariance, drift_m: 0.0, counted_at: nadir, votes }
    }

    /// How far a match is off, squared, in sigmas of both.
    fn off(&self, sighting: &Sighting) -> f32 {
        off(self.nadir, self.covariance, self.drift_m, sighting)
    }

    /// Whether a match shows other ground than the one that was counted last.
    fn is_fresh(&self, sighting: &Sighting) -> bool {
        self.counted_at.off_m(sighting.nadir) >= FRESH * sighting.side_m
    }
}

/// How far a match is off a place, squared, in sigmas of both; as far as can be where these are no numbers.
fn off(place: Local, covariance: Matrix2<f32>, drift_m: f32, sighting: &Sighting) -> f32 {
    let both = covariance + sighting.covariance + Matrix2::identity() * (drift_m * drift_m);
    let by = Vector2::new(sighting.nadir.east_m - place.east_m, sighting.nadir.north_m - place.north_m);
    let squared = both.try_inverse().map_or(f32::INFINITY, |inverse| (by.transpose() * inverse * by)[(0, 0)]);
    if squared >= 0.0 { squared } else { f32::INFINITY }
}

/// The places.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    tracks: Vec<Track, TRACKS>,
    /// The frame that all were carried on to.
    moment: Option<Moment>,
}

impl Tracks {
    /// Carries all of them on to a frame; those that may be further off than `reach_m` are forgotten. `sigma_m_per_s`: of the
    /// velocity, each axis.
    pub fn carry(&mut self, moment: Moment, sigma_m_per_s: f32, reach_m: f32) {
        let sigma_m_per_s = sigma_m_per_s.max(VELOCITY_SIGMA_M_PER_S);
        let Some(before) = self.moment.replace(moment) else { return };
        let step_us = moment.at.since(before.at);
        if !(0..=STEP_MAX_US).contains(&step_us) {
            self.tracks.clear();
        }
        let [east_m, north_m] = way_m(before, moment);
        self.tracks.retain_mut(|track| {
            track.nadir = Local { east_m: track.nadir.east_m + east_m, north_m: track.nadir.north_m + north_m };
            track.drift_m += sigma_m_per_s * step_us as f32 * 1e-6;
            track.drift_m <= reach_m
        });
    }

    /// Whether no place is known.
    pub fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// The place that counts, if one does.
    pub fn place(&self) -> Option<Local> {
        let (index, leader) = self.tracks.iter().enumerate().max_by_key(|(_, track)| track.votes)?;
        let is_beaten = |(other, track): (usize, &Track)| other != index && track.votes >= leader.votes;
        let counts = leader.votes >= VOTES_MIN && !self.tracks.iter().enumerate().any(is_beaten);
        counts.then_some(leader.nadir)
    }

    /// Begins anew where the vehicle has been found for certain.
    pub fn begin(&mut self, sighting: &Sighting) {
        self.tracks.clear();
        // There is room.
        let _ = self.tracks.push(Track::new(sighting, VOTES_MIN));
    }

    /// A match of the frame that all were carried on to. Whether it is to be believed. `prior`: the navigation's own place and one
    /// sigma of each axis, which counts where no place is known.
    pub fn matched(&mut self, sighting: &Sighting, prior: (Local, f32)) -> bool {
        let (place, sigma_m) = prior;
        if self.tracks.is_empty() && off(place, Matrix2::zeros(), sigma_m, sighting) <= GATE {
            self.begin(sighting);
            return true;
        }
        if self.tracks.is_empty() {
            // The navigation's word against the match's.
            let at = Sighting { nadir: place, covariance: Matrix2::identity() * (sigma_m * sigma_m), ..*sighting };
            let _ = self.tracks.push(Track::new(&at, 1));
        }
        let nearest = self.tracks.iter().map(|track| track.off(sighting)).enumerate();
        let nearest = nearest.min_by(|(_, one), (_, other)| one.total_cmp(other)).filter(|(_, off)| *off <= GATE);
        let Some((own, _)) = nearest else {
            self.begins_one(sighting);
            return false;
        };
        let is_fresh = self.tracks.get(own).is_some_and(|track| track.is_fresh(sighting));
        for (index, track) in self.tracks.iter_mut().enumerate() {
            if index == own {
                let (counted_at, votes) =
                    if is_fresh { (sighting.nadir, track.votes + 1) } else { (track.counted_at, track.votes) };
                *track = Track { counted_at, ..Track::new(sighting, votes.min(VOTES_MAX)) };
            } else if is_fresh {
                track.votes = track.votes.saturating_sub(1);
            }
        }
        let is_own = |place: Local| place == sighting.nadir;
        let is_believed = self.place().is_some_and(is_own);
        self.tracks.retain(|track| track.votes > 0);
        is_believed
    }

    /// A match that belongs to no place begins one, and speaks against all others where it shows other ground than they last had.
    fn begins_one(&mut self, sighting: &Sighting) {
        for track in &mut self.tracks {
            if track.is_fresh(sighting) {
                (track.votes, track.counted_at) = (track.votes.saturating_sub(1), sighting.nadir);
            }
        }
        self.tracks.retain(|track| track.votes > 0);
        if self.tracks.is_full() {
            let least = self.tracks.iter().enumerate().min_by_key(|(_, track)| track.votes).map(|(index, _)| index);
            least.map(|index| self.tracks.swap_remove(index));
        }
        let _ = self.tracks.push(Track::new(sighting, 1));
    }
}

#[cfg(test)]
mod tests;
