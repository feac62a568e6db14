//! The error-state Kalman filter of a strapdown navigation: 15 states, three each of attitude, velocity, position and of the biases
//! of gyros and accelerometers.
//!
//! Errors are truth less estimate. That of attitude is the small turn θ, along north, east, down, that takes the estimated attitude to
//! the true one. With specific force f along these axes and attitude R: θ' = −R δb_g, δv' = −f × … = θ × f − R δb_a, δp' = δv.
//! After P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, chapter 14, on a flat Earth.

use super::imu::Figures;
use super::strapdown::{Increment, Inertial, cross, turned};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};

/// Covariance of the errors, in the order of the module's first line.
pub type Covariance = SMatrix<f64, 15, 15>;

const ATTITUDE: usize = 0;
const VELOCITY: usize = 3;
const POSITION: usize = 6;
const GYRO: usize = 9;
const ACCELEROMETER: usize = 12;

/// From one prediction of the covariance to the next, seconds: ArduPilot's filter runs at 83 Hz on 12 ms, here on two steps of 10 ms.
const PREDICTION_S: f64 = 0.02;
/// How long a turn or a pull lasts, seconds, by which an error of scale is alike: that long it counts as one. Chosen: a turn's roll-in.
const MANOEUVRE_S: f64 = 2.0;

/// What the filter begins with, one sigma of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Begin {
    /// Pitch and roll, radians.
    pub tilt_rad: f64,
    /// Heading, radians.
    pub heading_rad: f64,
    /// m/s.
    pub velocity_m_s: f64,
    /// Metres.
    pub place_m: f64,
}

/// Estimate and covariance.
#[derive(Clone, Debug)]
pub struct Filter {
    figures: Figures,
    nav: Inertial,
    gyro_bias: Vector3<f64>,
    accelerometer_bias: Vector3<f64>,
    p: Covariance,
    /// What has come since the last prediction: specific force along north, east, down times time, absolute turn, time.
    pushed_m_s: Vector3<f64>,
    turned_rad: f64,
    since_s: f64,
}

impl Filter {
    /// At the beginning, biases unknown within the sensor's figures.
    #[must_use]
    pub fn new(nav: Inertial, begin: &Begin, figures: &Figures) -> Self {
        let sigmas = [
            [begin.tilt_rad, begin.tilt_rad, begin.heading_rad],
            [begin.velocity_m_s; 3],
            [begin.place_m; 3],
            [figures.gyro.turn_on.hypot(figures.gyro.instability); 3],
            [figures.accelerometer.turn_on.hypot(figures.accelerometer.instability); 3],
        ];
        let variances = SVector::<f64, 15>::from_fn(|row, _| sigmas[row / 3][row % 3].powi(2));
        Filter {
            figures: *figures,
            nav,
            gyro_bias: Vector3::zeros(),
            accelerometer_bias: Vector3::zeros(),
            p: Covariance::from_diagonal(&variances),
            pushed_m_s: Vector3::zeros(),
            turned_rad: 0.0,
            since_s: 0.0,
        }
    }

    /// Attitude, velocity, position.
    #[must_use]
    pub fn nav(&self) -> &Inertial {
        &self.nav
    }

    /// An increment less the biases as they are known.
    #[must_use]
    pub fn corrected(&self, step: &Increment) -> Increment {
        Increment {
            turn_rad: step.turn_rad - self.gyro_bias * step.dt_s,
            speed_m_s: step.speed_m_s - self.accelerometer_bias * step.dt_s,
            dt_s: step.dt_s,
        }
    }

    /// Covariance of north and east.
    #[must_use]
    pub fn horizontal(&self) -> Matrix2<f64> {
        self.p.fixed_view::<2, 2>(POSITION, POSITION).into_owned()
    }

    /// Variance of the position along north, east or down.
    #[must_use]
    pub fn position_variance(&self, axis: usize) -> f64 {
        self.p[(POSITION + axis, POSITION + axis)]
    }

    /// Goes on by a step.
    pub fn predict(&mut self, step: &Increment) {
        let step = self.corrected(step);
        self.pushed_m_s += self.nav.ned_from_body * step.speed_m_s;
        self.turned_rad += step.turn_rad.norm();
        self.since_s += step.dt_s;
        self.nav.advance(&step);
        if self.since_s > PREDICTION_S - 1e-9 {
            self.predict_covariance();
        }
    }

