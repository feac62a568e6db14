//! Position, error of the velocity and error of the attitude, and how well they are known.
//!
//! The attitude's error has two parts. What comes from an accelerometer's bias, or from how the camera was mounted, lasts, and turns
//! with the vehicle: the *tilt*. What an estimator makes of its gyroscopes and of the positions that it is given comes and goes within
//! ten seconds, and stays with the ground's axes: the *wander*.

use super::found::{Found, Unknown, moved_by_tilt};
use crate::math::{beside, hypot, sqrt, squared};
use crate::navigation::reckoning::{Moment, displacement_m};
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, SMatrix, Vector2};

/// One sigma of the tilt and of the wander that together are the attitude's error, each axis, radians.
pub(super) fn parts_rad(unknown: &Unknown) -> [f32; 2] {
    let wander = (WANDER_SHARE * unknown.tilt_rad).min(WANDER_MAX_RAD);
    let lasts = sqrt((squared(unknown.tilt_rad) - squared(wander)).max(0.0));
    [lasts, beside(wander, unknown.swings_rad)]
}

type Covariance = SMatrix<f32, STATES, STATES>;
type State = SMatrix<f32, STATES, 1>;
/// Where the states begin: position, velocity, tilt, wander.
pub(super) const VELOCITY: usize = 2;
pub(super) const TILT: usize = 4;
pub(super) const WANDER: usize = 6;
pub(super) const STATES: usize = 8;

/// Time constants by which velocity, tilt and wander forget, seconds. Chosen, by 24 flights of three minutes that were kept by their
/// fixes (consumer inertial sensors, two fixes a second): of an attitude's error in the ground's axes 0.95, 0.74, 0.45 and nothing
/// are left after 2, 6, 10 and 17 s, in the vehicle's a fifth for a minute; a velocity's error is that of the fixes that it
/// comes from. With half and twice as long the filter's errors are within a tenth of the same.
const VELOCITY_S: f32 = 8.0;
const TILT_S: f32 = 100.0;
const WANDER_S: f32 = 10.0;
/// Share of an attitude's sigma that wanders: three quarters of its variance, by the same flights.
const WANDER_SHARE: f32 = 0.87;
/// One sigma of it at most, radians: 0.3 degrees, a little more than in these flights. An attitude that is said to be worse than
/// that has been fitted worse, or is a camera's that leans.
const WANDER_MAX_RAD: f32 = 0.0052;
/// What the mean of two velocities is off as a share of their difference, of a turn by a radian: the way along an arc is by a twelfth of
/// the angle's square longer than its chord's velocities say, and no more than this up to half a circle.
const TURN_SHARE: f32 = 0.11;
/// One sigma of a way of one second beside that of the velocities' errors, metres; it grows with the root of the time. Velocities come in
/// whole centimetres a second.
const WAY_M: f32 = 0.1;

/// Without a match for so long an estimator's velocity may be off by more than was said, seconds.
const UNAIDED_S: f32 = 2.0;
/// One sigma of that, each axis, m/s: within the gate it is what was seen of an autopilot without fixes in a turn, 5 m/s on both axes.
const UNAIDED_M_PER_S: f32 = 1.5;

/// What a way of the last `seconds` may be off beside what the velocity's sigma says, metres, since the newest match is older than that:
/// an error v that lasts for t grows v² t² by v² (t² − (t − s)²) in a step s.
pub(super) fn unaided_m(matched_at: Micros, at: Micros, seconds: f32) -> f32 {
    let unaided_s = at.since(matched_at) as f32 * 1e-6;
    if unaided_s < UNAIDED_S {
        return 0.0;
    }
    UNAIDED_M_PER_S * sqrt(squared(unaided_s) - squared((unaided_s - seconds).max(0.0)))
}

/// What velocity, tilt and wander keep of themselves over so many seconds.
fn keeps(seconds: f32) -> [f32; 3] {
    [VELOCITY_S, TILT_S, WANDER_S].map(|constant_s| 1.0 / (1.0 + seconds / constant_s))
}

/// Carries what goes with the states, a column each: errors of them, or what they have in common with something. `forgets_tilt`: as
/// [`Estimate::carry`] does where there is a usual one.
pub(super) fn carry_along<const N: usize>(columns: &mut SMatrix<f32, STATES, N>, seconds: f32, forgets_tilt: bool) {
    let [keeps_velocity, knows_tilt, keeps_wander] = keeps(seconds);
    let keeps_tilt = if forgets_tilt { knows_tilt } else { 1.0 };
    for mut column in columns.column_iter_mut() {
        for axis in 0..2 {
            column[axis] -= column[VELOCITY + axis] * seconds;
            column[VELOCITY + axis] *= keeps_velocity;
            column[TILT + axis] *= keeps_tilt;
            column[WANDER + axis] *= keeps_wander;
        }
    }
}

/// What is estimated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) state: State,
    pub(super) covariance: Covariance,
}

/// A match against what was expected of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Innovation {
    /// How far east and north of that, metres.
    pub off: Vector2<f32>,
    /// That squared, in sigmas; infinite where nothing is known of these.
    pub squares: f32,
    /// Tilt that would explain what is beyond one sigma, radians.
    pub beyond_rad: f32,
    pub(super) seen: SMatrix<f32, STATES, 2>,
    pub(super) inverse: Matrix2<f32>,
}

