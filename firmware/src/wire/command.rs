//! Commands to the autopilot, and their acknowledgements.
//!
//! By their own few bytes: the `mavlink` crate's command numbers are an enumeration that lacks those of ArduPilot's dialect,
//! and an acknowledgement of one of them would not decode.

use super::extensions::extended;
use mavlink::dialects::common::{COMMAND_ACK_DATA, COMMAND_LONG_DATA, MavMessage};
use mavlink::error::ParserError;
use mavlink::{MavlinkVersion, MessageData};

/// MAV_CMD_SET_MESSAGE_INTERVAL.
pub const SET_MESSAGE_INTERVAL: u16 = 511;
/// MAV_CMD_REQUEST_MESSAGE.
pub const REQUEST_MESSAGE: u16 = 512;
/// MAV_CMD_SET_EKF_SOURCE_SET, of ArduPilot's dialect.
pub const SET_EKF_SOURCE_SET: u16 = 42_007;
/// MAV_CMD_EXTERNAL_POSITION_ESTIMATE.
pub const EXTERNAL_POSITION_ESTIMATE: u16 = 43_003;

/// MAV_RESULT: done.
pub const ACCEPTED: u8 = 0;
/// Busy, to be asked again.
pub const TEMPORARILY_REJECTED: u8 = 1;
/// Never, as asked.
pub const DENIED: u8 = 2;
/// Not known.
pub const UNSUPPORTED: u8 = 3;
/// Tried in vain.
pub const FAILED: u8 = 4;
/// Done later.
pub const IN_PROGRESS: u8 = 5;

/// What the autopilot is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// MAV_CMD_SET_MESSAGE_INTERVAL: a message's id and the interval in microseconds.
    Interval(u32, u32),
    /// MAV_CMD_REQUEST_MESSAGE: a message's id.
    Message(u32),
    /// MAV_CMD_SET_EKF_SOURCE_SET: the set of sources of its estimator, from 1.
    SourceSet(u8),
}

impl Ask {
    /// Its command.
    pub fn command(self, target: (u8, u8)) -> Command {
        let (command, parameters) = match self {
            // Ids and intervals are whole numbers below 2²⁴, which single precision holds.
            Ask::Interval(message, interval_us) => (SET_MESSAGE_INTERVAL, [message as f32, interval_us as f32]),
            Ask::Message(message) => (REQUEST_MESSAGE, [message as f32, 0.0]),
            Ask::SourceSet(set) => (SET_EKF_SOURCE_SET, [f32::from(set), 0.0]),
        };
        Command { command, parameters, target }
    }
}

/// COMMAND_LONG: a command, its first two parameters, and whom it is meant for; the other parameters are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// MAV_CMD.
    pub command: u16,
    /// The first two of seven.
    pub parameters: [f32; 2],
    /// System and component.
    pub target: (u8, u8),
}

impl MessageData for Command {
    type Message = MavMessage;

    const ID: u32 = COMMAND_LONG_DATA::ID;
    const NAME: &'static str = COMMAND_LONG_DATA::NAME;
    const EXTRA_CRC: u8 = COMMAND_LONG_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = COMMAND_LONG_DATA::ENCODED_LEN;

    fn ser(&self, _: MavlinkVersion, payload: &mut [u8]) -> usize {
        let [a, b] = self.parameters.map(f32::to_le_bytes);
        let (system, component) = self.target;
        let bytes = a.into_iter().chain(b).chain([0; 20]).chain(self.command.to_le_bytes()).chain([system, component]);
        // The confirmation, 0 for the first time, is a trailing zero, which MAVLink 2 cuts off.
        written(payload, bytes)
    }

    fn deser(_: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let byte = |at: usize| payload.get(at).copied().unwrap_or(0);
        let float = |at: usize| f32::from_le_bytes([byte(at), byte(at + 1), byte(at + 2), byte(at + 3)]);
        Ok(Command {
            command: u16::from_le_bytes([byte(28), byte(29)]),
            parameters: [float(0), float(4)],
            target: (byte(30), byte(31)),
        })
    }
}

/// Writes bytes into a payload; how many.
fn written(payload: &mut [u8], bytes: impl Iterator<Item = u8>) -> usize {
    payload.iter_mut().zip(bytes).map(|(to, from)| *to = from).count()
}

/// COMMAND_ACK: a command, what became of it, and who had given it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Acknowledgement {
    /// MAV_CMD.
    pub command: u16,
    /// MAV_RESULT.
    pub result: u8,
    /// System and component of who gave it; zeros for everybody.
    pub target: (u8, u8),
}

/// Bytes of COMMAND_ACK before its extensions, and those before the target.
const ACK_BASE: usize = 3;
const ACK_TARGET: usize = 5;

impl MessageData for Acknowledgement {
    type Message = MavMessage;

    const ID: u32 = COMMAND_ACK_DATA::ID;
    const NAME: &'static str = COMMAND_ACK_DATA::NAME;
    const EXTRA_CRC: u8 = COMMAND_ACK_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = ACK_BASE + ACK_TARGET + 2;

    fn ser(&self, _: MavlinkVersion, payload: &mut [u8]) -> usize {
        let [low, high] = self.command.to_le_bytes();
        let used = written(payload, [low, high, self.result].into_iter());
        let (system, component) = self.target;
        extended(payload, used, ACK_BASE, [0, 0, 0, 0, 0, system, component])
    }

    fn deser(_: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let byte = |at: usize| payload.get(at).copied().unwrap_or(0);
        let target = (byte(ACK_BASE + ACK_TARGET), byte(ACK_BASE + ACK_TARGET + 1));
        Ok(Acknowledgement { command: u16::from_le_bytes([byte(0), byte(1)]), result: byte(2), target })
    }
}
