//! The servo that turns the camera back to grid north: by itself, which is the ideal one with a lag, or as it is [`driven`].

pub mod driven;

use std::f64::consts::TAU;
use std::sync::{Mutex, PoisonError};

/// Step of the integration.
const STEP_US: u64 = 1000;

/// A first-order lag of the exact follow-up angle: dβ/dt = (β_exact − β)/τ, started on target at time 0.
///
/// Integrated in steps of 1 ms from time 0, each exact for a target held at the step's middle, and kept: the answer
/// does not depend on the order of the questions.
#[derive(Debug)]
pub struct Servo {
    lag_s: f64,
    /// The angle at each whole millisecond, without jumps at ±π.
    angles_rad: Mutex<Vec<f64>>,
}

impl Servo {
    /// `lag_s`: the time constant τ; 0 follows exactly.
    pub fn new(lag_s: f64) -> Self {
        Servo { lag_s, angles_rad: Mutex::new(Vec::new()) }
    }

    /// The angle at `t_us` within (−π, π]. `exact`: the target at an instant in seconds.
    pub fn at(&self, t_us: u64, exact: impl Fn(f64) -> f64) -> f64 {
        if self.lag_s == 0.0 {
            return exact(t_us as f64 * 1e-6);
        }
        let step_s = STEP_US as f64 * 1e-6;
        let kept = (-step_s / self.lag_s).exp();
        let index = (t_us / STEP_US) as usize;
        // Whole steps are pushed one by one: a thread that panicked elsewhere leaves a list that is good as it is.
        let mut angles = self.angles_rad.lock().unwrap_or_else(PoisonError::into_inner);
        let mut newest_rad = angles.last().copied().unwrap_or_else(|| exact(0.0));
        if angles.is_empty() {
            angles.push(newest_rad);
        }
        while angles.len() < index + 2 {
            let middle_s = (angles.len() as f64 - 0.5) * step_s;
            newest_rad += (1.0 - kept) * wrapped(exact(middle_s) - newest_rad);
            angles.push(newest_rad);
        }
        let u = (t_us % STEP_US) as f64 / STEP_US as f64;
        wrapped(angles[index] + u * (angles[index + 1] - angles[index]))
    }
}

/// The follow-up angle of a servo that follows exactly, within (−π, π]: it turns the camera's forward axis into the
/// vertical plane of grid north (paper 003: a13 = 0 and a11 > 0).
///
/// β = atan2(cos θ sin φ, cos γ cos φ + sin γ sin θ sin φ) for heading φ, pitch θ, roll γ. The paper's β = φ is up to
/// 1.7° off at 10° of tilt.
#[must_use]
pub fn follow_up_exact(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> f64 {
    let (sin_heading, cos_heading) = heading_rad.sin_cos();
    let (sin_pitch, cos_pitch) = pitch_rad.sin_cos();
    let (sin_roll, cos_roll) = roll_rad.sin_cos();
    (cos_pitch * sin_heading).atan2(cos_roll * cos_heading + sin_roll * sin_pitch * sin_heading)
}

/// `angle_rad` within (−π, π].
#[must_use]
pub fn wrapped(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    if turned > 0.5 * TAU { turned - TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of rate r is followed r τ behind once the start has died away. A target held over each step of h is
    /// itself right to (r h)²: the steady lag of the scheme is r (τ + h/2 − …) with an error below r h²/(12 τ).
    #[test]
    fn a_ramp_is_followed_one_time_constant_behind() {
        let (rate, lag_s) = (0.3, 0.1);
        let servo = Servo::new(lag_s);
        let behind = |t_us: u64| wrapped(rate * t_us as f64 * 1e-6 - servo.at(t_us, |t_s| wrapped(rate * t_s)));
        // 20 time constants, and 30 s: across ±π, with the older instant asked for last.
        for t_us in [30_000_500, 12_345_678, 2_000_000] {
            assert!((behind(t_us) - rate * lag_s).abs() < 1e-6, "{}", behind(t_us));
        }
        assert_eq!(behind(0), 0.0);
        let one = behind(100_000) / (rate * lag_s);
        assert!((one - (1.0 - (-1.0_f64).exp())).abs() < 1e-4, "{one}");
    }

    #[test]
    fn no_lag_is_the_target_itself() {
        assert_eq!(Servo::new(0.0).at(1_234_567, |t_s| t_s), 1.234567);
    }
}
