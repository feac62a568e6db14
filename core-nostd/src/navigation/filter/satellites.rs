//! Satellite navigation beside the matches: how far the map is off it, what it says of the tilt, and whether the two disagree.
//!
//! Three more states beside those of an estimate: the offset of the map, east and north (position by matches less position by
//! satellites), and by how much the receiver's positions are older than is usual. The offset is what both share for a whole flight: the
//! receiver's own error (reflections, ionosphere, satellites' clocks), the map's, and that of their reference systems. It is a
//! Gauss-Markov process, so that many positions a second do not average it away.
//!
//! This is a second estimate beside that of matches alone, which it never changes: what satellite navigation says can be forged. Of it
//! is used by how much its tilt differs, as long as that is within what matches alone say of the tilt, and as long as the two positions
//! do not disagree. Their difference is tested with the estimate of matches alone, as an average of the last positions against
//! both sigmas.
//!
//! Cost: while there are satellites as much again as the estimate by matches alone, and a position about what a match costs.

use super::JUMP;
use super::TRANSIENT;
use super::estimate::{Estimate, STATES, TILT, WANDER, carry_along, symmetric};
use super::found::{Found, Unknown, moved_by_tilt};
use crate::math::{hypot, squared};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

/// Time constant of the offset, seconds. Chosen: reflections at the vehicle change within minutes, what is left of troposphere and
/// ionosphere within half an hour.
const OFFSET_S: f32 = 600.0;
/// How much older than its stamp a position is, and one sigma of that, seconds. A receiver's message is stamped when it is handed over,
/// up to 0.2 s after the position's instant (0.12 to 0.22 s in ArduPilot's table of receivers): the middle, and a little more than the
/// sigma of what is spread evenly.
const LATE_S: f32 = 0.1;
const LATE_SIGMA_S: f32 = 0.06;
/// Least sigma that a receiver is believed, metres. Chosen: what it states leaves reflections out.
const SIGMA_MIN_M: f32 = 0.5;
/// A position that is known less well is none, metres. Chosen: what disagreed with it would not fit on most tiles.
const SIGMA_MAX_M: f32 = 100.0;
/// Positions that are averaged before they are held against the matches: two seconds of five a second.
const AVERAGED: f32 = 10.0;
/// Longest time between two of these, and between a position and the newest velocity, microseconds. Chosen: ten of five a second.
const GAP_US: i32 = 2_000_000;

/// A position of satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SatellitePosition {
    /// Its stamp.
    pub at: Micros,
    /// Where it puts the camera.
    pub local: Local,
    /// One sigma of each axis, as the receiver states it, metres.
    pub sigma_m: f32,
    /// One sigma of the map, each axis, metres.
    pub map_sigma_m: f32,
}

/// A position moved to the newest reported velocity.
pub(super) struct Moved {
    pub(super) position: SatellitePosition,
    pub(super) moment: Moment,
    /// What the way there may be off, each axis, square metres.
    pub(super) variance: f32,
}

/// The states of an estimate with the positions of satellites, and their covariance with the three.
#[derive(Clone, Copy, Debug)]
struct Joint {
    estimate: Estimate,
    cross: SMatrix<f32, STATES, 3>,
}

/// What is known by satellites.
#[derive(Clone, Debug)]
pub(super) struct Satellites {
    /// Sigmas of the three states where nothing is known of them: offset, offset, lateness; none before the first position.
    prior: Option<[f32; 3]>,
    state: Vector3<f32>,
    covariance: Matrix3<f32>,
    joint: Option<Joint>,
    /// By how much its tilt differs from that of matches alone, where it may be used.
    tilt_rad: Option<[f32; 2]>,
    /// Position by matches less that by satellites, averaged over so many.
    apart_m: Vector2<f32>,
    averaged: f32,
    disagrees: bool,
    waiting: Option<SatellitePosition>,
    newest_at: Micros,
}

impl Satellites {
    /// Nothing heard.
    pub(super) const fn new() -> Self {
        Satellites {
            prior: None,
            state: Vector3::new(0.0, 0.0, 0.0),
            covariance: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            joint: None,
            tilt_rad: None,
            apart_m: Vector2::new(0.0, 0.0),
            averaged: 0.0,
            disagrees: false,
            waiting: None,
            newest_at: Micros(0),
        }
    }

