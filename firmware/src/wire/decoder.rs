//! Finds MAVLink 2 messages in a stream of bytes.

use super::signature::{SIGNATURE, SIGNED};
use mavlink::dialects::common::MavMessage;
use mavlink::{MAV_STX_V2, Message, calculate_crc};

/// Longest message: 10 header, 255 payload, 2 checksum, 13 signature.
const LONGEST: usize = 280;
const HEADER: usize = 10;
const CHECKSUM: usize = 2;

/// What was seen on the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounters {
    /// Messages whose checksum held.
    pub good: u32,
    /// Candidates whose checksum failed.
    pub bad_checksum: u32,
    /// Candidates with an id that the dialect does not know, whose checksum therefore cannot be checked.
    pub unknown_id: u32,
    /// Candidates with incompatibility flags that we do not know.
    pub incompatible: u32,
    /// Bytes that belonged to no message.
    pub skipped_bytes: u32,
}

/// A message whose checksum held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Message id.
    pub id: u32,
    /// Sender's system id.
    pub system: u8,
    /// Sender's component id.
    pub component: u8,
    /// Payload, trailing zeros cut off as MAVLink 2 does.
    pub payload: &'a [u8],
    /// What a signature is about, where one followed; it is not checked here.
    pub signed: Option<Signed<'a>>,
}

/// A signed message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signed<'a> {
    /// From its first byte to its checksum.
    pub message: &'a [u8],
    /// What is behind it.
    pub signature: &'a [u8; SIGNATURE],
}

/// Gathers bytes until they are a message. A candidate that turns out wrong costs one byte, not its claimed length, so
/// a damaged header cannot swallow the good messages behind it.
#[derive(Debug)]
pub struct Decoder {
    buffer: [u8; LONGEST],
    filled: usize,
    /// Bytes at the front that the last packet used up.
    used: usize,
    counters: LinkCounters,
}

enum Candidate {
    Incomplete,
    Wrong,
    Whole(usize),
}

impl Decoder {
    /// Nothing received yet.
    pub const fn new() -> Self {
        Decoder {
            buffer: [0; LONGEST],
            filled: 0,
            used: 0,
            counters: LinkCounters { good: 0, bad_checksum: 0, unknown_id: 0, incompatible: 0, skipped_bytes: 0 },
        }
    }

    /// What was seen so far.
    pub fn counters(&self) -> LinkCounters {
        self.counters
    }

    /// Bytes that may yet become a message.
    pub fn waiting(&self) -> usize {
        self.filled.saturating_sub(self.used)
    }

    /// Where more bytes go, never empty after [`Decoder::next`] has returned `None`.
    pub fn free(&mut self) -> &mut [u8] {
        self.compact();
        self.buffer.get_mut(self.filled..).unwrap_or(&mut [])
    }

    /// Says that `count` bytes were written into [`Decoder::free`].
    pub fn filled(&mut self, count: usize) {
        self.filled = (self.filled + count).min(LONGEST);
    }

    /// Takes all of `bytes`, however many, and hands over each message that they complete.
    pub fn take(&mut self, bytes: &[u8], mut each: impl FnMut(&Packet<'_>)) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let room = self.free();
            let (now, later) = rest.split_at(room.len().min(rest.len()));
            room.iter_mut().zip(now).for_each(|(to, from)| *to = *from);
            self.filled(now.len());
            rest = later;
            while let Some(packet) = self.next() {
                each(&packet);
            }
        }
    }

    /// The next whole message, `None` when more bytes are needed.
    #[allow(clippy::should_implement_trait, reason = "lends its buffer, which an Iterator cannot")]
    pub fn next(&mut self) -> Option<Packet<'_>> {
        let length = loop {
            self.compact();
            match self.candidate() {
                Candidate::Incomplete => return None,
                Candidate::Whole(length) => break length,
                Candidate::Wrong => {
                    self.used = 1;
                    self.counters.skipped_bytes += 1;
                }
            }
        };
        self.counters.good += 1;
        self.used = length;
        let payload_end = HEADER + self.buffer[1] as usize;
        let whole = self.buffer.get(..length).unwrap_or(&[]);
        let signed = whole.split_last_chunk().filter(|_| self.buffer[2] & SIGNED != 0);
        Some(Packet {
            id: self.id(),
            system: self.buffer[5],
            component: self.buffer[6],
            payload: self.buffer.get(HEADER..payload_end).unwrap_or(&[]),
            signed: signed.map(|(message, signature)| Signed { message, signature }),
        })
    }

    fn id(&self) -> u32 {
        u32::from_le_bytes([self.buffer[7], self.buffer[8], self.buffer[9], 0])
    }

    /// Judges the bytes at the front.
    fn candidate(&mut self) -> Candidate {
        if self.filled == 0 {
            return Candidate::Incomplete;
        }
        if self.buffer[0] != MAV_STX_V2 {
            return Candidate::Wrong;
        }
        if self.filled < HEADER {
            return Candidate::Incomplete;
        }
        let flags = self.buffer[2];
        if flags & !SIGNED != 0 {
            self.counters.incompatible += 1;
            return Candidate::Wrong;
        }
        // The dialect answers 0 for an id that it does not know.
        let extra = MavMessage::extra_crc(self.id());
        if extra == 0 {
            self.counters.unknown_id += 1;
            return Candidate::Wrong;
        }
        let checked = HEADER + self.buffer[1] as usize;
        let length = checked + CHECKSUM + if flags & SIGNED != 0 { SIGNATURE } else { 0 };
        if self.filled < length {
            return Candidate::Incomplete;
        }
        // Longer than the longest message it cannot be: its length is a byte.
        let (Some(body), Some(&sent)) =
            (self.buffer.get(1..checked), self.buffer.get(checked..).and_then(|rest| rest.first_chunk()))
        else {
            return Candidate::Wrong;
        };
        if calculate_crc(body, extra) != u16::from_le_bytes(sent) {
            self.counters.bad_checksum += 1;
            return Candidate::Wrong;
        }
        Candidate::Whole(length)
    }

    /// Drops what was used and, in one go, everything up to the next possible start.
    fn compact(&mut self) {
        let filled = self.filled.min(LONGEST);
        let used = self.used.min(filled);
        let held = self.buffer.get(used..filled).unwrap_or(&[]);
        let noise = held.iter().take_while(|&&byte| byte != MAV_STX_V2).count();
        self.counters.skipped_bytes += noise as u32;
        let drop = used + noise;
        self.filled = filled.saturating_sub(drop);
        // By bytes: few are left behind a message.
        for to in 0..if drop > 0 { self.filled } else { 0 } {
            let Some(&byte) = self.buffer.get(drop + to) else { break };
            self.buffer.get_mut(to).into_iter().for_each(|to| *to = byte);
        }
        self.used = 0;
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Decoder::new()
    }
}
