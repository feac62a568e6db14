//! Jumps of the tilt: attitudes that are off from one frame to the next, and right again later.
//!
//! A match that lies far off what was expected is a jump of the tilt or of the place, and that match does not tell which. What it would
//! be of the tilt is added up until a turn tells: where the sum is what the tilt was before, the attitude has jumped back.

use super::estimate::{Estimate, Innovation};
use super::found::{Found, Unknown, moved_by_tilt, white};
use super::{KNOWN_M_PER_S, TRANSIENT};
use crate::math::{hypot, ln, sqrt, squared};
use crate::navigation::reckoning::JUMP_ONSET_US;
use crate::units::Micros;
use nalgebra::Vector2;

/// Largest tilt that may have jumped, radians: further off, and one sigma of what was expected beside, it was the place. Chosen:
/// turn and scale of a picture that was taken with such an error are ten per cent off, which no match survives.
const JUMP_MAX_RAD: f32 = 0.3;
/// A jump is told when the tilt is known to so many times what is not known beforehand.
const TOLD: f32 = 1.2;
/// A jump is one back where it leaves no larger share of itself, or where that explains the match so many times better than a jump of the
/// place to anywhere within [`JUMP_MAX_RAD`]. Chosen: a jump of the place comes so near to that once in sixteen times, or in ten.
const BACK_SHARE: f32 = 0.25;
const BACK_ODDS: f32 = 10.0;
/// What has jumped within so long is taken to swing, and what a turn has told of a jump has to hold for so long, microseconds. Chosen: half of
/// the period of 20 s with which a vehicle rocks slowly.
pub(super) const CALM_US: i32 = 10_000_000;
/// With such a period a vehicle rocks slowly, microseconds: what has not swung for as long does not.
const PERIOD_US: i32 = 2 * CALM_US;
/// What one match alone takes to be a jump back of what may swing, or a jump of the place, has to hold for so long before frames
/// have fixes again, microseconds; what was matched until then, and is back from one frame to the next, does not swing. Chosen:
/// a quarter of that period; where the swing of an attitude that is scaled turns round, it stays within a tenth for 3 s.
const PROVEN_US: i32 = PERIOD_US / 4;
/// A tilt that is further off what it was before than so many sigmas of that can jump back. Chosen: a normal error is once in a hundred.
pub(super) const LEARNT_SIGMAS: f32 = 3.0;

/// What has jumped.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Jumped {
    /// The tilt, back to what it was.
    Back,
    /// The tilt, to another one.
    Away,
    /// The place.
    Aside,
}

/// The last jump.
#[derive(Clone, Copy, Debug)]
struct Last {
    at: Micros,
    /// Nothing had jumped for [`PROVEN_US`].
    was_calm: bool,
    /// The tilt before it, and by how much all frames that saw a part of it have moved it, pitch and roll.
    from_rad: Vector2<f32>,
    by_rad: Vector2<f32>,
    jumped: Jumped,
    /// It is one back by what a single match says or while the velocity may be anything, or none of the tilt.
    is_unproven: bool,
    /// Since when no match has lain outside what was expected; from when a turn has told it on, if one has.
    quiet_since: Micros,
    is_told: bool,
}

/// What jumped, as far as nothing has told.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jumps {
    /// What pitch and roll are off where it was they that have jumped each time, radians; until a turn has told.
    to_rad: Option<Vector2<f32>>,
    last: Option<Last>,
    /// The tilt that matches have told at last, and that the estimate goes back to, radians.
    usual_rad: [f32; 2],
    /// How far the last match lay off what was expected, as far as the estimate has followed it, east and north, metres.
    off_before: Option<Vector2<f32>>,
}

/// What there is from a jump on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Begun {
    /// The match, as it is where the tilt is what it is more likely to be.
    pub found: Found,
    /// One sigma of that tilt, radians.
    pub sigma_rad: f32,
    /// By how much the tilt may be another one than the frame was rectified with, radians, beside that.
    pub off_rad: f32,
}

impl Last {
    /// How long all has to be as expected for it to be proven, microseconds.
    fn proven_us(&self) -> i32 {
        match (self.jumped, self.is_unproven) {
            (Jumped::Away, _) => CALM_US,
            (_, true) => PROVEN_US,
            (_, false) => 0,
        }
    }
}

impl Jumps {
    pub(super) const fn new() -> Self {
        Jumps { to_rad: None, last: None, usual_rad: [0.0; 2], off_before: None }
    }

    /// What the tilt goes back to; nothing while a jump is open.
    pub(super) fn usual_rad(&self) -> Option<[f32; 2]> {
        self.to_rad.is_none().then_some(self.usual_rad)
    }