    /// A position was heard: it waits for the next reported velocity. One that came late, behind a newer one, is left out.
    pub(super) fn heard(&mut self, position: SatellitePosition) {
        let Local { east_m, north_m } = position.local;
        let is_sound = [east_m, north_m, position.map_sigma_m].iter().all(|n| n.is_finite());
        let since_us = position.at.since(self.newest_at);
        // No number is no small one.
        if !(is_sound && position.sigma_m <= SIGMA_MAX_M) || (-GAP_US..=0).contains(&since_us) {
            return;
        }
        self.newest_at = position.at;
        if !(0..=GAP_US).contains(&since_us) {
            self.averaged = 0.0;
        }
        let sigma_m = position.sigma_m.max(SIGMA_MIN_M);
        self.waiting = Some(SatellitePosition { sigma_m, ..position });
    }

    /// The position that waits, where its instant has come.
    pub(super) fn due(&mut self, now: Micros) -> Option<SatellitePosition> {
        let position = self.waiting.take_if(|position| now.since(position.at) >= 0)?;
        (now.since(position.at) <= GAP_US).then_some(position)
    }

    /// By how far matches and satellites disagree, metres, where they do.
    pub(super) fn disagreement_m(&self) -> Option<f32> {
        self.disagrees.then(|| self.apart_m.norm())
    }

    /// By how much pitch and roll are off beside what matches alone say, radians.
    pub(super) fn tilt_rad(&self) -> Option<[f32; 2]> {
        self.tilt_rad
    }

    /// Offset of the map east and north, metres, and the larger sigma.
    #[cfg(test)]
    pub(super) fn offset(&self) -> ([f32; 2], f32) {
        let sigma = self.covariance[(0, 0)].max(self.covariance[(1, 1)]).sqrt();
        ([self.state[0], self.state[1]], sigma)
    }

    /// Nothing is known of the offset any more.
    pub(super) fn forget_offset(&mut self) {
        (self.joint, self.tilt_rad, self.state) = (None, None, Vector3::zeros());
        let sigmas = self.prior.unwrap_or_default();
        self.covariance = Matrix3::from_diagonal(&Vector3::from(sigmas.map(squared)));
    }

    /// The estimate by matches has ended: what is known of the offset stays.
    pub(super) fn end(&mut self) {
        (self.joint, self.tilt_rad, self.averaged) = (None, None, 0.0);
    }

    /// The estimate by matches has begun anew: what is known of the offset stays.
    pub(super) fn begun(&mut self, settled: &Estimate) {
        self.averaged = 0.0;
        if let Some(joint) = &mut self.joint {
            *joint = Joint { estimate: *settled, cross: SMatrix::zeros() };
        }
    }

    /// The reported velocity has changed by what is no motion.
    pub(super) fn doubt_velocity(&mut self, change_m_per_s: [f32; 2]) {
        if let Some(joint) = &mut self.joint {
            joint.estimate.doubt_velocity(change_m_per_s);
        }
    }

    /// As [`Estimate::carry`].
    pub(super) fn propagate(
        &mut self,
        moments: (Moment, Moment),
        beside_m: f32,
        usual_rad: Option<[f32; 2]>,
        unknown: &Unknown,
    ) {
        let Some(prior) = self.prior else { return };
        let (before, moment) = moments;
        let seconds = moment.at.since(before.at) as f32 * 1e-6;
        let keeps_offset = 1.0 / (1.0 + seconds / OFFSET_S);
        self.state *= keeps_offset;
        self.covariance *= squared(keeps_offset);
        self.covariance += Matrix3::from_diagonal(&Vector3::from(prior.map(squared))) * (1.0 - squared(keeps_offset));
        let Some(Joint { estimate, cross }) = &mut self.joint else { return };
        estimate.propagate(moments, beside_m, usual_rad, unknown);
        carry_along(cross, seconds, usual_rad.is_some());
        *cross *= keeps_offset;
    }

    /// A match that the estimate by matches alone has taken. `white`: its covariance without the tilt that lasts.
    pub(super) fn matched(&mut self, found: &Found, white: Matrix2<f32>) {
        let Some(Joint { estimate, cross }) = self.joint else { return };
        let innovation = estimate.innovation(found, white);
        if innovation.squares > JUMP {
            // By matches alone it was expected: the satellites are wrong.
            return self.forget_offset();
        }
        let common = |states: usize| cross.fixed_view::<2, 3>(states, 0).transpose();
        let seen = common(0) + common(TILT) * moved_by_tilt(found).transpose() + common(WANDER) * found.height_m;
        self.learn(&seen, &innovation.seen, &innovation.inverse, innovation.off);
    }

