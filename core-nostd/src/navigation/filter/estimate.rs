//! State and covariance of the Kalman filter: position, error of the velocity, error of the attitude.
//!
//! The attitude's error has two parts. The *tilt* is constant and turns with the vehicle: an accelerometer's bias, or
//! the camera's mounting. The *wander* stays in the ground's axes and decorrelates within ten seconds: the autopilot
//! estimator's errors by its gyroscopes and position updates.

use super::measurement::{Measurement, PriorSigmas, tilt_jacobian};
use crate::math::{combined_sigma, hypot, sqrt, squared};
use crate::navigation::reckoning::{Moment, displacement_m};
use crate::tile::Local;
use crate::units::Micros;
use nalgebra::{Matrix2, SMatrix, Vector2};

/// Sigmas of tilt and wander, which together are the attitude's, each axis, radians.
pub(super) fn part_sigmas_rad(prior: &PriorSigmas) -> [f32; 2] {
    let wander = (WANDER_SHARE * prior.tilt_rad).min(WANDER_MAX_RAD);
    let lasts = sqrt((squared(prior.tilt_rad) - squared(wander)).max(0.0));
    [lasts, combined_sigma(wander, prior.extra_wander_rad)]
}

type Covariance = SMatrix<f32, STATES, STATES>;
type State = SMatrix<f32, STATES, 1>;
/// Index of the first velocity, tilt and wander state; position is first.
pub(super) const VELOCITY: usize = 2;
pub(super) const TILT: usize = 4;
pub(super) const WANDER: usize = 6;
pub(super) const STATES: usize = 8;

/// Time constants of the Gauss-Markov processes of velocity, tilt and wander, seconds. Chosen, by 24 flights of three
/// minutes that were kept by their fixes (consumer inertial sensors, two fixes a second): an attitude's error in the
/// ground's axes is correlated by 0.95, 0.74, 0.45 and nothing after 2, 6, 10 and 17 s, in the vehicle's by a fifth for
/// a minute; a velocity's error is that of the fixes that it comes from. With half and twice these constants the
/// filter's errors are within a tenth of the same.
const VELOCITY_S: f32 = 8.0;
const TILT_S: f32 = 100.0;
const WANDER_S: f32 = 10.0;
/// Wander's share of an attitude's sigma: three quarters of its variance, by the same flights.
const WANDER_SHARE: f32 = 0.87;
/// Largest sigma of the wander, radians: 0.3 degrees, a little more than in these flights. A larger sigma of the
/// attitude is one of the mounting, or of a camera that leans.
const WANDER_MAX_RAD: f32 = 0.0052;
/// Error of the mean of two velocities, as a share of their difference, per radian of turn: an arc is longer than the
/// displacement by its chord's velocities by a twelfth of the squared angle; the share bounds that up to half a circle.
const ARC_SHARE: f32 = 0.11;
/// Process noise of the position: sigma of the displacement in one second besides the velocity's error, metres; it
/// grows with the root of the time. Velocities come in whole centimetres a second.
const DISPLACEMENT_M: f32 = 0.1;

/// Time without a match after which the velocity of the autopilot's estimator may be off by more than its sigma,
/// seconds.
const UNAIDED_S: f32 = 2.0;
/// That additional error, one sigma, each axis, m/s: within the gate it covers what was seen of an autopilot without
/// fixes in a turn, 5 m/s on both axes.
const UNAIDED_M_PER_S: f32 = 1.5;

/// Additional sigma of the displacement of the last `seconds` since the newest match is old, metres: a constant error v
/// adds v² t² over a time t, so v² (t² − (t − s)²) in a step s.
pub(super) fn unaided_m(matched_at: Micros, at: Micros, seconds: f32) -> f32 {
    let unaided_s = at.since(matched_at) as f32 * 1e-6;
    if unaided_s < UNAIDED_S {
        return 0.0;
    }
    UNAIDED_M_PER_S * sqrt(squared(unaided_s) - squared((unaided_s - seconds).max(0.0)))
}

/// Decay factors of velocity, tilt and wander over so many seconds.
fn decay(seconds: f32) -> [f32; 3] {
    [VELOCITY_S, TILT_S, WANDER_S].map(|constant_s| 1.0 / (1.0 + seconds / constant_s))
}

