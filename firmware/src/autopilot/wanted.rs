//! The parameters that an autopilot must, or had better, have set so that it uses fixes, and to what.
//!
//! Sources: the flights in ArduPlane's own simulator that `docs/autopilots.md` tells of, the ranges in ArduPilot's
//! `AP_VisualOdom`, `AP_NavEKF_Source` and `AP_NavEKF3`, and PX4's `ekf2` for its own.

use super::fixes::Form;
use crate::wire::incoming::AutopilotKind;

/// A parameter and its right values.
#[derive(Debug)]
pub struct Wanted {
    /// Its name, at most 16 characters.
    pub name: &'static str,
    /// Its right values.
    pub right: Right,
    /// Whether fixes do harm or no good without it; what is not required is told, and no more.
    pub is_required: bool,
}

/// What a parameter is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Right {
    /// This number.
    Is(f32),
    /// Within these bounds, both included; the last number is proposed.
    Within(f32, f32, f32),
    /// More than the attitudes that are wanted a second: nothing is sent as often as the autopilot's loop runs.
    AboveAttitudes,
    /// The id in our own messages.
    SensorId,
}

/// What the right values depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ours {
    /// From one attitude that is wanted to the next, microseconds.
    pub attitude_us: u32,
    /// GLOBAL_POSITION_SENSOR.id.
    pub sensor_id: u8,
}

/// Loop rate that is proposed where it suffices, hertz: that of ArduPilot's documented plane with 200 Hz of attitudes.
const LOOP_HZ: f32 = 300.0;
/// The fastest loop that all of ArduPilot's vehicles take.
const LOOP_MAX_HZ: f32 = 400.0;

impl Right {
    /// What is proposed instead of a wrong value.
    pub fn proposed(self, ours: Ours) -> f32 {
        match self {
            Right::Is(value) | Right::Within(_, _, value) => value,
            Right::AboveAttitudes if ours.attitudes_hz() < LOOP_HZ => LOOP_HZ,
            Right::AboveAttitudes => LOOP_MAX_HZ,
            Right::SensorId => f32::from(ours.sensor_id),
        }
    }

    /// Whether a value is right. What is no number is not.
    pub fn holds(self, value: f32, ours: Ours) -> bool {
        match self {
            Right::Is(_) | Right::SensorId => value == self.proposed(ours),
            Right::Within(least, most, _) => (least..=most).contains(&value),
            // Attitudes that not even the fastest loop sends are told of where they are denied.
            Right::AboveAttitudes => value > ours.attitudes_hz() || value >= LOOP_MAX_HZ,
        }
    }
}

impl Ours {
    fn attitudes_hz(self) -> f32 {
        1e6 / self.attitude_us.max(1) as f32
    }
}

const fn required(name: &'static str, right: Right) -> Wanted {
    Wanted { name, right, is_required: true }
}

const fn advised(name: &'static str, right: Right) -> Wanted {
    Wanted { name, right, is_required: false }
}

/// ArduPilot, fixes in its local frame. Velocity, height and heading of the second set must not be external navigation: what
/// our messages have of them is the autopilot's own estimate, which it would take for a measurement.
const ARDUPILOT: [Wanted; 10] = [
    required("VISO_TYPE", Right::Is(1.0)),
    required("EK3_SRC2_POSXY", Right::Is(6.0)),
    required("EK3_SRC2_VELXY", Right::Is(0.0)),
    required("EK3_SRC2_POSZ", Right::Is(1.0)),
    required("EK3_SRC2_VELZ", Right::Is(0.0)),
    required("EK3_SRC2_YAW", Right::Is(1.0)),
    // With 0 an outlier is clipped instead of rejected; the rest is ArduPilot's own range.
    advised("EK3_GLITCH_RAD", Right::Within(10.0, 100.0, 25.0)),
    advised("SCHED_LOOP_RATE", Right::AboveAttitudes),
    // A fix's stamp says its age, and the message that goes with it keeps that right: what is taken off here is taken off twice.
    // ArduPilot's default of 10 is 0.2 m at 20 m/s.
    advised("VISO_DELAY_MS", Right::Within(0.0, 10.0, 0.0)),
    // The floor of what is believed of a fix: beyond a metre good fixes count for little.
    advised("VISO_POS_M_NSE", Right::Within(0.0, 1.0, 0.2)),
];

/// PX4, fixes in degrees. Its height stays its own.
const PX4: [Wanted; 3] = [
    required("EKF2_AGP0_CTRL", Right::Is(1.0)),
    required("EKF2_AGP0_ID", Right::SensorId),
    // Its filter remembers EKF2_DELAY_MAX, 200 ms unless set.
    advised("EKF2_AGP0_DELAY", Right::Within(0.0, 200.0, 100.0)),
];

/// PX4, fixes in its local frame: horizontal positions alone.
const PX4_LOCAL: [Wanted; 1] = [required("EKF2_EV_CTRL", Right::Is(1.0))];

/// The most in a list.
pub const MOST: usize = ARDUPILOT.len();

/// What is wanted of an autopilot that gets fixes in this form; nothing of one that is not known.
pub fn of(kind: AutopilotKind, form: Form) -> &'static [Wanted] {
    match (kind, form.is_local()) {
        (AutopilotKind::Ardupilot, true) => &ARDUPILOT,
        (AutopilotKind::Px4, false) => &PX4,
        (AutopilotKind::Px4, true) => &PX4_LOCAL,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::{ARDUPILOT, MOST, Ours, PX4, PX4_LOCAL, Right};

    #[test]
    fn a_loop_must_be_faster_than_what_is_wanted_of_it() {
        let right = |hz: u32, value: f32| {
            Right::AboveAttitudes.holds(value, Ours { attitude_us: 1_000_000 / hz, sensor_id: 1 })
        };
        assert!(!right(50, 50.0) && right(50, 51.0) && !right(200, 200.0) && right(200, 300.0));
        let proposed = |hz: u32| Right::AboveAttitudes.proposed(Ours { attitude_us: 1_000_000 / hz, sensor_id: 1 });
        assert_eq!((proposed(200), proposed(333)), (300.0, 400.0));
    }

    #[test]
    fn what_is_proposed_is_right_and_no_number_is_not() {
        let ours = Ours { attitude_us: 5_000, sensor_id: 7 };
        for wanted in ARDUPILOT.iter().chain(&PX4).chain(&PX4_LOCAL) {
            assert!(wanted.right.holds(wanted.right.proposed(ours), ours), "{}", wanted.name);
            assert!(!wanted.right.holds(f32::NAN, ours) && !wanted.right.holds(-1.0, ours), "{}", wanted.name);
            assert!(wanted.name.len() <= 16, "{}", wanted.name);
        }
        assert!(PX4.len() <= MOST && PX4_LOCAL.len() <= MOST && MOST <= 16);
        assert_eq!(Right::SensorId.proposed(ours), 7.0);
    }
}
