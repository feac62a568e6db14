//! From MAVLink's messages, axes and units to the core's.
//!
//! The traps, all of them met in the field: ATTITUDE_QUATERNION and the slow messages stamp milliseconds, only
//! AUTOPILOT_STATE_FOR_GIMBAL_DEVICE stamps microseconds, in 32 bits of 64; DISTANCE_SENSOR counts centimetres, 65535 is
//! not 655 m and 0 is a vehicle on the ground; a signal quality of 1 means invalid while 0 means unknown; a gimbal's yaw
//! is clockwise and may be relative to north or to the vehicle, as its flags say; a TIMESYNC answer may name nobody.

use super::boot_time::BootTime;
use super::command::{Acknowledgement, Command};
use super::decoder::Packet;
use super::extensions::{GpsRaw, Timesync, signal_quality};
use super::order::{Order, order};
use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, COMMAND_INT_DATA, DISTANCE_SENSOR_DATA,
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, GPS_RAW_INT_DATA,
    GimbalDeviceFlags, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavModeFlag, MavSensorOrientation,
    PARAM_VALUE_DATA,
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
    /// Attitude.
    Attitude(BootTime, Attitude),
    /// Follow-up angle.
    FollowUp(BootTime, Radians),
    /// Slant range.
    Slant(BootTime, Metres),
    /// Position and velocity.
    Position(BootTime, PositionSample),
    /// How far the vehicle is below the origin of the autopilot's local frame, metres.
    Down(BootTime, f32),
    /// An answer to a TIMESYNC request: what the asking side had sent mirrored, and the autopilot's time.
    Timesync {
        /// What was sent, nanoseconds of the asking side's clock.
        sent_ns: i64,
        /// The autopilot's clock when it answered.
        theirs: Micros,
    },
    /// A TIMESYNC request, to be answered with our own time.
    TimesyncRequest {
        /// To be mirrored.
        theirs_ns: i64,
    },
    /// The autopilot's heartbeat.
    Heartbeat(Heartbeat),
    /// Where the autopilot's local frame begins.
    Origin(Geographic),
    /// What satellite navigation says.
    Gnss(Gnss),
    /// The result of a command: its number and MAV_RESULT.
    Acknowledged(u16, u8),
    /// A parameter of the autopilot.
    Parameter(Parameter),
    /// What a ground station has ordered, and who it is.
    Ordered(Order, (u8, u8)),
}

/// Satellite navigation as the autopilot has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gnss {
    /// When its receiver handed the position over.
    pub at: BootTime,
    /// It has a position in three dimensions.
    pub is_good: bool,
    /// Where that is, and one sigma of each axis, metres; nothing where it is not said.
    pub place: Option<(Geographic, f32)>,
}

/// What a heartbeat of the autopilot says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heartbeat {
    /// Whose software it is.
    pub kind: AutopilotKind,
    /// Whether it is armed.
    pub is_armed: bool,
}

/// Whose software the autopilot runs: they take fixes in different messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AutopilotKind {
    /// ArduPilot.
    Ardupilot,
    /// PX4.
    Px4,
    /// Another, or not known yet.
    #[default]
    Other,
}

/// A parameter: its name, filled up with zeros, its value, and MAV_PARAM_TYPE.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// PARAM_VALUE.param_id.
    pub name: [u8; 16],
    /// PARAM_VALUE.param_value. ArduPilot sends integers as numbers, PX4 their bits.
    pub value: f32,
    /// PARAM_VALUE.param_type.
    pub kind: u8,
}

/// MAV_PARAM_TYPE of the integers that PX4 has.
const UINT32: u8 = 5;
const INT32: u8 = 6;

impl Parameter {
    /// Its number, as this autopilot's software puts it into the message.
    pub fn number(&self, of: AutopilotKind) -> f32 {
        let bits = self.value.to_bits();
        match (of, self.kind) {
            (AutopilotKind::Px4, INT32) => bits as i32 as f32,
            (AutopilotKind::Px4, UINT32) => bits as f32,
            _ => self.value,
        }
    }

    /// Whether this is its name.
    pub fn is_called(&self, name: &str) -> bool {
        let end = self.name.iter().position(|byte| *byte == 0).unwrap_or(self.name.len());
        self.name.get(..end) == Some(name.as_bytes())
    }
}

/// Whose messages are taken: one sender, and one sensor, for each kind of sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Speakers {
    /// Our system and component.
    pub us: (u8, u8),
    /// The autopilot's.
    pub autopilot: (u8, u8),
    /// Who sends DISTANCE_SENSOR, and the id of the sensor; `None` takes the first one that looks down.
    pub range: ((u8, u8), Option<u8>),
    /// Who sends the follow-up axis' GIMBAL_DEVICE_ATTITUDE_STATUS.
    pub encoder: (u8, u8),
    /// System of the ground station whose orders are taken, from any of its components.
    pub ground_station: Option<u8>,
}

