//! The autopilot that the firmware believes to talk to: samples as MAVLink messages, and its clock.

use crate::vehicle::sensors::{Reading, Sample};
use mavlink::dialects::common::{
    AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, DISTANCE_SENSOR_DATA, EstimatorStatusFlags,
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GimbalDeviceErrorFlags, GimbalDeviceFlags,
    MavDistanceSensor, MavLandedState, MavSensorOrientation,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use plumbline_firmware::wire::extensions::Timesync;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;

/// The autopilot's system and component id.
const SYSTEM: u8 = 1;
const COMPONENT: u8 = 1;
/// The encoder's component id, MAV_COMP_ID_GIMBAL2.
const ENCODER: u8 = 171;
/// What a range finder without an echo sends.
const NO_ECHO_CM: u16 = u16::MAX;

/// Turns samples into messages.
#[derive(Debug, Default)]
pub struct Autopilot {
    sequence: u8,
}

impl Autopilot {
    /// The message of a sample; `None` for readings that travel by wire.
    ///
    /// # Errors
    /// A position that the reference system cannot convert.
    pub fn message(&mut self, sample: &Sample, crs: &Crs) -> Result<Option<Vec<u8>>, InputError> {
        Ok(match sample.reading {
            Reading::Pps { .. } => None,
            Reading::Attitude { heading_true_rad, pitch_rad, roll_rad, velocity_ned_m_s } => {
                let q = quaternion(heading_true_rad, pitch_rad, roll_rad);
                Some(self.encode(COMPONENT, &attitude(sample, q, velocity_ned_m_s)))
            }
            Reading::FollowUp { follow_up_rad } => Some(self.encode(ENCODER, &encoder(sample, follow_up_rad))),
            Reading::Range { slant_m } => Some(self.encode(COMPONENT, &range(sample, slant_m))),
            Reading::Position { east_m, north_m, up_m, velocity_ned_m_s } => {
                let degrees = crs.to_wgs84(east_m, north_m)?;
                Some(self.encode(COMPONENT, &position(sample, degrees, up_m, velocity_ned_m_s)))
            }
        })
    }

    /// The answer to a TIMESYNC request that carried `theirs_ns` and reached the autopilot at `at_us`.
    pub fn timesync_answer(&mut self, theirs_ns: i64, at_us: u64, to: (u8, u8)) -> Vec<u8> {
        let tc1 = at_us as i64 * 1000;
        self.encode(COMPONENT, &Timesync { tc1, ts1: theirs_ns, target: to })
    }

    fn encode<D: MessageData>(&mut self, component: u8, data: &D) -> Vec<u8> {
        let mut raw = MAVLinkV2MessageRaw::new();
        let header = MavHeader { system_id: SYSTEM.into(), component_id: component, sequence: self.sequence };
        self.sequence = self.sequence.wrapping_add(1);
        raw.serialize_message_data(header, data);
        raw.raw_bytes().to_vec()
    }
}

fn time_boot_ms(sample: &Sample) -> u32 {
    (sample.sampled_at_us / 1000) as u32
}

fn attitude(sample: &Sample, q: [f32; 4], velocity_ned_m_s: [f64; 3]) -> AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
    let [vx, vy, vz] = velocity_ned_m_s.map(|v| v as f32);
    AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
        time_boot_us: sample.sampled_at_us,
        q,
        q_estimated_delay_us: (sample.arrived_at_us - sample.sampled_at_us) as u32,
        vx,
        vy,
        vz,
        v_estimated_delay_us: 0,
        feed_forward_angular_velocity_z: f32::NAN,
        estimator_status: EstimatorStatusFlags::empty(),
        target_system: SYSTEM,
        target_component: 0,
        landed_state: MavLandedState::MAV_LANDED_STATE_IN_AIR,
    }
}

fn encoder(sample: &Sample, follow_up_rad: f64) -> GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
        time_boot_ms: time_boot_ms(sample),
        // The gimbal's yaw is clockwise, the follow-up angle counter-clockwise.
        q: quaternion(-follow_up_rad, 0.0, 0.0),
        angular_velocity_x: f32::NAN,
        angular_velocity_y: f32::NAN,
        angular_velocity_z: f32::NAN,
        failure_flags: GimbalDeviceErrorFlags::empty(),
        flags: GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
        target_system: 0,
        target_component: 0,
    }
}

fn range(sample: &Sample, slant_m: Option<f64>) -> DISTANCE_SENSOR_DATA {
    DISTANCE_SENSOR_DATA {
        time_boot_ms: time_boot_ms(sample),
        min_distance: 10,
        max_distance: 60_000,
        current_distance: slant_m.map_or(NO_ECHO_CM, |slant| (slant * 100.0).round() as u16),
        mavtype: MavDistanceSensor::MAV_DISTANCE_SENSOR_LASER,
        id: 0,
        orientation: MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270,
        covariance: u8::MAX,
    }
}

fn position(
    sample: &Sample,
    (lat, lon): (f64, f64),
    up_m: f64,
    velocity_ned_m_s: [f64; 3],
) -> GLOBAL_POSITION_INT_DATA {
    let [vx, vy, vz] = velocity_ned_m_s.map(|v| (v * 100.0).round() as i16);
    GLOBAL_POSITION_INT_DATA {
        time_boot_ms: time_boot_ms(sample),
        lat: (lat * 1e7).round() as i32,
        lon: (lon * 1e7).round() as i32,
        alt: (up_m * 1000.0).round() as i32,
        relative_alt: (up_m * 1000.0).round() as i32,
        vx,
        vy,
        vz,
        hdg: u16::MAX,
    }
}

/// [w, x, y, z] of the turn from world north-east-down to body forward-right-down by heading, pitch, roll: the product
/// of the three elementary quaternions, in f64 and apart from the core's.
fn quaternion(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> [f32; 4] {
    let about = |axis: usize, angle: f64| {
        let mut q = [(0.5 * angle).cos(), 0.0, 0.0, 0.0];
        q[axis + 1] = (0.5 * angle).sin();
        q
    };
    let q = product(product(about(2, heading_rad), about(1, pitch_rad)), about(0, roll_rad));
    q.map(|component| component as f32)
}

fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}
