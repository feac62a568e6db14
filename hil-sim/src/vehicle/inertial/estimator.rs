//! The autopilot's estimator around the filter, as ArduPilot's EKF3 has it: the filter runs behind the present by the largest delay of
//! a sensor, so that each measurement is taken when it was; what is told of the present is the filter's state and the inertial
//! steps since. Corrections reach the present at once.
//!
//! Gates and resets are those of its sources and of what was measured: a position is taken within five sigmas; one that is rejected for
//! ten seconds is jumped to, and so is the first one when the filter no longer knows its place within EK3_GLITCH_RAD. A jump
//! leaves the velocity as it is.

use super::filter::{Begin, Filter};
use super::imu::Figures;
use super::strapdown::{Increment, Inertial};
use super::vision::VisionFix;
use crate::vehicle::servo::wrapped;
use nalgebra::{Matrix2, Vector2, Vector3};
use std::collections::VecDeque;

/// How far behind the present the filter runs: the delay of satellite navigation that AP_GPS_Backend assumes, its largest.
pub const HORIZON_US: u64 = 200_000;
/// EK3_POS_I_GATE, EK3_VEL_I_GATE and EK3_HGT_I_GATE: 500 hundredths of a sigma.
const GATE_SIGMAS: f64 = 5.0;
/// posRetryTimeUseVel_ms: after so long without a position that passed its gate the next one is jumped to. Measured: a steady
/// offset of 60 m was held off for about 10 s.
const POSITION_TIMEOUT_US: u64 = 10_000_000;
/// hgtRetryTimeMode12_ms.
const HEIGHT_TIMEOUT_US: u64 = 5_000_000;
/// A filter that is lost jumps after a silence of this at least, and not from one fix to the next: its velocity, which only fixes
/// correct, would keep it lost, where ArduPilot's has its airspeed. Chosen: ten intervals of fixes.
const LOST_US: u64 = 5_000_000;
/// What it takes a position's sigma for at most.
const SIGMA_MAX_M: f64 = 10.0;
/// EK3_ALT_M_NSE of a plane.
const BARO_SIGMA_M: f64 = 3.0;

/// Something measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measurement {
    /// Satellite navigation: north, east; velocity north, east, down.
    Gnss {
        /// North and east.
        place_m: [f64; 2],
        /// North, east, down.
        velocity_m_s: Vector3<f64>,
    },
    /// A companion's position.
    Vision(VisionFix),
    /// The barometer's height, as distance down.
    Down(f64),
    /// The compass, radians.
    Heading(f64),
}

/// What the estimator assumes of its sensors, and its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The inertial sensor's figures.
    pub figures: Figures,
    /// What it begins with.
    pub begin: Begin,
    /// Satellite navigation's sigmas: position, velocity.
    pub gnss: [f64; 2],
    /// The compass' sigma, radians.
    pub heading_rad: f64,
    /// EK3_GLITCH_RAD; with 0 no position is rejected.
    pub glitch_m: f64,
}

/// How many fixes were taken, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FixCounts {
    /// Within the gate.
    pub fused: u32,
    /// Beyond it.
    pub rejected: u32,
    /// Jumped to.
    pub resets: u32,
}

/// The estimator.
#[derive(Clone, Debug)]
pub struct Estimator {
    settings: Settings,
    filter: Filter,
    /// Where the filter is.
    at_us: u64,
    /// The present.
    present: Inertial,
    /// Steps that the filter has not got, by their ends.
    steps: VecDeque<(u64, Increment)>,
    /// Measurements that it has not got, by when they were.
    waiting: VecDeque<(u64, Measurement)>,
    /// When a position and a height passed their gates last.
    passed_us: u64,
    height_us: u64,
    /// The sender's reset counter as it was last.
    resets: Option<u8>,
    /// What became of the fixes.
    pub counts: FixCounts,
}

