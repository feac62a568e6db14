//! MAVLink on the truth's connection: what is asked of the simulated vehicle, and what it says.

use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA,
    HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType, SIM_STATE_DATA, VIBRATION_DATA,
};
use mavlink::{MavlinkVersion, MessageData};
use plumbline_firmware::wire::command::{ACCEPTED, Acknowledgement, Ask, SET_MESSAGE_INTERVAL};
use plumbline_firmware::wire::decoder::{Decoder, Packet};
use plumbline_firmware::wire::extensions::Timesync;
use plumbline_firmware::wire::outgoing::Encoder;

/// System of the vehicle that the firmware believes to fly in.
pub const VEHICLE: u8 = 1;
/// Component id of an autopilot.
pub const AUTOPILOT: u8 = 1;
/// Who we are on the truth's connection: MAV_COMP_ID_ONBOARD_COMPUTER of the vehicle. No ground station: losing one makes an
/// autopilot turn home.
const US: (u8, u8) = (VEHICLE, 191);
/// Where SIM_STATE's extension fields begin: behind 21 floats.
const SIM_STATE_EXTENSIONS: usize = 84;

/// Names of the messages that are asked for, by id.
pub const SIM_STATE: u32 = SIM_STATE_DATA::ID;
/// The estimated attitude, which bears a time.
pub const ATTITUDE_QUATERNION: u32 = ATTITUDE_QUATERNION_DATA::ID;
/// The autopilot's own position.
pub const GLOBAL_POSITION_INT: u32 = GLOBAL_POSITION_INT_DATA::ID;
/// Whether there is satellite navigation.
pub const GPS_RAW_INT: u32 = GPS_RAW_INT_DATA::ID;

/// Sent behind SIM_STATE by the same loop, with microseconds: all that is wanted of it.
pub const VIBRATION: u32 = VIBRATION_DATA::ID;

/// What a message is called in a sentence.
pub fn name(id: u32) -> &'static str {
    match id {
        SIM_STATE => "SIM_STATE (108)",
        ATTITUDE_QUATERNION => "ATTITUDE_QUATERNION (31)",
        GLOBAL_POSITION_INT => "GLOBAL_POSITION_INT (33)",
        GPS_RAW_INT => "GPS_RAW_INT (24)",
        VIBRATION => "VIBRATION (241)",
        _ => "a message",
    }
}

/// The simulated vehicle as it truly is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimState {
    /// [w, x, y, z] of the turn from north-east-down to forward-right-down.
    pub attitude: [f64; 4],
    /// 1e-7 degrees, latitude and longitude; `None` from a simulator that sends degrees as floats alone, which step by 0.4 m.
    pub place_e7: Option<[i32; 2]>,
    /// Above mean sea level, metres.
    pub alt_m: f64,
    /// North, east, down.
    pub velocity_ned_m_s: [f64; 3],
}

/// Where the autopilot believes to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnPosition {
    /// Since its boot.
    pub time_boot_ms: u32,
    /// 1e-7 degrees, latitude and longitude.
    pub place_e7: [i32; 2],
    /// Above mean sea level, metres.
    pub alt_m: f64,
    /// Above home, metres.
    pub above_home_m: f64,
    /// North, east, down.
    pub velocity_ned_m_s: [f64; 3],
}

/// What is of use of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said {
    /// HEARTBEAT of an autopilot: its system, whether it is armed.
    Heartbeat {
        /// Its system id.
        system: u8,
        /// Whether it is armed.
        is_armed: bool,
    },
    /// SIM_STATE.
    Truth(SimState),
    /// ATTITUDE_QUATERNION: milliseconds since boot, [w, x, y, z].
    Attitude(u32, [f64; 4]),
    /// AUTOPILOT_STATE_FOR_GIMBAL_DEVICE: microseconds since boot, in 32 bits of some autopilots.
    GimbalAttitude(u64),
    /// GLOBAL_POSITION_INT.
    Position(OwnPosition),
    /// VIBRATION's stamp, microseconds since boot.
    Stamp(u64),
    /// GPS_RAW_INT: the kind of fix, of which 2 and more are a position.
    Gnss(u8),
    /// An answer to TIMESYNC.
    Timesync {
        /// What was asked with, nanoseconds.
        sent_ns: i64,
        /// The autopilot's clock, microseconds.
        theirs_us: f64,
    },
    /// COMMAND_ACK of SET_MESSAGE_INTERVAL: whether it was accepted.
    Interval(bool),
}

