//! What a strapdown inertial sensor measures: the truth with turn-on bias, bias instability, scale and white noise.

use super::strapdown::{GRAVITY_M_S2, Increment};
use crate::noise::{GaussMarkov, White};
use crate::scenario::Grade;
use nalgebra::Vector3;

/// Time constant of the bias instability. Chosen: where the Allan deviations of such sensors are lowest, some minutes.
const INSTABILITY_S: f64 = 300.0;
/// Of the scale's error on the data sheet, which is what any unit of a series may have, one sigma is taken to be a third.
const OF_TOLERANCE: f64 = 1.0 / 3.0;
/// How far a flight controller's sensor has warmed since the gyros were zeroed and the accelerometers calibrated, kelvin. Chosen: a
/// box in the sun; what its offset changes by then is its turn-on bias.
const WARMED_K: f64 = 10.0;
/// What the vibration of an aeroplane adds to the white noise of a sensor that is screwed to it, a root of a hertz: gyros, accelerometers.
/// ArduPilot's filter allows by default for 0.015 rad/s and 0.35 m/s² in each step of 12 ms (EK3_GYRO_P_NSE, EK3_ACC_P_NSE). Chosen: a
/// third of that, since its defaults are to cover all airframes. A tactical sensor stands on dampers of its own.
const VIBRATION: [f64; 2] = [0.015 / 3.0 * STEP_ROOT_S, 0.35 / 3.0 * STEP_ROOT_S];
/// The root of 12 ms.
const STEP_ROOT_S: f64 = 0.109_544_511_501_033_2;
const MILLI_G: f64 = 1e-3 * GRAVITY_M_S2;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Errors of one triad of gyros or accelerometers, one sigma of each axis; rad/s or m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// White noise, a root of a hertz.
    pub white: f64,
    /// Bias instability.
    pub instability: f64,
    /// Bias since power-on.
    pub turn_on: f64,
    /// Scale, of one.
    pub scale: f64,
}

/// Errors of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Gyros.
    pub gyro: Errors,
    /// Accelerometers.
    pub accelerometer: Errors,
}

/// Bosch BMI088 (data sheet BST-BMI088-DS001), as flight controllers carry it: gyros 0.014 °/s/√Hz, bias stability 2 °/h, offset
/// 0.015 °/s/K, sensitivity to 1 %; accelerometers 175 µg/√Hz, offset 0.2 mg/K. It does not tell the accelerometers' instability:
/// 40 µg is taken, what Allan deviations of its kind show, and 0.5 % for their sensitivity once calibrated.
const CONSUMER: Figures = Figures {
    gyro: Errors {
        white: 0.014 * DEG + VIBRATION[0],
        instability: 2.0 * DEG / 3600.0,
        turn_on: 0.015 * DEG * WARMED_K,
        scale: 0.01 * OF_TOLERANCE,
    },
    accelerometer: Errors {
        white: 0.175 * MILLI_G + VIBRATION[1],
        instability: 0.04 * MILLI_G,
        turn_on: 0.2 * MILLI_G * WARMED_K,
        scale: 0.005 * OF_TOLERANCE,
    },
};

/// Sensonor STIM300 with accelerometers of 10 g (data sheet TS1524): gyros 0.15 °/√h, instability 0.5 °/h, 5 °/h over temperature,
/// scale to 500 ppm; accelerometers 0.06 m/s/√h, instability 0.05 mg, on to on 0.75 mg, scale to 300 ppm.
const TACTICAL: Figures = Figures {
    gyro: Errors {
        white: 0.15 * DEG / 60.0,
        instability: 0.5 * DEG / 3600.0,
        turn_on: 5.0 * DEG / 3600.0,
        scale: 500e-6 * OF_TOLERANCE,
    },
    accelerometer: Errors {
        white: 0.06 / 60.0,
        instability: 0.05 * MILLI_G,
        turn_on: 0.75 * MILLI_G,
        scale: 300e-6 * OF_TOLERANCE,
    },
};

impl Grade {
    /// Its errors.
    #[must_use]
    pub fn figures(self) -> Figures {
        match self {
            Grade::Consumer => CONSUMER,
            Grade::Tactical => TACTICAL,
        }
    }
}

impl Errors {
    /// What the bias instability adds to the bias' variance a second.
    #[must_use]
    pub fn instability_density(&self) -> f64 {
        2.0 * self.instability * self.instability / INSTABILITY_S
    }
}

/// Three gyros, or three accelerometers.
#[derive(Clone, Debug)]
struct Triad {
    white: [White; 3],
    instability: [GaussMarkov; 3],
    turn_on: [f64; 3],
    scale: [f64; 3],
}

impl Triad {
    fn new(errors: &Errors, seed: u64, name: &str) -> Self {
        let named = |what: &str, axis: usize| format!("imu.{name}.{what}.{axis}");
        let drawn =
            |sigma: f64, what: &str| std::array::from_fn(|axis| White::new(sigma, seed, &named(what, axis)).draw());
        Triad {
            white: std::array::from_fn(|axis| White::new(errors.white, seed, &named("white", axis))),
            instability: std::array::from_fn(|axis| {
                GaussMarkov::new(errors.instability, INSTABILITY_S, seed, &named("instability", axis))
            }),
            turn_on: drawn(errors.turn_on, "turn_on"),
            scale: drawn(errors.scale, "scale"),
        }
    }

    /// The increment of a true one over `dt_s`.
    fn measure(&mut self, truth: Vector3<f64>, dt_s: f64, at_us: u64) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let bias = self.turn_on[axis] + self.instability[axis].at(at_us);
            truth[axis] * (1.0 + self.scale[axis]) + bias * dt_s + self.white[axis].draw() * dt_s.sqrt()
        })
    }
}

/// The sensor of one flight.
#[derive(Clone, Debug)]
pub struct Imu {
    gyro: Triad,
    accelerometer: Triad,
}

impl Imu {
    /// At power-on.
    #[must_use]
    pub fn new(figures: &Figures, seed: u64) -> Self {
        Imu {
            gyro: Triad::new(&figures.gyro, seed, "gyro"),
            accelerometer: Triad::new(&figures.accelerometer, seed, "accelerometer"),
        }
    }

    /// What it says of a step that ends at `at_us`.
    pub fn measure(&mut self, truth: &Increment, at_us: u64) -> Increment {
        Increment {
            turn_rad: self.gyro.measure(truth.turn_rad, truth.dt_s, at_us),
            speed_m_s: self.accelerometer.measure(truth.speed_m_s, truth.dt_s, at_us),
            dt_s: truth.dt_s,
        }
    }
}
