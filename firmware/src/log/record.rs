//! What a log is made of. A record is stored as its length (u16, little-endian) and itself in postcard's encoding.

use crate::wire::telemetry::{FrameReport, InstantReport};
use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

/// Bytes, in one piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blob<'a>(pub &'a [u8]);

impl Serialize for Blob<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for Blob<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        <&[u8]>::deserialize(deserializer).map(Blob)
    }
}

/// One record. Ticks are the capture timer's.
#[allow(clippy::large_enum_variant, reason = "no heap to put the large one on, and one at a time is made")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record<'a> {
    /// What the application ran on; every log begins with it.
    Head(Head),
    /// The configuration store as it lay in flash, behind the head.
    #[serde(borrow)]
    Configuration(Blob<'a>),
    /// A piece of the tile store: where it begins, and its bytes. Pieces come in their order, among other records.
    Tiles(u32, Blob<'a>),
    /// So many records were dropped here, since the ring was full.
    Gap(u32),
    /// The log was closed as it should be; nothing follows.
    Close,
    /// Something of the simulator's, which knows the truth. A board writes none.
    Annotation(Blob<'a>),
    /// Bytes from the link.
    Bytes(u32, Blob<'a>),
    /// A pulse per second.
    Pulse(u32),
    /// An edge, and whether it rose.
    Edge(u32, bool),
    /// A beat.
    Beat(u32),
    /// A frame: its number, the arrival of its first row, columns and rows.
    Start(u32, u32, (u16, u16)),
    /// What is kept of the frame was chosen.
    Begin,
    /// Its rows: 0, or the code of the refusal.
    Rows(u8),
    /// The timer when its pose was computed.
    Pose(u32),
    /// Its patch: columns and rows, runs of three little-endian u16 each, pixels.
    Patch((u16, u16), Blob<'a>, Blob<'a>),
    /// What it came to, and latitude and longitude of its fix in 1e-7 degrees.
    Frame(FrameReport, InstantReport, Option<(i32, i32)>),
    /// The timer when a time request went out.
    Asked(u32),
    /// A packet that was refused for its signature: which, from 0, of those that the bytes before it complete, and the code of
    /// the verdict. All others were taken.
    Refused(u8, u8),
    /// A command to the camera, behind a frame's rows: the number of the first frame that it holds for, and its exposure in
    /// microseconds.
    Exposure(u32, u32),
}

/// What the application ran on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// Bytes of frame memory: they decide how frames are reduced.
    pub frame_memory: u32,
    /// Bytes of the tile store.
    pub tiles_bytes: u32,
    /// Checksum of the whole tile store.
    pub tiles_crc: u32,
}

impl<'a> Record<'a> {
    /// The record in `bytes`, all of them. Any bytes may come.
    pub fn decode(bytes: &'a [u8]) -> Option<Self> {
        match postcard::take_from_bytes(bytes) {
            Ok((record, [])) => Some(record),
            _ => None,
        }
    }

    /// As it is stored, without its length; nothing where `buffer` is too small.
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        postcard::to_slice(self, buffer).ok().map(|bytes| &*bytes)
    }
}
