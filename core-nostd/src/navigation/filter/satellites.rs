//! Satellite navigation beside the matches: offset of the map, correction of the tilt, test of agreement.
//!
//! Three states are added to those of an estimate: the map's offset, east and north (position by matches less position
//! by satellites), and the receiver's latency beyond the usual one. The offset holds all that is common to a flight:
//! the receiver's own error (reflections, ionosphere, satellite clocks), the map's, and that of their reference
//! systems. It is a Gauss-Markov process, so that many positions a second do not average it away.
//!
//! This second estimate never changes the one by matches alone, since satellite navigation can be forged. Only its
//! difference in tilt is used, while that is consistent with matches alone and the two positions agree. Agreement is
//! tested against the estimate by matches alone, with an average of the last positions and both sigmas.
//!
//! Cost: while there are satellites, that of the estimate by matches alone again, and about a match for each position.

use super::JUMP_GATE;
use super::TRANSIENT_GATE;
use super::estimate::{Estimate, STATES, TILT, WANDER, propagate_columns, symmetric};
use super::measurement::{Measurement, PriorSigmas, tilt_jacobian};
use crate::math::{hypot, squared};
use crate::navigation::reckoning::Moment;
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2, Vector3};

/// Correlation time of the offset, seconds. Chosen: reflections at the vehicle change within minutes, the remaining
/// errors of troposphere and ionosphere within half an hour.
const OFFSET_S: f32 = 600.0;
/// Latency of a position against its stamp, and its sigma, seconds. A receiver's message is stamped when it is handed
/// over, up to 0.2 s after the position's instant (0.12 to 0.22 s in ArduPilot's table of receivers): the middle, and a
/// little more than the sigma of a uniform distribution.
const LATENCY_S: f32 = 0.1;
const LATENCY_SIGMA_S: f32 = 0.06;
/// Lower limit of a receiver's stated sigma, metres. Chosen: receivers leave reflections out.
const SIGMA_MIN_M: f32 = 0.5;
/// Positions with a larger sigma are ignored, metres. Chosen: what disagreed with it would not fit on most tiles.
const SIGMA_MAX_M: f32 = 100.0;
/// Positions that are averaged for the test of agreement: two seconds of five a second.
const AVERAGED: f32 = 10.0;
/// Longest gap between two of these, and between a position and the newest velocity, microseconds. Chosen: ten of five
/// a second.
const GAP_US: i32 = 2_000_000;

/// A position of satellite navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SatellitePosition {
    /// Its stamp.
    pub at: Micros,
    /// Position of the camera.
    pub local: Local,
    /// The receiver's stated sigma, each axis, metres.
    pub sigma_m: f32,
    /// Sigma of the map, each axis, metres.
    pub map_sigma_m: f32,
}

/// A position moved to the instant of the newest reported velocity.
pub(super) struct Moved {
    pub(super) position: SatellitePosition,
    pub(super) moment: Moment,
    /// Variance of that displacement, each axis, square metres.
    pub(super) variance: f32,
}

/// The estimate that includes satellite positions, and its covariance with the three states.
#[derive(Clone, Copy, Debug)]
struct Joint {
    estimate: Estimate,
    cross: SMatrix<f32, STATES, 3>,
}

/// State of the satellite filter.
#[derive(Clone, Debug)]
pub(super) struct Satellites {
    /// Prior sigmas of the three states: offset east and north, metres, latency, seconds; `None` before the first
    /// position.
    offset_prior: Option<[f32; 3]>,
    state: Vector3<f32>,
    covariance: Matrix3<f32>,
    joint: Option<Joint>,
    /// Tilt of the joint estimate less that of matches alone, if it may be used.
    tilt_rad: Option<[f32; 2]>,
    /// Mean difference, position by matches less that by satellites, and number of positions in it.
    difference_m: Vector2<f32>,
    averaged: f32,
    disagrees: bool,
    pending: Option<SatellitePosition>,
    newest_at: Micros,
}