    /// What the three states and the others have in common with a measurement, that one's inverse covariance, and how far it is off.
    fn learn(
        &mut self,
        seen: &SMatrix<f32, 3, 2>,
        seen_others: &SMatrix<f32, STATES, 2>,
        inverse: &Matrix2<f32>,
        off: Vector2<f32>,
    ) {
        let Some(Joint { estimate, cross }) = &mut self.joint else { return };
        let (gain, gain_others) = (seen * inverse, seen_others * inverse);
        estimate.state += gain_others * off;
        estimate.covariance = symmetric(&(estimate.covariance - gain_others * seen_others.transpose()));
        *cross -= gain_others * seen.transpose();
        self.state += gain * off;
        self.covariance = symmetric(&(self.covariance - gain * seen.transpose()));
    }

    /// A position, held against the estimate by matches alone.
    pub(super) fn take(&mut self, moved: &Moved, settled: &Estimate) {
        let Moved { position, moment, variance } = moved;
        let sigma_m = hypot(position.sigma_m, position.map_sigma_m);
        let is_first = self.prior.replace([sigma_m, sigma_m, LATE_SIGMA_S]).is_none();
        if is_first {
            self.forget_offset();
        }
        let velocity = Vector2::from(moment.velocity_m_per_s);
        let place = Vector2::new(position.local.east_m, position.local.north_m) + velocity * LATE_S;
        let white = squared(position.sigma_m) + variance;
        self.compare(place, velocity, white, settled);
        if self.disagrees {
            return self.forget_offset();
        }
        let Joint { estimate, cross } =
            *self.joint.get_or_insert(Joint { estimate: *settled, cross: SMatrix::zeros() });
        let expected =
            estimate.state.fixed_view::<2, 1>(0, 0) - self.state.fixed_view::<2, 1>(0, 0) - velocity * self.state[2];
        let seen_others = estimate.covariance.fixed_view::<STATES, 2>(0, 0)
            - cross.fixed_view::<STATES, 2>(0, 0)
            - cross.column(2) * velocity.transpose();
        let seen = cross.fixed_view::<2, 3>(0, 0).transpose()
            - self.covariance.fixed_view::<3, 2>(0, 0)
            - self.covariance.column(2) * velocity.transpose();
        let all = seen_others.fixed_view::<2, 2>(0, 0) - seen.fixed_view::<2, 2>(0, 0) - velocity * seen.row(2)
            + Matrix2::identity() * white;
        let off = place - expected;
        let Some(inverse) = all.try_inverse() else { return };
        // No number is no small one.
        if (off.transpose() * inverse * off)[(0, 0)] <= JUMP {
            self.learn(&seen, &seen_others, &inverse, off);
        }
    }

    /// Whether the positions of late are where matches alone say.
    fn compare(&mut self, place: Vector2<f32>, velocity: Vector2<f32>, white: f32, settled: &Estimate) {
        let (local, covariance) = settled.position();
        let apart_m = Vector2::new(local.east_m, local.north_m) - place;
        self.averaged = (self.averaged + 1.0).min(AVERAGED);
        self.apart_m += (apart_m - self.apart_m) / self.averaged;
        if self.averaged < AVERAGED {
            return;
        }
        let sigma_m = self.prior.unwrap_or_default()[0];
        let all = covariance
            + Matrix2::identity() * (squared(sigma_m) + white / AVERAGED)
            + velocity * velocity.transpose() * squared(LATE_SIGMA_S);
        let Some(inverse) = all.try_inverse() else { return };
        let squares = (self.apart_m.transpose() * inverse * self.apart_m)[(0, 0)];
        self.disagrees = squares > if self.disagrees { TRANSIENT } else { JUMP };
    }

    /// Positions and matches up to the newest velocity have been taken: what is left of what satellites say of the tilt.
    pub(super) fn settle(&mut self, settled: Option<&Estimate>) {
        self.tilt_rad = None;
        let (Some(Joint { estimate, .. }), Some(settled)) = (&self.joint, settled) else { return };
        let ([pitch, roll], [was_pitch, was_roll]) = (estimate.tilt_rad(), settled.tilt_rad());
        let off = Vector2::new(pitch - was_pitch, roll - was_roll);
        let squares = settled
            .tilt_covariance()
            .try_inverse()
            .map_or(f32::INFINITY, |inverse| (off.transpose() * inverse * off)[(0, 0)]);
        if estimate.is_sound()
            && self.state.iter().chain(&self.covariance).all(|n| n.is_finite())
            && squares <= TRANSIENT
        {
            self.tilt_rad = Some(off.into());
        } else {
            self.forget_offset();
        }
    }
}

#[cfg(test)]
mod tests;
