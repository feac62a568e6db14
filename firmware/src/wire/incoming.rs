//! From MAVLink's messages, axes and units to the core's.
//!
//! The traps, all of them met in the field: ATTITUDE_QUATERNION and the slow messages stamp milliseconds, only
//! AUTOPILOT_STATE_FOR_GIMBAL_DEVICE stamps microseconds; DISTANCE_SENSOR counts centimetres and 65535 is not 655 m;
//! a signal quality of 1 means invalid while 0 means unknown; a gimbal's yaw is clockwise and may be relative to
//! north or to the vehicle, as its flags say.

use super::decoder::Packet;
use super::extensions::{Timesync, signal_quality};
use super::outgoing::AUTOPILOT;
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, DISTANCE_SENSOR_DATA,
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GimbalDeviceFlags, HEARTBEAT_DATA, MavModeFlag,
    MavSensorOrientation,
};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::frames::{attitude_from_ned_quaternion, follow_up_from_gimbal_quaternion};
use plumbline_core::pipeline::PositionSample;
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Metres, Micros, Radians};

/// A message's content in the core's terms. Headings are relative to true north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incoming {
    /// Attitude stamped in microseconds.
    Attitude(Micros, Attitude),
    /// Attitude stamped in milliseconds only.
    CoarseAttitude(Micros, Attitude),
    /// Follow-up angle.
    FollowUp(Micros, Radians),
    /// Slant range.
    Slant(Micros, Metres),
    /// Position and velocity.
    Position(PositionSample),
    /// An answer to a TIMESYNC request of ours: our own stamp in nanoseconds mirrored, and the autopilot's time.
    Timesync {
        /// What we sent, nanoseconds of our clock.
        sent_ns: i64,
        /// The autopilot's clock when it answered.
        theirs: Micros,
    },
    /// The autopilot's heartbeat: whether it is armed.
    Armed(bool),
    /// A TIMESYNC request, to be answered with our own time.
    TimesyncRequest {
        /// To be mirrored.
        theirs_ns: i64,
    },
}

/// Why a good message gives no sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// Not for us.
    NotOurs,
    /// A payload that does not decode, or a value that means "invalid".
    Invalid,
}

/// The sample in `packet`. `us`: our system and component id.
///
/// # Errors
/// [`Unusable`].
pub fn incoming(packet: &Packet<'_>, us: (u8, u8)) -> Result<Incoming, Unusable> {
    // Another vehicle on the link is none of ours.
    if packet.system != us.0 {
        return Err(Unusable::NotOurs);
    }
    match packet.id {
        AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID => {
            let state: AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA = payload(packet)?;
            let attitude = attitude_from_ned_quaternion(state.q).ok_or(Unusable::Invalid)?;
            Ok(Incoming::Attitude(Micros(state.time_boot_us), attitude))
        }
        ATTITUDE_QUATERNION_DATA::ID => {
            let q: ATTITUDE_QUATERNION_DATA = payload(packet)?;
            let attitude = attitude_from_ned_quaternion([q.q1, q.q2, q.q3, q.q4]).ok_or(Unusable::Invalid)?;
            Ok(Incoming::CoarseAttitude(millis(q.time_boot_ms), attitude))
        }
        GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID => follow_up(&payload(packet)?),
        DISTANCE_SENSOR_DATA::ID => slant(&payload(packet)?, signal_quality(packet.payload)),
        GLOBAL_POSITION_INT_DATA::ID => {
            let position: GLOBAL_POSITION_INT_DATA = payload(packet)?;
            Ok(Incoming::Position(PositionSample {
                sampled_at: millis(position.time_boot_ms),
                position: Geographic { lat_e7: position.lat, lon_e7: position.lon },
                north_m_per_s: position.vx as f32 * 0.01,
                east_m_per_s: position.vy as f32 * 0.01,
            }))
        }
        // Only the autopilot's own: a ground station and other devices send heartbeats too.
        HEARTBEAT_DATA::ID if packet.component == AUTOPILOT => {
            let heartbeat: HEARTBEAT_DATA = payload(packet)?;
            Ok(Incoming::Armed(heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED)))
        }
        Timesync::ID => timesync(&payload(packet)?, us),
        _ => Err(Unusable::NotOurs),
    }
}

fn payload<D: MessageData>(packet: &Packet<'_>) -> Result<D, Unusable> {
    D::deser(MavlinkVersion::V2, packet.payload).map_err(|_| Unusable::Invalid)
}

fn millis(time_boot_ms: u32) -> Micros {
    Micros(time_boot_ms as u64 * 1000)
}

/// Only a yaw relative to the vehicle is the follow-up angle: by its flag or, for senders older than the flags, by the
/// absence of a yaw lock.
fn follow_up(status: &GIMBAL_DEVICE_ATTITUDE_STATUS_DATA) -> Result<Incoming, Unusable> {
    let vehicle = GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME;
    let earth = GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME;
    let locked = status.flags.contains(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_LOCK);
    let in_vehicle = status.flags.contains(vehicle) || !(status.flags.contains(earth) || locked);
    if !in_vehicle || status.flags.contains(vehicle | earth) {
        return Err(Unusable::Invalid);
    }
    let follow_up = follow_up_from_gimbal_quaternion(status.q).ok_or(Unusable::Invalid)?;
    Ok(Incoming::FollowUp(millis(status.time_boot_ms), follow_up))
}

fn slant(sensor: &DISTANCE_SENSOR_DATA, quality: u8) -> Result<Incoming, Unusable> {
    const INVALID_CM: u16 = u16::MAX;
    const QUALITY_INVALID: u8 = 1;
    if sensor.orientation != MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270 {
        return Err(Unusable::NotOurs);
    }
    let cm = sensor.current_distance;
    // Limits of 0 mean that the sensor does not state them.
    let beyond = sensor.max_distance != 0 && cm > sensor.max_distance;
    if cm == 0 || cm == INVALID_CM || cm < sensor.min_distance || beyond || quality == QUALITY_INVALID {
        return Err(Unusable::Invalid);
    }
    Ok(Incoming::Slant(millis(sensor.time_boot_ms), Metres(cm as f32 * 0.01)))
}

/// tc1 = 0 is a request; an answer must be addressed to us (an answer to nobody comes from a peer too old to tell).
fn timesync(sync: &Timesync, us: (u8, u8)) -> Result<Incoming, Unusable> {
    if sync.tc1 == 0 {
        return Ok(Incoming::TimesyncRequest { theirs_ns: sync.ts1 });
    }
    if sync.target != us {
        return Err(Unusable::NotOurs);
    }
    let theirs = u64::try_from(sync.tc1).map_err(|_| Unusable::Invalid)? / 1000;
    Ok(Incoming::Timesync { sent_ns: sync.ts1, theirs: Micros(theirs) })
}
