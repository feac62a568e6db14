//! Error of the reported velocity, from the displacement between matches.
//!
//! An estimator with a wrong velocity, as after a long time without fixes, takes the error for a tilt once fixes come, and is off in both
//! for some ten seconds: matches with its attitude are off to the same side for as long.

use super::reckoning::{DeadReckoning, Moment};
use crate::math::sqrt;
use crate::tile::Local;
use crate::units::Micros;

/// Shortest and longest time between two matches that are compared, microseconds: over less noise dominates, over more the error itself has
/// changed.
const APART_US: i32 = 1_000_000;
const APART_MAX_US: i32 = 4_000_000;
/// Time constant with which an observed error decays, seconds: velocity and tilt oscillate, a quarter of a period of 16 s apart, in
/// ArduPlane 4.8 after 40 s without fixes.
const MEMORY_S: f32 = 5.0;
/// An error counts beyond so many sigmas of the velocity.
const SIGMAS: f32 = 2.0;

/// Estimate of the velocity's error.
#[derive(Clone, Copy, Debug)]
pub struct VelocityError {
    newest_at: Option<Micros>,
    /// Two matches, dead-reckoned to the newest one: the older is compared, the newer replaces it.
    since: [Option<DeadReckoning>; 2],
    /// At the newest match, m/s.
    error_m_per_s: f32,
}

impl Default for VelocityError {
    fn default() -> Self {
        VelocityError::new()
    }
}

impl VelocityError {
    /// No error.
    pub const fn new() -> Self {
        VelocityError { newest_at: None, since: [None; 2], error_m_per_s: 0.0 }
    }

    /// The error beyond the configured sigma, m/s.
    pub fn m_per_s(&self) -> f32 {
        self.error_m_per_s
    }

    /// Takes an accepted match. `nadir`: in the tile's frame; `sigma_m_per_s`: configured sigma of the velocity, each axis.
    pub fn matched(&mut self, moment: Moment, nadir: Local, sigma_m_per_s: f32) {
        let seconds = self.newest_at.map_or(0.0, |newest_at| moment.at.since(newest_at) as f32 * 1e-6);
        self.newest_at = Some(moment.at);
        self.since = self.since.map(|since| since?.to(moment, APART_MAX_US));
        let [older, newer] = self.since;
        let seen = older.map_or(0.0, |older| older.off_m(nadir) / (older.age_us().max(APART_US) as f32 * 1e-6));
        let beyond = sqrt((seen * seen - SIGMAS * SIGMAS * sigma_m_per_s * sigma_m_per_s).max(0.0));
        self.error_m_per_s = beyond.max(self.error_m_per_s / (1.0 + seconds.max(0.0) / MEMORY_S));
        let begins = Some(DeadReckoning::new(moment, nadir));
        match newer {
            Some(since) if since.age_us() < APART_US => {}
            Some(since) => self.since = [Some(since), begins],
            None => self.since = [older, begins],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::VelocityError;
    use crate::navigation::reckoning::Moment;
    use crate::tile::Local;
    use crate::units::Micros;

    /// Matches four times a second of a vehicle that flies east at 20 m/s in bends; `error`: of the reported velocity. The estimate.
    fn seen(error: impl Fn(f32) -> f32, seconds: f32, sigma_m_per_s: f32) -> f32 {
        let mut velocity = VelocityError::new();
        for frame in 0..(4.0 * seconds) as u32 {
            let at_s = 0.25 * frame as f32;
            // 20 m/s east, and a north-south oscillation of 5 m/s with a period of 12.6 s.
            let nadir = Local { east_m: 20.0 * at_s, north_m: 10.0 * (1.0 - libm::cosf(0.5 * at_s)) };
            let moment = Moment {
                at: Micros(1_000_000 + 250_000 * u64::from(frame)),
                velocity_m_per_s: [20.0 + error(at_s), 5.0 * libm::sinf(0.5 * at_s)],
            };
            velocity.matched(moment, nadir, sigma_m_per_s);
        }
        velocity.m_per_s()
    }

    #[test]
    fn an_error_of_the_velocity_is_seen_and_forgotten() {
        assert!(seen(|_| 0.0, 20.0, 0.05) < 0.01, "a velocity that is right");
        assert!((seen(|_| 4.0, 10.0, 0.0) - 4.0).abs() < 0.02);
        // Beyond two sigmas of 1 m/s; 1.9 m/s is none.
        assert!((seen(|_| 4.0, 10.0, 1.0) - 12.0f32.sqrt()).abs() < 0.02);
        assert_eq!(seen(|_| 1.9, 10.0, 1.0), 0.0);
        // Seven seconds after its end, of which two are still compared with matches before.
        let left = seen(|at_s| if at_s < 10.0 { 4.0 } else { 0.0 }, 17.0, 0.05);
        assert!((0.8..1.6).contains(&left), "{left}");
    }

    #[test]
    fn matches_that_lie_far_apart_are_not_compared() {
        let mut velocity = VelocityError::new();
        for second in [0u64, 5, 10] {
            let moment = Moment { at: Micros(1_000_000 + 1_000_000 * second), velocity_m_per_s: [0.0; 2] };
            velocity.matched(moment, Local { east_m: 50.0 * second as f32, north_m: 0.0 }, 0.5);
        }
        assert_eq!(velocity.m_per_s(), 0.0);
    }
}
