//! How far attitude and velocity are off, by matches against the way flown between them.
//!
//! A Kalman filter of six states: the position of the camera, the error of the reported velocity, and the error of the attitude in
//! the vehicle's own axes, pitch and roll. A match finds the nadir where the position is, less what the attitude's error moves it;
//! the reported velocity carries the position on. On a straight leg position and tilt cannot be told apart: what the tilt moves the
//! nadir by turns with the vehicle and the position does not, so that a turn tells them apart. An offset of the map does not turn
//! either: it stays in the position, and no match finds it.
//!
//! So the attitude that frames are rectified with is corrected by what turns have told, and the covariance of a fix holds what they
//! have not. A match that the filter did not expect is not explained: where it is believed all the same, the attitude may have
//! jumped as well as the position, and both are as uncertain as that from then on, until they jump back.
//!
//! The filter's position is sent to nobody: it would be the same matches again.
//!
//! Cost: some 900 instructions a frame, and 600 a match.

use super::reckoning::{Moment, way_m};
use crate::math::{hypot, sin_cos, sqrt, squared};
use crate::tile::Local;
use nalgebra::{Matrix2, SMatrix, Vector2};

type Covariance = SMatrix<f32, 6, 6>;
type State = SMatrix<f32, 6, 1>;
/// Where the states begin: position, velocity, tilt.
const VELOCITY: usize = 2;
const TILT: usize = 4;

/// Time constants by which velocity and attitude forget their errors, seconds. Chosen: an estimator with fixes mends its velocity within
/// half a minute; the bias of an attitude is that of its accelerometers and lasts minutes.
const VELOCITY_S: f32 = 30.0;
const TILT_S: f32 = 100.0;
/// Time constant by which a tilt is forgotten that comes and goes, seconds. Chosen: a swing of an attitude that is late or scaled has
/// gone on to the other side within that.
const TRANSIENT_S: f32 = 5.0;
/// Longest way between two frames, microseconds: beyond the filter begins anew.
const STEP_MAX_US: i32 = 9_000_000;
/// What the mean of two velocities is off as a share of their difference, of a turn by a radian: the way along an arc is by a twelfth of
/// the angle's square longer than its chord's velocities say, and no more than this up to half a circle.
const TURN_SHARE: f32 = 0.11;
/// How late a reported velocity is, seconds: positions come five times a second, and take as long to arrive. While the vehicle turns it
/// is off by its acceleration times that.
const LATE_S: f32 = 0.3;
/// One sigma of a way beside that of the velocities' errors, metres: velocities come in whole centimetres a second, five times a second.
const WAY_M: f32 = 0.05;
/// Innovations squared, in sigmas, of two degrees of freedom: beyond the first once in a hundred the tilt comes and goes, beyond the
/// second once in a hundred thousand something has jumped.
const TRANSIENT: f32 = 9.2;
const JUMP: f32 = 23.0;

/// One sigma of what the filter does not know when it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Of the velocity, each axis, m/s.
    pub velocity_m_per_s: f32,
    /// Of pitch and roll, each, that lasts, radians.
    pub tilt_rad: f32,
}

/// A match, as far as it concerns the filter.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Where it puts the nadir.
    pub nadir: Local,
    /// Covariance of that without the tilt's error, (east, north), square metres.
    pub covariance: Matrix2<f32>,
    /// One sigma of a tilt that comes and goes, radians.
    pub transient_rad: f32,
    /// Height above ground, metres.
    pub height_m: f32,
    /// Heading, clockwise from grid north, radians.
    pub heading_rad: f32,
    /// How far east and north of the place that counted before, where it has overruled that, metres.
    pub overruled_m: Option<[f32; 2]>,
}

/// What is estimated.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    state: State,
    covariance: Covariance,
}

/// The filter.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    moment: Moment,
    estimate: Option<Estimate>,
    /// One sigma of a tilt that comes and goes, and that matches have shown, radians.
    transient_rad: f32,
    /// By how much pitch and roll have jumped since all agreed, where it was they that have, radians.
    jumped_rad: Vector2<f32>,
}

/// How an error of pitch and roll moves the nadir that is found, (east, north) metres for each radian: nose up too far by so much, it
/// is found as far behind; right wing down too far, to the right.
fn moved_by_tilt(height_m: f32, heading_rad: f32) -> Matrix2<f32> {
    let (sin, cos) = sin_cos(heading_rad);
    Matrix2::new(-sin, cos, -cos, -sin) * height_m
}

