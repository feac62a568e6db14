//! Jumps of the attitude: errors that begin from one frame to the next, and end later.
//!
//! A match far beyond the gate is a jump of the tilt or of the position, and that match alone does not show which. The
//! equivalent tilt is accumulated until a turn separates them; where the sum leads back to the tilt before, the
//! attitude has jumped back.

use super::estimate::{Estimate, Innovation};
use super::measurement::{Measurement, PriorSigmas, tilt_jacobian, white};
use super::{TRANSIENT_GATE, VELOCITY_KNOWN_M_PER_S};
use crate::math::{hypot, ln, sqrt, squared};
use crate::navigation::reckoning::JUMP_ONSET_US;
use crate::units::Micros;
use nalgebra::Vector2;

/// Largest jump of the tilt, radians; a larger offset, less one sigma of the prediction, was one of the position.
/// Chosen: rotation and scale of a picture with such an error are ten per cent off, which no match survives.
const JUMP_MAX_RAD: f32 = 0.3;
/// A jump is resolved when the tilt's sigma is at most so many times its prior sigma.
const RESOLVED: f32 = 1.2;
/// A jump is a return if at most this share of it remains, or if the return explains the match so many times better
/// than a jump of the position to anywhere within [`JUMP_MAX_RAD`]. Chosen: a jump of the position comes so near to
/// that once in sixteen times, or in ten.
const BACK_SHARE: f32 = 0.25;
const BACK_ODDS: f32 = 10.0;
/// A tilt that has jumped within this time is taken to swing, and a jump resolved by a turn has to hold for it,
/// microseconds. Chosen: half of the period of 20 s with which a vehicle rocks slowly.
pub(super) const CALM_US: i32 = 10_000_000;
/// That period, microseconds: without a swing for so long a tilt is not swinging.
pub(super) const PERIOD_US: i32 = 2 * CALM_US;
/// Time for which a return of a possibly swinging tilt, or a jump of the position, has to hold before frames have fixes
/// again if a single match has shown it, microseconds. What was matched until then, and returns from one frame to the
/// next, does not swing. Chosen: a quarter of that period; where the swing of a scaled attitude turns round, it stays
/// within a tenth for 3 s.
const CONFIRMATION_US: i32 = PERIOD_US / 4;
/// A tilt can jump back if it is off its value before by more than so many sigmas of that. Chosen: a normal error is
/// once in a hundred.
pub(super) const LEARNT_SIGMAS: f32 = 3.0;

/// What has jumped.
#[derive(Clone, Copy, Debug, PartialEq)]
enum JumpKind {
    /// The tilt, back to its value before.
    Return,
    /// The tilt, to another value.
    Tilt,
    /// The position.
    Position,
}

impl JumpKind {
    fn of(is_return: bool, by_tilt: bool) -> Self {
        match (is_return, by_tilt) {
            (true, _) => JumpKind::Return,
            (false, true) => JumpKind::Tilt,
            (false, false) => JumpKind::Position,
        }
    }
}

/// The last jump.
#[derive(Clone, Copy, Debug)]
struct Jump {
    at: Micros,
    /// Nothing had jumped for [`CONFIRMATION_US`].
    was_calm: bool,
    /// The tilt before it, and its size over all frames that saw a part of it, pitch and roll.
    from_rad: Vector2<f32>,
    by_rad: Vector2<f32>,
    /// Its largest size so far, over the frames that saw a part of it, radians.
    most_rad: f32,
    kind: JumpKind,
    /// A return by a single match or while the velocity is unknown, or a jump of the position.
    is_unconfirmed: bool,
    /// The last match beyond the gate; or the instant at which a turn has resolved the jump, if one has.
    quiet_since: Micros,
    is_resolved: bool,
}

/// The unresolved jumps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jumps {
    /// The tilt if all of them were of the tilt, radians; `None` once resolved.
    to_rad: Option<Vector2<f32>>,
    last: Option<Jump>,
    /// Mean to which the tilt decays: the last resolved one, radians.
    mean_rad: [f32; 2],
    /// Innovation of the last match less what the estimate has taken over of it, east and north, metres.
    off_before: Option<Vector2<f32>>,
}

