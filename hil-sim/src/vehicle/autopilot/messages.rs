//! What samples are as messages.

use super::SYSTEM;
use crate::vehicle::sensors::Sample;
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, DISTANCE_SENSOR_DATA, EstimatorStatusFlags,
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GimbalDeviceErrorFlags, GimbalDeviceFlags,
    LOCAL_POSITION_NED_DATA, MavDistanceSensor, MavLandedState, MavSensorOrientation,
};

/// What a range finder without an echo sends.
const NO_ECHO_CM: u16 = u16::MAX;

fn time_boot_ms(sample: &Sample) -> u32 {
    (sample.sampled_at_us / 1000) as u32
}

pub(super) fn attitude(
    sample: &Sample,
    q: [f32; 4],
    velocity_ned_m_s: [f64; 3],
) -> AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
    let [vx, vy, vz] = velocity_ned_m_s.map(|v| v as f32);
    AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA {
        // Counted in 32 bits of the field's 64, as ArduPilot does.
        time_boot_us: u64::from(sample.sampled_at_us as u32),
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

pub(super) fn coarse_attitude(sample: &Sample, [q1, q2, q3, q4]: [f32; 4]) -> ATTITUDE_QUATERNION_DATA {
    ATTITUDE_QUATERNION_DATA { time_boot_ms: time_boot_ms(sample), q1, q2, q3, q4, ..ATTITUDE_QUATERNION_DATA::DEFAULT }
}

pub(super) fn encoder(sample: &Sample, follow_up_rad: f64) -> GIMBAL_DEVICE_ATTITUDE_STATUS_DATA {
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

pub(super) fn range(sample: &Sample, slant_m: Option<f64>) -> DISTANCE_SENSOR_DATA {
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

/// The height alone, which is all that a companion wants of it.
pub(super) fn local(sample: &Sample, down_m: f64) -> LOCAL_POSITION_NED_DATA {
    LOCAL_POSITION_NED_DATA { time_boot_ms: time_boot_ms(sample), z: down_m as f32, ..LOCAL_POSITION_NED_DATA::DEFAULT }
}

pub(super) fn position(
    sample: &Sample,
    (lat, lon): (f64, f64),
    [up_m, above_home_m]: [f64; 2],
    velocity_ned_m_s: [f64; 3],
    heading_true_rad: Option<f64>,
) -> GLOBAL_POSITION_INT_DATA {
    let [vx, vy, vz] = velocity_ned_m_s.map(|v| (v * 100.0).round() as i16);
    GLOBAL_POSITION_INT_DATA {
        time_boot_ms: time_boot_ms(sample),
        lat: (lat * 1e7).round() as i32,
        lon: (lon * 1e7).round() as i32,
        alt: (up_m * 1000.0).round() as i32,
        relative_alt: (above_home_m * 1000.0).round() as i32,
        vx,
        vy,
        vz,
        // From 0 to 359.99 degrees; all ones are none.
        hdg: heading_true_rad.map_or(u16::MAX, |rad| (100.0 * rad.to_degrees()).round().rem_euclid(36_000.0) as u16),
    }
}

/// [w, x, y, z] of the turn from world north-east-down to body forward-right-down by heading, pitch, roll: the product
/// of the three elementary quaternions, in f64 and apart from the core's.
pub(super) fn quaternion(heading_rad: f64, pitch_rad: f64, roll_rad: f64) -> [f32; 4] {
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