    /// Whether a frame may have seen a part of a jump alone.
    pub(super) fn is_jumping(&self, at: Micros) -> bool {
        self.last.is_some_and(|last| (0..JUMP_ONSET_US).contains(&at.since(last.at)))
    }

    /// By how much the tilt may be off, though a match said that it is back or that it was the place, or a turn has told it a moment ago,
    /// radians.
    pub(super) fn unproven_rad(&self, at: Micros) -> f32 {
        let is_open = |last: &Last| (0..last.proven_us()).contains(&at.since(last.quiet_since));
        self.last.filter(is_open).map_or(0.0, |last| last.by_rad.norm())
    }

    /// What is known of the tilt from velocities on that were reported for an instant, which may tell a jump.
    pub(super) fn known(&mut self, at: Micros, estimate: &Estimate, unknown: &Unknown) {
        let is_recent = self.last.is_some_and(|last| at.since(last.at) < PERIOD_US);
        if is_recent && unknown.velocity_m_per_s > KNOWN_M_PER_S {
            self.swung(at, unknown.tilt_rad);
        }
        let is_open = self.unproven_rad(at) > 0.0;
        let Some(last) = &mut self.last else { return };
        if self.to_rad.is_some() && estimate.tilt_sigma_rad() <= TOLD * unknown.tilt_rad {
            self.to_rad = None;
            (last.is_told, last.quiet_since) = (true, at);
        } else if last.is_told && !is_open {
            last.is_told = false;
            self.usual_rad = estimate.tilt_rad();
        }
    }

    /// The tilt goes back to this one from now on, pitch and roll in radians: no jump has made it so.
    pub(super) fn goes_back_to(&mut self, usual_rad: [f32; 2]) {
        self.usual_rad = usual_rad;
    }

    /// A match lies outside what was expected, or nothing would, since the velocity may be anything: what is not proven yet has to hold from
    /// here on.
    /// `by_rad`: by how much.
    pub(super) fn swung(&mut self, at: Micros, by_rad: f32) {
        let is_open = by_rad > 0.0 && self.unproven_rad(at) > 0.0;
        if let Some(last) = self.last.as_mut().filter(|_| is_open) {
            last.quiet_since = at;
        }
    }

    /// By how much a match is off, east and north in metres, with what the frame before may have seen of the same jump; only where that brings
    /// the tilt back from one frame to the next.
    pub(super) fn back_by(
        &mut self,
        (at, before): (Micros, Micros),
        expected: &Estimate,
        (found, &Innovation { off, squares, .. }): (&Found, &Innovation),
        unknown: &Unknown,
    ) -> Option<Vector2<f32>> {
        let with_last = self.off_before.filter(|_| at.since(before) < JUMP_ONSET_US).map(|before| before + off);
        self.off_before = Some(off);
        // What has jumped a moment ago swings back, too.
        let is_usual = with_last.is_none() || squares <= TRANSIENT;
        if is_usual || self.last.is_none_or(|last| at.since(last.at) < PROVEN_US) {
            return None;
        }
        let from_rad = self.to_rad.unwrap_or(expected.tilt_rad().into());
        [Some(off), with_last].into_iter().flatten().find(|off| {
            let by_rad = by_tilt_rad(*off, found);
            let is_far = by_rad.norm() > LEARNT_SIGMAS * unknown.tilt_rad;
            is_far && self.usual().any(|usual| (from_rad + by_rad - usual).norm() <= BACK_SHARE * by_rad.norm())
        })
    }

    /// The estimate has followed that match.
    pub(super) fn followed(&mut self, estimate: &Estimate, found: &Found) {
        let left = estimate.innovation(found, white(found, 0.0)).off;
        self.off_before = self.off_before.map(|off| off - left);
    }