/// How the estimate restarts after a jump.
#[derive(Clone, Copy, Debug)]
pub(super) struct Restart {
    /// The match, corrected for the more likely tilt.
    pub measurement: Measurement,
    /// Sigma of that tilt, radians.
    pub sigma_rad: f32,
    /// Additional error of the tilt that the frame was rectified with, radians.
    pub off_rad: f32,
    /// Sigma of the tilt that may swing on, each axis, radians.
    pub swing_rad: f32,
}

impl Jump {
    /// Time without an outlier after which it is confirmed, microseconds.
    fn confirmation_us(&self) -> i32 {
        match (self.kind, self.is_unconfirmed) {
            (JumpKind::Tilt, _) => CALM_US,
            (_, true) => CONFIRMATION_US,
            (_, false) => 0,
        }
    }
}

impl Jumps {
    pub(super) const fn new() -> Self {
        Jumps { to_rad: None, last: None, mean_rad: [0.0; 2], off_before: None }
    }

    /// Mean to which the tilt decays; `None` while a jump is unresolved.
    pub(super) fn mean_rad(&self) -> Option<[f32; 2]> {
        self.to_rad.is_none().then_some(self.mean_rad)
    }

    /// Whether a frame may have seen a part of the last jump only.
    pub(super) fn is_jumping(&self, at: Micros) -> bool {
        self.last.is_some_and(|last| (0..JUMP_ONSET_US).contains(&at.since(last.at)))
    }

    /// Possible error of the tilt by an unconfirmed jump (a return, a jump of the position, or one just resolved by a
    /// turn), radians.
    pub(super) fn unconfirmed_rad(&self, at: Micros) -> f32 {
        let is_open = |last: &Jump| (0..last.confirmation_us()).contains(&at.since(last.quiet_since));
        self.last.filter(is_open).map_or(0.0, |last| last.by_rad.norm())
    }

    /// Resolves a jump if the tilt is known at the instant of a reported velocity.
    pub(super) fn resolve(&mut self, at: Micros, estimate: &Estimate, prior: &PriorSigmas) {
        let is_recent = self.last.is_some_and(|last| at.since(last.at) < PERIOD_US);
        if is_recent && prior.velocity_m_per_s > VELOCITY_KNOWN_M_PER_S {
            self.restart_confirmation(at, prior.tilt_rad);
        }
        let is_open = self.unconfirmed_rad(at) > 0.0;
        let Some(last) = &mut self.last else { return };
        if self.to_rad.is_some() && estimate.tilt_sigma_rad() <= RESOLVED * prior.tilt_rad {
            self.to_rad = None;
            (last.is_resolved, last.quiet_since) = (true, at);
        } else if last.is_resolved && !is_open {
            last.is_resolved = false;
            self.mean_rad = estimate.tilt_rad();
        }
    }

    /// The tilt before all jumps, pitch and roll, radians.
    pub(super) fn before_rad(&self) -> [f32; 2] {
        self.mean_rad
    }

    /// Ends all jumps: the tilt is this one again, pitch and roll, radians.
    pub(super) fn end(&mut self, mean_rad: [f32; 2]) {
        *self = Jumps { mean_rad, ..Jumps::new() };
    }

    /// Velocities were interrupted until `at`, or the clock was set back: what has jumped is still off.
    pub(super) fn interrupted(&mut self, at: Micros) {
        self.off_before = None;
        if let Some(last) = self.last.as_mut().filter(|last| at.since(last.at.max(last.quiet_since)) < 0) {
            (last.at, last.quiet_since) = (at, at);
        }
    }

    /// Sets the mean to which the tilt decays, pitch and roll, radians, without a jump.
    pub(super) fn set_mean(&mut self, mean_rad: [f32; 2]) {
        self.mean_rad = mean_rad;
    }

    /// Restarts the confirmation of a jump: a match lies beyond the gate by the tilt `by_rad`, or the velocity is so
    /// uncertain that none would.
    pub(super) fn restart_confirmation(&mut self, at: Micros, by_rad: f32) {
        let is_open = by_rad > 0.0 && self.unconfirmed_rad(at) > 0.0;
        if let Some(last) = self.last.as_mut().filter(|_| is_open) {
            last.quiet_since = at;
        }
    }