impl Satellites {
    /// Without any position.
    pub(super) const fn new() -> Self {
        Satellites {
            offset_prior: None,
            state: Vector3::new(0.0, 0.0, 0.0),
            covariance: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            joint: None,
            tilt_rad: None,
            difference_m: Vector2::new(0.0, 0.0),
            averaged: 0.0,
            disagrees: false,
            pending: None,
            newest_at: Micros(0),
        }
    }

    /// Takes a position, which waits for the next reported velocity. One older than the newest is ignored.
    pub(super) fn receive(&mut self, position: SatellitePosition) {
        let Local { east_m, north_m } = position.local;
        let is_valid = [east_m, north_m, position.map_sigma_m].iter().all(|n| n.is_finite());
        let since_us = position.at.since(self.newest_at);
        // Written so that a NaN is refused.
        if !(is_valid && position.sigma_m <= SIGMA_MAX_M) || (-GAP_US..=0).contains(&since_us) {
            return;
        }
        self.newest_at = position.at;
        if !(0..=GAP_US).contains(&since_us) {
            self.averaged = 0.0;
        }
        let sigma_m = position.sigma_m.max(SIGMA_MIN_M);
        self.pending = Some(SatellitePosition { sigma_m, ..position });
    }

    /// The waiting position, if its instant has been reached.
    pub(super) fn due(&mut self, now: Micros) -> Option<SatellitePosition> {
        let position = self.pending.take_if(|position| now.since(position.at) >= 0)?;
        (now.since(position.at) <= GAP_US).then_some(position)
    }

    /// Distance between matches and satellites, metres, if they disagree.
    pub(super) fn disagreement_m(&self) -> Option<f32> {
        self.disagrees.then(|| self.difference_m.norm())
    }

    /// Correction of the tilt by matches alone, pitch and roll, radians.
    pub(super) fn tilt_rad(&self) -> Option<[f32; 2]> {
        self.tilt_rad
    }

    /// Offset of the map east and north, metres, and its larger sigma.
    #[cfg(test)]
    pub(super) fn offset(&self) -> ([f32; 2], f32) {
        let sigma = self.covariance[(0, 0)].max(self.covariance[(1, 1)]).sqrt();
        ([self.state[0], self.state[1]], sigma)
    }

    /// Resets the offset to its prior.
    pub(super) fn reset_offset(&mut self) {
        (self.joint, self.tilt_rad, self.state) = (None, None, Vector3::zeros());
        let sigmas = self.offset_prior.unwrap_or_default();
        self.covariance = Matrix3::from_diagonal(&Vector3::from(sigmas.map(squared)));
    }

    /// The estimate by matches was reset; the offset is kept.
    pub(super) fn stop(&mut self) {
        (self.joint, self.tilt_rad, self.averaged) = (None, None, 0.0);
    }

    /// The estimate by matches was restarted; the offset is kept.
    pub(super) fn restart(&mut self, settled: &Estimate) {
        self.averaged = 0.0;
        if let Some(joint) = &mut self.joint {
            *joint = Joint { estimate: *settled, cross: SMatrix::zeros() };
        }
    }

    /// The reported velocity has changed by what is no motion.
    pub(super) fn inflate_velocity(&mut self, change_m_per_s: [f32; 2]) {
        if let Some(joint) = &mut self.joint {
            joint.estimate.inflate_velocity(change_m_per_s);
        }
    }

    /// As [`Estimate::propagate`].
    pub(super) fn propagate(
        &mut self,
        moments: (Moment, Moment),
        displacement_sigma_m: f32,
        mean_rad: Option<[f32; 2]>,
        prior: &PriorSigmas,
    ) {
        let Some(offset_prior) = self.offset_prior else { return };
        let (before, moment) = moments;
        let seconds = moment.at.since(before.at) as f32 * 1e-6;
        let keeps_offset = 1.0 / (1.0 + seconds / OFFSET_S);
        self.state *= keeps_offset;
        self.covariance *= squared(keeps_offset);
        self.covariance +=
            Matrix3::from_diagonal(&Vector3::from(offset_prior.map(squared))) * (1.0 - squared(keeps_offset));
        let Some(Joint { estimate, cross }) = &mut self.joint else { return };
        estimate.propagate(moments, displacement_sigma_m, mean_rad, prior);
        propagate_columns(cross, seconds, mean_rad.is_some());
        *cross *= keeps_offset;
    }

