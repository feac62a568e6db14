//! Places where the vehicle may be, and which of them counts.
//!
//! A match that is wrong is mostly far off: a picture that repeats, or ground that has changed, puts it anywhere in the search. So
//! each place is carried on by the velocity, and a match belongs to the place that it lies at, or begins one of its own. What a place
//! is worth is the number of pieces of ground that have spoken for it less those that have spoken for others: matches over the same
//! ground count once, since whatever fools one of them fools them all (parcels of 40 m side by side agree for ever). Ground is told
//! apart by the way flown, not by where matches lie. A match is believed where its place is worth [`VOTES_MIN`], and more than every
//! other.
//!
//! Vehicles that stand over one piece of ground gather no votes: where the first place was wrong, they have no fix until it is
//! forgotten.

use super::protection::larger_sigma_m;
use super::reckoning::{JUMPING_US, Moment, way_m};
use crate::math::{hypot, ln, sin_cos, sqrt};
use crate::tile::Local;
use crate::units::Micros;
use core::cmp::Ordering;
use heapless::Vec;
use nalgebra::{Matrix2, Vector2};

/// Places at most. Chosen: the one that counts, one that contradicts it, and one more.
const TRACKS: usize = 3;
/// Most that a place is worth. Each piece of other ground takes one and gives one, so that three overrule it. Chosen: with a footprint
/// of 140 m and 25 m/s they take some ten seconds.
pub const VOTES_MAX: u8 = 4;
/// A match is believed where its place is worth as much: what begins a place that counts, and one piece of ground more than any
/// contradiction.
pub const VOTES_MIN: u8 = 2;
/// A match belongs to a place within so many sigmas squared, of two degrees of freedom: normal errors lie beyond once in a hundred
/// thousand.
pub const GATE: f32 = 23.0;
/// Share of the smaller side of a footprint by which the vehicle has to go on for other ground. Chosen: a quarter is seen twice.
const FRESH: f32 = 0.75;
/// And by which a place has moved that was contradicted meanwhile. Chosen: what is called a wrong match is 3 pixels off, of 35.
const MOVED: f32 = 0.1;
/// Least sigma of a reported velocity, each axis, m/s: within the gate it is what was seen of an autopilot without fixes in a turn,
/// 5 m/s on both axes.
const VELOCITY_SIGMA_M_PER_S: f32 = 1.5;
/// Longest time between two frames over which places are carried on, microseconds: half a circle at 20 degrees a second, up to which
/// [`TURN_SHARE`] holds.
const STEP_MAX_US: i32 = 9_000_000;
/// What the mean of two velocities is off at most, as a share of their difference, in turns of up to half a circle.
const TURN_SHARE: f32 = 0.35;
/// A place is doubtful where the gate around it reaches over so much of the search: it would take in what is found by chance.
const DOUBTFUL: f32 = 0.5;
/// There a match counts all the same within this share of the search. Chosen: of what is found by chance one in twenty lies there.
const NEAR: f32 = 0.25;

/// Behind a match that contradicts those before, frames have no fix for so long, microseconds: a match that the directions confirm is wrong
/// once in 23,000 times, so that it is rather the attitude that is off, and swings through what is expected. Chosen: four frames.
const CALM_US: i32 = 1_000_000;

/// A match, as far as it concerns where the vehicle is.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Where it puts the nadir.
    pub nadir: Local,
    /// Covariance of that, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// That covariance without the part of the tilt's drift, which the next frame shares.
    pub white: Matrix2<f32>,
    /// Smaller side of the footprint, metres.
    pub side_m: f32,
    /// Heading, clockwise from grid north, radians.
    pub heading_rad: f32,
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
    /// The way flown when ground spoke for it last, and when some spoke against it.
    counted_at: Local,
    doubted_at: Local,
    votes: u8,
    begun: Begun,
}

/// How far a place is from the one that counted before, as it began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aside {
    /// East and north, metres.
    pub by_m: [f32; 2],
    /// Heading of the vehicle then, clockwise from grid north, radians.
    pub heading_rad: f32,
}