impl Estimator {
    /// At `at_us`.
    #[must_use]
    pub fn new(nav: Inertial, settings: &Settings, at_us: u64) -> Self {
        Estimator {
            settings: *settings,
            filter: Filter::new(nav, &settings.begin, &settings.figures),
            at_us,
            present: nav,
            steps: VecDeque::new(),
            waiting: VecDeque::new(),
            passed_us: at_us,
            height_us: at_us,
            resets: None,
            counts: FixCounts::default(),
        }
    }

    /// What it believes of the present.
    #[must_use]
    pub fn present(&self) -> &Inertial {
        &self.present
    }

    /// The filter, and when it is.
    #[must_use]
    pub fn filter(&self) -> (u64, &Filter) {
        (self.at_us, &self.filter)
    }

    /// Takes something that was measured at `at_us`; what is older than the filter counts as of the filter's own time.
    pub fn take(&mut self, at_us: u64, measurement: Measurement) {
        let at_us = at_us.max(self.at_us);
        let place = self.waiting.partition_point(|(other, _)| *other <= at_us);
        self.waiting.insert(place, (at_us, measurement));
    }

    /// Goes on by a step that ends at `now_us`.
    pub fn advance(&mut self, now_us: u64, step: &Increment) {
        self.steps.push_back((now_us, *step));
        let mut is_corrected = false;
        while let Some((end_us, step)) = self.steps.pop_front_if(|(end_us, _)| *end_us + HORIZON_US <= now_us) {
            self.filter.predict(&step);
            self.at_us = end_us;
            while let Some((_, measurement)) = self.waiting.pop_front_if(|(at_us, _)| *at_us <= end_us) {
                self.fuse(&measurement);
                is_corrected = true;
            }
        }
        if is_corrected {
            self.present = *self.filter.nav();
            self.steps.iter().for_each(|(_, step)| self.present.advance(&self.filter.corrected(step)));
        } else {
            self.present.advance(&self.filter.corrected(step));
        }
    }

    fn fuse(&mut self, measurement: &Measurement) {
        let [place_sigma_m, velocity_sigma_m_s] = self.settings.gnss;
        match measurement {
            Measurement::Gnss { place_m, velocity_m_s } => {
                self.filter.fuse_velocity(*velocity_m_s, velocity_sigma_m_s);
                self.position(*place_m, place_sigma_m);
            }
            Measurement::Vision(fix) => {
                let has_reset = self.resets.replace(fix.resets).is_some_and(|before| before != fix.resets);
                let taken = if has_reset { Taken::Jumped } else { self.position(fix.place_m, fix.sigma_m) };
                let counts = &mut self.counts;
                match taken {
                    Taken::Fused => counts.fused += 1,
                    Taken::Rejected => counts.rejected += 1,
                    Taken::Jumped => counts.resets += 1,
                }
                if has_reset {
                    self.jump(fix.place_m);
                }
            }
            Measurement::Down(down_m) => self.height(*down_m),
            Measurement::Heading(heading_rad) => {
                let [believed_rad, ..] = self.filter.nav().angles_rad();
                self.filter.fuse_heading(wrapped(heading_rad - believed_rad), self.settings.heading_rad);
            }
        }
    }

    /// A position, by its gate.
    fn position(&mut self, place_m: [f64; 2], sigma_m: f64) -> Taken {
        let sigma_m = sigma_m.min(SIGMA_MAX_M);
        let glitch_m = self.settings.glitch_m;
        let off = Vector2::from(place_m) - self.filter.nav().place_m.xy();
        let known = self.filter.position_variance(0) + self.filter.position_variance(1);
        let ratio = off.norm_squared() / (GATE_SIGMAS.powi(2) * (known + 2.0 * sigma_m * sigma_m));
        let silent_us = self.at_us - self.passed_us;
        let is_lost = glitch_m > 0.0 && known > glitch_m * glitch_m && silent_us > LOST_US;
        let has_timed_out = silent_us > POSITION_TIMEOUT_US;
        if ratio >= 1.0 && glitch_m > 0.0 && !has_timed_out {
            return Taken::Rejected;
        }
        self.passed_us = self.at_us;
        if has_timed_out || is_lost {
            self.jump(place_m);
            return Taken::Jumped;
        }
        // Without a radius an outlier is taken for a third: measured, one of 150 m pulled 49 m.
        let sigma_m = if ratio < 1.0 { sigma_m } else { known.sqrt() };
        self.filter.fuse_horizontal(place_m, sigma_m);
        Taken::Fused
    }

