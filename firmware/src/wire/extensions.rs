//! MAVLink 2 extension fields that we need.
//!
//! The `mavlink` crate leaves extensions out unless a feature is on that drags the standard library into the image. Two
//! are needed: TIMESYNC's target, without which answers meant for others would be taken, and DISTANCE_SENSOR's signal
//! quality, one value of which means "invalid". Extensions follow the base fields in the order of the definition;
//! missing bytes are zeros.

use mavlink::dialects::common::{MavMessage, TIMESYNC_DATA};
use mavlink::error::ParserError;
use mavlink::{MavlinkVersion, MessageData};

/// DISTANCE_SENSOR: 14 bytes of base fields, two fields of view, a quaternion, then the signal quality.
const QUALITY_OFFSET: usize = 14 + 4 + 4 + 16;

/// Signal quality of a DISTANCE_SENSOR payload, percent; 0 unknown, 1 invalid.
pub fn signal_quality(payload: &[u8]) -> u8 {
    payload.get(QUALITY_OFFSET).copied().unwrap_or(0)
}

/// TIMESYNC with its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timesync {
    /// 0 in a request, the answering side's time in an answer, nanoseconds.
    pub tc1: i64,
    /// The asking side's time, nanoseconds.
    pub ts1: i64,
    /// System and component it is meant for; zeros for everybody.
    pub target: (u8, u8),
}

impl MessageData for Timesync {
    type Message = MavMessage;

    const ID: u32 = TIMESYNC_DATA::ID;
    const NAME: &'static str = TIMESYNC_DATA::NAME;
    const EXTRA_CRC: u8 = TIMESYNC_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = TIMESYNC_DATA::ENCODED_LEN + 2;

    fn ser(&self, version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let base = TIMESYNC_DATA { tc1: self.tc1, ts1: self.ts1 };
        let length = TIMESYNC_DATA::ENCODED_LEN;
        let used = base.ser(version, payload);
        match payload.get_mut(used..length + 2) {
            Some(rest) if self.target != (0, 0) => {
                rest.fill(0);
                if let [.., system, component] = rest {
                    (*system, *component) = self.target;
                }
                if self.target.1 == 0 { length + 1 } else { length + 2 }
            }
            _ => used,
        }
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let base = TIMESYNC_DATA::deser(version, payload)?;
        let byte = |at: usize| payload.get(TIMESYNC_DATA::ENCODED_LEN + at).copied().unwrap_or(0);
        Ok(Timesync { tc1: base.tc1, ts1: base.ts1, target: (byte(0), byte(1)) })
    }
}