    /// Innovation of a match, east and north in metres, with what the frame before may have seen of the same jump, if
    /// it returns the tilt from one frame to the next.
    pub(super) fn sudden_return(
        &mut self,
        (at, before): (Micros, Micros),
        expected: &Estimate,
        (measurement, &Innovation { off, nis, .. }): (&Measurement, &Innovation),
        prior: &PriorSigmas,
    ) -> Option<Vector2<f32>> {
        let with_last = self.off_before.filter(|_| at.since(before) < JUMP_ONSET_US).map(|before| before + off);
        self.off_before = Some(off);
        // What has jumped a moment ago may be swinging back.
        let is_consistent = with_last.is_none() || nis <= TRANSIENT_GATE;
        if is_consistent || self.last.is_none_or(|last| at.since(last.at) < CONFIRMATION_US) {
            return None;
        }
        let from_rad = self.to_rad.unwrap_or(expected.tilt_rad().into());
        [Some(off), with_last].into_iter().flatten().find(|off| {
            let by_rad = equivalent_tilt_rad(*off, measurement);
            let is_far = by_rad.norm() > LEARNT_SIGMAS * prior.tilt_rad;
            is_far && self.means().any(|mean| (from_rad + by_rad - mean).norm() <= BACK_SHARE * by_rad.norm())
        })
    }

    /// The estimate was updated by that match.
    pub(super) fn followed(&mut self, estimate: &Estimate, measurement: &Measurement) {
        let left = estimate.innovation(measurement, white(measurement, 0.0)).off;
        self.off_before = self.off_before.map(|off| off - left);
    }

    /// Restarts after an outlier: the match of the frame at `at`, the match before it, and its innovation `off`, east
    /// and north in metres, against `expected`. `known_rad`: the tilt estimated before.
    pub(super) fn jumped(
        &mut self,
        (at, before, off): (Micros, Micros, Vector2<f32>),
        (known_rad, expected): ([f32; 2], Option<Estimate>),
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) -> Restart {
        let known_rad = Vector2::from(known_rad);
        let more_rad = equivalent_tilt_rad(off, measurement);
        let beside_rad = expected.map_or(0.0, |estimate| estimate.position_sigma_m() / measurement.height_m);
        // The frame before may have seen a part of this jump.
        let last = self.last.filter(|_| self.is_jumping(at));
        let from_rad = last.map_or(self.to_rad.unwrap_or(known_rad), |last| last.from_rad);
        let by_rad = more_rad + last.map_or(Vector2::zeros(), |last| last.by_rad);
        let by_tilt = by_rad.norm() <= JUMP_MAX_RAD + beside_rad;
        let to_rad = if by_tilt { from_rad + by_rad } else { from_rad };
        let likely =
            expected.filter(|_| by_tilt).and_then(|estimate| self.likely_return(at, &estimate, measurement, prior));
        let is_near = |mean: &Vector2<f32>| by_tilt && (to_rad - mean).norm() <= BACK_SHARE * by_rad.norm();
        // A return stays one if little follows.
        let stays = |last: &Jump| {
            by_tilt && last.kind == JumpKind::Return && more_rad.norm() <= BACK_SHARE * last.by_rad.norm()
        };
        let stays = || last.filter(stays).map(|_| self.mean_rad.into());
        let back = likely.or_else(|| self.means().find(is_near)).or_else(stays);
        let begun_at = last.map_or(at, |last| last.at);
        let is_sudden = at.since(before) < JUMP_ONSET_US;
        let is_swinging = !is_sudden && self.last.is_some_and(|last| at.since(last.at) < PERIOD_US);
        // A return from one frame to the next, or one too exact for chance, holds whatever the velocity, unless there
        // was a swing a moment ago.
        let was_calm =
            self.last.is_none_or(|last| at.since(last.at) >= CONFIRMATION_US || last.at == begun_at && last.was_calm);
        let is_exact = (to_rad - back.unwrap_or(to_rad)).norm() <= LEARNT_SIGMAS * prior.tilt_rad;
        let is_hidden = prior.velocity_m_per_s > VELOCITY_KNOWN_M_PER_S && !(was_calm && (is_sudden || is_exact));
        let was_unconfirmed = last.is_some_and(|last| last.is_unconfirmed);
        let is_unconfirmed = was_unconfirmed || !by_tilt || is_hidden || likely.is_some() && is_swinging;
        self.last = Some(Jump {
            at: begun_at,
            was_calm,
            from_rad,
            by_rad,
            most_rad: last.map_or(0.0, |last| last.most_rad).max(by_rad.norm()),
            kind: JumpKind::of(back.is_some(), by_tilt),
            is_unconfirmed,
            quiet_since: begun_at,
            is_resolved: false,
        });
        if let Some(back) = back {
            self.mean_rad = back.into();
        }
        let tilt_rad = back.unwrap_or(known_rad);
        let left_rad = likely.unwrap_or(to_rad) - tilt_rad;
        let sigma_rad = hypot(prior.tilt_rad, sqrt(0.5 * left_rad.norm_squared()));
        self.to_rad = (sigma_rad > RESOLVED * prior.tilt_rad).then_some(tilt_rad + left_rad);
        // The frame may have seen a part of this jump only.
        let seen_rad = last.map_or(0.0, |_| more_rad.norm());
        let off_rad = (known_rad - tilt_rad).norm().max(seen_rad);
        let measurement = measurement.with_tilt(tilt_rad.into());
        Restart { measurement, sigma_rad, off_rad, swing_rad: self.swing_rad(prior) }
    }

