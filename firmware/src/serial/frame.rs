//! Messages on the line: postcard, its CRC32 behind it, all of it COBS between two zeros.
//!
//! The zero in front ends whatever a broken line left unfinished. A message with a wrong CRC, with bytes left over or too
//! long for its buffer is dropped and counted.

use super::message::Envelope;
use crate::stores::framing::{CRC, checksum};
use cobs::{DecodeResult, DecoderState};
use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};
use serde::{Deserialize, Serialize};

/// The bytes of a message, in `buffer`; `None` where it is too small.
pub fn encode<'b, M: Serialize>(envelope: &Envelope<M>, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let (first, rest) = buffer.split_first_mut()?;
    *first = 0;
    let cobs = Cobs::try_new(Slice::new(rest)).ok()?;
    let used = postcard::serialize_with_flavor(envelope, CrcModifier::new(cobs, CRC.digest())).ok()?.len();
    buffer.get(..=used)
}

/// The message of a body that a [`Receiver`] found.
pub fn decode<'b, M: Deserialize<'b>>(body: &'b [u8]) -> Option<Envelope<M>> {
    match postcard::take_from_bytes_crc32(body, CRC.digest()) {
        Ok((envelope, [])) => Some(envelope),
        _ => None,
    }
}

/// The version of a `Hello` or `Welcome` of any version.
pub fn version(body: &[u8]) -> Option<u16> {
    let (message, crc) = body.split_last_chunk::<4>()?;
    // Session, id, which message; the first one of both kinds carries the version.
    let (head, _) = postcard::take_from_bytes::<(u32, u32, u32, u16)>(message).ok()?;
    (checksum(message) == u32::from_le_bytes(*crc) && head.2 == 0).then_some(head.3)
}

/// What a [`Receiver`] has to say to a byte.
#[derive(Debug, PartialEq, Eq)]
pub enum Unframed<'a> {
    /// Nothing yet.
    Nothing,
    /// What stood between two zeros, COBS undone.
    Body(&'a [u8]),
    /// What stood there was no COBS, or too long.
    Bad,
}

/// Longest body, bytes: a message and its CRC.
const BODY_MAX: usize = super::PIECE_MAX + super::HEAD_MAX + 4;

/// Collects what stands between two zeros, undoing COBS byte by byte.
#[derive(Debug)]
pub struct Receiver {
    body: [u8; BODY_MAX],
    /// More than the body holds where bytes were dropped.
    length: usize,
    state: DecoderState,
}

impl Receiver {
    /// Nothing received.
    pub const fn new() -> Self {
        Receiver { body: [0; BODY_MAX], length: 0, state: DecoderState::Idle }
    }

    /// Takes a byte.
    pub fn take(&mut self, byte: u8) -> Unframed<'_> {
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => Unframed::Nothing,
            Ok(DecodeResult::DataContinue(byte)) => {
                if let Some(next) = self.body.get_mut(self.length) {
                    *next = byte;
                }
                // One beyond the body says that it is too long.
                self.length = (self.length + 1).min(BODY_MAX + 1);
                Unframed::Nothing
            }
            Ok(DecodeResult::DataComplete) => {
                let length = core::mem::take(&mut self.length);
                self.body.get(..length).map_or(Unframed::Bad, Unframed::Body)
            }
            Err(_) => {
                self.length = 0;
                Unframed::Bad
            }
        }
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}
