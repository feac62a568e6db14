//! What a ground station asks and is told: the mission that is flown, the parameters that the simulated autopilot has. Orders are declined.
//!
//! As ArduPilot has it, item 0 of a mission is the home. Questions in MAVLink 2 are understood; ground stations change to it once they hear it.

#[expect(deprecated, reason = "ground stations still ask by it, and are to be answered in whole numbers")]
use mavlink::dialects::common::MISSION_REQUEST_DATA;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, MISSION_ACK_DATA, MISSION_CLEAR_ALL_DATA,
    MISSION_COUNT_DATA, MISSION_CURRENT_DATA, MISSION_ITEM_INT_DATA, MISSION_REQUEST_INT_DATA,
    MISSION_REQUEST_LIST_DATA, MavCmd, MavFrame, MavMissionResult, MavResult, PARAM_REQUEST_LIST_DATA,
    PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use mavlink::{MAV_STX_V2, MavlinkVersion, MessageData, calculate_crc};
use plumbline_firmware::wire::decoder::{Decoder, Packet};

/// System and component of the simulated autopilot.
pub(super) const AUTOPILOT: (u8, u8) = (1, 1);

/// A place of the mission: latitude and longitude in 1e-7 degrees, height above the height datum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Latitude and longitude.
    pub place_e7: [i32; 2],
    /// Metres.
    pub up_m: f32,
}

/// What there is to tell.
#[derive(Clone, Debug, Default)]
pub struct Knowledge {
    /// In the order of flight; empty where the flight follows none.
    pub waypoints: Vec<Waypoint>,
    /// Whether it begins again behind the last one.
    pub is_round: bool,
    /// The autopilot's parameters.
    pub parameters: Vec<PARAM_VALUE_DATA>,
}

/// One for each ground station: its bytes become messages one by one.
#[derive(Debug, Default)]
pub(super) struct Listener(Decoder);

/// Answers, and numbers them.
#[derive(Debug, Default)]
pub(super) struct Answers {
    items: Vec<MISSION_ITEM_INT_DATA>,
    parameters: Vec<PARAM_VALUE_DATA>,
    sequence: u8,
}

impl Answers {
    pub(super) fn new(knowledge: &Knowledge) -> Self {
        Answers { items: items(knowledge), parameters: knowledge.parameters.clone(), sequence: 0 }
    }

    /// The bytes that answer what these bytes complete.
    pub(super) fn to(&mut self, listener: &mut Listener, bytes: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        listener.0.take(bytes, |packet| self.answer(packet, &mut answer));
        answer
    }

    /// What is said unasked: which item is flown to; nothing of a flight without a mission.
    pub(super) fn current(&mut self, waypoint: usize) -> Vec<u8> {
        let mut said = Vec::new();
        if !self.items.is_empty() {
            self.send(&MISSION_CURRENT_DATA { seq: item_of(waypoint) as u16 }, MISSION, &mut said);
        }
        said
    }

