//! How an ArduPilot takes a companion's positions: which messages count, how old it takes them for, and how good.
//!
//! As in its sources of March 2026, and as measured in its own simulator: the stamps' offset is learned from the message that was on
//! its way for the shortest time, whichever it is; one number is the sigma of both axes; a driver that heard nothing for 300 ms is
//! not healthy. Any quality is taken, as VISO_QUAL_MIN has it by default.

use plumbline_firmware::wire::fix_message::{Odometry, VisionPosition};

/// AP_VISUALODOM_TIMEOUT_MS.
const TIMEOUT_US: u64 = 300_000;
/// JitterCorrection: how late a message may be, and after how many the offset is learned anew.
const LAG_MAX_US: i64 = 500_000;
const LEARNED_OF: u32 = 100;
/// Half of the filter's own step of 12 ms (EKF_TARGET_DT), which it takes off every stamp.
const HALF_STEP_US: u64 = 6_000;
/// Elements of the upper right triangle of a covariance of six whose sum is one axis' variance.
const DIAGONAL: [usize; 3] = [0, 6, 11];

/// What a companion sends of position and velocity.
#[derive(Clone, Debug, PartialEq)]
pub enum Vision {
    /// ODOMETRY.
    Odometry(Odometry),
    /// VISION_POSITION_ESTIMATE.
    Position(VisionPosition),
    /// VISION_SPEED_ESTIMATE, of which the stamp alone counts.
    Speed {
        /// Microseconds.
        stamp_us: u64,
    },
}

/// A position as the filter gets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisionFix {
    /// When it is taken to have been, microseconds.
    pub at_us: u64,
    /// North and east of the filter's origin.
    pub place_m: [f64; 2],
    /// One sigma of each axis.
    pub sigma_m: f64,
    /// The sender's reset counter.
    pub resets: u8,
}

/// The driver of visual odometry, with the parameters that it has.
#[derive(Clone, Debug)]
pub struct Driver {
    /// VISO_DELAY_MS, microseconds.
    pub delay_us: u64,
    /// VISO_POS_M_NSE.
    pub noise_m: f64,
    offset_us: Option<i64>,
    least_us: i64,
    counted: u32,
    heard_us: Option<u64>,
}

impl Driver {
    /// Before the first message.
    #[must_use]
    pub fn new(delay_ms: f64, noise_m: f64) -> Self {
        Driver {
            delay_us: (1e3 * delay_ms.max(0.0)) as u64,
            noise_m,
            offset_us: None,
            least_us: 0,
            counted: 0,
            heard_us: None,
        }
    }

    /// Whether it heard something within its time.
    #[must_use]
    pub fn is_healthy(&self, now_us: u64) -> bool {
        self.heard_us.is_some_and(|heard_us| now_us.saturating_sub(heard_us) < TIMEOUT_US)
    }

    /// Takes a message that arrives at `now_us`; the position in it.
    pub fn take(&mut self, message: &Vision, now_us: u64) -> Option<VisionFix> {
        let stamp_us = match message {
            Vision::Odometry(odometry) => odometry.base.time_usec,
            Vision::Position(position) => position.base.usec,
            Vision::Speed { stamp_us } => *stamp_us,
        };
        let was_us = self.on_own_clock(stamp_us, now_us);
        self.heard_us = Some(now_us);
        let (place, covariance, resets) = match message {
            Vision::Odometry(odometry) => {
                let base = &odometry.base;
                ([base.x, base.y, base.z], base.pose_covariance, odometry.resets)
            }
            Vision::Position(position) => {
                let base = &position.base;
                ([base.x, base.y, base.z], position.covariance, position.resets)
            }
            Vision::Speed { .. } => return None,
        };
        if !place.iter().all(|m| m.is_finite()) {
            return None;
        }
        let variance: f64 = DIAGONAL.iter().map(|index| f64::from(covariance[*index])).sum();
        // 100 m is what it takes at most, and what is no number becomes.
        let sigma_m = if variance.is_finite() { variance.max(0.0).sqrt() } else { 100.0 };
        Some(VisionFix {
            at_us: was_us.saturating_sub(self.delay_us + HALF_STEP_US),
            place_m: [f64::from(place[0]), f64::from(place[1])],
            sigma_m: sigma_m.clamp(self.noise_m.min(100.0), 100.0),
            resets,
        })
    }

    /// A sender's stamp on its own clock: the smallest lag seen is taken for none.
    fn on_own_clock(&mut self, stamp_us: u64, now_us: u64) -> u64 {
        let lag_us = now_us as i64 - stamp_us as i64;
        let mut offset_us = self.offset_us.map_or(lag_us, |offset_us| offset_us.min(lag_us));
        if lag_us - offset_us > LAG_MAX_US {
            offset_us = lag_us - LAG_MAX_US;
        }
        let was_us = (stamp_us as i64 + offset_us).max(0) as u64;
        self.least_us = if self.counted == 0 { lag_us } else { self.least_us.min(lag_us) };
        self.counted += 1;
        if self.counted == LEARNED_OF {
            (offset_us, self.counted) = (self.least_us, 0);
        }
        self.offset_us = Some(offset_us);
        was_us
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::ODOMETRY_DATA;

    fn odometry(stamp_us: u64) -> Vision {
        let mut base = ODOMETRY_DATA { time_usec: stamp_us, x: 3.0, y: 4.0, ..ODOMETRY_DATA::DEFAULT };
        (base.pose_covariance[0], base.pose_covariance[6]) = (0.5, 0.5);
        Vision::Odometry(Odometry { base, ..Odometry::default() })
    }

    /// A fix of 100 ms alone is taken for new; beside a message that is new it is as old as it is.
    #[test]
    fn ages_count_from_the_quickest_message() {
        let mut alone = Driver::new(0.0, 0.2);
        let fix = alone.take(&odometry(900_000), 1_000_000).unwrap();
        assert_eq!(fix.at_us, 1_000_000 - HALF_STEP_US);
        let mut beside = Driver::new(0.0, 0.2);
        assert_eq!(beside.take(&Vision::Speed { stamp_us: 998_000 }, 1_000_000), None);
        let fix = beside.take(&odometry(900_000), 1_002_000).unwrap();
        assert_eq!(fix.at_us, 902_000 - HALF_STEP_US);
        assert_eq!((fix.place_m, fix.sigma_m), ([3.0, 4.0], 1.0));
        // The delay's parameter comes on top.
        let mut delayed = Driver::new(100.0, 0.2);
        delayed.take(&Vision::Speed { stamp_us: 1_000_000 }, 1_000_000);
        assert_eq!(delayed.take(&odometry(900_000), 1_000_000).unwrap().at_us, 800_000 - HALF_STEP_US);
    }

    #[test]
    fn the_sigma_has_a_floor_and_silence_is_not_healthy() {
        let mut driver = Driver::new(0.0, 5.0);
        assert!(!driver.is_healthy(0));
        assert_eq!(driver.take(&odometry(1_000_000), 1_000_000).unwrap().sigma_m, 5.0);
        assert!(driver.is_healthy(1_299_999) && !driver.is_healthy(1_300_000));
    }
}