/// What a stream of bytes says.
#[derive(Debug, Default)]
pub struct Listener {
    decoder: Decoder,
}

impl Listener {
    /// Takes bytes; what they say is appended to `said`.
    pub fn take(&mut self, bytes: &[u8], said: &mut Vec<Said>) {
        self.decoder.take(bytes, |packet| said.extend(of(packet)));
    }

    /// Good messages so far, of whatever kind.
    pub fn messages(&self) -> u32 {
        self.decoder.counters().good
    }

    /// Bytes that belonged to no MAVLink 2 message.
    pub fn skipped_bytes(&self) -> u32 {
        self.decoder.counters().skipped_bytes
    }
}

fn payload<D: MessageData>(packet: &Packet<'_>) -> Option<D> {
    D::deser(MavlinkVersion::V2, packet.payload).ok()
}

/// Other components of the vehicle say nothing here that counts.
fn of(packet: &Packet<'_>) -> Option<Said> {
    if packet.component != AUTOPILOT {
        return None;
    }
    match packet.id {
        HEARTBEAT_DATA::ID => {
            let beat: HEARTBEAT_DATA = payload(packet)?;
            let is_armed = beat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
            let is_autopilot = beat.autopilot != MavAutopilot::MAV_AUTOPILOT_INVALID;
            is_autopilot.then_some(Said::Heartbeat { system: packet.system, is_armed })
        }
        SIM_STATE => Some(Said::Truth(sim_state(packet)?)),
        ATTITUDE_QUATERNION => {
            let q: ATTITUDE_QUATERNION_DATA = payload(packet)?;
            Some(Said::Attitude(q.time_boot_ms, unit([q.q1, q.q2, q.q3, q.q4])?))
        }
        GLOBAL_POSITION_INT => {
            let position: GLOBAL_POSITION_INT_DATA = payload(packet)?;
            Some(Said::Position(OwnPosition {
                time_boot_ms: position.time_boot_ms,
                place_e7: [position.lat, position.lon],
                alt_m: f64::from(position.alt) * 1e-3,
                above_home_m: f64::from(position.relative_alt) * 1e-3,
                velocity_ned_m_s: [position.vx, position.vy, position.vz].map(|v| f64::from(v) * 0.01),
            }))
        }
        GPS_RAW_INT => Some(Said::Gnss(payload::<GPS_RAW_INT_DATA>(packet)?.fix_type as u8)),
        AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA::ID => {
            Some(Said::GimbalAttitude(payload::<AUTOPILOT_STATE_FOR_GIMBAL_DEVICE_DATA>(packet)?.time_boot_us))
        }
        VIBRATION => Some(Said::Stamp(payload::<VIBRATION_DATA>(packet)?.time_usec)),
        Timesync::ID => {
            let sync: Timesync = payload(packet)?;
            (sync.tc1 > 0).then_some(Said::Timesync { sent_ns: sync.ts1, theirs_us: sync.tc1 as f64 * 1e-3 })
        }
        Acknowledgement::ID => {
            let ack: Acknowledgement = payload(packet)?;
            (ack.command == SET_MESSAGE_INTERVAL).then_some(Said::Interval(ack.result == ACCEPTED))
        }
        _ => None,
    }
}