    fn answer(&mut self, packet: &Packet<'_>, out: &mut Vec<u8>) {
        let them = (packet.system, packet.component);
        match packet.id {
            MISSION_REQUEST_LIST_DATA::ID => {
                let Some(asked) = read::<MISSION_REQUEST_LIST_DATA>(packet) else { return };
                if is_us(asked.target_system, asked.target_component) {
                    // There are neither fences nor rally points.
                    let mission_type = mission_type::<MISSION_REQUEST_LIST_DATA>(packet);
                    let count = if mission_type == MISSION { self.items.len() as u16 } else { 0 };
                    let answer = MISSION_COUNT_DATA { count, target_system: them.0, target_component: them.1 };
                    self.send(&answer, mission_type, out);
                }
            }
            MISSION_REQUEST_INT_DATA::ID | REQUEST_ID => {
                // Both have the same fields.
                let Some(asked) = read::<MISSION_REQUEST_INT_DATA>(packet) else { return };
                if is_us(asked.target_system, asked.target_component) {
                    self.item(asked.seq, mission_type::<MISSION_REQUEST_INT_DATA>(packet), them, out);
                }
            }
            PARAM_REQUEST_LIST_DATA::ID | PARAM_REQUEST_READ_DATA::ID | PARAM_SET_DATA::ID => {
                self.parameter(packet, out)
            }
            MISSION_COUNT_DATA::ID => {
                let Some(asked) = read::<MISSION_COUNT_DATA>(packet) else { return };
                if is_us(asked.target_system, asked.target_component) {
                    self.deny(mission_type::<MISSION_COUNT_DATA>(packet), them, out);
                }
            }
            MISSION_CLEAR_ALL_DATA::ID => {
                let Some(asked) = read::<MISSION_CLEAR_ALL_DATA>(packet) else { return };
                if is_us(asked.target_system, asked.target_component) {
                    self.deny(mission_type::<MISSION_CLEAR_ALL_DATA>(packet), them, out);
                }
            }
            COMMAND_LONG_DATA::ID => {
                let Some(asked) = read::<COMMAND_LONG_DATA>(packet) else { return };
                self.refuse((asked.target_system, asked.target_component), asked.command, out);
            }
            COMMAND_INT_DATA::ID => {
                let Some(asked) = read::<COMMAND_INT_DATA>(packet) else { return };
                self.refuse((asked.target_system, asked.target_component), asked.command, out);
            }
            _ => {}
        }
    }

    /// One item; a number beyond the last one is answered by its error.
    fn item(&mut self, seq: u16, mission_type: u8, them: (u8, u8), out: &mut Vec<u8>) {
        let item = self.items.get(usize::from(seq)).filter(|_| mission_type == MISSION).cloned();
        let Some(item) = item else {
            return self.acknowledge(MavMissionResult::MAV_MISSION_INVALID_SEQUENCE, mission_type, them, out);
        };
        self.send(&MISSION_ITEM_INT_DATA { target_system: them.0, target_component: them.1, ..item }, MISSION, out);
    }

    /// All parameters, or one by its place or name; one that is to be set stays as it is, which the answer says.
    fn parameter(&mut self, packet: &Packet<'_>, out: &mut Vec<u8>) {
        let named = |id: &[u8]| self.parameters.iter().position(|known| named(&*known.param_id) == named(id));
        let (target, places) = match packet.id {
            PARAM_REQUEST_LIST_DATA::ID => {
                let Some(asked) = read::<PARAM_REQUEST_LIST_DATA>(packet) else { return };
                ((asked.target_system, asked.target_component), 0..self.parameters.len())
            }
            PARAM_SET_DATA::ID => {
                let Some(asked) = read::<PARAM_SET_DATA>(packet) else { return };
                let Some(place) = named(&*asked.param_id) else { return };
                ((asked.target_system, asked.target_component), place..place + 1)
            }
            _ => {
                let Some(asked) = read::<PARAM_REQUEST_READ_DATA>(packet) else { return };
                let place = usize::try_from(asked.param_index).ok().or_else(|| named(&*asked.param_id));
                let Some(place) = place.filter(|place| *place < self.parameters.len()) else { return };
                ((asked.target_system, asked.target_component), place..place + 1)
            }
        };
        for place in places.filter(|_| is_us(target.0, target.1)) {
            let parameter = self.parameters[place].clone();
            self.send(&parameter, MISSION, out);
        }
    }

    /// Nobody who watches changes a mission.
    fn deny(&mut self, mission_type: u8, them: (u8, u8), out: &mut Vec<u8>) {
        self.acknowledge(MavMissionResult::MAV_MISSION_DENIED, mission_type, them, out);
    }

    /// A mission's error.
    fn acknowledge(&mut self, mavtype: MavMissionResult, mission_type: u8, them: (u8, u8), out: &mut Vec<u8>) {
        let answer = MISSION_ACK_DATA { target_system: them.0, target_component: them.1, mavtype };
        self.send(&answer, mission_type, out);
    }