/// Single precision leaves halves that differ, and what differs grows.
fn symmetric(covariance: &Covariance) -> Covariance {
    (covariance + covariance.transpose()) * 0.5
}

impl Filter {
    /// Nothing known.
    pub const fn new() -> Self {
        let moment = Moment { at: crate::units::Micros(0), velocity_m_per_s: [0.0; 2] };
        Filter { moment, estimate: None, transient_rad: 0.0, jumped_rad: Vector2::new(0.0, 0.0) }
    }

    /// Error of pitch and roll that is known, radians: what is reported less what is true.
    pub fn tilt_rad(&self) -> [f32; 2] {
        self.estimate.map_or([0.0; 2], |estimate| [estimate.state[TILT], estimate.state[TILT + 1]])
    }

    /// One sigma of each of the tilts that matches have shown lately and nothing explains, radians: one that comes and goes, or what
    /// is left of a jump that neither has been taken back nor a turn has told. `unknown_rad`: where nothing is known.
    pub fn unexplained_rad(&self, unknown_rad: f32) -> f32 {
        sqrt((squared(self.tilt_sigma_rad(unknown_rad)) - squared(unknown_rad)).max(0.0))
    }

    /// One sigma of pitch's and roll's error that is left of it, the larger one, radians. `unknown_rad`: where nothing is known.
    pub fn tilt_sigma_rad(&self, unknown_rad: f32) -> f32 {
        let left = |estimate: Estimate| {
            let [pitch, roll] = [TILT, TILT + 1].map(|axis| estimate.covariance[(axis, axis)]);
            sqrt(pitch.max(roll).max(0.0))
        };
        hypot(self.estimate.map_or(unknown_rad, left), self.transient_rad)
    }

    /// Carries it on to a frame.
    pub fn carry(&mut self, moment: Moment, unknown: &Unknown) {
        let before = core::mem::replace(&mut self.moment, moment);
        let step_us = moment.at.since(before.at);
        let seconds = step_us as f32 * 1e-6;
        if !(0..=STEP_MAX_US).contains(&step_us) {
            *self = Filter { moment, ..Filter::new() };
            return;
        }
        self.transient_rad /= 1.0 + seconds / TRANSIENT_S;
        self.jumped_rad /= 1.0 + seconds / TILT_S;
        let Some(Estimate { state, covariance }) = &mut self.estimate else { return };
        let [east, north] = way_m(before, moment);
        let keeps = [1.0 / (1.0 + seconds / VELOCITY_S), 1.0 / (1.0 + seconds / TILT_S)];
        for axis in 0..2 {
            // True is the reported velocity less its error.
            state[axis] -= state[VELOCITY + axis] * seconds;
            state[VELOCITY + axis] *= keeps[0];
            state[TILT + axis] *= keeps[1];
        }
        state[0] += east;
        state[1] += north;
        let mut by = Covariance::identity();
        for axis in 0..2 {
            by[(axis, VELOCITY + axis)] = -seconds;
            by[(VELOCITY + axis, VELOCITY + axis)] = keeps[0];
            by[(TILT + axis, TILT + axis)] = keeps[1];
        }
        *covariance = symmetric(&(by * *covariance * by.transpose()));
        let turned = hypot(
            moment.velocity_m_per_s[0] - before.velocity_m_per_s[0],
            moment.velocity_m_per_s[1] - before.velocity_m_per_s[1],
        );
        let speed = hypot(moment.velocity_m_per_s[0], moment.velocity_m_per_s[1]).max(1.0);
        let bent_m = TURN_SHARE * (turned / speed).min(core::f32::consts::PI) * turned * seconds;
        let fresh = |keep: f32, sigma: f32| (1.0 - squared(keep)) * squared(sigma);
        for axis in 0..2 {
            covariance[(axis, axis)] += squared(WAY_M) + squared(bent_m);
            let late = squared(turned / seconds.max(0.05) * LATE_S);
            let velocity = &mut covariance[(VELOCITY + axis, VELOCITY + axis)];
            *velocity = (*velocity + fresh(keeps[0], unknown.velocity_m_per_s)).max(late);
            covariance[(TILT + axis, TILT + axis)] += fresh(keeps[1], unknown.tilt_rad);
        }
    }

