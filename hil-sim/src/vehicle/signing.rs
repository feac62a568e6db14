//! The other side of a link whose messages are signed: the simulated autopilot signs what it sends as it sends it, and takes
//! nothing of the firmware's that is not well signed.

use mavlink::dialects::common::MavMessage;
use mavlink::{Message, calculate_crc};
use plumbline_firmware::wire::decoder::Packet;
use plumbline_firmware::wire::signature::{Key, SIGNED, Signature, tail};
use plumbline_firmware::wire::signing::streams::BEHIND;
use std::collections::BTreeMap;

/// The autopilot's time at the start of a flight: 2026-01-01, 4018 days after 2015-01-01, units of 10 us. Chosen.
const START: u64 = 4018 * 86_400 * 100_000;
/// The id of its link.
const LINK: u8 = 0;
/// Bytes of a message before and behind its payload.
const HEADER: usize = 10;
const CHECKSUM: usize = 2;

/// A key, and what was signed and heard with it.
#[derive(Clone, Debug)]
pub struct Signatory {
    key: Key,
    stamp: u64,
    streams: BTreeMap<(u8, u8, u8), u64>,
    /// Messages that were refused.
    refused: u64,
}

impl Signatory {
    /// At the start of a flight.
    pub fn new(key: Key) -> Self {
        Signatory { key, stamp: START, streams: BTreeMap::new(), refused: 0 }
    }

    /// The unsigned messages that follow each other in `bytes`, signed, at this instant of the flight.
    pub fn signed(&mut self, bytes: &[u8], at_us: u64) -> Vec<u8> {
        let (mut rest, mut signed) = (bytes, Vec::new());
        while let Some(&length) = rest.get(1) {
            let Some((message, behind)) = rest.split_at_checked(HEADER + usize::from(length) + CHECKSUM) else { break };
            rest = behind;
            let mut message = message.to_vec();
            message[2] |= SIGNED;
            let id = u32::from_le_bytes([message[7], message[8], message[9], 0]);
            let end = message.len() - CHECKSUM;
            let checksum = calculate_crc(&message[1..end], MavMessage::extra_crc(id)).to_le_bytes();
            message[end..].copy_from_slice(&checksum);
            self.stamp = (self.stamp + 1).max(START + at_us / 10);
            let digest = self.key.digest(&message, tail(LINK, self.stamp));
            signed.extend(&message);
            signed.extend(Signature { link: LINK, stamp: self.stamp, digest }.bytes());
        }
        signed
    }

    /// Whether a message of the firmware's is well signed and new.
    pub fn takes(&mut self, packet: &Packet<'_>) -> bool {
        let is_taken = self.is_good(packet).is_some();
        self.refused += u64::from(!is_taken);
        is_taken
    }

    fn is_good(&mut self, packet: &Packet<'_>) -> Option<()> {
        let signed = packet.signed?;
        let Signature { link, stamp, digest } = Signature::of(*signed.signature);
        let least = match self.streams.get(&(packet.system, packet.component, link)) {
            Some(last) => last + 1,
            None => self.stamp.saturating_sub(BEHIND),
        };
        if digest != self.key.digest(signed.message, tail(link, stamp)) || stamp < least {
            return None;
        }
        self.streams.insert((packet.system, packet.component, link), stamp);
        self.stamp = self.stamp.max(stamp);
        Some(())
    }

    /// Messages of the firmware's that were refused.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
