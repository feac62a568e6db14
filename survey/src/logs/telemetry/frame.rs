//! A frame with its stamp, as it lies in the log.

use mavlink::dialects::ardupilotmega::MavMessage;
use mavlink::{MAV_STX, MAV_STX_V2, MavlinkVersion, Message, calculate_crc};

/// Bytes of the stamp before each frame.
const STAMP: usize = 8;
/// Bytes of a checksum.
const CHECKSUM: usize = 2;
/// Bytes of the signature of a frame whose first incompatibility flag is set.
const SIGNATURE: usize = 13;
/// Stamps between 2000 and 2100 are believed: what lies outside is no frame. Microseconds since 1970.
const STAMPS_US: std::ops::Range<u64> = 946_684_800_000_000..4_102_444_800_000_000;

/// Not yet decoded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    pub version: MavlinkVersion,
    /// Its arrival, microseconds since 1970.
    pub stamp_us: u64,
    pub system: u32,
    pub component: u8,
    pub id: u32,
    pub payload: &'a [u8],
    /// Where the next one's stamp begins.
    pub end: usize,
    /// What the checksum is of.
    checked: &'a [u8],
    checksum: u16,
}

impl<'a> Frame<'a> {
    /// The frame whose stamp begins at a place, if it can be one.
    pub fn at(bytes: &'a [u8], at: usize) -> Option<Self> {
        let rest = bytes.get(at..)?;
        let stamp_us = u64::from_be_bytes(*rest.first_chunk::<STAMP>()?);
        let frame = &rest[STAMP..];
        let (&[stx, length, flags], true) = (frame.first_chunk::<3>()?, STAMPS_US.contains(&stamp_us)) else {
            return None;
        };
        let (version, head, signature) = match stx {
            MAV_STX => (MavlinkVersion::V1, 6, 0),
            MAV_STX_V2 if flags & !1 == 0 => (MavlinkVersion::V2, 10, SIGNATURE * usize::from(flags & 1)),
            _ => return None,
        };
        let sum_at = head + usize::from(length);
        let whole = frame.get(..sum_at + CHECKSUM + signature)?;
        let (system, component, id) = match version {
            MavlinkVersion::V1 => (whole[3], whole[4], u32::from(whole[5])),
            MavlinkVersion::V2 => (whole[5], whole[6], u32::from_le_bytes([whole[7], whole[8], whole[9], 0])),
        };
        Some(Frame {
            version,
            stamp_us,
            system: system.into(),
            component,
            id,
            payload: &whole[head..sum_at],
            end: at + STAMP + whole.len(),
            checked: &whole[1..sum_at],
            checksum: u16::from_le_bytes([whole[sum_at], whole[sum_at + 1]]),
        })
    }

    /// Whether the dialect has the message, without which its checksum cannot be told.
    pub fn is_known(&self) -> bool {
        MavMessage::default_message_from_id(self.id).is_some()
    }

    /// Whether its checksum holds.
    pub fn is_intact(&self) -> bool {
        self.is_known() && calculate_crc(self.checked, MavMessage::extra_crc(self.id)) == self.checksum
    }
}
