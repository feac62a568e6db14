//! What goes wrong on the link, after the fault injector of smoltcp's examples: seeded and counted.

pub mod line;
pub mod passage;
#[cfg(test)]
mod tests;

use crate::noise::{stream, uniform};
use crate::scenario::LinkFaults;
use rand_chacha::ChaCha12Rng;

/// A message id that no dialect uses; the low 16 bits are random.
const UNKNOWN_ID: u32 = 0xF0_0000;
/// Longest payload of an invented message, bytes.
const UNKNOWN_PAYLOAD_MAX: f64 = 64.0;

/// What was done to the link so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FaultCounts {
    /// Messages that came in.
    pub messages: u64,
    /// Messages that lost their end, or all.
    pub cut: u64,
    /// Messages that left with at least one flipped bit.
    pub damaged: u64,
    /// Bits that were flipped.
    pub flipped_bits: u64,
    /// Messages of an unknown kind that were put in.
    pub unknown: u64,
}

/// Does the scenario's faults to one direction of a link.
#[derive(Debug)]
pub struct FaultInjector {
    faults: LinkFaults,
    rng: ChaCha12Rng,
    counts: FaultCounts,
}

impl FaultInjector {
    /// `direction` names the stream of random numbers, so that the two directions of a link fail independently.
    #[must_use]
    pub fn new(faults: LinkFaults, seed: u64, direction: &str) -> Self {
        let rng = stream(seed, &format!("fault.{direction}"));
        FaultInjector { faults, rng, counts: FaultCounts::default() }
    }

    /// What was done so far.
    #[must_use]
    pub fn counts(&self) -> FaultCounts {
        self.counts
    }

    /// Appends to `link` what becomes of `message`: an unknown message before it, less of it, flipped bits in it.
    pub fn pass(&mut self, message: &[u8], link: &mut Vec<u8>) {
        self.counts.messages += 1;
        if self.happens(self.faults.unknown_percent) {
            self.counts.unknown += 1;
            self.append_unknown(link);
        }
        let mut kept = message.len();
        if self.happens(self.faults.cut_percent) {
            self.counts.cut += 1;
            kept = (uniform(&mut self.rng) * kept as f64) as usize;
        }
        let start = link.len();
        link.extend_from_slice(&message[..kept]);
        self.flip_bits(&mut link[start..]);
    }

    fn happens(&mut self, percent: f64) -> bool {
        uniform(&mut self.rng) * 100.0 < percent
    }

    fn flip_bits(&mut self, bytes: &mut [u8]) {
        let bits = bytes.len() as u64 * 8;
        let mut next = self.bits_to_next_flip();
        self.counts.damaged += u64::from(next < bits);
        while next < bits {
            bytes[(next / 8) as usize] ^= 1 << (next % 8);
            self.counts.flipped_bits += 1;
            next = next.saturating_add(1).saturating_add(self.bits_to_next_flip());
        }
    }

    /// Good bits before the next flip. Geometric, which has no memory: every bit flips by itself at the given rate,
    /// without a draw for each, and each message may start anew.
    fn bits_to_next_flip(&mut self) -> u64 {
        let rate = self.faults.bit_error_percent / 100.0;
        if rate == 0.0 {
            return u64::MAX;
        }
        ((1.0 - uniform(&mut self.rng)).ln() / (-rate).ln_1p()) as u64
    }

    /// A MAVLink 2 message that is whole but of a kind that nobody knows: header, random payload, random checksum.
    fn append_unknown(&mut self, link: &mut Vec<u8>) {
        let mut byte = || (uniform(&mut self.rng) * 256.0) as u8;
        let [id_low, id_middle, id_high, _] =
            (UNKNOWN_ID | u32::from(u16::from_le_bytes([byte(), byte()]))).to_le_bytes();
        let length = (f64::from(byte()) / 256.0 * UNKNOWN_PAYLOAD_MAX) as u8;
        link.extend([0xFD, length, 0, 0, byte(), 1, 1, id_low, id_middle, id_high]);
        link.extend((0..length as usize + 2).map(|_| byte()));
    }
}
