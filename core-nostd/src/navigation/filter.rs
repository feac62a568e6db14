//! How far attitude and velocity are off, by matches against the way flown between them.
//!
//! A Kalman filter of eight states: the position of the camera, the error of the reported velocity, the error of the attitude in
//! the vehicle's own axes, pitch and roll, and what of it wanders in the ground's. A match finds the nadir where the position is, less
//! what the attitude's error moves it; the reported velocity carries the position on. On a straight leg position and tilt cannot be told
//! apart: what the tilt moves the nadir by turns with the vehicle and the position does not, so that a turn tells them apart. An offset
//! of the map does not turn either: it stays in the position, and no match finds it.
//!
//! So the attitude that frames are rectified with is corrected by what turns have told, and the covariance of a fix holds what they
//! have not. A match that the filter did not expect is not explained: where it is believed all the same, the attitude may have
//! jumped as well as the position, and both are as uncertain as that from then on, until a turn tells or the attitude has jumped back
//! to what it was.
//!
//! A velocity is reported a few tenths of a second after its instant, and in a turn it is another one by then. So what is learnt of a
//! match waits for the velocities around it; until they come the position is reckoned on with the last acceleration.
//!
//! The filter's position is sent to nobody as a fix: it would be the same matches again.

mod found;
mod estimate;
mod alike;
mod judged;
mod jumps;
mod misalignment;
mod settle;
mod satellites;

use super::reckoning::{Moment, displacement_m};
use crate::math::{beside, hypot, sqrt, squared};
use crate::tile::Local;
use crate::units::Micros;
use estimate::{Estimate, parts_rad, unaided_m};
use found::white;
pub use found::{Found, Unknown};
use heapless::Deque;
use judged::{Judged, TRANSIENT_MAX_RAD, Without};
use jumps::{Jumps, LEARNT_SIGMAS};
use misalignment::Misalignment;
use nalgebra::{Matrix2, Vector2};
pub use satellites::SatellitePosition;
use satellites::{Moved, Satellites};

/// Time constant by which a tilt is forgotten that comes and goes, seconds. Chosen: half of the period of 20 s with which a vehicle rocks
/// slowly, within which the swing of an attitude that is late or scaled has gone on to the other side.
const TRANSIENT_S: f32 = 10.0;
/// And where the velocity is so uncertain that a swing may pass for its error: a swing and a half. Chosen.
const HIDDEN_S: f32 = 3.0 * TRANSIENT_S;
/// One sigma of the velocity from which on that is so, each axis, m/s. Chosen: a swing of five degrees 120 m up moves a match by twice as much.
const HIDDEN_M_PER_S: f32 = 1.5;
/// Longest way between two reported velocities, and beyond the newest, microseconds: beyond the filter begins anew.
const STEP_MAX_US: i32 = 9_000_000;
/// One sigma of how fast an acceleration changes, m/s³: beyond the newest velocity that was reported the last acceleration goes on.
/// Chosen: a vehicle that banks by 45 degrees within two seconds.
const JERK_M_PER_S3: f32 = 5.0;
/// Beyond so much a change of the velocity is no motion: the estimator has thrown its velocity over, m/s². Chosen: a turn banked by
/// 57 degrees.
const ACCELERATION_MAX_M_PER_S2: f32 = 15.0;
/// Matches that wait for the velocity at their instant. Chosen: frames ten times a second, and a velocity that comes up to 0.6 s late.
const WAITING: usize = 8;
/// Innovations squared, in sigmas, of two degrees of freedom: beyond the first once in a hundred the tilt comes and goes, beyond the
/// second once in a hundred thousand something has jumped.
const TRANSIENT: f32 = 9.2;
const JUMP: f32 = 23.0;
/// Known no better than this a velocity is one that nobody reports, one sigma of each axis, m/s: more was not seen of an autopilot.
const KNOWN_M_PER_S: f32 = 5.0;

/// The filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The newest velocity that was reported, and the acceleration to it from the one before, m/s².
    reported: Moment,
    acceleration: [f32; 2],
    /// At that instant, with all matches before it.
    settled: Option<Estimate>,
    /// Matches since with their frames' instants, oldest first.
    waiting: Deque<(Micros, Found), WAITING>,
    /// The newest frame, and the estimate there with all matches.
    moment: Moment,
    newest: Option<Estimate>,
    /// The newest frame with a match, and what was expected there.
    matched_at: Micros,
    without: Option<Without>,
    /// One sigma of a tilt that comes and goes, and that matches have shown, radians, and when it began to.
    transient_rad: f32,
    swung_at: Micros,
    /// What it was before.
    swung_rad: f32,
    jumps: Jumps,
    misalignment: Misalignment,
    /// What satellite navigation says beside the matches, and by how much pitch and roll are off by that at the newest frame, radians.
    satellites: Satellites,
    by_satellites_rad: Option<[f32; 2]>,
}