    /// A match of the frame that it was carried on to, which is believed. One sigma of a tilt, radians, by which its fix is more
    /// uncertain than was known before: 0 for a match that was expected.
    pub fn matched(&mut self, found: &Found, unknown: &Unknown) -> f32 {
        let moved = moved_by_tilt(found.height_m, found.heading_rad);
        let transient = hypot(found.transient_rad, self.transient_rad);
        let white = found.covariance + moved * moved.transpose() * squared(transient);
        if let Some(aside) = found.overruled_m {
            return self.jumped(Vector2::from(aside), (found, white, moved), unknown);
        }
        let Some(estimate) = self.estimate else {
            self.estimate = Some(Estimate::begun(found, white, moved, [0.0; 2], unknown));
            return 0.0;
        };
        let off = Vector2::new(found.nadir.east_m - estimate.state[0], found.nadir.north_m - estimate.state[1]);
        let seen = estimate.seen(moved);
        let all = seen.fixed_view::<2, 2>(0, 0) + moved * seen.fixed_view::<2, 2>(TILT, 0) + white;
        let inverse = all.try_inverse();
        let squares = inverse.map_or(f32::INFINITY, |inverse| (off.transpose() * inverse * off)[(0, 0)]);
        let beyond_rad = sqrt((0.5 * (off.norm_squared() - all.trace())).max(0.0)) / found.height_m;
        if squares.is_nan() || squares > JUMP {
            return self.jumped(off, (found, white, moved), unknown);
        }
        if squares > TRANSIENT && beyond_rad > self.transient_rad {
            let more_rad = sqrt(squared(beyond_rad) - squared(self.transient_rad));
            self.transient_rad = beyond_rad;
            self.matched(found, unknown);
            return more_rad;
        }
        if let Some(inverse) = inverse {
            let gain = seen * inverse;
            let Estimate { state, covariance } = estimate;
            let covariance = symmetric(&(covariance - gain * seen.transpose()));
            self.estimate = Some(Estimate { state: state + gain * off, covariance });
        }
        0.0
    }
}

impl Filter {
    /// A match that is so far off what was expected begins anew; the tilt by which it may have been is not known any more, and what of
    /// that is news is returned, radians.
    fn jumped(
        &mut self,
        off: Vector2<f32>,
        (found, white, moved): (&Found, Matrix2<f32>, Matrix2<f32>),
        unknown: &Unknown,
    ) -> f32 {
        let known_rad = self.tilt_sigma_rad(unknown.tilt_rad);
        self.jumped_rad += moved.transpose() * off / squared(found.height_m);
        let tilt_rad = hypot(unknown.tilt_rad, sqrt(0.5 * self.jumped_rad.norm_squared()));
        let unknown = Unknown { tilt_rad, ..*unknown };
        self.estimate = Some(Estimate::begun(found, white, moved, self.tilt_rad(), &unknown));
        sqrt((squared(tilt_rad) - squared(known_rad)).max(0.0))
    }
}

impl Default for Filter {
    fn default() -> Self {
        Filter::new()
    }
}

impl Estimate {
    /// From a match on that was rectified with an attitude less `tilt_rad`.
    fn begun(
        found: &Found,
        white: Matrix2<f32>,
        moved: Matrix2<f32>,
        tilt_rad: [f32; 2],
        unknown: &Unknown,
    ) -> Estimate {
        let tilt = squared(unknown.tilt_rad);
        let mut covariance = Covariance::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&(white + moved * moved.transpose() * tilt));
        covariance.fixed_view_mut::<2, 2>(0, TILT).copy_from(&(moved * -tilt));
        covariance.fixed_view_mut::<2, 2>(TILT, 0).copy_from(&(moved.transpose() * -tilt));
        for axis in 0..2 {
            covariance[(VELOCITY + axis, VELOCITY + axis)] = squared(unknown.velocity_m_per_s);
            covariance[(TILT + axis, TILT + axis)] = tilt;
        }
        let Local { east_m, north_m } = found.nadir;
        Estimate { state: State::from([east_m, north_m, 0.0, 0.0, tilt_rad[0], tilt_rad[1]]), covariance }
    }

    /// Covariance of the states with the nadir that is found.
    fn seen(&self, moved: Matrix2<f32>) -> SMatrix<f32, 6, 2> {
        self.covariance.fixed_view::<6, 2>(0, 0) + self.covariance.fixed_view::<6, 2>(0, TILT) * moved.transpose()
    }
}

#[cfg(test)]
mod tests;
