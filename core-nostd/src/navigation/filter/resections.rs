//! Resection while the attitude is in doubt or checked: when it begins, which tilt frames are corrected for, and what it shows of the attitude.
//!
//! Once the resected tilt agrees with the one before the doubt, the attitude is taken to be correct again: the filter restarts with it. With any
//! other tilt, the next frames are corrected for it, and the doubt remains.

use super::estimate::Estimate;
use super::innovation_test::TRANSIENT_MAX_RAD;
use super::jumps::{LEARNT_SIGMAS, PERIOD_US};
use super::measurement::{Measurement, PriorSigmas};
use super::resection::{GAP_US, Resected, Resection};
use super::{Filter, HIDDEN_M_PER_S, TRANSIENT_GATE};
use crate::math::{combined_sigma, sqrt, squared};
use crate::navigation::reckoning::JUMP_ONSET_US;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Vector2};

/// Longest time without a picture for which matches alone update the position, microseconds. Chosen: dead reckoning is off by as much as a
/// picture then.
const PICTURED_US: i32 = 5_000_000;
/// Largest sigma of the resected tilt for frames to be corrected for it, radians. Chosen: a pixel 120 m up over pixels of 5 m.
const KNOWN_RAD: f32 = 0.04;

/// Sigma of a tilt that pictures cannot show yet, as a share of the largest with which frames have fixes. Chosen: a displacement by three
/// degrees 150 m up, over pixels of 5 m, is three sigmas then.
const OPEN_SHARE: f32 = 0.85;
/// Largest sigma with which pictures show it for frames to have fixes, in the same unit. Chosen: two pixels of displacement; half as much keeps one
/// flight in six waiting for more than two seconds behind a gap.
const OPEN_MAX: f32 = 3.3;

/// The second estimate while the attitude is in doubt or checked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resections {
    newest: Option<Resection>,
    /// When they showed that the attitude was correct again.
    correct_at: Option<Micros>,
    /// When a match that could hide a jump of the tilt was found last, or pictures that were asked because of it showed one.
    asked_at: Option<Micros>,
    /// Sigma of the tilt that the newest of them adds, radians.
    pictured_rad: f32,
}

impl Resections {
    pub(super) const fn new() -> Self {
        Resections { newest: None, correct_at: None, asked_at: None, pictured_rad: 0.0 }
    }

    /// Velocities were interrupted: the position is not known further. That pictures have shown a correct attitude a moment ago is.
    pub(super) fn interrupted(&mut self) {
        self.newest = None;
    }
}

impl Filter {
    /// Has the newest frame corrected for another tilt than the estimated one, if there is reason to: for the resected one if that
    /// contradicts it; or for the one before the jumps, if the estimated one was learnt and is far off it, where no match is found
    /// (`is_lost`): the learnt error may have ended.
    // Inlined, its working memory would lie on the stack below other stages; so would those of the next two.
    #[inline(never)]
    pub fn try_other_tilt(&mut self, is_lost: bool, prior: &PriorSigmas) {
        let estimated_rad = Vector2::from(self.matched_tilt_rad());
        let contradicts = |resection: &Resection| {
            let age_us = self.moment.at.since(resection.moment.at);
            (0..GAP_US).contains(&age_us)
                && resection.estimate.tilt_sigma_rad() <= KNOWN_RAD
                && !resection.is_near(&estimated_rad)
        };
        let resected_rad = self.resections.newest.filter(contradicts).map(|resection| self.likely_rad(&resection));
        let before_rad = (is_lost && self.is_tilt_learnt(prior)).then(|| Vector2::from(self.jumps.before_rad()));
        self.tried_rad = resected_rad.or(before_rad).map(Into::into);
    }

    /// The resected tilt, or one of those to return to that is as likely.
    fn likely_rad(&self, resection: &Resection) -> Vector2<f32> {
        self.jumps.means().find(|mean| resection.is_near(mean)).unwrap_or(resection.tilt_rad())
    }

    /// Whether the newest frame is corrected for another tilt than the estimated one.
    pub fn is_other_tilt_tried(&self) -> bool {
        self.tried_rad.is_some()
    }

    /// Whether the estimated tilt is far off the one before the jumps.
    fn is_tilt_learnt(&self, prior: &PriorSigmas) -> bool {
        let learnt_rad = Vector2::from(self.matched_tilt_rad()) - Vector2::from(self.jumps.before_rad());
        learnt_rad.norm() > LEARNT_SIGMAS * prior.tilt_rad
    }