    /// Nor has an order an effect.
    fn refuse(&mut self, target: (u8, u8), command: MavCmd, out: &mut Vec<u8>) {
        if is_us(target.0, target.1) {
            let result = MavResult::MAV_RESULT_UNSUPPORTED;
            self.send(&COMMAND_ACK_DATA { command, result }, MISSION, out);
        }
    }

    /// A message with, behind its fields, the kind of mission that it is about: an extension that the `mavlink` crate lacks. As every zero at a
    /// message's end, that of the flight's own mission is not sent.
    fn send<D: MessageData>(&mut self, message: &D, mission_type: u8, out: &mut Vec<u8>) {
        let mut payload = [0; 255];
        let mut length = message.ser(MavlinkVersion::V2, &mut payload);
        if mission_type != MISSION {
            payload[D::ENCODED_LEN] = mission_type;
            length = D::ENCODED_LEN + 1;
        }
        let ([low, middle, high, _], (system, component)) = (D::ID.to_le_bytes(), AUTOPILOT);
        let start = out.len();
        out.extend([MAV_STX_V2, length as u8, 0, 0, self.sequence, system, component, low, middle, high]);
        out.extend(&payload[..length]);
        // From the length on.
        let checksum = calculate_crc(&out[start + 1..], D::EXTRA_CRC);
        out.extend(checksum.to_le_bytes());
        self.sequence = self.sequence.wrapping_add(1);
    }
}

/// MAV_MISSION_TYPE_MISSION.
const MISSION: u8 = 0;
/// The request as it was before there were whole numbers.
#[expect(deprecated, reason = "as above")]
const REQUEST_ID: u32 = MISSION_REQUEST_DATA::ID;

/// The kind of mission that a message is about, behind its fields: zeros at a message's end are not sent.
fn mission_type<D: MessageData>(packet: &Packet<'_>) -> u8 {
    packet.payload.get(D::ENCODED_LEN).copied().unwrap_or(MISSION)
}

/// Whether the autopilot is meant: by its number, or by the 0 of all.
fn is_us(system: u8, component: u8) -> bool {
    [0, AUTOPILOT.0].contains(&system) && [0, AUTOPILOT.1].contains(&component)
}

fn read<D: MessageData>(packet: &Packet<'_>) -> Option<D> {
    D::deser(MavlinkVersion::V2, packet.payload).ok()
}

/// A parameter's name without the zeros behind it.
fn named(id: &[u8]) -> &[u8] {
    &id[..id.iter().position(|byte| *byte == 0).unwrap_or(id.len())]
}

/// Behind the home.
fn item_of(waypoint: usize) -> usize {
    waypoint + 1
}

/// Home, the waypoints, and where a flight goes round the jump back to the first.
fn items(knowledge: &Knowledge) -> Vec<MISSION_ITEM_INT_DATA> {
    let Some(home) = knowledge.waypoints.first() else { return Vec::new() };
    let waypoint = |seq: usize, waypoint: &Waypoint| MISSION_ITEM_INT_DATA {
        x: waypoint.place_e7[0],
        y: waypoint.place_e7[1],
        z: waypoint.up_m,
        seq: seq as u16,
        command: MavCmd::MAV_CMD_NAV_WAYPOINT,
        frame: MavFrame::MAV_FRAME_GLOBAL,
        current: u8::from(seq == 1),
        autocontinue: 1,
        ..MISSION_ITEM_INT_DATA::DEFAULT
    };
    let mut items = vec![waypoint(0, home)];
    items.extend(knowledge.waypoints.iter().enumerate().map(|(index, point)| waypoint(item_of(index), point)));
    if knowledge.is_round {
        items.push(MISSION_ITEM_INT_DATA {
            // To item 1, for ever.
            param1: 1.0,
            param2: -1.0,
            seq: items.len() as u16,
            command: MavCmd::MAV_CMD_DO_JUMP,
            frame: MavFrame::MAV_FRAME_MISSION,
            autocontinue: 1,
            ..MISSION_ITEM_INT_DATA::DEFAULT
        });
    }
    items
}
