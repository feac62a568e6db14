//! Kalman filter for the errors of attitude and velocity, from matches and the reported velocity.
//!
//! Eight states: position of the camera; error of the reported velocity; constant error of the attitude in the
//! vehicle's axes, pitch and roll (tilt); its wandering error in the ground's axes (wander). A match measures the
//! nadir, which is the position displaced by the attitude's error. The reported velocity propagates the position. On a
//! straight leg position and tilt are not observable separately; in a turn they are, since the tilt's displacement
//! turns with the vehicle. A constant offset of the map does not turn either: it stays in the position and is not
//! observable.
//!
//! Frames are rectified with the attitude corrected by the estimated tilt, and the covariance of a fix contains what is
//! left of it. A match beyond the gate is unexplained: if it is accepted all the same, position and attitude may both
//! have jumped. Both get that uncertainty until a turn separates them, the attitude has jumped back, or pictures show the
//! tilt.
//!
//! A velocity arrives a few tenths of a second after its instant, and in a turn it has changed by then. So a match
//! waits for the velocities around it; until they come the position is extrapolated with the last acceleration.
//!
//! The filter's position is never sent as a fix: it would use the same matches again.

mod measurement;
mod estimate;
mod correlated;
mod innovation_test;
mod jumps;
mod misalignment;
mod settle;
mod interruption;
mod satellites;
mod resection;
mod resections;

use super::reckoning::{Moment, displacement_m};
use crate::math::{combined_sigma, hypot, sqrt, squared};
use crate::tile::Local;
use crate::units::Micros;
use estimate::{Estimate, part_sigmas_rad, unaided_m};
use heapless::Deque;
use innovation_test::{Outcome, Prediction, TRANSIENT_MAX_RAD};
use jumps::{Jumps, LEARNT_SIGMAS};
use measurement::white;
pub use measurement::{Measurement, PriorSigmas};
use misalignment::Misalignment;
use nalgebra::{Matrix2, Vector2};
pub use resection::Resected;
use resections::Resections;
pub use satellites::SatellitePosition;
use satellites::{Moved, Satellites};

/// Time constant by which a transient tilt that matches have shown decays, seconds. Chosen: half of the period of 20 s
/// with which a vehicle rocks slowly, within which the swing of a late or scaled attitude has changed its sign.
const TRANSIENT_S: f32 = 10.0;
/// Its value while the velocity is so uncertain that its error may hide a swing: one and a half periods. Chosen.
const HIDDEN_S: f32 = 3.0 * TRANSIENT_S;
/// Sigma of the velocity above which that is so, each axis, m/s. Chosen: a swing of five degrees 120 m up moves a match
/// by twice as much.
const HIDDEN_M_PER_S: f32 = 1.5;
/// Longest interval between two reported velocities, and longest extrapolation beyond the newest, microseconds; after a
/// longer one the filter is reset.
const STEP_MAX_US: i32 = 9_000_000;
/// Jerk, one sigma, m/s³: beyond the newest reported velocity the last acceleration is held. Chosen: a vehicle that
/// banks by 45 degrees within two seconds.
const JERK_M_PER_S3: f32 = 5.0;
/// Largest acceleration between reported velocities, m/s²: more is a reset of the autopilot's estimator, not motion.
/// Chosen: a turn banked by 57 degrees.
const ACCELERATION_MAX_M_PER_S2: f32 = 15.0;
/// Matches that wait for the velocity at their instant. Chosen: ten frames a second, and a velocity up to 0.6 s late.
const PENDING_MAX: usize = 8;
/// Gate of the squared normalised innovation, two degrees of freedom. Normal errors exceed it once in a hundred: then the tilt has a
/// transient error.
pub const TRANSIENT_GATE: f32 = 9.2;
/// Likewise once in a hundred thousand: then something has jumped.
pub const JUMP_GATE: f32 = 23.0;
/// Largest sigma of a velocity that counts as reported, each axis, m/s: no larger error was seen of an autopilot.
const VELOCITY_KNOWN_M_PER_S: f32 = 5.0;

