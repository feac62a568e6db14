//! Who is on the link, and how fixes are sent.

use crate::scenario::bounds::Bounded;
use plumbline_firmware::stores::configuration::{ALTITUDES_M, CORRELATION_MAX_S, START_SIGMA_MAX_M};
use serde::{Deserialize, Serialize};

/// Who is on the link, and how fixes are sent to the autopilot. A sample is taken from the sender that is named here and from
/// no other.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
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
    /// Who has the autopilot use fixes instead of satellite navigation.
    pub switch_source: SwitchSource,
    /// System id of the ground station whose orders are taken; 0 takes nobody's.
    pub ground_station: u8,
    /// Whether a fix that finds a lost position changes the reset counter, by which the autopilot begins anew from it.
    pub reset_on_reacquisition: bool,
    /// Where the vehicle stands at first, where satellite navigation does not tell.
    pub start: Option<Start>,
}

/// A start without satellite navigation.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Latitude.
    pub lat_deg: f64,
    /// Longitude.
    pub lon_deg: f64,
    /// One sigma of each axis, metres.
    pub sigma_m: f64,
    /// One sigma of the autopilot's heading until it has a position.
    #[serde(default)]
    pub heading_sigma_deg: f64,
    /// Height above sea level.
    #[serde(default)]
    pub altitude_m: f64,
    /// Whether the autopilot is given the place as the origin of its frame where it has none.
    #[serde(default)]
    pub set_origin: bool,
}

/// Who has the autopilot use fixes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SwitchSource {
    /// Its pilot.
    #[default]
    Never,
    /// The firmware, where satellite navigation is lost.
    OnGnssLoss,
    /// The firmware, where a ground station tells it to.
    Told,
}

/// How long errors of fixes are taken to stay alike unless told otherwise, seconds: the memory of an autopilot's filter, 5 to 7 s
/// with ArduPlane 4.8 on fixes, over 2.83, by which an error that lasts is as large as that filter expects it.
const CORRELATION_S: f64 = 2.5;

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
            fix_correlation_s: CORRELATION_S,
            map_sigma_m: 0.0,
            switch_source: SwitchSource::Never,
            ground_station: 255,
            reset_on_reacquisition: false,
            start: None,
        }
    }
}

/// The message that fixes are sent in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
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
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let own = [
            ("link.system", self.system.into(), 1.0, 255.0),
            ("link.fix_sensor_id", self.fix_sensor_id.into(), 1.0, 255.0),
            ("link.fix_rate_hz", self.fix_rate_hz, 0.02, 100.0),
            ("link.fix_correlation_s", self.fix_correlation_s, 0.0, CORRELATION_MAX_S.into()),
            ("link.map_sigma_m", self.map_sigma_m, 0.0, 1000.0),
        ];
        own.into_iter().chain(self.start.iter().flat_map(Start::ranges)).collect()
    }
}

impl Start {
    fn ranges(&self) -> [Bounded; 5] {
        [
            ("link.start.lat_deg", self.lat_deg, -90.0, 90.0),
            ("link.start.lon_deg", self.lon_deg, -180.0, 180.0),
            ("link.start.sigma_m", self.sigma_m, 0.01, START_SIGMA_MAX_M.into()),
            ("link.start.heading_sigma_deg", self.heading_sigma_deg, 0.0, 180.0),
            ("link.start.altitude_m", self.altitude_m, (*ALTITUDES_M.start()).into(), (*ALTITUDES_M.end()).into()),
        ]
    }
}
