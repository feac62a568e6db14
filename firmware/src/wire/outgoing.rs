//! What we send: each message encoded into a buffer of the caller's.

use super::extensions::Timesync;
use super::signature::{SIGNATURE, SIGNED};
use super::signing::Signing;
use super::telemetry::{TUNNEL_BYTES, Telemetry};
use crate::shared::Shared;
use mavlink::dialects::common::{
    self, CAMERA_IMAGE_CAPTURED_DATA, CAMERA_TRIGGER_DATA, DATA_TRANSMISSION_HANDSHAKE_DATA, ENCAPSULATED_DATA_DATA,
    GIMBAL_DEVICE_SET_ATTITUDE_DATA, GimbalDeviceFlags, HEARTBEAT_DATA, MavAutopilot, MavBool, MavModeFlag,
    MavSeverity, MavState, MavTunnelPayloadType, MavType, MavlinkDataStreamType, PARAM_REQUEST_READ_DATA,
    STATUSTEXT_DATA, TUNNEL_DATA,
};
use mavlink::{MAV_STX_V2, MavlinkVersion, MessageData, calculate_crc};
use plumbline_core::frames::{gimbal_quaternion_from_follow_up, ned_quaternion_from_attitude};
use plumbline_core::pipeline::Situation;
use plumbline_core::tile::Geographic;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};

/// Our system id, the vehicle's, where no settings say another.
pub const SYSTEM: u8 = 1;
/// Our component id, MAV_COMP_ID_GIMBAL: what makes an autopilot send AUTOPILOT_STATE_FOR_GIMBAL_DEVICE.
pub const COMPONENT: u8 = 154;
/// Bytes of picture in an ENCAPSULATED_DATA message.
pub const CHUNK: usize = 253;

/// Encodes messages and numbers them. The frame around a payload is our own, ten lines: the `mavlink` crate's reads its
/// lengths back from the buffer and checks them by panics.
#[derive(Debug)]
pub struct Encoder<'s> {
    sequence: u8,
    /// Our system and component.
    us: (u8, u8),
    /// What all of them are signed with, if they are.
    signing: Option<&'s Shared<Signing>>,
    bytes: [u8; HEADER + PAYLOAD + CHECKSUM + SIGNATURE],
}

/// Bytes of a frame before its payload, of the longest payload, and behind it.
const HEADER: usize = 10;
const PAYLOAD: usize = 255;
const CHECKSUM: usize = 2;

impl<'s> Encoder<'s> {
    /// Sequence from 0, of messages of this system and component.
    pub const fn new(us: (u8, u8), signing: Option<&'s Shared<Signing>>) -> Self {
        Encoder { sequence: 0, us, signing, bytes: [0; HEADER + PAYLOAD + CHECKSUM + SIGNATURE] }
    }

    /// The message's bytes, valid until the next call.
    pub fn encode<D: MessageData>(&mut self, data: &D) -> &[u8] {
        let length = match self.bytes.get_mut(HEADER..HEADER + PAYLOAD) {
            Some(payload) => data.ser(MavlinkVersion::V2, payload),
            None => 0,
        };
        self.frame((D::ID, D::EXTRA_CRC), length)
    }

    /// Puts header, checksum and signature around a payload that is in place. Kept apart: it is the same for all messages.
    #[inline(never)]
    fn frame(&mut self, (id, extra): (u32, u8), length: usize) -> &[u8] {
        let end = HEADER + length.min(PAYLOAD);
        let [low, middle, high, _] = id.to_le_bytes();
        let Some(header) = self.bytes.first_chunk_mut::<HEADER>() else { return &[] };
        let (system, component) = self.us;
        let flags = if self.signing.is_some() { SIGNED } else { 0 };
        *header = [MAV_STX_V2, length as u8, flags, 0, self.sequence, system, component, low, middle, high];
        self.sequence = self.sequence.wrapping_add(1);
        // From the length on.
        let checksum = calculate_crc(self.bytes.get(1..end).unwrap_or(&[]), extra).to_le_bytes();
        if let Some(target) = self.bytes.get_mut(end..).and_then(|rest| rest.first_chunk_mut()) {
            *target = checksum;
        }
        let Some(signing) = self.signing else { return self.bytes.get(..end + CHECKSUM).unwrap_or(&[]) };
        self.signed(signing, end + CHECKSUM).unwrap_or(&[])
    }

    /// Puts the signature behind a message of so many bytes; without one nothing may be sent.
    fn signed(&mut self, signing: &Shared<Signing>, end: usize) -> Option<&[u8]> {
        let (message, rest) = self.bytes.split_at_mut_checked(end)?;
        *rest.first_chunk_mut()? = signing.with(|signing| signing.sign(message))?;
        self.bytes.get(..end + SIGNATURE)
    }
}

/// HEARTBEAT of a gimbal: the device announces itself as one so that the autopilot sends it its state. Until fixes can be made
/// it stands by.
pub fn heartbeat(is_ready: bool) -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_GIMBAL,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: if is_ready { MavState::MAV_STATE_ACTIVE } else { MavState::MAV_STATE_STANDBY },
        mavlink_version: 3,
    }
}

/// HEARTBEAT of a board that is up and cannot do its work.
pub fn grounded_heartbeat() -> HEARTBEAT_DATA {
    HEARTBEAT_DATA { system_status: MavState::MAV_STATE_CRITICAL, ..heartbeat(false) }
}

/// STATUSTEXT: a line for the pilot, ended by a zero where it is shorter.
pub fn status_text(severity: MavSeverity, line: [u8; 50]) -> STATUSTEXT_DATA {
    STATUSTEXT_DATA { severity, text: line.into() }
}