/// Propagates columns that transform as the states do: their errors, or their covariance with something.
/// `forgets_tilt`: the tilt decays, as in [`Estimate::propagate`] with a mean.
pub(super) fn propagate_columns<const N: usize>(
    columns: &mut SMatrix<f32, STATES, N>,
    seconds: f32,
    forgets_tilt: bool,
) {
    let [decay_velocity, decay_tilt, decay_wander] = decay(seconds);
    let kept_tilt = if forgets_tilt { decay_tilt } else { 1.0 };
    for mut column in columns.column_iter_mut() {
        for axis in 0..2 {
            column[axis] -= column[VELOCITY + axis] * seconds;
            column[VELOCITY + axis] *= decay_velocity;
            column[TILT + axis] *= kept_tilt;
            column[WANDER + axis] *= decay_wander;
        }
    }
}

/// State vector and covariance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub(super) state: State,
    pub(super) covariance: Covariance,
}

/// Innovation of a match.
#[derive(Clone, Copy, Debug)]
pub(super) struct Innovation {
    /// Measured less predicted nadir, east and north, metres.
    pub off: Vector2<f32>,
    /// Normalised innovation squared; infinite if the covariance is invalid.
    pub nis: f32,
    /// Tilt that would explain the excess over one sigma, radians.
    pub excess_tilt_rad: f32,
    /// Covariance of the states with the measurement, P Hᵀ.
    pub(super) cross_covariance: SMatrix<f32, STATES, 2>,
    /// Inverse of the innovation's covariance.
    pub(super) inverse: Matrix2<f32>,
}

/// Restores the symmetry that rounding in single precision breaks, which would grow.
pub(super) fn symmetric<const N: usize>(covariance: &SMatrix<f32, N, N>) -> SMatrix<f32, N, N> {
    (covariance + covariance.transpose()) * 0.5
}

impl Innovation {
    /// `covariance`: the innovation's own.
    fn new(off: Vector2<f32>, cross_covariance: SMatrix<f32, STATES, 2>, covariance: &Matrix2<f32>) -> Self {
        let inverse = covariance.try_inverse();
        let nis = inverse.map_or(f32::INFINITY, |inverse| (off.transpose() * inverse * off)[(0, 0)]);
        // Negative only by rounding in the covariance.
        let nis = if nis >= 0.0 { nis } else { f32::INFINITY };
        Innovation { off, nis, excess_tilt_rad: 0.0, cross_covariance, inverse: inverse.unwrap_or_default() }
    }

    /// Product of the two sigmas, square metres; infinite if the covariance is invalid.
    pub(super) fn spread(&self) -> f32 {
        let inverse = self.inverse.determinant();
        if inverse > 0.0 { 1.0 / sqrt(inverse) } else { f32::INFINITY }
    }
}