/// Why a good message gives no sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// Not for us, or of a kind that we have no use for.
    NotOurs,
    /// Of a kind that we use, from somebody whom we do not listen to.
    Foreign,
    /// A payload that does not decode, or a value that means "invalid".
    Invalid,
}

/// The sample in `packet`, where it comes from whom the settings name.
///
/// # Errors
/// [`Unusable`].
pub fn incoming(packet: &Packet<'_>, speakers: &Speakers) -> Result<Incoming, Unusable> {
    let speaker = match packet.id {
        GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID => speakers.encoder,
        DISTANCE_SENSOR_DATA::ID => speakers.range.0,
        AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID
        | ATTITUDE_QUATERNION_DATA::ID
        | GLOBAL_POSITION_INT_DATA::ID
        | LOCAL_POSITION_NED_DATA::ID
        | GPS_GLOBAL_ORIGIN_DATA::ID
        | GPS_RAW_INT_DATA::ID
        | Acknowledgement::ID
        | PARAM_VALUE_DATA::ID => speakers.autopilot,
        Timesync::ID => return timesync(packet, speakers),
        Command::ID | COMMAND_INT_DATA::ID => return ordered(packet, speakers),
        // A ground station and other devices send heartbeats too.
        HEARTBEAT_DATA::ID if (packet.system, packet.component) == speakers.autopilot => speakers.autopilot,
        _ => return Err(Unusable::NotOurs),
    };
    if (packet.system, packet.component) != speaker {
        return Err(Unusable::Foreign);
    }
    match packet.id {
        GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID => follow_up(&payload(packet)?),
        DISTANCE_SENSOR_DATA::ID => slant(&payload(packet)?, signal_quality(packet.payload), speakers.range.1),
        Acknowledgement::ID => acknowledged(&payload(packet)?, speakers),
        _ => of_the_autopilot(packet),
    }
}

/// What others have asked for is acknowledged to them, past us.
fn acknowledged(ack: &Acknowledgement, speakers: &Speakers) -> Result<Incoming, Unusable> {
    let is_for_us = ack.target == (0, 0) || ack.target == speakers.us;
    if is_for_us { Ok(Incoming::Acknowledged(ack.command, ack.result)) } else { Err(Unusable::NotOurs) }
}

/// An order to us; the autopilot's own commands to a gimbal are none.
fn ordered(packet: &Packet<'_>, speakers: &Speakers) -> Result<Incoming, Unusable> {
    let (order, target) = order(packet).ok_or(Unusable::NotOurs)?;
    if target != speakers.us {
        return Err(Unusable::NotOurs);
    }
    if speakers.ground_station != Some(packet.system) {
        return Err(Unusable::Foreign);
    }
    Ok(Incoming::Ordered(order, (packet.system, packet.component)))
}

fn of_the_autopilot(packet: &Packet<'_>) -> Result<Incoming, Unusable> {
    match packet.id {
        AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID => {
            let state: AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA = payload(packet)?;
            let attitude = attitude_from_ned_quaternion(state.q).ok_or(Unusable::Invalid)?;
            Ok(Incoming::Attitude(BootTime::Micros(state.time_boot_us), attitude))
        }
        ATTITUDE_QUATERNION_DATA::ID => {
            let q: ATTITUDE_QUATERNION_DATA = payload(packet)?;
            let attitude = attitude_from_ned_quaternion([q.q1, q.q2, q.q3, q.q4]).ok_or(Unusable::Invalid)?;
            Ok(Incoming::Attitude(BootTime::Millis(q.time_boot_ms), attitude))
        }
        GLOBAL_POSITION_INT_DATA::ID => position(&payload(packet)?),
        LOCAL_POSITION_NED_DATA::ID => {
            let local: LOCAL_POSITION_NED_DATA = payload(packet)?;
            if !local.z.is_finite() {
                return Err(Unusable::Invalid);
            }
            Ok(Incoming::Down(BootTime::Millis(local.time_boot_ms), local.z))
        }
        GPS_GLOBAL_ORIGIN_DATA::ID => {
            let origin: GPS_GLOBAL_ORIGIN_DATA = payload(packet)?;
            Ok(Incoming::Origin(geographic(origin.latitude, origin.longitude)?))
        }
        GPS_RAW_INT_DATA::ID => Ok(Incoming::Gnss(gnss(&payload(packet)?))),
        PARAM_VALUE_DATA::ID => {
            let parameter: PARAM_VALUE_DATA = payload(packet)?;
            let (name, kind) = (parameter.param_id.into(), parameter.param_type as u8);
            Ok(Incoming::Parameter(Parameter { name, value: parameter.param_value, kind }))
        }
        _ => {
            let heartbeat: HEARTBEAT_DATA = payload(packet)?;
            let kind = match heartbeat.autopilot {
                MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA => AutopilotKind::Ardupilot,
                MavAutopilot::MAV_AUTOPILOT_PX4 => AutopilotKind::Px4,
                _ => AutopilotKind::Other,
            };
            let is_armed = heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
            Ok(Incoming::Heartbeat(Heartbeat { kind, is_armed }))
        }
    }
}