fn sim_state(packet: &Packet<'_>) -> Option<SimState> {
    let state: SIM_STATE_DATA = payload(packet)?;
    let whole = |at: usize| {
        // Trailing zeros are cut off.
        let byte = |at: usize| packet.payload.get(at).copied().unwrap_or(0);
        i32::from_le_bytes(std::array::from_fn(|i| byte(SIM_STATE_EXTENSIONS + at + i)))
    };
    let place_e7 = [whole(0), whole(4)];
    let numbers = [state.alt, state.vn, state.ve, state.vd];
    numbers.iter().all(|number| number.is_finite()).then_some(SimState {
        attitude: unit([state.q1, state.q2, state.q3, state.q4])?,
        place_e7: (place_e7 != [0; 2]).then_some(place_e7),
        alt_m: f64::from(state.alt),
        velocity_ned_m_s: [state.vn, state.ve, state.vd].map(f64::from),
    })
}

/// A quaternion of length 1; `None` for one that is none.
fn unit(q: [f32; 4]) -> Option<[f64; 4]> {
    let q = q.map(f64::from);
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.5 && length < 2.0).then(|| q.map(|x| x / length))
}

/// What is sent on the truth's connection.
#[derive(Debug)]
pub struct Speaker {
    encoder: Encoder<'static>,
}

impl Default for Speaker {
    fn default() -> Self {
        Speaker { encoder: Encoder::new(US, None) }
    }
}

impl Speaker {
    /// HEARTBEAT, without which an autopilot may send nothing.
    pub fn heartbeat(&mut self) -> Vec<u8> {
        self.encode(&HEARTBEAT_DATA {
            custom_mode: 0,
            mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
            base_mode: MavModeFlag::empty(),
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        })
    }

    /// TIMESYNC, to the autopilot alone: one without a target is passed on to every other component.
    pub fn timesync(&mut self, now_ns: i64) -> Vec<u8> {
        self.encode(&Timesync { tc1: 0, ts1: now_ns, target: (VEHICLE, AUTOPILOT) })
    }

    /// SET_MESSAGE_INTERVAL.
    pub fn interval(&mut self, id: u32, interval_us: u32) -> Vec<u8> {
        self.encode(&Ask::Interval(id, interval_us).command((VEHICLE, AUTOPILOT)))
    }

    fn encode<D: MessageData>(&mut self, data: &D) -> Vec<u8> {
        self.encoder.encode(data).to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message with the payload `bytes`, from the autopilot.
    fn said(id: u32, bytes: &[u8]) -> Option<Said> {
        of(&Packet { id, system: 1, component: 1, payload: bytes, signed: None })
    }

    #[test]
    fn the_place_is_in_the_extension_fields() {
        let mut bytes = [0; 92];
        bytes[..4].copy_from_slice(&1f32.to_le_bytes());
        bytes[60..64].copy_from_slice(&584f32.to_le_bytes());
        bytes[84..88].copy_from_slice(&(-353_632_610i32).to_le_bytes());
        bytes[88..92].copy_from_slice(&1_491_652_300i32.to_le_bytes());
        let Some(Said::Truth(state)) = said(SIM_STATE, &bytes) else { panic!("no truth") };
        assert_eq!(state.place_e7, Some([-353_632_610, 1_491_652_300]));
        assert_eq!((state.alt_m, state.attitude), (584.0, [1.0, 0.0, 0.0, 0.0]));
        // Of a sender that does not know them.
        let Some(Said::Truth(state)) = said(SIM_STATE, &bytes[..84]) else { panic!("no truth") };
        assert_eq!(state.place_e7, None);
    }

    #[test]
    fn whatever_comes_in_pieces_is_put_together() {
        let mut speaker = Speaker::default();
        let mut bytes = vec![7, 0xfd, 3];
        bytes.extend(speaker.heartbeat());
        bytes.extend(speaker.timesync(5));
        let (mut listener, mut heard) = (Listener::default(), Vec::new());
        bytes.chunks(5).for_each(|piece| listener.take(piece, &mut heard));
        // We are no autopilot, and what we ask is no answer.
        assert!(heard.is_empty());
        assert_eq!(listener.messages(), 2);
    }
}