impl Filter {
    /// Nothing known.
    pub const fn new() -> Self {
        let moment = Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] };
        Filter {
            reported: moment,
            acceleration: [0.0; 2],
            settled: None,
            waiting: Deque::new(),
            moment,
            newest: None,
            matched_at: moment.at,
            without: None,
            transient_rad: 0.0,
            swung_at: moment.at,
            swung_rad: 0.0,
            jumps: Jumps::new(),
            misalignment: Misalignment::new(),
            satellites: Satellites::new(),
            by_satellites_rad: None,
        }
    }

    /// Error of pitch and roll that is known, radians: what is reported less what is true.
    pub fn tilt_rad(&self) -> [f32; 2] {
        let [pitch, roll] = self.matched_tilt_rad();
        self.by_satellites_rad.map_or([pitch, roll], |[more, aside]| [pitch + more, roll + aside])
    }

    /// What matches alone know of it.
    fn matched_tilt_rad(&self) -> [f32; 2] {
        self.newest.map_or([0.0; 2], |estimate| estimate.tilt_rad())
    }

    /// By how far satellite navigation disagrees with the map, metres, where it does.
    pub fn disagreement_m(&self) -> Option<f32> {
        self.satellites.disagreement_m()
    }

    /// A position of satellite navigation: it counts with the next reported velocity.
    pub fn satellites(&mut self, position: SatellitePosition) {
        self.satellites.heard(position);
    }

    /// One sigma of each of the tilts that matches have shown lately and nothing explains, radians: one that comes and goes, or what
    /// is left of a jump that neither has been taken back nor a turn has told.
    pub fn unexplained_rad(&self, unknown: &Unknown) -> f32 {
        let shown_rad = sqrt((squared(self.shown_rad(unknown)) - squared(unknown.sigma_rad())).max(0.0));
        let unproven_rad = self.jumps.unproven_rad(self.moment.at);
        // One tilt, of which all of these say the same.
        let open_rad = shown_rad.max(unproven_rad);
        if self.sees_swings() {
            return open_rad;
        }
        // What has jumped may be anything, and what was learnt may have gone as it came.
        let [pitch, roll] = self.matched_tilt_rad();
        let learnt_rad = Some(hypot(pitch, roll)).filter(|learnt_rad| *learnt_rad > LEARNT_SIGMAS * unknown.tilt_rad);
        open_rad.max(if unproven_rad > 0.0 { TRANSIENT_MAX_RAD } else { 0.0 }).max(learnt_rad.unwrap_or(0.0))
    }

    /// One sigma of pitch's and roll's error that is left of it, the larger one, by matches alone, radians: what wanders is in it as if
    /// nothing were known of that, since no frame is rectified with it.
    pub fn tilt_sigma_rad(&self, unknown: &Unknown) -> f32 {
        beside(self.shown_rad(unknown), self.misalignment.doubt_rad())
    }

    /// That without what a misalignment may be.
    fn shown_rad(&self, unknown: &Unknown) -> f32 {
        let [_, wander_rad] = parts_rad(unknown);
        let known_rad =
            self.newest.map_or(unknown.sigma_rad(), |estimate| hypot(estimate.tilt_sigma_rad(), wander_rad));
        hypot(known_rad, self.transient_rad)
    }

    /// By how much the reported velocity is off to the east and to the north, m/s, each with its variance; nothing before the first match.
    pub fn velocity_error(&self) -> Option<[(f32, f32); 2]> {
        self.newest.map(|estimate| estimate.velocity())
    }

    /// Where the camera is at the newest frame, and the covariance of that, square metres; nothing before the first match.
    pub fn position(&self) -> Option<(Local, Matrix2<f32>)> {
        let (local, covariance) = self.newest?.position();
        Some((local, covariance + self.misalignment.doubt_m2()))
    }

    /// How far east and north of that it would be without the newest match, and the covariance there; nothing where that match began
    /// the estimate.
    pub fn without(&self) -> Option<(Vector2<f32>, Matrix2<f32>)> {
        let (_, covariance) = self.position()?;
        self.without.map(|without| (without.off_m, covariance + without.larger))
    }

    /// A velocity was reported: what was reckoned beyond the one before is reckoned anew.
    pub fn reported(&mut self, moment: Moment, unknown: &Unknown) {
        let before = core::mem::replace(&mut self.reported, moment);
        let step_us = moment.at.since(before.at);
        if !(1..=STEP_MAX_US).contains(&step_us) {
            return self.begin_anew(moment);
        }
        let seconds = step_us as f32 * 1e-6;
        let change = core::array::from_fn(|axis| moment.velocity_m_per_s[axis] - before.velocity_m_per_s[axis]);
        let is_thrown = hypot(change[0], change[1]) > ACCELERATION_MAX_M_PER_S2 * seconds;
        self.acceleration = if is_thrown { [0.0; 2] } else { change.map(|change| change / seconds) };
        self.transient_rad /= 1.0 + seconds / if self.sees_swings() { TRANSIENT_S } else { HIDDEN_S };
        let usual_rad = self.jumps.usual_rad();
        if let Some(settled) = &mut self.settled {
            if is_thrown {
                settled.doubt_velocity(change);
                self.satellites.doubt_velocity(change);
            }
            let beside_m = unaided_m(self.matched_at, moment.at, seconds);
            settled.propagate((before, moment), beside_m, usual_rad, unknown);
            self.misalignment.propagate(seconds, usual_rad.is_some());
            self.satellites.propagate((before, moment), beside_m, usual_rad, unknown);
        }
        while self.waiting.front().is_some_and(|(at, _)| *at <= moment.at) {
            self.settle_oldest(unknown);
        }
        self.find_misalignment();
        if let Some(settled) = &self.settled {
            self.jumps.known(moment.at, settled, unknown);
        }
        if self.settled.is_some_and(|settled| !settled.is_sound()) {
            self.begin_anew(moment);
        }
        self.take_satellites();
        (self.moment, self.newest) = (moment, self.settled);
        for index in 0..self.waiting.len() {
            let Some((at, found)) = self.waiting.iter().nth(index).copied() else { break };
            self.carry_on(at, unknown);
            let counted = self.counted(&found);
            self.newest = self.newest.map(|newest| newest.with(&newest.innovation(&found, counted)));
        }
    }

    /// What is reported may not be so: all begins anew with the next velocity.
    pub fn forget(&mut self) {
        self.begin_anew(self.reported);
    }

    /// Nothing is known but the newest velocity, and what satellites say of the map.
    fn begin_anew(&mut self, moment: Moment) {
        // In its place: built anew it would lie on the stack as well.
        (self.acceleration, self.moment, self.matched_at) = ([0.0; 2], moment, Micros(0));
        (self.settled, self.newest, self.without) = (None, None, None);
        self.waiting.clear();
        (self.transient_rad, self.jumps, self.by_satellites_rad) = (0.0, Jumps::new(), None);
        self.misalignment = Misalignment::new();
        self.satellites.end();
    }

    /// The position of satellites that waits, where the newest velocity is not before it, moved there by what is known of the way.
    fn take_satellites(&mut self) {
        if let (Some(settled), Some(position)) = (self.settled, self.satellites.due(self.reported.at)) {
            let (apart_s, [east, north]) = (self.reported.at.since(position.at) as f32 * 1e-6, settled.velocity());
            let local = position
                .local
                .moved(displacement_m(self.reckoned(position.at), self.reported))
                .moved([-east.0 * apart_s, -north.0 * apart_s]);
            let position = SatellitePosition { local, ..position };
            let variance = squared(apart_s) * east.1.max(north.1);
            self.satellites.take(&Moved { position, moment: self.reported, variance }, &settled);
        }
        self.satellites.settle(self.settled.as_ref());
    }

    /// Carries it on to a frame, whose attitude is corrected by what is known of the tilt from here on.
    pub fn propagate(&mut self, at: Micros, unknown: &Unknown) {
        self.by_satellites_rad = self.satellites.tilt_rad();
        self.carry_on(at, unknown);
    }

    fn carry_on(&mut self, at: Micros, unknown: &Unknown) {
        let moment = self.reckoned(at);
        let before = core::mem::replace(&mut self.moment, moment);
        let late_us = at.since(self.reported.at);
        if late_us > STEP_MAX_US {
            self.begin_anew(moment);
        }
        let usual_rad = self.jumps.usual_rad();
        let Some(newest) = &mut self.newest else { return };
        let seconds = at.since(before.at) as f32 * 1e-6;
        if seconds < 0.0 {
            newest.back(displacement_m(moment, before), -seconds);
        } else {
            let late_m = 0.5 * JERK_M_PER_S3 * squared(late_us.max(0) as f32 * 1e-6) * seconds;
            let beside_m = hypot(late_m, unaided_m(self.matched_at, at, seconds));
            newest.propagate((before, moment), beside_m, usual_rad, unknown);
        }
    }

    /// A match of the frame that it was carried on to, which is believed; `overruled_m`: how far it is from the place that counted before,
    /// where it has overruled that, as a tilt of the vehicle's would have it at this heading, east and north. One sigma of a tilt, radians,
    /// by which its fix is more uncertain than was known before: 0 for a match that was expected.
    pub fn matched(&mut self, found: &Found, overruled_m: Option<[f32; 2]>, unknown: &Unknown) -> f32 {
        let before = core::mem::replace(&mut self.matched_at, self.moment.at);
        let judged = match (overruled_m, self.newest) {
            (Some(aside), _) => Judged::Jumped(aside.into()),
            (None, None) => return self.begin(found, unknown),
            (None, Some(newest)) if self.jumps.is_jumping(self.moment.at) => {
                Judged::Jumped(newest.innovation(found, self.white(found)).off)
            }
            (None, Some(newest)) => {
                let plain = newest.innovation(found, white(found, 0.0));
                match self.jumps.back_by((self.moment.at, before), &newest, (found, &plain), unknown) {
                    Some(off) => Judged::Jumped(off),
                    None => self.judged(self.moment.at, &newest, (found, &plain), unknown),
                }
            }
        };
        match judged {
            Judged::Jumped(off) => {
                let known_rad = self.tilt_sigma_rad(unknown);
                let known = (self.matched_tilt_rad(), self.newest);
                let begun = self.jumps.jumped((self.moment.at, before, off), known, found, unknown);
                let begun_unknown = Unknown { tilt_rad: begun.sigma_rad, ..*unknown };
                self.begin(&begun.found, &begun_unknown);
                let more_rad = sqrt((squared(begun_unknown.sigma_rad()) - squared(known_rad)).max(0.0));
                hypot(more_rad, begun.off_rad)
            }
            Judged::Expected { estimate: newest, more_rad, .. } => {
                self.jumps.followed(&newest, found);
                self.jumps.swung(self.moment.at, more_rad);
                self.without = self.newest.map(|expected| Without::new(&expected, &newest));
                self.newest = Some(newest);
                if self.waiting.is_full() {
                    self.settle_oldest(unknown);
                }
                // There is room.
                let _ = self.waiting.push_back((self.moment.at, *found));
                more_rad
            }
        }
    }

    /// The velocity at an instant near the newest that was reported, carried on by the acceleration between the last two: in a turn
    /// the newest alone lags behind by what the vehicle has turned since.
    pub fn reckoned(&self, at: Micros) -> Moment {
        let seconds = at.since(self.reported.at) as f32 * 1e-6;
        let velocity = |axis: usize| self.reported.velocity_m_per_s[axis] + self.acceleration[axis] * seconds;
        Moment { at, velocity_m_per_s: core::array::from_fn(velocity) }
    }

    fn white(&self, found: &Found) -> Matrix2<f32> {
        white(found, self.transient_rad)
    }

    /// From a match on; nothing of it was expected.
    fn begin(&mut self, found: &Found, unknown: &Unknown) -> f32 {
        let white = self.white(found);
        let back = displacement_m(self.moment, self.reported);
        let apart_s = self.moment.at.since(self.reported.at) as f32 * 1e-6;
        let less = Matrix2::identity() * squared(unknown.velocity_m_per_s * apart_s);
        self.newest = Some(Estimate::begun(found, white, unknown));
        let settled = Estimate::begun(&found.moved(back), white + less, unknown);
        self.satellites.begun(&settled);
        self.settled = Some(settled);
        self.misalignment.begun(found);
        self.without = None;
        self.waiting.clear();
        0.0
    }

    /// Whether a tilt that swings would lie outside what is expected.
    fn sees_swings(&self) -> bool {
        self.newest
            .is_none_or(|newest| newest.velocity().iter().all(|(_, variance)| *variance <= squared(HIDDEN_M_PER_S)))
    }
}

impl Default for Filter {
    fn default() -> Self {
        Filter::new()
    }
}

#[cfg(test)]
mod tests;
