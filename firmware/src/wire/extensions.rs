//! MAVLink 2 extension fields that we need.
//!
//! The `mavlink` crate leaves extensions out unless a feature is on that drags the standard library into the image. Three are
//! needed: TIMESYNC's target, without which answers meant for others would be taken, DISTANCE_SENSOR's signal quality, one value
//! of which means "invalid", and GPS_RAW_INT's horizontal accuracy. Extensions follow the base fields in the order of the
//! definition; missing bytes are zeros.

use mavlink::dialects::common::{GPS_RAW_INT_DATA, MavMessage, TIMESYNC_DATA};
use mavlink::error::ParserError;
use mavlink::{MavlinkVersion, MessageData};

/// DISTANCE_SENSOR: 14 bytes of base fields, two fields of view, a quaternion, then the signal quality.
const QUALITY_OFFSET: usize = 14 + 4 + 4 + 16;

/// Signal quality of a DISTANCE_SENSOR payload, percent; 0 unknown, 1 invalid.
pub fn signal_quality(payload: &[u8]) -> u8 {
    payload.get(QUALITY_OFFSET).copied().unwrap_or(0)
}

/// Writes the extension behind base fields whose trailing zeros may have been cut off; the length of all, its own cut off.
pub(super) fn extended<const N: usize>(payload: &mut [u8], used: usize, base: usize, extension: [u8; N]) -> usize {
    let Some(significant) = extension.iter().rposition(|byte| *byte != 0) else { return used };
    if let Some(zeros) = payload.get_mut(used.min(base)..base) {
        zeros.fill(0);
    }
    if let Some(rest) = payload.get_mut(base..) {
        rest.iter_mut().zip(extension).for_each(|(to, from)| *to = from);
    }
    base + significant + 1
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
        let used = base.ser(version, payload);
        extended(payload, used, TIMESYNC_DATA::ENCODED_LEN, [self.target.0, self.target.1])
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let base = TIMESYNC_DATA::deser(version, payload)?;
        let byte = |at: usize| payload.get(TIMESYNC_DATA::ENCODED_LEN + at).copied().unwrap_or(0);
        Ok(Timesync { tc1: base.tc1, ts1: base.ts1, target: (byte(0), byte(1)) })
    }
}

/// GPS_RAW_INT with its horizontal accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct GpsRaw {
    /// The base fields.
    pub base: GPS_RAW_INT_DATA,
    /// h_acc: one sigma of the position, millimetres; 0 from those who do not say.
    pub h_acc_mm: u32,
}

/// Its first extension is the height above the ellipsoid, of four bytes.
const H_ACC_OFFSET: usize = GPS_RAW_INT_DATA::ENCODED_LEN + 4;

impl MessageData for GpsRaw {
    type Message = MavMessage;

    const ID: u32 = GPS_RAW_INT_DATA::ID;
    const NAME: &'static str = GPS_RAW_INT_DATA::NAME;
    const EXTRA_CRC: u8 = GPS_RAW_INT_DATA::EXTRA_CRC;
    const ENCODED_LEN: usize = GPS_RAW_INT_DATA::ENCODED_LEN + 8;

    fn ser(&self, version: MavlinkVersion, payload: &mut [u8]) -> usize {
        let used = self.base.ser(version, payload);
        let [a, b, c, d] = self.h_acc_mm.to_le_bytes();
        extended(payload, used, GPS_RAW_INT_DATA::ENCODED_LEN, [0, 0, 0, 0, a, b, c, d])
    }

    fn deser(version: MavlinkVersion, payload: &[u8]) -> Result<Self, ParserError> {
        let base = GPS_RAW_INT_DATA::deser(version, payload)?;
        let byte = |at: usize| payload.get(H_ACC_OFFSET + at).copied().unwrap_or(0);
        Ok(GpsRaw { base, h_acc_mm: u32::from_le_bytes(core::array::from_fn(byte)) })
    }
}