/// Single precision leaves halves that differ, and what differs grows.
pub(super) fn symmetric<const N: usize>(covariance: &SMatrix<f32, N, N>) -> SMatrix<f32, N, N> {
    (covariance + covariance.transpose()) * 0.5
}

impl Innovation {
    /// The product of its two sigmas, square metres; infinite where nothing is known of these.
    pub(super) fn spread(&self) -> f32 {
        let inverse = self.inverse.determinant();
        if inverse > 0.0 { 1.0 / sqrt(inverse) } else { f32::INFINITY }
    }
}

impl Estimate {
    /// From a match on. `white`: its covariance without the tilt that lasts.
    pub(super) fn begun(found: &Found, white: Matrix2<f32>, unknown: &Unknown) -> Estimate {
        let moved = moved_by_tilt(found);
        let [tilt, wander] = parts_rad(unknown).map(squared);
        let mut covariance = Covariance::zeros();
        let wandered = Matrix2::identity() * (squared(found.height_m) * wander);
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&(white + moved * moved.transpose() * tilt + wandered));
        covariance.fixed_view_mut::<2, 2>(0, TILT).copy_from(&(moved * -tilt));
        covariance.fixed_view_mut::<2, 2>(TILT, 0).copy_from(&(moved.transpose() * -tilt));
        for axis in 0..2 {
            covariance[(VELOCITY + axis, VELOCITY + axis)] = squared(unknown.velocity_m_per_s);
            covariance[(TILT + axis, TILT + axis)] = tilt;
            covariance[(WANDER + axis, WANDER + axis)] = wander;
            covariance[(axis, WANDER + axis)] = -found.height_m * wander;
            covariance[(WANDER + axis, axis)] = -found.height_m * wander;
        }
        let Local { east_m, north_m } = found.nadir;
        let [pitch, roll] = found.less_tilt_rad;
        Estimate { state: State::from([east_m, north_m, 0.0, 0.0, pitch, roll, 0.0, 0.0]), covariance }
    }

    /// Where the camera is, and the covariance of that, square metres.
    pub(super) fn position(&self) -> (Local, Matrix2<f32>) {
        let local = Local { east_m: self.state[0], north_m: self.state[1] };
        (local, self.covariance.fixed_view::<2, 2>(0, 0).into_owned())
    }

    /// One sigma of that, the larger axis, metres.
    pub(super) fn position_sigma_m(&self) -> f32 {
        sqrt(self.covariance[(0, 0)].max(self.covariance[(1, 1)]).max(0.0))
    }

    /// Error of pitch and roll that is known, radians.
    pub(super) fn tilt_rad(&self) -> [f32; 2] {
        [self.state[TILT], self.state[TILT + 1]]
    }

    /// One sigma of what is left of it, the larger one, radians.
    pub(super) fn tilt_sigma_rad(&self) -> f32 {
        let [pitch, roll] = [TILT, TILT + 1].map(|axis| self.covariance[(axis, axis)]);
        sqrt(pitch.max(roll).max(0.0))
    }

    /// How well it is known of pitch and roll, square radians.
    pub(super) fn tilt_covariance(&self) -> Matrix2<f32> {
        self.covariance.fixed_view::<2, 2>(TILT, TILT).into_owned()
    }

    /// Whether every number is one, and every variance may be.
    pub(super) fn is_sound(&self) -> bool {
        let variances = (0..STATES).all(|axis| self.covariance[(axis, axis)] >= 0.0);
        variances && self.state.iter().chain(&self.covariance).all(|number| number.is_finite())
    }

    /// Error of the velocity, east and north, m/s, and the variance of each.
    pub(super) fn velocity(&self) -> [(f32, f32); 2] {
        [VELOCITY, VELOCITY + 1].map(|axis| (self.state[axis], self.covariance[(axis, axis)]))
    }

    /// The reported velocity has changed by what is no motion.
    pub(super) fn doubt_velocity(&mut self, change_m_per_s: [f32; 2]) {
        for (axis, change) in change_m_per_s.iter().enumerate() {
            self.covariance[(VELOCITY + axis, VELOCITY + axis)] += squared(*change);
        }
    }

    /// As it is where the tilt, or the place, may have changed by one sigma of a tilt, radians.
    pub(super) fn doubted(&self, by_rad: f32, found: &Found) -> Estimate {
        let mut doubted = *self;
        for axis in 0..2 {
            doubted.covariance[(axis, axis)] += squared(by_rad * found.height_m);
            doubted.covariance[(TILT + axis, TILT + axis)] += squared(by_rad);
        }
        doubted
    }

    /// On from one moment to a later one. `beside_m`: one sigma of the way beside what the velocity's error makes. `usual_rad`: the
    /// tilt that it forgets its own for; nothing while nobody knows, when it forgets nothing and knows less and less.
    pub(super) fn propagate(
        &mut self,
        (before, moment): (Moment, Moment),
        beside_m: f32,
        usual_rad: Option<[f32; 2]>,
        unknown: &Unknown,
    ) {
        let Estimate { state, covariance } = self;
        let seconds = moment.at.since(before.at) as f32 * 1e-6;
        let [east, north] = displacement_m(before, moment);
        let [keeps_velocity, knows_tilt, keeps_wander] = keeps(seconds);
        let keeps_tilt = if usual_rad.is_some() { knows_tilt } else { 1.0 };
        for axis in 0..2 {
            // True is the reported velocity less its error.
            state[axis] -= state[VELOCITY + axis] * seconds;
            state[VELOCITY + axis] *= keeps_velocity;
            state[WANDER + axis] *= keeps_wander;
            if let Some(usual) = usual_rad.and_then(|usual| usual.get(axis).copied()) {
                state[TILT + axis] = usual + (state[TILT + axis] - usual) * keeps_tilt;
            }
        }
        state[0] += east;
        state[1] += north;
        let mut by = Covariance::identity();
        for axis in 0..2 {
            by[(axis, VELOCITY + axis)] = -seconds;
            by[(VELOCITY + axis, VELOCITY + axis)] = keeps_velocity;
            by[(TILT + axis, TILT + axis)] = keeps_tilt;
            by[(WANDER + axis, WANDER + axis)] = keeps_wander;
        }
        *covariance = symmetric(&(by * *covariance * by.transpose()));
        let change = |axis: usize| moment.velocity_m_per_s[axis] - before.velocity_m_per_s[axis];
        let turned = hypot(change(0), change(1));
        let speed = hypot(moment.velocity_m_per_s[0], moment.velocity_m_per_s[1]).max(1.0);
        let bent_m = TURN_SHARE * (turned / speed).min(core::f32::consts::PI) * turned * seconds;
        let way = squared(WAY_M) * seconds + squared(bent_m) + squared(beside_m);
        let fresh = |keep: f32, sigma: f32| (1.0 - squared(keep)) * squared(sigma);
        let [tilt, wander] = parts_rad(unknown);
        for axis in 0..2 {
            covariance[(axis, axis)] += way;
            covariance[(VELOCITY + axis, VELOCITY + axis)] += fresh(keeps_velocity, unknown.velocity_m_per_s);
            covariance[(TILT + axis, TILT + axis)] += fresh(knows_tilt, tilt);
            covariance[(WANDER + axis, WANDER + axis)] += fresh(keeps_wander, wander);
        }
    }

    /// Back by a way of so many seconds, which are too few for more to change.
    pub(super) fn back(&mut self, [east, north]: [f32; 2], seconds: f32) {
        self.state[0] -= east - self.state[VELOCITY] * seconds;
        self.state[1] -= north - self.state[VELOCITY + 1] * seconds;
    }

    /// As it would be if the tilt were another one, known to `sigma_rad`, and nothing of what is known of it told the position any more.
    pub(super) fn with_tilt(&self, tilt_rad: [f32; 2], sigma_rad: f32) -> Estimate {
        let mut other = *self;
        let [pitch, roll] = tilt_rad;
        (other.state[TILT], other.state[TILT + 1]) = (pitch, roll);
        for axis in TILT..TILT + 2 {
            for one in 0..STATES {
                (other.covariance[(axis, one)], other.covariance[(one, axis)]) = (0.0, 0.0);
            }
            other.covariance[(axis, axis)] = squared(sigma_rad);
        }
        other
    }

    /// A match against it. `white`: its covariance without the tilt that lasts.
    pub(super) fn innovation(&self, found: &Found, white: Matrix2<f32>) -> Innovation {
        let moved = moved_by_tilt(found);
        let off = Vector2::new(found.nadir.east_m - self.state[0], found.nadir.north_m - self.state[1])
            - moved * Vector2::from(self.tilt_rad())
            - self.state.fixed_view::<2, 1>(WANDER, 0) * found.height_m
            + moved * Vector2::from(found.less_tilt_rad);
        let common = |states: usize| self.covariance.fixed_view::<STATES, 2>(0, states);
        let seen = common(0) + common(TILT) * moved.transpose() + common(WANDER) * found.height_m;
        let own = |states: usize| seen.fixed_view::<2, 2>(states, 0);
        let all = own(0) + moved * own(TILT) + own(WANDER) * found.height_m + white;
        let inverse = all.try_inverse();
        let squares = inverse.map_or(f32::INFINITY, |inverse| (off.transpose() * inverse * off)[(0, 0)]);
        let beyond_rad = sqrt((0.5 * (off.norm_squared() - all.trace())).max(0.0)) / found.height_m;
        // Less than none is a covariance that rounding has spoilt.
        let squares = if squares >= 0.0 { squares } else { f32::INFINITY };
        Innovation { off, squares, beyond_rad, seen, inverse: inverse.unwrap_or_default() }
    }

    /// With a match.
    pub(super) fn with(&self, innovation: &Innovation) -> Estimate {
        let gain = innovation.seen * innovation.inverse;
        Estimate {
            state: self.state + gain * innovation.off,
            covariance: symmetric(&(self.covariance - gain * innovation.seen.transpose())),
        }
    }
}