    fn predict_covariance(&mut self) {
        let dt = std::mem::take(&mut self.since_s);
        let pushed = std::mem::take(&mut self.pushed_m_s);
        let turned_rad = std::mem::take(&mut self.turned_rad);
        let r = self.nav.ned_from_body;
        let mut f = Covariance::zeros();
        let mut put = |row: usize, col: usize, block: Matrix3<f64>| {
            f.fixed_view_mut::<3, 3>(row, col).copy_from(&block);
        };
        put(ATTITUDE, GYRO, -r * dt);
        put(VELOCITY, ATTITUDE, -cross(pushed));
        put(VELOCITY, ACCELEROMETER, -r * dt);
        put(POSITION, VELOCITY, Matrix3::identity() * dt);
        let step = Covariance::identity() + f + f * f * 0.5;
        self.p = step * self.p * step.transpose();
        let Figures { gyro, accelerometer } = &self.figures;
        // Errors of scale are no states: within a manoeuvre they are one error, from one to the next another.
        let (rate, force) = (turned_rad / dt, pushed.norm() / dt);
        let of_scale = |scale: f64, strength: f64| (scale * strength).powi(2) * MANOEUVRE_S;
        let densities = [
            gyro.white.powi(2) + of_scale(gyro.scale, rate),
            accelerometer.white.powi(2) + of_scale(accelerometer.scale, (force - super::strapdown::GRAVITY_M_S2).abs()),
            0.0,
            gyro.instability_density(),
            accelerometer.instability_density(),
        ];
        for (index, density) in (0..15).map(|index| (index, densities[index / 3])) {
            self.p[(index, index)] += density * dt;
        }
        self.p = (self.p + self.p.transpose()) * 0.5;
    }

    /// Takes a measurement: `innovation` is measured less estimated, `h` what the errors do to it, `variance` its noise by axis.
    pub fn fuse<const M: usize>(
        &mut self,
        h: &SMatrix<f64, M, 15>,
        innovation: &SVector<f64, M>,
        variance: &SVector<f64, M>,
    ) {
        let noise = SMatrix::<f64, M, M>::from_diagonal(variance);
        let ph = self.p * h.transpose();
        let Some(inverse) = (h * ph + noise).try_inverse() else { return };
        let gain = ph * inverse;
        // Joseph's form, which keeps the covariance one.
        let kept = Covariance::identity() - gain * h;
        self.p = kept * self.p * kept.transpose() + gain * noise * gain.transpose();
        self.p = (self.p + self.p.transpose()) * 0.5;
        self.correct(&(gain * innovation));
    }

    fn correct(&mut self, errors: &SVector<f64, 15>) {
        let part = |at: usize| errors.fixed_rows::<3>(at).into_owned();
        self.nav.ned_from_body = turned(part(ATTITUDE)) * self.nav.ned_from_body;
        self.nav.velocity_m_s += part(VELOCITY);
        self.nav.place_m += part(POSITION);
        self.gyro_bias += part(GYRO);
        self.accelerometer_bias += part(ACCELEROMETER);
    }

    /// Takes a velocity, north, east, down.
    pub fn fuse_velocity(&mut self, velocity_m_s: Vector3<f64>, sigma_m_s: f64) {
        let innovation = velocity_m_s - self.nav.velocity_m_s;
        self.fuse(&picked::<3>(VELOCITY), &innovation, &Vector3::repeat(sigma_m_s * sigma_m_s));
    }

    /// Takes a position, north and east.
    pub fn fuse_horizontal(&mut self, place_m: [f64; 2], sigma_m: f64) {
        let innovation = Vector2::from(place_m) - self.nav.place_m.xy();
        self.fuse(&picked::<2>(POSITION), &innovation, &Vector2::repeat(sigma_m * sigma_m));
    }

    /// Takes a height, as distance down.
    pub fn fuse_down(&mut self, down_m: f64, sigma_m: f64) {
        let innovation = SVector::<f64, 1>::new(down_m - self.nav.place_m.z);
        self.fuse(&picked::<1>(POSITION + 2), &innovation, &SVector::<f64, 1>::new(sigma_m * sigma_m));
    }

    /// Takes a heading: `off_rad` is measured less estimated, within half a turn.
    pub fn fuse_heading(&mut self, off_rad: f64, sigma_rad: f64) {
        // Of the body's forward axis (a, b, c): heading = atan2(b, a), and a small turn θ moves the axis by θ × (a, b, c).
        let forward = self.nav.ned_from_body.column(0);
        let (a, b, c) = (forward[0], forward[1], forward[2]);
        let level = a * a + b * b;
        let mut h = SMatrix::<f64, 1, 15>::zeros();
        (h[ATTITUDE], h[ATTITUDE + 1], h[ATTITUDE + 2]) = (-a * c / level, -b * c / level, 1.0);
        self.fuse(&h, &SVector::<f64, 1>::new(off_rad), &SVector::<f64, 1>::new(sigma_rad * sigma_rad));
    }

    /// Begins anew from a position, north and east: what was known of it, and with what, is forgotten.
    pub fn reset_horizontal(&mut self, [north_m, east_m]: [f64; 2], sigma_m: f64) {
        (self.nav.place_m.x, self.nav.place_m.y) = (north_m, east_m);
        for axis in [POSITION, POSITION + 1] {
            self.p.row_mut(axis).fill(0.0);
            self.p.column_mut(axis).fill(0.0);
            self.p[(axis, axis)] = sigma_m * sigma_m;
        }
    }
}

/// `M` errors from the one at `first` on.
fn picked<const M: usize>(first: usize) -> SMatrix<f64, M, 15> {
    SMatrix::from_fn(|row, col| f64::from(u8::from(col == first + row)))
}
