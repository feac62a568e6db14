//! What a second sender says in place of the autopilot.

use crate::vehicle::sensors::{Reading, Sample};

/// How far off it is: metres, radians, and the range as a factor.
const OFF_M: f64 = 300.0;
const OFF_RAD: f64 = 0.3;
const OFF_TIMES: f64 = 1.5;

/// A sample with other values, far beyond what noise does.
pub(super) fn strange(sample: &Sample) -> Sample {
    let reading = match sample.reading {
        Reading::Pps { second } => Reading::Pps { second },
        Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s } => Reading::Attitude {
            heading_true_rad: heading_true_rad + OFF_RAD,
            pitch_rad: pitch_rad + OFF_RAD,
            roll_rad: roll_rad - OFF_RAD,
            velocity_ned_m_s: velocity_ned_m_s.map(|v| -v),
        },
        Reading::FollowUp { follow_up_rad } => Reading::FollowUp { follow_up_rad: follow_up_rad + OFF_RAD },
        Reading::Range { slant_m } => Reading::Range { slant_m: slant_m.map(|slant_m| slant_m * OFF_TIMES) },
        Reading::Position { east_m, north_m, up_m, velocity_ned_m_s } => Reading::Position {
            east_m: east_m + OFF_M,
            north_m: north_m - OFF_M,
            up_m: up_m + OFF_M,
            velocity_ned_m_s: velocity_ned_m_s.map(|v| -v),
        },
    };
    Sample { reading, ..*sample }
}