    fn jump(&mut self, place_m: [f64; 2]) {
        self.passed_us = self.at_us;
        self.filter.reset_horizontal(place_m, 0.5 * self.settings.glitch_m.max(1.0));
    }

    /// A height, by its gate; one that is off for long is taken all the same.
    fn height(&mut self, down_m: f64) {
        let off_m = down_m - self.filter.nav().place_m.z;
        let variance = self.filter.position_variance(2) + BARO_SIGMA_M * BARO_SIGMA_M;
        if off_m * off_m < GATE_SIGMAS.powi(2) * variance || self.at_us - self.height_us > HEIGHT_TIMEOUT_US {
            self.height_us = self.at_us;
            self.filter.fuse_down(down_m, BARO_SIGMA_M);
        }
    }

    /// Normalised error squared of the filter's north and east, against where the vehicle was when the filter is; 2 expected.
    #[must_use]
    pub fn nees(&self, truth_m: [f64; 2]) -> Option<f64> {
        let off = Vector2::from(truth_m) - self.filter.nav().place_m.xy();
        let inverse: Matrix2<f64> = self.filter.horizontal().try_inverse()?;
        Some((off.transpose() * inverse * off).x)
    }
}

/// What became of a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    Fused,
    Rejected,
    Jumped,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Grade;
    use crate::vehicle::inertial::strapdown::GRAVITY_M_S2;
    use nalgebra::Matrix3;

    const STEP_US: u64 = 5_000;
    /// Fixes come so often, and so late.
    const FIX_US: u64 = 500_000;
    const AGE_US: u64 = 100_000;

    fn settings(glitch_m: f64) -> Settings {
        let begin = Begin { tilt_rad: 0.005, heading_rad: 0.02, velocity_m_s: 0.2, place_m: 0.5 };
        Settings { figures: Grade::Consumer.figures(), begin, gnss: [2.0, 0.1], heading_rad: 0.02, glitch_m }
    }

    /// Straight north at 20 m/s by a sensor without error, with fixes that `off` puts beside the truth, to the east; what it believes
    /// to be off by to the east, each second.
    fn flown(estimator: &mut Estimator, seconds: u64, off: impl Fn(u64) -> Option<f64>) -> Vec<f64> {
        let step = Increment {
            turn_rad: Vector3::zeros(),
            speed_m_s: Vector3::new(0.0, 0.0, -GRAVITY_M_S2 * 0.005),
            dt_s: 0.005,
        };
        let mut east_m = Vec::new();
        for now_us in (1..=seconds * 1_000_000 / STEP_US).map(|index| index * STEP_US) {
            if now_us > FIX_US
                && now_us % FIX_US == AGE_US
                && let Some(off_m) = off(now_us - AGE_US)
            {
                let at_us = now_us - AGE_US;
                let place_m = [20e-6 * at_us as f64, off_m];
                estimator.take(at_us, Measurement::Vision(VisionFix { at_us, place_m, sigma_m: 1.0, resets: 0 }));
            }
            estimator.advance(now_us, &step);
            if now_us % 1_000_000 == 0 {
                east_m.push(estimator.present().place_m.y);
            }
        }
        east_m
    }

    fn begun(glitch_m: f64) -> Estimator {
        let nav = Inertial {
            ned_from_body: Matrix3::identity(),
            velocity_m_s: Vector3::new(20.0, 0.0, 0.0),
            place_m: Vector3::zeros(),
        };
        Estimator::new(nav, &settings(glitch_m), 0)
    }

    /// Fixes that are late are taken when they were: at 20 m/s nothing is 2 m behind.
    #[test]
    fn late_fixes_count_when_they_were() {
        let mut estimator = begun(25.0);
        let east_m = flown(&mut estimator, 30, |_| Some(0.0));
        assert!(east_m.iter().all(|m| m.abs() < 1e-6));
        assert!((estimator.present().place_m.x - 600.0).abs() < 1e-6, "{}", estimator.present().place_m);
        assert_eq!((estimator.counts.rejected, estimator.counts.resets), (0, 0));
        // One that is older than the filter counts as of the filter's time: 0.3 s of age are 0.2 s of it, 2 m at 20 m/s.
        let mut early = begun(25.0);
        flown(&mut early, 10, |_| Some(0.0));
        let (filter_us, _) = early.filter();
        let place_m = [20e-6 * (filter_us - 100_000) as f64, 0.0];
        early.take(filter_us - 100_000, Measurement::Vision(VisionFix { at_us: 0, place_m, sigma_m: 1.0, resets: 0 }));
        flown_on(&mut early);
        assert!(early.filter().1.nav().place_m.x < 20e-6 * early.filter().0 as f64 - 0.05);
    }

    /// One more step.
    fn flown_on(estimator: &mut Estimator) {
        let step = Increment {
            turn_rad: Vector3::zeros(),
            speed_m_s: Vector3::new(0.0, 0.0, -GRAVITY_M_S2 * 0.005),
            dt_s: 0.005,
        };
        let now_us = estimator.filter().0 + HORIZON_US + STEP_US;
        estimator.advance(now_us, &step);
    }

    /// A single fix that is 150 m wrong is rejected; with a radius of 0 it is taken as far as its gate goes.
    #[test]
    fn an_outlier_is_rejected() {
        let off = |at_us: u64| Some(if at_us == 20_000_000 { 150.0 } else { 0.0 });
        let mut estimator = begun(25.0);
        let east_m = flown(&mut estimator, 30, off);
        assert!(east_m.iter().all(|m| m.abs() < 1e-6) && estimator.counts.rejected == 1, "{:?}", estimator.counts);
        let mut without = begun(0.0);
        let pulled_m = flown(&mut without, 30, off).into_iter().fold(0.0, f64::max);
        assert!((40.0..60.0).contains(&pulled_m) && without.counts.rejected == 0, "{pulled_m}");
    }

    /// A steady offset of 60 m is held off for ten seconds and then jumped to.
    #[test]
    fn a_steady_offset_is_held_off_for_ten_seconds() {
        let mut estimator = begun(25.0);
        let east_m = flown(&mut estimator, 40, |at_us| Some(if at_us > 15_000_000 { 60.0 } else { 0.0 }));
        let jumped_s = 1 + east_m.iter().position(|m| *m > 30.0).expect("it is taken in the end");
        assert!((25..=27).contains(&jumped_s), "{jumped_s} s");
        assert!((east_m[39] - 60.0).abs() < 5.0 && estimator.counts.resets == 1, "{east_m:?} {:?}", estimator.counts);
    }

    /// After a minute without fixes the filter no longer knows its place within 25 m, and jumps to the first.
    #[test]
    fn a_filter_that_is_lost_jumps_to_the_first_fix() {
        let mut estimator = begun(25.0);
        let is_covered = |at_us: u64| (10_000_000..80_000_000).contains(&at_us);
        flown(&mut estimator, 90, |at_us| (!is_covered(at_us)).then_some(if at_us < 10_000_000 { 0.0 } else { 3.0 }));
        assert_eq!((estimator.counts.resets, estimator.counts.rejected), (1, 0), "{:?}", estimator.counts);
        assert!((estimator.present().place_m.y - 3.0).abs() < 3.0);
    }
}