    /// The match of a frame at an instant is so far off, east and north in metres, from what was `expected` by the one before it.
    /// `known_rad`: what the tilt was taken to be.
    pub(super) fn jumped(
        &mut self,
        (at, before, off): (Micros, Micros, Vector2<f32>),
        (known_rad, expected): ([f32; 2], Option<Estimate>),
        found: &Found,
        unknown: &Unknown,
    ) -> Begun {
        let known_rad = Vector2::from(known_rad);
        let more_rad = by_tilt_rad(off, found);
        let beside_rad = expected.map_or(0.0, |estimate| estimate.position_sigma_m() / found.height_m);
        // A frame before this one may have seen a part of it.
        let last = self.last.filter(|_| self.is_jumping(at));
        let from_rad = last.map_or(self.to_rad.unwrap_or(known_rad), |last| last.from_rad);
        let by_rad = more_rad + last.map_or(Vector2::zeros(), |last| last.by_rad);
        let by_tilt = by_rad.norm() <= JUMP_MAX_RAD + beside_rad;
        let to_rad = if by_tilt { from_rad + by_rad } else { from_rad };
        let likely = expected.filter(|_| by_tilt).and_then(|estimate| self.likely_back(at, &estimate, found, unknown));
        let is_near = |usual: &Vector2<f32>| by_tilt && (to_rad - usual).norm() <= BACK_SHARE * by_rad.norm();
        // One that was back stays so as long as little follows.
        let stays =
            |last: &Last| by_tilt && last.jumped == Jumped::Back && more_rad.norm() <= BACK_SHARE * last.by_rad.norm();
        let stays = || last.filter(stays).map(|_| self.usual_rad.into());
        let back = likely.or_else(|| self.usual().find(is_near)).or_else(stays);
        let begun_at = last.map_or(at, |last| last.at);
        let quiet_since = begun_at;
        let is_sudden = at.since(before) < JUMP_ONSET_US;
        let is_swinging = !is_sudden && self.last.is_some_and(|last| at.since(last.at) < PERIOD_US);
        let was_unproven = last.is_some_and(|last| last.is_unproven);
        // What is back from one frame to the next, or so near that it is no chance, is so whatever the velocity is, unless it has swung a moment
        // ago.
        let was_calm =
            self.last.is_none_or(|last| at.since(last.at) >= PROVEN_US || last.at == begun_at && last.was_calm);
        let is_exact = (to_rad - back.unwrap_or(to_rad)).norm() <= LEARNT_SIGMAS * unknown.tilt_rad;
        let is_hidden = unknown.velocity_m_per_s > KNOWN_M_PER_S && !(was_calm && (is_sudden || is_exact));
        let is_unproven = was_unproven || !by_tilt || is_hidden || likely.is_some() && is_swinging;
        let jumped = match back {
            Some(_) => Jumped::Back,
            None if by_tilt => Jumped::Away,
            None => Jumped::Aside,
        };
        let last_jump =
            Last { at: begun_at, was_calm, from_rad, by_rad, jumped, is_unproven, quiet_since, is_told: false };
        self.last = Some(last_jump);
        if let Some(back) = back {
            self.usual_rad = back.into();
        }
        let tilt_rad = back.unwrap_or(known_rad);
        let left_rad = likely.unwrap_or(to_rad) - tilt_rad;
        let sigma_rad = hypot(unknown.tilt_rad, sqrt(0.5 * left_rad.norm_squared()));
        self.to_rad = (sigma_rad > TOLD * unknown.tilt_rad).then_some(tilt_rad + left_rad);
        // The frame may have seen a part of this one, too.
        let seen_rad = last.map_or(0.0, |_| more_rad.norm());
        let off_rad = (known_rad - tilt_rad).norm().max(seen_rad);
        Begun { found: found.with_tilt(tilt_rad.into()), sigma_rad, off_rad }
    }

    /// The tilt that it was before a jump some time ago, where that explains a match best.
    pub(super) fn likely_back(
        &self,
        at: Micros,
        estimate: &Estimate,
        found: &Found,
        unknown: &Unknown,
    ) -> Option<Vector2<f32>> {
        if self.last.is_none_or(|last| at.since(last.at) < CALM_US) {
            return None;
        }
        let known_rad = Vector2::from(estimate.tilt_rad());
        let explains = |usual: &Vector2<f32>| {
            let back = estimate.with_tilt((*usual).into(), unknown.tilt_rad);
            let is_off = (known_rad - usual).norm() > LEARNT_SIGMAS * unknown.tilt_rad;
            is_off && explains_best(&back.innovation(found, white(found, 0.0)), found)
        };
        self.usual().find(explains)
    }

    /// What it was before the jumps, and what is reported.
    fn usual(&self) -> impl Iterator<Item = Vector2<f32>> + use<> {
        [Vector2::from(self.usual_rad), Vector2::zeros()].into_iter()
    }
}

/// Pitch and roll that move a match so far, east and north in metres.
fn by_tilt_rad(off: Vector2<f32>, found: &Found) -> Vector2<f32> {
    moved_by_tilt(found).transpose() * off / squared(found.height_m)
}

/// Whether a tilt that was assumed explains a match [`BACK_ODDS`] times better than a jump of the place to anywhere within
/// [`JUMP_MAX_RAD`]: the normal density there, e^(-x/2) / (2 pi s), against one over that circle's area.
fn explains_best(innovation: &Innovation, found: &Found) -> bool {
    let ratio = 0.5 * squared(JUMP_MAX_RAD * found.height_m) / (BACK_ODDS * innovation.spread());
    ratio > 1.0 && 0.5 * innovation.squares <= ln(ratio)
}
