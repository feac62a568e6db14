//! A servo that goes where it is told: with a lag, no faster than it can, between its stops, and with backlash.

use super::wrapped;
use crate::scenario::world::FollowUp;
use std::collections::VecDeque;

/// Step of the integration.
const STEP_US: u64 = 1000;
/// From the command's last byte to the servo's own loop, microseconds. Chosen: half a period of the usual 333 Hz.
const COMMAND_US: u64 = 1_500;
/// A limit of this is none: the camera turns around and around on slip rings.
const NO_STOP_DEG: f64 = 180.0;

/// The servo of one flight. It remembers what it did.
#[derive(Clone, Debug)]
pub struct DrivenServo {
    lag_s: f64,
    rate_rad_s: f64,
    limit_rad: Option<f64>,
    backlash_rad: f64,
    /// Commands that have not reached it: when they do, and their angles.
    commands: VecDeque<(u64, f64)>,
    target_rad: f64,
    /// The motor's angle, before the backlash.
    motor_rad: f64,
    /// The camera's at each step from time 0, without jumps at ±π.
    angles_rad: Vec<f64>,
}

impl DrivenServo {
    /// At power-on: ahead.
    #[must_use]
    pub fn new(settings: &FollowUp) -> Self {
        DrivenServo {
            lag_s: settings.servo_lag_s,
            rate_rad_s: settings.servo_rate_deg_s.to_radians(),
            limit_rad: (settings.servo_limit_deg < NO_STOP_DEG).then(|| settings.servo_limit_deg.to_radians()),
            backlash_rad: settings.servo_backlash_deg.to_radians(),
            commands: VecDeque::new(),
            target_rad: 0.0,
            motor_rad: 0.0,
            angles_rad: vec![0.0],
        }
    }

    /// Is told at `at_us` to go to an angle.
    pub fn command(&mut self, at_us: u64, angle_rad: f64) {
        self.commands.push_back((at_us + COMMAND_US, angle_rad));
    }

    /// The camera's angle at `t_us` within (−π, π]. What is commanded later than it was asked for last comes too late for it.
    pub fn at(&mut self, t_us: u64) -> f64 {
        let index = (t_us / STEP_US) as usize;
        while self.angles_rad.len() < index + 2 {
            self.step();
        }
        let part = (t_us % STEP_US) as f64 / STEP_US as f64;
        wrapped(self.angles_rad[index] + part * (self.angles_rad[index + 1] - self.angles_rad[index]))
    }

    fn step(&mut self) {
        let now_us = self.angles_rad.len() as u64 * STEP_US;
        while let Some((_, angle_rad)) = self.commands.pop_front_if(|(at_us, _)| *at_us <= now_us) {
            self.target_rad = angle_rad;
        }
        let dt_s = STEP_US as f64 * 1e-6;
        let off_rad = match self.limit_rad {
            // Between stops there is one way, the short one may lead through them.
            Some(limit_rad) => wrapped(self.target_rad).clamp(-limit_rad, limit_rad) - self.motor_rad,
            None => wrapped(self.target_rad - self.motor_rad),
        };
        let share = if self.lag_s > 0.0 { 1.0 - (-dt_s / self.lag_s).exp() } else { 1.0 };
        let most_rad = self.rate_rad_s * dt_s;
        self.motor_rad += (share * off_rad).clamp(-most_rad, most_rad);
        let half_rad = 0.5 * self.backlash_rad;
        let before_rad = self.angles_rad.last().copied().unwrap_or_default();
        self.angles_rad.push(before_rad.clamp(self.motor_rad - half_rad, self.motor_rad + half_rad));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn servo(change: impl FnOnce(&mut FollowUp)) -> DrivenServo {
        let mut settings = FollowUp { servo_backlash_deg: 0.0, servo_rate_deg_s: 100.0, ..FollowUp::default() };
        change(&mut settings);
        DrivenServo::new(&settings)
    }

    #[test]
    fn a_step_is_followed_at_the_rate_limit() {
        let mut servo = servo(|_| {});
        servo.command(0, 1.0);
        // Half a radian takes 0.5 / 100°/s after the command's way.
        let half_us = (0.5 / 100.0_f64.to_radians() * 1e6) as u64 + COMMAND_US;
        assert!((servo.at(half_us) - 0.5).abs() < 2.0 * 100.0_f64.to_radians() * 1e-3);
        assert!((servo.at(2_000_000) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn around_the_back_it_goes_the_short_way_unless_there_are_stops() {
        let mut free = servo(|_| {});
        free.command(0, 3.0);
        free.at(3_000_000);
        free.command(3_000_000, -3.0);
        assert!((free.at(3_300_000) + 3.0).abs() < 1e-9, "{}", free.at(3_300_000));
        let mut stopped = servo(|settings| settings.servo_limit_deg = 90.0);
        stopped.command(0, 3.0);
        assert!((stopped.at(3_000_000) - 90.0_f64.to_radians()).abs() < 1e-9);
    }

    /// Back and forth by less than the backlash nothing moves; beyond it the camera is half of it behind.
    #[test]
    fn backlash_holds_the_camera() {
        let mut servo = servo(|settings| settings.servo_backlash_deg = 1.0);
        let half_rad = 0.5_f64.to_radians();
        servo.command(0, 0.2);
        assert!((servo.at(1_000_000) - (0.2 - half_rad)).abs() < 1e-9);
        servo.command(1_000_000, 0.2 - half_rad);
        assert!((servo.at(2_000_000) - (0.2 - half_rad)).abs() < 1e-9);
    }
}