impl Aside {
    /// As it would be if it had turned with the vehicle to such a heading, metres east and north.
    pub fn turned_to(&self, heading_rad: f32) -> [f32; 2] {
        let (sin, cos) = sin_cos(heading_rad - self.heading_rad);
        let [east, north] = self.by_m;
        [east * cos + north * sin, north * cos - east * sin]
    }
}

/// When a place was seen first.
#[derive(Clone, Copy, Debug)]
struct Begun {
    at: Micros,
    aside: Option<Aside>,
}

impl Track {
    fn new(sighting: &Sighting, gone: Local, votes: u8, begun: Begun) -> Self {
        let Sighting { nadir, covariance, .. } = *sighting;
        Track { nadir, covariance, drift_m: 0.0, counted_at: gone, doubted_at: gone, votes, begun }
    }

    /// A piece of ground speaks against it, once.
    fn doubt(&mut self, gone: Local, fresh_m: f32) {
        if self.doubted_at.off_m(gone) >= fresh_m {
            (self.votes, self.doubted_at) = (self.votes.saturating_sub(1), gone);
        }
    }
}

/// How far a match is off a place, squared, in sigmas of both, and the logarithm of what these cover; as far as can be where they
/// are no numbers.
fn off(place: Local, covariance: Matrix2<f32>, drift_m: f32, sighting: &Sighting) -> (f32, f32) {
    let both = covariance + sighting.covariance + Matrix2::identity() * (drift_m * drift_m);
    let by = Vector2::new(sighting.nadir.east_m - place.east_m, sighting.nadir.north_m - place.north_m);
    let squared = both.try_inverse().map_or(f32::INFINITY, |inverse| (by.transpose() * inverse * by)[(0, 0)]);
    let spread = both.determinant();
    if squared >= 0.0 && spread > 0.0 { (squared, ln(spread)) } else { (f32::INFINITY, 0.0) }
}

impl Sighting {
    /// Whether it lies at a place with its covariance, and one sigma beside, each axis, within [`GATE`].
    pub fn agrees(&self, (place, covariance): (Local, Matrix2<f32>), drift_m: f32) -> bool {
        off(place, covariance, drift_m, self).0 <= GATE
    }

    fn aside(&self, from: Local) -> Aside {
        let by_m = [self.nadir.east_m - from.east_m, self.nadir.north_m - from.north_m];
        Aside { by_m, heading_rad: self.heading_rad }
    }

    fn is_finite(&self) -> bool {
        self.nadir.east_m.is_finite() && self.nadir.north_m.is_finite() && self.covariance.iter().all(|c| c.is_finite())
    }
}

/// What dead reckoning is off by after so long, one sigma of each axis, metres. `sigma_m_per_s`: of the velocity.
pub fn drift_m(sigma_m_per_s: f32, age_us: i32) -> f32 {
    sigma_m_per_s.max(VELOCITY_SIGMA_M_PER_S) * age_us as f32 * 1e-6
}

/// The places.
#[derive(Clone, Debug)]
pub struct Tracks {
    tracks: Vec<Track, TRACKS, u8>,
    /// The frame that all were carried on to, at first power-on, and the way to it by the velocities.
    moment: Moment,
    gone: Local,
    /// A place has been known before.
    was_known: bool,
    /// The last place that counted, when it did, and how far from it the place began that the newest match has made count in its stead.
    led: Option<Local>,
    led_at: Micros,
    overruled: Option<Aside>,
    /// When a match contradicted those before.
    contradicted_at: Option<Micros>,
}

impl Default for Tracks {
    fn default() -> Self {
        Tracks::new()
    }
}