fn payload<D: MessageData>(packet: &Packet<'_>) -> Result<D, Unusable> {
    D::deser(MavlinkVersion::V2, packet.payload).map_err(|_| Unusable::Invalid)
}

/// A place; latitude and longitude 0 are what autopilots send for one that they do not know.
fn geographic(lat_e7: i32, lon_e7: i32) -> Result<Geographic, Unusable> {
    if (lat_e7, lon_e7) == (0, 0) { Err(Unusable::Invalid) } else { Ok(Geographic { lat_e7, lon_e7 }) }
}

/// One sigma of each axis of a receiver that does not say it, metres. Chosen: a single-frequency receiver with an open sky has 2 to 3,
/// and who does not say it may have less of a sky. PX4's and ArduPilot's `eph` is a dilution, which says nothing of the receiver.
const GNSS_SIGMA_M: f32 = 5.0;

fn gnss(GpsRaw { base, h_acc_mm }: &GpsRaw) -> Gnss {
    // GPS_FIX_TYPE: 3 is a position in three dimensions, more are better ones.
    let is_good = base.fix_type as u8 >= 3;
    let sigma_m = if *h_acc_mm == 0 { GNSS_SIGMA_M } else { *h_acc_mm as f32 / 1000.0 };
    let place = geographic(base.lat, base.lon).ok().filter(|_| is_good);
    Gnss { at: BootTime::Micros(base.time_usec), is_good, place: place.map(|place| (place, sigma_m)) }
}

fn position(position: &GLOBAL_POSITION_INT_DATA) -> Result<Incoming, Unusable> {
    let sample = PositionSample {
        position: geographic(position.lat, position.lon)?,
        north_m_per_s: position.vx as f32 * 0.01,
        east_m_per_s: position.vy as f32 * 0.01,
        altitude_m: Some(position.alt as f32 * 0.001),
        home_m: Some(position.alt.saturating_sub(position.relative_alt) as f32 * 0.001),
        climb_m_per_s: position.vz as f32 * -0.01,
    };
    Ok(Incoming::Position(BootTime::Millis(position.time_boot_ms), sample))
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
    Ok(Incoming::FollowUp(BootTime::Millis(status.time_boot_ms), follow_up))
}

fn slant(sensor: &DISTANCE_SENSOR_DATA, quality: u8, wanted: Option<u8>) -> Result<Incoming, Unusable> {
    const INVALID_CM: u16 = u16::MAX;
    const QUALITY_INVALID: u8 = 1;
    if sensor.orientation != MavSensorOrientation::MAV_SENSOR_ROTATION_PITCH_270 {
        return Err(Unusable::NotOurs);
    }
    if wanted.is_some_and(|id| id != sensor.id) {
        return Err(Unusable::Foreign);
    }
    let cm = sensor.current_distance;
    // Limits of 0 mean that the sensor does not state them.
    let beyond = sensor.max_distance != 0 && cm > sensor.max_distance;
    if cm == 0 || cm == INVALID_CM || cm < sensor.min_distance || beyond || quality == QUALITY_INVALID {
        return Err(Unusable::Invalid);
    }
    Ok(Incoming::Slant(BootTime::Millis(sensor.time_boot_ms), Metres(cm as f32 * 0.01)))
}

/// tc1 = 0 is a request; an answer is addressed to us or, from an autopilot whose messages have no such fields, to nobody:
/// whether it answers a request of ours, its mirrored stamp tells.
fn timesync(packet: &Packet<'_>, speakers: &Speakers) -> Result<Incoming, Unusable> {
    let sync: Timesync = payload(packet)?;
    let is_for_us = sync.target == (0, 0) || sync.target == speakers.us;
    if sync.tc1 == 0 {
        return Ok(Incoming::TimesyncRequest { theirs_ns: sync.ts1 });
    }
    if !is_for_us {
        return Err(Unusable::NotOurs);
    }
    if (packet.system, packet.component) != speakers.autopilot {
        return Err(Unusable::Foreign);
    }
    let theirs = u64::try_from(sync.tc1).map_err(|_| Unusable::Invalid)? / 1000;
    Ok(Incoming::Timesync { sent_ns: sync.ts1, theirs: Micros(theirs) })
}