    /// Updates by a match that the estimate by matches alone has taken. `white`: its covariance without the constant
    /// tilt.
    pub(super) fn matched(&mut self, measurement: &Measurement, white: Matrix2<f32>) {
        let Some(Joint { estimate, cross }) = self.joint else { return };
        let innovation = estimate.innovation(measurement, white);
        if innovation.nis > JUMP_GATE {
            // It was consistent with matches alone, so the satellites are wrong.
            return self.reset_offset();
        }
        let common = |states: usize| cross.fixed_view::<2, 3>(states, 0).transpose();
        let seen =
            common(0) + common(TILT) * tilt_jacobian(measurement).transpose() + common(WANDER) * measurement.height_m;
        self.kalman_update(&seen, &innovation.cross_covariance, &innovation.inverse, innovation.off);
    }

    /// Kalman update: covariance of the three states (`seen`) and of the others with the measurement, its inverse
    /// covariance, and the innovation.
    fn kalman_update(
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

    /// Updates by a position, after testing it against the estimate by matches alone.
    pub(super) fn update(&mut self, moved: &Moved, settled: &Estimate) {
        let Moved { position, moment, variance } = moved;
        let sigma_m = hypot(position.sigma_m, position.map_sigma_m);
        let is_first = self.offset_prior.replace([sigma_m, sigma_m, LATENCY_SIGMA_S]).is_none();
        if is_first {
            self.reset_offset();
        }
        let velocity = Vector2::from(moment.velocity_m_per_s);
        let position_m = Vector2::new(position.local.east_m, position.local.north_m) + velocity * LATENCY_S;
        let white = squared(position.sigma_m) + variance;
        self.compare(position_m, velocity, white, settled);
        if self.disagrees {
            return self.reset_offset();
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
        let off = position_m - expected;
        let Some(inverse) = all.try_inverse() else { return };
        // Written so that a NaN is refused.
        if (off.transpose() * inverse * off)[(0, 0)] <= JUMP_GATE {
            self.kalman_update(&seen, &seen_others, &inverse, off);
        }
    }

    /// Tests whether the mean of the last positions agrees with matches alone.
    fn compare(&mut self, position_m: Vector2<f32>, velocity: Vector2<f32>, white: f32, settled: &Estimate) {
        let (local, covariance) = settled.position();
        let difference_m = Vector2::new(local.east_m, local.north_m) - position_m;
        self.averaged = (self.averaged + 1.0).min(AVERAGED);
        self.difference_m += (difference_m - self.difference_m) / self.averaged;
        if self.averaged < AVERAGED {
            return;
        }
        let sigma_m = self.offset_prior.unwrap_or_default()[0];
        let all = covariance
            + Matrix2::identity() * (squared(sigma_m) + white / AVERAGED)
            + velocity * velocity.transpose() * squared(LATENCY_SIGMA_S);
        let Some(inverse) = all.try_inverse() else { return };
        let nis = (self.difference_m.transpose() * inverse * self.difference_m)[(0, 0)];
        self.disagrees = nis > if self.disagrees { TRANSIENT_GATE } else { JUMP_GATE };
    }

    /// After all positions and matches up to the newest velocity: the correction of the tilt.
    pub(super) fn correct_tilt(&mut self, settled: Option<&Estimate>) {
        self.tilt_rad = None;
        let (Some(Joint { estimate, .. }), Some(settled)) = (&self.joint, settled) else { return };
        let ([pitch, roll], [was_pitch, was_roll]) = (estimate.tilt_rad(), settled.tilt_rad());
        let off = Vector2::new(pitch - was_pitch, roll - was_roll);
        let nis = settled
            .tilt_covariance()
            .try_inverse()
            .map_or(f32::INFINITY, |inverse| (off.transpose() * inverse * off)[(0, 0)]);
        if estimate.is_valid()
            && self.state.iter().chain(&self.covariance).all(|n| n.is_finite())
            && nis <= TRANSIENT_GATE
        {
            self.tilt_rad = Some(off.into());
        } else {
            self.reset_offset();
        }
    }
}

#[cfg(test)]
mod tests;
