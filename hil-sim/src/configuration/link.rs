//! The link in the configuration store.

use crate::scenario::{FixMessage, Vehicle};
use plumbline_firmware::stores::configuration::Link;

/// The link's settings of a vehicle.
pub(super) fn of(vehicle: &Vehicle) -> Link {
    let link = &vehicle.link;
    Link {
        autopilot: (link.system, link.autopilot_component),
        range: (link.range_component, link.range_sensor),
        encoder: link.encoder_component,
        range_interval_us: 1_000_000 / vehicle.range.rate_hz.max(1),
        fix_message: match link.fix_message {
            FixMessage::Auto => 0,
            FixMessage::Odometry => 1,
            FixMessage::GlobalPositionSensor => 2,
            FixMessage::VisionPositionEstimate => 3,
        },
        sensor_id: link.fix_sensor_id,
        fix_interval_us: (1e6 / link.fix_rate_hz).round() as u32,
        correlation_s: link.fix_correlation_s as f32,
        map_sigma_m: link.map_sigma_m as f32,
    }
}