    /// Whether pictures have shown a moment ago that the attitude is correct again.
    pub fn was_attitude_in_doubt(&self) -> bool {
        self.is_recent(self.resections.correct_at)
    }

    /// Whether a match of the newest frame may be displaced by so many metres by a jump of the tilt and pass the gate all the same: frames before it
    /// were not matched (`is_gap`) and the prediction has become as uncertain meanwhile, or a reset has left no prediction.
    pub fn may_hide(&self, is_gap: bool, displacement_m: f32) -> bool {
        let hidden_m = |newest: Estimate| sqrt(TRANSIENT_GATE) * newest.position_sigma_m();
        self.newest.map_or(self.kept_tilt.is_some(), |newest| is_gap && hidden_m(newest) > displacement_m)
    }

    /// Has pictures asked for the tilt for a while.
    pub fn ask_pictures(&mut self) {
        self.resections.asked_at = Some(self.moment.at);
    }

    /// Whether pictures have to show the tilt although the attitude is not in doubt: it was a moment ago, its error was learnt and may end, or
    /// they have been asked.
    pub fn is_attitude_checked(&self, prior: &PriorSigmas) -> bool {
        self.has_been_off(prior) || self.are_pictures_asked()
    }

    /// Whether pictures have been asked for the tilt a moment ago.
    pub fn are_pictures_asked(&self) -> bool {
        self.is_recent(self.resections.asked_at)
    }

    /// Whether the attitude was in doubt a moment ago, or its error was learnt.
    pub fn has_been_off(&self, prior: &PriorSigmas) -> bool {
        self.was_attitude_in_doubt() || self.is_tilt_learnt(prior)
    }

    /// Whether an instant is less than a period ago, within which what swings would be off again.
    fn is_recent(&self, at: Option<Micros>) -> bool {
        at.is_some_and(|at| (0..PERIOD_US).contains(&self.moment.at.since(at)))
    }

    /// How far a match of the frame propagated to is off the prediction, east and north, metres, if that is beyond a gate of the squared
    /// normalised innovation.
    pub fn innovation_beyond(&self, gate: f32, measurement: &Measurement) -> Option<[f32; 2]> {
        let newest = self.newest.as_ref().filter(|newest| !newest.is_surely_within(gate, measurement))?;
        let innovation = newest.innovation(measurement, self.white(measurement));
        (innovation.nis > gate).then(|| innovation.off.into())
    }

    /// Forgets what pictures have shown.
    pub fn clear_resections(&mut self) {
        self.resections = Resections::new();
    }

    /// Takes a match with what its picture shows, if it shows anything, while the attitude is in doubt or checked, before the filter takes
    /// it. `is_checked`: it is not in doubt. Returns the position by resection with its covariance, east and north, square metres; `None` if
    /// pictures have not shown it lately.
    #[inline(never)]
    pub fn resect(
        &mut self,
        resected: Option<&Resected>,
        is_checked: bool,
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) -> Option<(Local, Matrix2<f32>)> {
        let resected = resected.filter(|resected| resected.is_valid());
        // With a worse velocity the tilt's swings would pass for its error.
        let prior = &PriorSigmas { velocity_m_per_s: prior.velocity_m_per_s.min(HIDDEN_M_PER_S), ..*prior };
        let moment = self.moment;
        let before = self.newest.filter(|_| resected.is_some() && !is_checked && self.observes_swings());
        let before = before.map(|newest| Resection::new(moment, newest));
        let propagated = self.resections.newest.and_then(|newest| newest.propagated(moment, prior));
        let updated = |resection: Resection| {
            let matched = resection.matched(measurement);
            match resected {
                Some(resected) => matched.resected(resected, measurement),
                None => Some(matched).filter(|matched| moment.at.since(matched.pictured_at) < PICTURED_US),
            }
        };
        let begin = || {
            resected.and_then(|resected| Resection::begin(moment, measurement, prior).resected(resected, measurement))
        };
        let newest = propagated.or(before).and_then(updated).or_else(begin);
        self.resections.newest = newest.filter(|newest| newest.estimate.is_valid());
        self.resections.newest.map(|newest| newest.position(measurement.height_m))
    }