/// The Kalman filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The newest reported velocity, and the mean acceleration since the one before, m/s².
    reported: Moment,
    acceleration: [f32; 2],
    /// Estimate at that instant, with all matches up to it.
    settled: Option<Estimate>,
    /// Matches since, with the instants of their frames, oldest first.
    pending: Deque<(Micros, Measurement), PENDING_MAX>,
    /// The newest frame's moment, and the estimate there with all matches.
    moment: Moment,
    newest: Option<Estimate>,
    /// The newest frame with a match, and the prediction there.
    matched_at: Micros,
    prediction: Option<Prediction>,
    /// Sigma of the transient tilt that matches have shown, radians, and when it began.
    transient_rad: f32,
    swing_at: Micros,
    /// The sigma before that.
    before_swing_rad: f32,
    jumps: Jumps,
    /// Another tilt than the estimated one that the newest frame is corrected for, pitch and roll, radians.
    tried_rad: Option<[f32; 2]>,
    /// Position and tilt by matches and their pictures while the attitude is in doubt or checked.
    resections: Resections,
    misalignment: Misalignment,
    /// What a reset has left of the tilt until the next match: the estimate, pitch and roll, and its larger sigma, radians.
    kept_tilt: Option<([f32; 2], f32)>,
    /// Satellite navigation beside the matches, and its correction of pitch and roll at the newest frame, radians.
    satellites: Satellites,
    satellite_tilt_rad: Option<[f32; 2]>,
}

