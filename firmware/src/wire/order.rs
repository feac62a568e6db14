//! Commands of a ground station to us.

use super::command::{Command, EXTERNAL_POSITION_ESTIMATE, SET_EKF_SOURCE_SET};
use super::decoder::Packet;
use mavlink::dialects::common::COMMAND_INT_DATA;
use mavlink::{MavlinkVersion, MessageData};
use plumbline_core::tile::Geographic;

/// What is ordered, as far as it can be meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// MAV_CMD_SET_EKF_SOURCE_SET: the set of sources, from 1 to 3.
    SourceSet(Option<u8>),
    /// MAV_CMD_EXTERNAL_POSITION_ESTIMATE: where the vehicle stands, and one sigma of each axis, metres.
    Position(Option<(Geographic, f32)>),
}

impl Order {
    /// Its command's number.
    pub fn command(self) -> u16 {
        match self {
            Order::SourceSet(_) => SET_EKF_SOURCE_SET,
            Order::Position(_) => EXTERNAL_POSITION_ESTIMATE,
        }
    }
}

/// Sets of sources that ArduPilot has.
const SOURCE_SETS: [u8; 3] = [1, 2, 3];
/// MAV_FRAME_GLOBAL and MAV_FRAME_GLOBAL_INT: what latitude and longitude are in.
const GLOBAL: [u8; 2] = [0, 5];
/// Largest sigma of a position, metres: as far as the largest reference reaches, and beyond any search.
const SIGMA_MAX_M: f32 = 100_000.0;

/// The order in a COMMAND_LONG or COMMAND_INT, and whom it is meant for; nothing for commands that we have no use for. A
/// position comes by COMMAND_INT alone: the other message has it in single precision, a metre coarse.
pub fn order(packet: &Packet<'_>) -> Option<(Order, (u8, u8))> {
    let byte = |at: usize| packet.payload.get(at).copied().unwrap_or(0);
    let float = |at: usize| f32::from_le_bytes([byte(at), byte(at + 1), byte(at + 2), byte(at + 3)]);
    let degrees = |at: usize| i32::from_le_bytes([byte(at), byte(at + 1), byte(at + 2), byte(at + 3)]);
    // Command, parameters and target lie at the same places in both.
    let Command { command, parameters: [first, _], target } =
        Command::deser(MavlinkVersion::V2, packet.payload).ok()?;
    let order = match command {
        SET_EKF_SOURCE_SET => Order::SourceSet(SOURCE_SETS.into_iter().find(|set| f32::from(*set) == first)),
        EXTERNAL_POSITION_ESTIMATE => {
            // Behind four parameters latitude, longitude and altitude; the frame behind the target.
            let sigma_m = float(8);
            let place = Geographic { lat_e7: degrees(16), lon_e7: degrees(20) };
            let is_meant = packet.id == COMMAND_INT_DATA::ID
                && GLOBAL.contains(&byte(32))
                && sigma_m > 0.0
                && sigma_m <= SIGMA_MAX_M
                && (place.lat_e7, place.lon_e7) != (0, 0)
                && place.is_possible();
            Order::Position(is_meant.then_some((place, sigma_m)))
        }
        _ => return None,
    };
    Some((order, target))
}