    /// Draws the conclusions, after the match is taken. `is_in_doubt`: the attitude is, not only checked. `known_rad`: sigma of a tilt with
    /// which frames have fixes. Returns the sigma of a tilt that this adds to the frame's, radians; `None` if the attitude remains in doubt.
    #[inline(never)]
    pub fn conclude(
        &mut self,
        (is_in_doubt, known_rad): (bool, f32),
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) -> Option<f32> {
        let newest = self.resections.newest?;
        // A frame's attitude is fitted to samples over as long: pictures of so long a time show one after a jump.
        if is_in_doubt && self.moment.at.since(newest.since) >= JUMP_ONSET_US {
            self.restart_as_resected(&newest, known_rad, measurement, prior);
        }
        let is_known = if self.was_attitude_in_doubt() {
            newest.tilt_variance() <= squared(known_rad)
        } else {
            newest.estimate.tilt_sigma_rad() <= OPEN_MAX * known_rad
        };
        (!is_in_doubt && is_known).then(|| self.check_tilt(&newest, known_rad, prior))
    }

    /// Checks an attitude that is not in doubt: it has a transient tilt again if matches have left where the velocity leads a moment after
    /// a doubt, or if the resected tilt is another than the estimated one. Returns the sigma that this adds, radians.
    fn check_tilt(&mut self, resection: &Resection, known_rad: f32, prior: &PriorSigmas) -> f32 {
        let estimated_rad = Vector2::from(self.matched_tilt_rad());
        let shown_rad = if resection.has_jumped && self.was_attitude_in_doubt() {
            TRANSIENT_MAX_RAD
        } else {
            // Of each axis, beyond one sigma.
            let known = resection.tilt_variance() + self.newest.map_or(0.0, |newest| squared(newest.tilt_sigma_rad()));
            sqrt((0.5 * (resection.tilt_rad() - estimated_rad).norm_squared() - known).max(0.0))
        };
        let is_open = self.are_pictures_asked() && resection.tilt_variance() > squared(known_rad);
        let open_rad = if is_open { OPEN_SHARE * known_rad } else { 0.0 };
        if self.has_been_off(prior) {
            let before_rad = self.transient_rad;
            self.transient_rad = before_rad.max(shown_rad);
            return sqrt((squared(self.transient_rad) - squared(before_rad)).max(0.0)).max(open_rad);
        }
        // Nothing but pictures speaks for another tilt: it counts as long as they show it, or could not yet.
        if shown_rad > known_rad {
            self.ask_pictures();
        }
        self.resections.pictured_rad = shown_rad.max(open_rad);
        self.resections.pictured_rad
    }

    /// Sigma of a tilt by pictures that were asked, radians: the position of the filter may be off by it as matches are.
    pub fn pictured_rad(&self) -> f32 {
        if self.are_pictures_asked() { self.resections.pictured_rad } else { 0.0 }
    }

    /// Restarts from a match with the tilt before the doubt, if that is the resected one, known well enough for fixes.
    /// Otherwise, if the estimated tilt is not, with the resected one, as uncertain as after a jump there.
    fn restart_as_resected(
        &mut self,
        resection: &Resection,
        known_rad: f32,
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) {
        let correct = self.jumps.means().find(|correct| resection.is_near(correct));
        // What is shown beyond it may be noise or not, so it counts as uncertainty of each axis.
        let left_rad = |correct: &Vector2<f32>| {
            sqrt(resection.tilt_variance() + 0.5 * (resection.tilt_rad() - correct).norm_squared())
        };
        if let Some(correct_rad) = correct.filter(|correct| left_rad(correct) <= known_rad) {
            let left_rad = left_rad(&correct_rad);
            self.jumps.end(correct_rad.into());
            (self.transient_rad, self.before_swing_rad) = (0.0, 0.0);
            self.resections.correct_at = Some(resection.moment.at);
            let prior = PriorSigmas { tilt_rad: combined_sigma(prior.tilt_rad, left_rad), ..*prior };
            self.start(&measurement.with_tilt(correct_rad.into()), &prior);
            return;
        }
        let estimated_rad = Vector2::from(self.matched_tilt_rad());
        if resection.is_near(&estimated_rad) {
            return;
        }
        let shown_rad = self.likely_rad(resection);
        let from_rad = [estimated_rad, Vector2::from(self.jumps.before_rad())];
        let squares = from_rad.map(|from_rad| (shown_rad - from_rad).norm_squared());
        let jump_rad = sqrt(0.5 * squares.into_iter().fold(0.0, f32::max));
        let prior = PriorSigmas { tilt_rad: combined_sigma(prior.tilt_rad, jump_rad), ..*prior };
        self.start(&measurement.with_tilt(shown_rad.into()), &prior);
    }
}