impl Tracks {
    /// None.
    pub const fn new() -> Self {
        let origin = Local { east_m: 0.0, north_m: 0.0 };
        let moment = Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] };
        Tracks {
            tracks: Vec::new(),
            moment,
            gone: origin,
            was_known: false,
            led: None,
            led_at: Micros(0),
            overruled: None,
            contradicted_at: None,
        }
    }

    /// Carries all of them on to a frame; those that may be further off than `reach_m` are forgotten. `sigma_m_per_s`: of the
    /// velocity, each axis.
    pub fn carry(&mut self, moment: Moment, sigma_m_per_s: f32, reach_m: f32) {
        let before = core::mem::replace(&mut self.moment, moment);
        let step_us = moment.at.since(before.at);
        if !(0..=STEP_MAX_US).contains(&step_us) {
            // Whoever takes so few frames has the navigation alone.
            self.tracks.clear();
            (self.was_known, self.led) = (false, None);
        }
        let way = way_m(before, moment);
        let [east, north] = moment.velocity_m_per_s;
        let turned = hypot(east - before.velocity_m_per_s[0], north - before.velocity_m_per_s[1]);
        let drift_m = drift_m(sigma_m_per_s, step_us) + TURN_SHARE * turned * step_us as f32 * 1e-6;
        self.gone = self.gone.moved(way);
        self.led = self.led.map(|led| led.moved(way));
        self.overruled = None;
        self.tracks.retain_mut(|track| {
            track.nadir = track.nadir.moved(way);
            track.drift_m += drift_m;
            track.drift_m <= reach_m
        });
    }

    /// The place that counts, if one does.
    pub fn place(&self) -> Option<Local> {
        self.leader().map(|leader| leader.nadir)
    }

    fn leader(&self) -> Option<&Track> {
        let (index, leader) = self.tracks.iter().enumerate().max_by_key(|(_, track)| track.votes)?;
        let is_beaten = |(other, track): (usize, &Track)| other != index && track.votes >= leader.votes;
        let counts = leader.votes >= VOTES_MIN && !self.tracks.iter().enumerate().any(is_beaten);
        counts.then_some(leader)
    }

    /// The other places where the vehicle may be, with the larger sigma of each, metres.
    pub fn others(&self) -> impl Iterator<Item = (Local, f32)> + '_ {
        let counts = self.place();
        let others = self.tracks.iter().filter(move |track| counts != Some(track.nadir));
        others.map(|track| (track.nadir, hypot(larger_sigma_m(&track.covariance), track.drift_m)))
    }

    /// A match of the newest frame contradicts those before.
    pub fn contradicted(&mut self) {
        self.contradicted_at = Some(self.moment.at);
    }

    /// Whether none has lately.
    pub fn is_calm(&self) -> bool {
        self.contradicted_at.is_none_or(|at| !(0..CALM_US).contains(&self.moment.at.since(at)))
    }

    /// Whether no place is known.
    pub fn is_empty(&self) -> bool {
        self.tracks.is_empty()
    }

    /// Whether a match has to be found again before it counts: the place that counts may be anywhere in half of the search and
    /// the match does not lie near it, or the place has been forgotten.
    pub fn is_doubtful(&self, nadir: Local, reach_m: f32) -> bool {
        let reaches = |leader: &Track| sqrt(GATE) * leader.drift_m > DOUBTFUL * reach_m;
        let is_off = |leader: &Track| leader.nadir.off_m(nadir) > NEAR * reach_m;
        if self.tracks.is_empty() {
            self.was_known
        } else {
            self.leader().is_some_and(|leader| reaches(leader) && is_off(leader))
        }
    }

    /// How far from the place that counted before another one began that the match of the newest frame has made count in its stead. Later
    /// they drift apart by what the velocity is off.
    pub fn overruled(&self) -> Option<Aside> {
        self.overruled
    }

    /// Begins anew where the vehicle has been found twice, or where the navigation expected it.
    pub fn begin(&mut self, sighting: &Sighting) {
        (self.was_known, self.led, self.led_at) = (true, Some(sighting.nadir), self.moment.at);
        self.tracks.clear();
        // There is room.
        let begun = Begun { at: self.moment.at, aside: None };
        let _ = self.tracks.push(Track::new(sighting, self.gone, VOTES_MIN, begun));
    }

    /// How a place began that a match belongs to, or begins. One that was there when a place counted last tells nothing of how far the match is
    /// from that: it may be the same one, which a match far off belongs to after a while without any.
    fn begun(&self, own: Option<&Track>, sighting: &Sighting) -> Begun {
        let at = own.map_or(self.moment.at, |own| own.begun.at);
        let is_beginning = self.moment.at.since(at) < JUMPING_US || self.led_at.since(at) >= 0;
        let known = own.and_then(|own| own.begun.aside).filter(|_| !is_beginning);
        Begun { at, aside: known.or_else(|| self.led.map(|led| sighting.aside(led))) }
    }

    /// Takes one out.
    fn taken(&mut self, index: usize) -> Option<Track> {
        let track = self.tracks.get(index).copied()?;
        let mut at = 0..;
        self.tracks.retain(|_| at.next() != Some(index));
        Some(track)
    }

    /// A match of the frame that all were carried on to, while places are known. Whether it is to be believed.
    pub fn matched(&mut self, sighting: &Sighting) -> bool {
        if !sighting.is_finite() {
            return false;
        }
        let (gone, fresh_m) = (self.gone, FRESH * sighting.side_m);
        let offs = self.tracks.iter().map(|track| off(track.nadir, track.covariance, track.drift_m, sighting));
        // The most likely one: of two at the same distance in sigmas that with the smaller ones.
        let likely = offs.enumerate().filter(|(_, (squared, _))| *squared <= GATE);
        let nearest = likely.min_by(|(_, one), (_, other)| (one.0 + one.1).total_cmp(&(other.0 + other.1)));
        let counted = self.place();
        let own = nearest.and_then(|(index, _)| self.taken(index));
        let is_news = own.is_none_or(|own| counted != Some(own.nadir));
        let counted_at = own.map(|own| own.counted_at);
        let is_fresh = counted_at.is_none_or(|at| at.off_m(gone) >= fresh_m);
        let begun = self.begun(own.as_ref(), sighting);
        let own = own.unwrap_or(Track::new(sighting, gone, 0, begun));
        let (counted_at, votes) = if is_fresh { (gone, own.votes + 1) } else { (own.counted_at, own.votes) };
        let votes = votes.min(VOTES_MAX);
        let own = Track { counted_at, doubted_at: own.doubted_at, ..Track::new(sighting, gone, votes, begun) };
        // Others at the same place are the same one.
        self.tracks.retain(|track| !sighting.agrees((track.nadir, track.covariance), 0.0));
        self.tracks.iter_mut().for_each(|track| track.doubt(gone, fresh_m));
        self.tracks.retain(|track| track.votes > 0);
        if self.tracks.is_full() {
            let worth = |track: &Track| (track.votes, -track.drift_m);
            let less = |one: &Track, other: &Track| worth(one).partial_cmp(&worth(other)).unwrap_or(Ordering::Equal);
            let least = self.tracks.iter().enumerate().min_by(|(_, one), (_, other)| less(one, other));
            least.map(|(index, _)| index).and_then(|index| self.taken(index));
        }
        // There is room.
        let _ = self.tracks.push(own);
        let counts = self.place() == Some(sighting.nadir);
        if counts {
            let led_at = core::mem::replace(&mut self.led_at, self.moment.at);
            let was_contradicted = self.contradicted_at.is_some_and(|at| at.since(led_at) > 0);
            let led = self.led.replace(sighting.nadir);
            // What the way since may explain is where others were that did not count.
            let has_moved = |led: &Local| was_contradicted && sighting.nadir.off_m(*led) > MOVED * sighting.side_m;
            let aside = |led: Local| sighting.aside(led);
            self.overruled = match is_news {
                true => led.map(|led| begun.aside.unwrap_or(aside(led))),
                false => led.filter(has_moved).map(aside),
            };
        }
        counts
    }
}

#[cfg(test)]
mod tests;
