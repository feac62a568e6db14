//! Strapdown integration: attitude, velocity and position from the increments of an inertial sensor.

use nalgebra::{Matrix3, Vector3};

/// Standard gravity, m/s² (CGPM 1901), down.
pub const GRAVITY_M_S2: f64 = 9.806_65;
/// Below this a turn's sine and cosine are their series', radians: their fifth terms are then below 1e-18.
const SMALL_RAD: f64 = 1e-4;

/// What an inertial sensor measured within one step, along the body's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Turn, radians.
    pub turn_rad: Vector3<f64>,
    /// Specific force times time, m/s.
    pub speed_m_s: Vector3<f64>,
    /// Length of the step, seconds.
    pub dt_s: f64,
}

/// Attitude, velocity and position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// From the body's axes to north, east, down.
    pub ned_from_body: Matrix3<f64>,
    /// North, east, down.
    pub velocity_m_s: Vector3<f64>,
    /// North, east, down.
    pub place_m: Vector3<f64>,
}

impl Inertial {
    /// Goes on by one step. Velocity by the attitude at the step's middle, position by the mean velocity.
    pub fn advance(&mut self, step: &Increment) {
        let middle = self.ned_from_body * turned(step.turn_rad * 0.5);
        let before_m_s = self.velocity_m_s;
        self.velocity_m_s += middle * step.speed_m_s + gravity() * step.dt_s;
        self.place_m += (before_m_s + self.velocity_m_s) * (0.5 * step.dt_s);
        self.ned_from_body = orthonormal(self.ned_from_body * turned(step.turn_rad));
    }

    /// What a sensor without error measures on the way to `to`: [`Self::advance`] backwards.
    #[must_use]
    pub fn increment(&self, to: &Self, dt_s: f64) -> Increment {
        let turn_rad = turn_of(self.ned_from_body.transpose() * to.ned_from_body);
        let middle = self.ned_from_body * turned(turn_rad * 0.5);
        let speed_m_s = middle.transpose() * (to.velocity_m_s - self.velocity_m_s - gravity() * dt_s);
        Increment { turn_rad, speed_m_s, dt_s }
    }

    /// Heading, pitch and roll, radians.
    #[must_use]
    pub fn angles_rad(&self) -> [f64; 3] {
        let r = &self.ned_from_body;
        [r[(1, 0)].atan2(r[(0, 0)]), -r[(2, 0)].clamp(-1.0, 1.0).asin(), r[(2, 1)].atan2(r[(2, 2)])]
    }
}

/// Gravity, north, east, down.
fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, GRAVITY_M_S2)
}