impl Estimate {
    /// Initialises from a match. `white`: its covariance without the constant tilt.
    pub(super) fn from_match(measurement: &Measurement, white: Matrix2<f32>, prior: &PriorSigmas) -> Estimate {
        let jacobian = tilt_jacobian(measurement);
        let [tilt, wander] = part_sigmas_rad(prior).map(squared);
        let mut covariance = Covariance::zeros();
        let wandered = Matrix2::identity() * (squared(measurement.height_m) * wander);
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&(white + jacobian * jacobian.transpose() * tilt + wandered));
        covariance.fixed_view_mut::<2, 2>(0, TILT).copy_from(&(jacobian * -tilt));
        covariance.fixed_view_mut::<2, 2>(TILT, 0).copy_from(&(jacobian.transpose() * -tilt));
        for axis in 0..2 {
            covariance[(VELOCITY + axis, VELOCITY + axis)] = squared(prior.velocity_m_per_s);
            covariance[(TILT + axis, TILT + axis)] = tilt;
            covariance[(WANDER + axis, WANDER + axis)] = wander;
            covariance[(axis, WANDER + axis)] = -measurement.height_m * wander;
            covariance[(WANDER + axis, axis)] = -measurement.height_m * wander;
        }
        let Local { east_m, north_m } = measurement.nadir;
        let [pitch, roll] = measurement.corrected_tilt_rad;
        Estimate { state: State::from([east_m, north_m, 0.0, 0.0, pitch, roll, 0.0, 0.0]), covariance }
    }

    /// Position of the camera, and its covariance, square metres.
    pub(super) fn position(&self) -> (Local, Matrix2<f32>) {
        let local = Local { east_m: self.state[0], north_m: self.state[1] };
        (local, self.covariance.fixed_view::<2, 2>(0, 0).into_owned())
    }

    /// Its larger sigma, metres.
    pub(super) fn position_sigma_m(&self) -> f32 {
        sqrt(self.covariance[(0, 0)].max(self.covariance[(1, 1)]).max(0.0))
    }

    /// Estimated error of pitch and roll, radians.
    pub(super) fn tilt_rad(&self) -> [f32; 2] {
        [self.state[TILT], self.state[TILT + 1]]
    }

    /// The larger sigma of the error that is left, radians.
    pub(super) fn tilt_sigma_rad(&self) -> f32 {
        let [pitch, roll] = [TILT, TILT + 1].map(|axis| self.covariance[(axis, axis)]);
        sqrt(pitch.max(roll).max(0.0))
    }

    /// Covariance of pitch and roll, square radians.
    pub(super) fn tilt_covariance(&self) -> Matrix2<f32> {
        self.covariance.fixed_view::<2, 2>(TILT, TILT).into_owned()
    }

    /// Whether all numbers are finite and no variance is negative.
    pub(super) fn is_valid(&self) -> bool {
        let variances = (0..STATES).all(|axis| self.covariance[(axis, axis)] >= 0.0);
        variances && self.state.iter().chain(&self.covariance).all(|number| number.is_finite())
    }

    /// Error of the velocity, east and north, m/s, each with its variance.
    pub(super) fn velocity(&self) -> [(f32, f32); 2] {
        [VELOCITY, VELOCITY + 1].map(|axis| (self.state[axis], self.covariance[(axis, axis)]))
    }

    /// Adds the variance of a change of the reported velocity that is no motion.
    pub(super) fn inflate_velocity(&mut self, change_m_per_s: [f32; 2]) {
        for (axis, change) in change_m_per_s.iter().enumerate() {
            self.covariance[(VELOCITY + axis, VELOCITY + axis)] += squared(*change);
        }
    }

    /// With the variance of a change of tilt or position added, sigma in radians of tilt.
    pub(super) fn inflated(&self, by_rad: f32, measurement: &Measurement) -> Estimate {
        let mut inflated = *self;
        for axis in 0..2 {
            inflated.covariance[(axis, axis)] += squared(by_rad * measurement.height_m);
            inflated.covariance[(TILT + axis, TILT + axis)] += squared(by_rad);
        }
        inflated
    }

    /// Propagates from one moment to a later one. `displacement_sigma_m`: besides the velocity's error.
    /// `mean_rad`: mean to which the tilt decays; `None` while that is unknown, when the tilt keeps its value and its
    /// variance grows.
    pub(super) fn propagate(
        &mut self,
        (before, moment): (Moment, Moment),
        displacement_sigma_m: f32,
        mean_rad: Option<[f32; 2]>,
        prior: &PriorSigmas,
    ) {
        let Estimate { state, covariance } = self;
        let seconds = moment.at.since(before.at) as f32 * 1e-6;
        let [east, north] = displacement_m(before, moment);
        let [decay_velocity, decay_tilt, decay_wander] = decay(seconds);
        let kept_tilt = if mean_rad.is_some() { decay_tilt } else { 1.0 };
        for axis in 0..2 {
            // The true velocity is the reported one less its error.
            state[axis] -= state[VELOCITY + axis] * seconds;
            state[VELOCITY + axis] *= decay_velocity;
            state[WANDER + axis] *= decay_wander;
            if let Some(mean) = mean_rad.and_then(|mean| mean.get(axis).copied()) {
                state[TILT + axis] = mean + (state[TILT + axis] - mean) * kept_tilt;
            }
        }
        state[0] += east;
        state[1] += north;
        let mut transition = Covariance::identity();
        for axis in 0..2 {
            transition[(axis, VELOCITY + axis)] = -seconds;
            transition[(VELOCITY + axis, VELOCITY + axis)] = decay_velocity;
            transition[(TILT + axis, TILT + axis)] = kept_tilt;
            transition[(WANDER + axis, WANDER + axis)] = decay_wander;
        }
        *covariance = symmetric(&(transition * *covariance * transition.transpose()));
        let change = |axis: usize| moment.velocity_m_per_s[axis] - before.velocity_m_per_s[axis];
        let turned = hypot(change(0), change(1));
        let speed = hypot(moment.velocity_m_per_s[0], moment.velocity_m_per_s[1]).max(1.0);
        let arc_m = ARC_SHARE * (turned / speed).min(core::f32::consts::PI) * turned * seconds;
        let displacement = squared(DISPLACEMENT_M) * seconds + squared(arc_m) + squared(displacement_sigma_m);
        let driving_noise = |kept: f32, sigma: f32| (1.0 - squared(kept)) * squared(sigma);
        let [tilt, wander] = part_sigmas_rad(prior);
        for axis in 0..2 {
            covariance[(axis, axis)] += displacement;
            covariance[(VELOCITY + axis, VELOCITY + axis)] += driving_noise(decay_velocity, prior.velocity_m_per_s);
            covariance[(TILT + axis, TILT + axis)] += driving_noise(decay_tilt, tilt);
            covariance[(WANDER + axis, WANDER + axis)] += driving_noise(decay_wander, wander);
        }
    }

    /// Propagates back over a time so short that only the position changes.
    pub(super) fn propagate_back(&mut self, [east, north]: [f32; 2], seconds: f32) {
        self.state[0] -= east - self.state[VELOCITY] * seconds;
        self.state[1] -= north - self.state[VELOCITY + 1] * seconds;
    }

    /// With another tilt of this sigma, uncorrelated with the other states.
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

    /// With the variance of a change of tilt added, sigma in radians.
    pub(super) fn with_tilt_noise(mut self, by_rad: f32) -> Estimate {
        for axis in TILT..TILT + 2 {
            self.covariance[(axis, axis)] += squared(by_rad);
        }
        self
    }

    /// Innovation of a match. `white`: its covariance without the constant tilt.
    pub(super) fn innovation(&self, measurement: &Measurement, white: Matrix2<f32>) -> Innovation {
        let jacobian = tilt_jacobian(measurement);
        let off = self.off(measurement, &jacobian);
        let common = |states: usize| self.covariance.fixed_view::<STATES, 2>(0, states);
        let cross_covariance = common(0) + common(TILT) * jacobian.transpose() + common(WANDER) * measurement.height_m;
        let own = |states: usize| cross_covariance.fixed_view::<2, 2>(states, 0);
        let all = own(0) + jacobian * own(TILT) + own(WANDER) * measurement.height_m + white;
        let excess_tilt_rad = sqrt((0.5 * (off.norm_squared() - all.trace())).max(0.0)) / measurement.height_m;
        Innovation { excess_tilt_rad, ..Innovation::new(off, cross_covariance, &all) }
    }

    /// Measured less predicted nadir, east and north, metres.
    fn off(&self, measurement: &Measurement, jacobian: &Matrix2<f32>) -> Vector2<f32> {
        Vector2::new(measurement.nadir.east_m - self.state[0], measurement.nadir.north_m - self.state[1])
            - jacobian * Vector2::from(self.tilt_rad())
            - self.state.fixed_view::<2, 1>(WANDER, 0) * measurement.height_m
            + jacobian * Vector2::from(measurement.corrected_tilt_rad)
    }

    /// Whether a match is surely within a gate of the normalised innovation: within that of its own covariance, whose lesser
    /// eigenvalue is at least the determinant over the trace.
    pub(super) fn is_surely_within(&self, gate: f32, measurement: &Measurement) -> bool {
        let off = self.off(measurement, &tilt_jacobian(measurement));
        let own = &measurement.covariance;
        off.norm_squared() * own.trace() <= gate * own.determinant()
    }

    /// Innovation of a position measured without the attitude.
    pub(super) fn position_innovation(&self, position: Local, covariance: Matrix2<f32>) -> Innovation {
        let cross_covariance = self.covariance.fixed_view::<STATES, 2>(0, 0).into_owned();
        let all = cross_covariance.fixed_view::<2, 2>(0, 0) + covariance;
        Innovation::new(Vector2::from(self.position().0.to(position)), cross_covariance, &all)
    }

    /// Updated by a match.
    pub(super) fn updated(&self, innovation: &Innovation) -> Estimate {
        let gain = innovation.cross_covariance * innovation.inverse;
        Estimate {
            state: self.state + gain * innovation.off,
            covariance: symmetric(&(self.covariance - gain * innovation.cross_covariance.transpose())),
        }
    }
}