/// The servo's command: follow-up angle β relative to the vehicle, as a gimbal yaw. Rates are left to the servo.
pub fn servo(follow_up: Radians, system: u8) -> GIMBAL_DEVICE_SET_ATTITUDE_DATA {
    GIMBAL_DEVICE_SET_ATTITUDE_DATA {
        q: gimbal_quaternion_from_follow_up(follow_up),
        angular_velocity_x: f32::NAN,
        angular_velocity_y: f32::NAN,
        angular_velocity_z: f32::NAN,
        flags: GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
        target_system: system,
        target_component: 0,
    }
}

/// TIMESYNC request: our time in nanoseconds, asking for the autopilot's.
pub fn timesync_request(ours_ns: i64, target: (u8, u8)) -> Timesync {
    Timesync { tc1: 0, ts1: ours_ns, target }
}

/// TIMESYNC answer to a request that carried `theirs_ns`.
pub fn timesync_answer(ours_ns: i64, theirs_ns: i64, target: (u8, u8)) -> Timesync {
    Timesync { tc1: ours_ns, ts1: theirs_ns, target }
}

/// PARAM_REQUEST_READ of a parameter by its name, of which the message holds 16 characters.
pub fn parameter_request(name: &str, (target_system, target_component): (u8, u8)) -> PARAM_REQUEST_READ_DATA {
    /// PARAM_REQUEST_READ.param_index: by the name.
    const BY_NAME: i16 = -1;
    let mut id = [0; 16];
    id.iter_mut().zip(name.bytes()).for_each(|(to, from)| *to = from);
    PARAM_REQUEST_READ_DATA { param_index: BY_NAME, target_system, target_component, param_id: id.into() }
}

/// SET_GPS_GLOBAL_ORIGIN: where the autopilot's frame is to begin, its height above sea level in millimetres. The definition
/// calls it superseded by a command that no autopilot knows yet.
#[expect(deprecated, reason = "its successor is not known to ArduPilot")]
pub fn origin(place: Geographic, altitude_mm: i32, target_system: u8) -> common::SET_GPS_GLOBAL_ORIGIN_DATA {
    let (latitude, longitude) = (place.lat_e7, place.lon_e7);
    common::SET_GPS_GLOBAL_ORIGIN_DATA { latitude, longitude, altitude: altitude_mm, target_system }
}

/// CAMERA_TRIGGER: when the picture was taken, by its middle.
pub fn camera_trigger(mid_exposure_at: Micros, sequence: u32) -> CAMERA_TRIGGER_DATA {
    CAMERA_TRIGGER_DATA { time_usec: mid_exposure_at.0, seq: sequence }
}

/// CAMERA_IMAGE_CAPTURED at `position`. The quaternion is the camera's: the vehicle's attitude turned by the
/// follow-up angle, which for small tilts is the camera's own heading; `true_heading` is relative to true north.
pub fn image_captured(
    situation: &Situation,
    true_attitude: Attitude,
    position: Geographic,
    sequence: u32,
) -> CAMERA_IMAGE_CAPTURED_DATA {
    CAMERA_IMAGE_CAPTURED_DATA {
        time_utc: 0,
        time_boot_ms: (situation.mid_exposure_at.0 / 1000) as u32,
        lat: position.lat_e7,
        lon: position.lon_e7,
        alt: 0,
        relative_alt: (situation.height_m * 1000.0) as i32,
        q: camera_quaternion(true_attitude, situation.follow_up),
        image_index: sequence as i32,
        camera_id: 0,
        capture_result: MavBool::MAV_BOOL_TRUE,
        file_url: [0; 205].into(),
    }
}

/// World-from-camera quaternion: attitude, then the turn by −β about the body's down axis.
fn camera_quaternion(attitude: Attitude, follow_up: Radians) -> [f32; 4] {
    let [w, x, y, z] = ned_quaternion_from_attitude(attitude);
    let [c, _, _, s] = gimbal_quaternion_from_follow_up(follow_up);
    [w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s]
}

/// The image transmission protocol's announcement of a raw 8-bit picture of `size` (cols, rows).
pub fn picture_announcement((cols, rows): (u16, u16)) -> DATA_TRANSMISSION_HANDSHAKE_DATA {
    let size = cols as u32 * rows as u32;
    DATA_TRANSMISSION_HANDSHAKE_DATA {
        size,
        width: cols,
        height: rows,
        packets: size.div_ceil(CHUNK as u32) as u16,
        mavtype: MavlinkDataStreamType::MAVLINK_DATA_STREAM_IMG_RAW8U,
        payload: CHUNK as u8,
        jpg_quality: 0,
    }
}

/// One piece of a picture; the last one is filled up with zeros.
pub fn picture_piece(number: u16, pixels: &[u8]) -> ENCAPSULATED_DATA_DATA {
    let mut data = [0; CHUNK];
    for (to, from) in data.iter_mut().zip(pixels) {
        *to = *from;
    }
    ENCAPSULATED_DATA_DATA { seqnr: number, data }
}

/// Our own telemetry.
pub fn tunnel(telemetry: &Telemetry) -> TUNNEL_DATA {
    let mut payload = [0; TUNNEL_BYTES];
    let payload_length = telemetry.encode(&mut payload).unwrap_or(0);
    TUNNEL_DATA {
        payload_type: MavTunnelPayloadType::MAV_TUNNEL_PAYLOAD_TYPE_UNKNOWN,
        target_system: 0,
        target_component: 0,
        payload_length,
        payload,
    }
}