/// From the body's axes to north, east, down, of heading, pitch and roll.
#[must_use]
pub fn ned_from_body([heading, pitch, roll]: [f64; 3]) -> Matrix3<f64> {
    let ((sh, ch), (sp, cp), (sr, cr)) = (heading.sin_cos(), pitch.sin_cos(), roll.sin_cos());
    Matrix3::new(
        ch * cp,
        ch * sp * sr - sh * cr,
        ch * sp * cr + sh * sr,
        sh * cp,
        sh * sp * sr + ch * cr,
        sh * sp * cr - ch * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}

/// The matrix whose product with a vector is the cross product.
#[must_use]
pub fn cross(v: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rodrigues' formula: the rotation by a turn.
#[must_use]
pub fn turned(turn_rad: Vector3<f64>) -> Matrix3<f64> {
    let angle = turn_rad.norm();
    let (first, second) = if angle < SMALL_RAD {
        (1.0 - angle * angle / 6.0, 0.5 - angle * angle / 24.0)
    } else {
        (angle.sin() / angle, (1.0 - angle.cos()) / (angle * angle))
    };
    let skew = cross(turn_rad);
    Matrix3::identity() + skew * first + skew * skew * second
}

/// The turn of a rotation by less than half a turn.
fn turn_of(r: Matrix3<f64>) -> Vector3<f64> {
    let axis = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) * 0.5;
    let sine = axis.norm();
    let angle = sine.atan2(0.5 * (r.trace() - 1.0));
    if sine < SMALL_RAD { axis * (1.0 + sine * sine / 6.0) } else { axis * (angle / sine) }
}

/// The rotation again of a matrix that rounding has moved off it: columns by Gram and Schmidt.
fn orthonormal(m: Matrix3<f64>) -> Matrix3<f64> {
    let x = m.column(0).into_owned();
    let x = x / x.norm();
    let y = m.column(1).into_owned();
    let y = y - x * x.dot(&y);
    let y = y / y.norm();
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.005;

    fn still() -> Inertial {
        Inertial {
            ned_from_body: ned_from_body([1.0, 0.1, -0.2]),
            velocity_m_s: Vector3::zeros(),
            place_m: Vector3::zeros(),
        }
    }

    /// What a still sensor measures, by hand: the ground's push upwards, in the body's axes.
    fn rest(nav: &Inertial, bias_m_s2: Vector3<f64>) -> Increment {
        let push = nav.ned_from_body.transpose() * Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
        Increment { turn_rad: Vector3::zeros(), speed_m_s: (push + bias_m_s2) * DT_S, dt_s: DT_S }
    }

    #[test]
    fn a_still_sensor_without_bias_does_not_drift() {
        let mut nav = still();
        let step = rest(&nav, Vector3::zeros());
        (0..60_000).for_each(|_| nav.advance(&step));
        assert!(nav.place_m.norm() < 1e-6 && nav.velocity_m_s.norm() < 1e-8, "{nav:?}");
    }

    /// A known bias b drifts by b t²/2.
    #[test]
    fn a_bias_of_the_accelerometer_drifts_with_the_square_of_time() {
        let mut nav = still();
        let bias = Vector3::new(0.02, -0.01, 0.005);
        let step = rest(&nav, bias);
        (0..20_000).for_each(|_| nav.advance(&step));
        let t_s = 20_000.0 * DT_S;
        let expected = nav.ned_from_body * bias * (0.5 * t_s * t_s);
        assert!((nav.place_m - expected).norm() < 1e-6 * expected.norm(), "{} {expected}", nav.place_m);
    }

    /// A known bias b of a level gyro tilts by b t, and drifts by g b t³/6.
    #[test]
    fn a_bias_of_the_gyro_drifts_with_the_cube_of_time() {
        let mut nav = Inertial { ned_from_body: Matrix3::identity(), ..still() };
        let rate = 1e-6;
        let step = Increment { turn_rad: Vector3::new(0.0, rate * DT_S, 0.0), ..rest(&nav, Vector3::zeros()) };
        (0..20_000).for_each(|_| nav.advance(&step));
        let t_s = 20_000.0 * DT_S;
        let expected = -GRAVITY_M_S2 * rate * t_s.powi(3) / 6.0;
        assert!((nav.place_m.x / expected - 1.0).abs() < 1e-3, "{} {expected}", nav.place_m);
    }

    #[test]
    fn increments_are_the_integration_backwards() {
        let from = Inertial { velocity_m_s: Vector3::new(20.0, -3.0, 1.0), ..still() };
        for angles in [[1.02, 0.09, -0.23], [1.0, 0.1, -0.2], [1.3, -0.2, 0.4]] {
            let velocity_m_s = Vector3::new(20.3, -2.8, 0.9);
            let place_m = (from.velocity_m_s + velocity_m_s) * (0.5 * DT_S);
            let to = Inertial { ned_from_body: ned_from_body(angles), velocity_m_s, place_m };
            let mut nav = from;
            nav.advance(&from.increment(&to, DT_S));
            assert!((nav.ned_from_body - to.ned_from_body).norm() < 1e-12);
            assert!((nav.velocity_m_s - velocity_m_s).norm() < 1e-12 && (nav.place_m - place_m).norm() < 1e-12);
            assert!(nav.angles_rad().iter().zip(angles).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}
