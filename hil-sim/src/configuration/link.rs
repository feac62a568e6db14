//! The link in the configuration store.

use crate::scenario::{FixMessage, SwitchSource, Vehicle};
use plumbline_firmware::stores::configuration::{Link, Start};

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
        switching: match link.switch_source {
            SwitchSource::Never => 0,
            SwitchSource::OnGnssLoss => 1,
            SwitchSource::Told => 2,
        },
        ground_station: link.ground_station,
        resets_on_reacquisition: link.reset_on_reacquisition,
        start: link.start.map(|start| {
            let e7 = |deg: f64| (deg * 1e7).round() as i32;
            Start {
                place_e7: (e7(start.lat_deg), e7(start.lon_deg)),
                sigma_m: start.sigma_m as f32,
                // Half a turn must not be more than that in single precision.
                heading_sigma_rad: (start.heading_sigma_deg.to_radians() as f32).min(std::f32::consts::PI),
                altitude_m: start.altitude_m as f32,
                sets_origin: start.set_origin,
            }
        }),
    }
}