impl Filter {
    /// Without any information.
    pub const fn new() -> Self {
        let moment = Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] };
        Filter {
            reported: moment,
            acceleration: [0.0; 2],
            settled: None,
            pending: Deque::new(),
            moment,
            newest: None,
            matched_at: moment.at,
            prediction: None,
            transient_rad: 0.0,
            swing_at: moment.at,
            before_swing_rad: 0.0,
            jumps: Jumps::new(),
            tried_rad: None,
            resections: Resections::new(),
            misalignment: Misalignment::new(),
            kept_tilt: None,
            satellites: Satellites::new(),
            satellite_tilt_rad: None,
        }
    }

    /// Error of pitch and roll to correct the newest frame for, reported less true, radians: the estimated one, or
    /// another ([`Filter::try_other_tilt`]).
    pub fn tilt_rad(&self) -> [f32; 2] {
        let [pitch, roll] = self.tried_rad.unwrap_or(self.matched_tilt_rad());
        self.satellite_tilt_rad.map_or([pitch, roll], |[more, aside]| [pitch + more, roll + aside])
    }

    /// That error from matches alone.
    fn matched_tilt_rad(&self) -> [f32; 2] {
        let kept_rad = self.kept_tilt.map_or([0.0; 2], |(kept_rad, _)| kept_rad);
        self.newest.map_or(kept_rad, |estimate| estimate.tilt_rad())
    }

    /// Distance between satellite navigation and the map, metres, if they disagree.
    pub fn disagreement_m(&self) -> Option<f32> {
        self.satellites.disagreement_m()
    }

    /// Takes a position of satellite navigation; it is used at the next reported velocity.
    pub fn satellites(&mut self, position: SatellitePosition) {
        self.satellites.receive(position);
    }

    /// Sigma of the unexplained part of pitch and roll that recent matches have shown, each, radians: a transient tilt,
    /// or a jump that has neither been reversed nor been separated by a turn.
    pub fn unexplained_rad(&self, prior: &PriorSigmas) -> f32 {
        let shown_rad = sqrt((squared(self.shown_rad(prior)) - squared(prior.sigma_rad())).max(0.0));
        let unconfirmed_rad = self.jumps.unconfirmed_rad(self.moment.at);
        // These are estimates of the same tilt, so they are not added.
        let open_rad = shown_rad.max(unconfirmed_rad);
        if self.observes_swings() {
            return open_rad;
        }
        // A jump may have been of any size, and the estimated tilt may have vanished unnoticed.
        let [pitch, roll] = self.matched_tilt_rad();
        let learnt_rad = Some(hypot(pitch, roll)).filter(|learnt_rad| *learnt_rad > LEARNT_SIGMAS * prior.tilt_rad);
        open_rad.max(if unconfirmed_rad > 0.0 { TRANSIENT_MAX_RAD } else { 0.0 }).max(learnt_rad.unwrap_or(0.0))
    }

    /// Larger sigma of the error of pitch and roll that is left, by matches alone, radians. The wander counts in full,
    /// since no frame is corrected for it.
    pub fn tilt_sigma_rad(&self, prior: &PriorSigmas) -> f32 {
        combined_sigma(self.shown_rad(prior), self.misalignment.sigma_rad())
    }

    /// That sigma without a possible misalignment.
    fn shown_rad(&self, prior: &PriorSigmas) -> f32 {
        let [_, wander_rad] = part_sigmas_rad(prior);
        let before_rad = self.start_prior(prior).sigma_rad();
        let known_rad = self.newest.map_or(before_rad, |estimate| hypot(estimate.tilt_sigma_rad(), wander_rad));
        hypot(known_rad, self.transient_rad)
    }

    /// Error of the reported velocity, east and north, m/s, each with its variance; `None` before the first match.
    pub fn velocity_error(&self) -> Option<[(f32, f32); 2]> {
        self.newest.map(|estimate| estimate.velocity())
    }

    /// Position of the camera at the newest frame, and its covariance, square metres; `None` before the first match.
    pub fn position(&self) -> Option<(Local, Matrix2<f32>)> {
        let (local, covariance) = self.newest?.position();
        Some((local, covariance + self.misalignment.position_covariance()))
    }

    /// Prediction of the newest frame without its match: offset from [`Filter::position`] east and north, metres, and
    /// covariance; `None` if the estimate started with that match.
    pub fn prediction(&self) -> Option<(Vector2<f32>, Matrix2<f32>)> {
        let (_, covariance) = self.position()?;
        self.prediction.map(|prediction| (prediction.off_m, covariance + prediction.extra_covariance))
    }

    /// Takes a reported velocity, and propagates anew what was extrapolated beyond the one before.
    pub fn reported(&mut self, moment: Moment, prior: &PriorSigmas) {
        let before = core::mem::replace(&mut self.reported, moment);
        let step_us = moment.at.since(before.at);
        if !(1..=STEP_MAX_US).contains(&step_us) {
            return self.reset(moment);
        }
        let seconds = step_us as f32 * 1e-6;
        let change = core::array::from_fn(|axis| moment.velocity_m_per_s[axis] - before.velocity_m_per_s[axis]);
        let is_reset = hypot(change[0], change[1]) > ACCELERATION_MAX_M_PER_S2 * seconds;
        self.acceleration = if is_reset { [0.0; 2] } else { change.map(|change| change / seconds) };
        self.transient_rad /= 1.0 + seconds / if self.observes_swings() { TRANSIENT_S } else { HIDDEN_S };
        let mean_rad = self.jumps.mean_rad();
        if let Some(settled) = &mut self.settled {
            if is_reset {
                settled.inflate_velocity(change);
                self.satellites.inflate_velocity(change);
            }
            let displacement_sigma_m = unaided_m(self.matched_at, moment.at, seconds);
            settled.propagate((before, moment), displacement_sigma_m, mean_rad, prior);
            self.misalignment.propagate(seconds, mean_rad.is_some());
            self.satellites.propagate((before, moment), displacement_sigma_m, mean_rad, prior);
        }
        while self.pending.front().is_some_and(|(at, _)| *at <= moment.at) {
            self.settle_oldest(prior);
        }
        self.detect_misalignment();
        if let Some(settled) = &self.settled {
            self.jumps.resolve(moment.at, settled, prior);
        }
        if self.settled.is_some_and(|settled| !settled.is_valid()) {
            self.reset(moment);
        }
        self.update_by_satellites();
        (self.moment, self.newest) = (moment, self.settled);
        for index in 0..self.pending.len() {
            let Some((at, measurement)) = self.pending.iter().nth(index).copied() else { break };
            self.propagate_to(at, prior);
            let inflated_covariance = self.inflated_covariance(&measurement);
            self.newest =
                self.newest.map(|newest| newest.updated(&newest.innovation(&measurement, inflated_covariance)));
        }
    }

    /// Updates by the waiting satellite position once the newest velocity is no older, after moving it to that instant.
    fn update_by_satellites(&mut self) {
        if let (Some(settled), Some(position)) = (self.settled, self.satellites.due(self.reported.at)) {
            let (apart_s, [east, north]) = (self.reported.at.since(position.at) as f32 * 1e-6, settled.velocity());
            let local = position
                .local
                .moved(displacement_m(self.extrapolated(position.at), self.reported))
                .moved([-east.0 * apart_s, -north.0 * apart_s]);
            let position = SatellitePosition { local, ..position };
            let variance = squared(apart_s) * east.1.max(north.1);
            self.satellites.update(&Moved { position, moment: self.reported, variance }, &settled);
        }
        self.satellites.correct_tilt(self.settled.as_ref());
    }

    /// Propagates to a frame, whose attitude is corrected by the tilt as estimated then.
    pub fn propagate(&mut self, at: Micros, prior: &PriorSigmas) {
        self.satellite_tilt_rad = self.satellites.tilt_rad();
        self.propagate_to(at, prior);
    }

    fn propagate_to(&mut self, at: Micros, prior: &PriorSigmas) {
        let moment = self.extrapolated(at);
        let before = core::mem::replace(&mut self.moment, moment);
        let late_us = at.since(self.reported.at);
        if late_us > STEP_MAX_US {
            self.reset(moment);
        }
        let mean_rad = self.jumps.mean_rad();
        let Some(newest) = &mut self.newest else { return };
        let seconds = at.since(before.at) as f32 * 1e-6;
        if seconds < 0.0 {
            newest.propagate_back(displacement_m(moment, before), -seconds);
        } else {
            let late_m = 0.5 * JERK_M_PER_S3 * squared(late_us.max(0) as f32 * 1e-6) * seconds;
            let displacement_sigma_m = hypot(late_m, unaided_m(self.matched_at, at, seconds));
            newest.propagate((before, moment), displacement_sigma_m, mean_rad, prior);
        }
    }

    /// Updates by an accepted match of the frame propagated to. `overruled_m`: its offset from the track that counted
    /// before, east and north, if it has overruled that one, as a tilt would cause it at this heading. Returns the
    /// additional sigma of a tilt for the uncertainty of its fix, radians: 0 if the match was consistent.
    pub fn matched(&mut self, measurement: &Measurement, overruled_m: Option<[f32; 2]>, prior: &PriorSigmas) -> f32 {
        let before = core::mem::replace(&mut self.matched_at, self.moment.at);
        let outcome = match (overruled_m, self.newest) {
            (Some(aside), _) => Outcome::Outlier(aside.into()),
            (None, None) => return self.start(measurement, &self.start_prior(prior)),
            (None, Some(newest)) if self.jumps.is_jumping(self.moment.at) => {
                Outcome::Outlier(newest.innovation(measurement, self.white(measurement)).off)
            }
            (None, Some(newest)) => {
                let plain = newest.innovation(measurement, white(measurement, 0.0));
                match self.jumps.sudden_return((self.moment.at, before), &newest, (measurement, &plain), prior) {
                    Some(off) => Outcome::Outlier(off),
                    None if self.contradicts_neighbour(before, &newest, (measurement, &plain.off), prior) => {
                        Outcome::Outlier(plain.off)
                    }
                    None => self.test_innovation(self.moment.at, &newest, (measurement, &plain), prior),
                }
            }
        };
        match outcome {
            Outcome::Outlier(off) => {
                let known_rad = self.tilt_sigma_rad(prior);
                let known = (self.matched_tilt_rad(), self.newest);
                let restart = self.jumps.jumped((self.moment.at, before, off), known, measurement, prior);
                let restart_prior = PriorSigmas { tilt_rad: restart.sigma_rad, ..*prior };
                self.transient_rad = self.transient_rad.max(restart.swing_rad);
                self.start(&restart.measurement, &restart_prior);
                let more_rad = sqrt((squared(restart_prior.sigma_rad()) - squared(known_rad)).max(0.0));
                hypot(more_rad, restart.off_rad)
            }
            Outcome::Consistent { estimate: newest, more_rad, .. } => {
                self.jumps.followed(&newest, measurement);
                self.jumps.restart_confirmation(self.moment.at, more_rad);
                self.prediction = self.newest.map(|expected| Prediction::new(&expected, &newest));
                self.newest = Some(newest);
                if self.pending.is_full() {
                    self.settle_oldest(prior);
                }
                // Room for it was made above.
                let _ = self.pending.push_back((self.moment.at, *measurement));
                more_rad
            }
        }
    }

    /// Velocity at an instant near the newest reported one, extrapolated with the acceleration between the last two: in
    /// a turn the newest velocity alone lags behind.
    pub fn extrapolated(&self, at: Micros) -> Moment {
        let seconds = at.since(self.reported.at) as f32 * 1e-6;
        let velocity = |axis: usize| self.reported.velocity_m_per_s[axis] + self.acceleration[axis] * seconds;
        Moment { at, velocity_m_per_s: core::array::from_fn(velocity) }
    }

    fn white(&self, measurement: &Measurement) -> Matrix2<f32> {
        white(measurement, self.transient_rad)
    }

    /// Starts from a match, without a prediction.
    fn start(&mut self, measurement: &Measurement, prior: &PriorSigmas) -> f32 {
        let white = self.white(measurement);
        let back = displacement_m(self.moment, self.reported);
        let apart_s = self.moment.at.since(self.reported.at) as f32 * 1e-6;
        let less = Matrix2::identity() * squared(prior.velocity_m_per_s * apart_s);
        self.newest = Some(Estimate::from_match(measurement, white, prior));
        let settled = Estimate::from_match(&measurement.moved(back), white + less, prior);
        self.satellites.restart(&settled);
        self.settled = Some(settled);
        self.misalignment.restart(measurement);
        (self.prediction, self.kept_tilt) = (None, None);
        self.pending.clear();
        0.0
    }

    /// Whether the velocity is known well enough for a swinging tilt to exceed the gate.
    fn observes_swings(&self) -> bool {
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