    /// Sigma, each axis, radians, of a tilt that may swing on: how far the last jump has come back from its largest size within its duration. At
    /// most [`LEARNT_SIGMAS`]: a larger swing is noticed, and a single wrong match is not to cost fixes.
    fn swing_rad(&self, prior: &PriorSigmas) -> f32 {
        let back_rad = self.last.map_or(0.0, |last| sqrt(0.5) * (last.most_rad - last.by_rad.norm()));
        back_rad.min(LEARNT_SIGMAS * prior.tilt_rad)
    }

    /// The tilt before a jump some time ago, if a return to it explains a match best.
    pub(super) fn likely_return(
        &self,
        at: Micros,
        estimate: &Estimate,
        measurement: &Measurement,
        prior: &PriorSigmas,
    ) -> Option<Vector2<f32>> {
        if self.last.is_none_or(|last| at.since(last.at) < CALM_US) {
            return None;
        }
        let known_rad = Vector2::from(estimate.tilt_rad());
        let explains = |mean: &Vector2<f32>| {
            let back = estimate.with_tilt((*mean).into(), prior.tilt_rad);
            let is_off = (known_rad - mean).norm() > LEARNT_SIGMAS * prior.tilt_rad;
            is_off && explains_best(&back.innovation(measurement, white(measurement, 0.0)), measurement)
        };
        self.means().find(explains)
    }

    /// Tilts to return to: that before the jumps, and none.
    pub(super) fn means(&self) -> impl Iterator<Item = Vector2<f32>> + use<> {
        [Vector2::from(self.mean_rad), Vector2::zeros()].into_iter()
    }
}

/// Pitch and roll equivalent to an offset of a match, east and north in metres.
fn equivalent_tilt_rad(off: Vector2<f32>, measurement: &Measurement) -> Vector2<f32> {
    tilt_jacobian(measurement).transpose() * off / squared(measurement.height_m)
}

/// Whether an assumed tilt explains a match [`BACK_ODDS`] times better than a jump of the position to anywhere within
/// [`JUMP_MAX_RAD`]: the normal density there, e^(-x/2) / (2 pi s), against one over that circle's area.
fn explains_best(innovation: &Innovation, measurement: &Measurement) -> bool {
    let ratio = 0.5 * squared(JUMP_MAX_RAD * measurement.height_m) / (BACK_ODDS * innovation.spread());
    ratio > 1.0 && 0.5 * innovation.nis <= ln(ratio)
}
