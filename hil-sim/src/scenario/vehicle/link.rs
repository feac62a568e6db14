//! Who is on the link, and how fixes are sent.

use crate::scenario::bounds::Bounded;
use plumbline_firmware::stores::configuration::CORRELATION_MAX_S;
use serde::Deserialize;

/// Who is on the link, and how fixes are sent to the autopilot. A sample is taken from the sender that is named here and from
/// no other.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default)]
pub struct Link {
    /// System id of the vehicle, ours too.
    pub system: u8,
    /// Component id of the autopilot.
    pub autopilot_component: u8,
    /// Component id of who sends DISTANCE_SENSOR.
    pub range_component: u8,
    /// DISTANCE_SENSOR.id of the laser; any that looks down unless given.
    pub range_sensor: Option<u8>,
    /// Component id of the follow-up axis' encoder.
    pub encoder_component: u8,
    /// The message that fixes are sent in.
    pub fix_message: FixMessage,
    /// GLOBAL_POSITION_SENSOR.id.
    pub fix_sensor_id: u8,
    /// Fixes sent a second, at most.
    pub fix_rate_hz: f64,
    /// How long the errors of fixes stay alike.
    pub fix_correlation_s: f64,
    /// What the map may lie beside the ground, one sigma of each axis: it enlarges the covariance that is sent.
    pub map_sigma_m: f64,
}

impl Default for Link {
    fn default() -> Self {
        Link {
            system: 1,
            autopilot_component: 1,
            range_component: 1,
            range_sensor: None,
            encoder_component: 171,
            fix_message: FixMessage::Auto,
            fix_sensor_id: 1,
            fix_rate_hz: 2.0,
            fix_correlation_s: CORRELATION_MAX_S.into(),
            map_sigma_m: 0.0,
        }
    }
}

/// The message that fixes are sent in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FixMessage {
    /// As the autopilot's heartbeat says: ODOMETRY for ArduPilot, GLOBAL_POSITION_SENSOR for PX4 and others.
    #[default]
    Auto,
    /// ODOMETRY.
    Odometry,
    /// GLOBAL_POSITION_SENSOR.
    GlobalPositionSensor,
    /// VISION_POSITION_ESTIMATE.
    VisionPositionEstimate,
}

impl Link {
    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> [Bounded; 5] {
        [
            ("link.system", self.system.into(), 1.0, 255.0),
            ("link.fix_sensor_id", self.fix_sensor_id.into(), 1.0, 255.0),
            ("link.fix_rate_hz", self.fix_rate_hz, 0.02, 100.0),
            ("link.fix_correlation_s", self.fix_correlation_s, 0.0, CORRELATION_MAX_S.into()),
            ("link.map_sigma_m", self.map_sigma_m, 0.0, 1000.0),
        ]
    }
}
