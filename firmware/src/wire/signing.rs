//! Signing of MAVLink 2 messages, both ways (<https://mavlink.io/en/guide/message_signing.html>).
//!
//! With a key every message that is sent is signed, and of those that come only the well signed and new ones are taken; the
//! others are counted by their [`Verdict`]. The one message that the specification lets pass unsigned, RADIO_STATUS, is of no
//! use here. Without a key nothing is signed, and what is signed is taken unchecked.
//!
//! [`clock`]: the time in our signatures. [`streams`]: the newest time of each sender.

pub mod clock;
pub mod streams;

use super::decoder::Packet;
use super::signature::{Key, SIGNATURE, Signature, is_same, tail};
use clock::StampClock;
use plumbline_core::units::Ticks;
use streams::{Stream, Streams};

/// The id of our link: there is one.
const LINK: u8 = 0;

/// What is to be done with a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Verdict {
    /// Take it.
    Taken = 0,
    /// Refuse it: it is not signed.
    Unsigned = 1,
    /// Refuse it: signed with another key, or changed on its way.
    Wrong = 2,
    /// Refuse it: not newer than the last of its stream.
    Replayed = 3,
    /// Refuse it: the first of its stream, and more than a minute behind our own time.
    Late = 4,
    /// Refuse it: the first of its stream, and there is no room for another one.
    Crowded = 5,
}

impl Verdict {
    /// The verdict with this code.
    pub fn from_code(code: u8) -> Option<Verdict> {
        use Verdict as V;
        [V::Taken, V::Unsigned, V::Wrong, V::Replayed, V::Late, V::Crowded].into_iter().find(|v| *v as u8 == code)
    }
}

/// Messages that were refused, by their verdicts from [`Verdict::Unsigned`] on.
pub type Refused = [u32; 5];

/// Where the time is kept over a lost power.
pub trait Keeper: core::fmt::Debug {
    /// Reserves the time beyond `stamp`, at once; until where it is reserved, the end excluded.
    fn reserve(&self, stamp: u64) -> u64;
}

/// The key and what changes with each message.
#[derive(Clone, Debug)]
pub struct Signing {
    key: Key,
    /// Where the time is kept, and how far it has been reserved there.
    keeper: Option<&'static dyn Keeper>,
    reserved: u64,
    clock: StampClock,
    streams: Streams,
    refused: Refused,
}

impl Signing {
    /// With this key. `stamp`: a time that nothing which was sent or taken with this key is beyond, as far as the board knows.
    pub fn new(key: Key, stamp: u64) -> Self {
        let (clock, streams) = (StampClock::new(stamp), Streams::new());
        Signing { key, keeper: None, reserved: u64::MAX, clock, streams, refused: Refused::default() }
    }

    /// With a time that is kept: nothing is signed or taken with one that has not been reserved before.
    pub fn kept(self, keeper: &'static dyn Keeper) -> Self {
        let reserved = keeper.reserve(self.clock.stamp());
        Signing { keeper: Some(keeper), reserved, ..self }
    }

    /// Reserves the time up to this one, where that has not been done.
    fn reserve(&mut self, stamp: u64) {
        if let Some(keeper) = self.keeper.filter(|_| stamp >= self.reserved) {
            self.reserved = keeper.reserve(stamp);
        }
    }

    /// The signature of the next message to be sent.
    pub fn sign(&mut self, message: &[u8]) -> [u8; SIGNATURE] {
        let stamp = self.clock.issue();
        self.reserve(stamp);
        Signature { link: LINK, stamp, digest: self.key.digest(message, tail(LINK, stamp)) }.bytes()
    }

    /// Whether a message is taken; what is not, is counted.
    pub fn judge(&mut self, packet: &Packet<'_>) -> Verdict {
        let verdict = self.verdict(packet);
        let place = (verdict as usize).checked_sub(1).and_then(|place| self.refused.get_mut(place));
        place.into_iter().for_each(|count| *count = count.wrapping_add(1));
        verdict
    }

    fn verdict(&mut self, packet: &Packet<'_>) -> Verdict {
        let Some(signed) = packet.signed else { return Verdict::Unsigned };
        let Signature { link, stamp, digest } = Signature::of(*signed.signature);
        // Nothing is believed of a message before this, least of all its time.
        if !is_same(digest, self.key.digest(signed.message, tail(link, stamp))) {
            return Verdict::Wrong;
        }
        let verdict = self.streams.take(
            Stream { system: packet.system, component: packet.component, link },
            stamp,
            self.clock.stamp(),
        );
        if verdict == Verdict::Taken {
            self.clock.received(stamp);
            self.reserve(stamp);
        }
        verdict
    }

    /// The time goes on with the timer; to be called more often than that wraps.
    pub fn advance(&mut self, now: Ticks) {
        self.clock.advance(now);
    }

    /// The newest time that was sent or validly received.
    pub fn stamp(&self) -> u64 {
        self.clock.stamp()
    }

    /// What was refused.
    pub fn refused(&self) -> Refused {
        self.refused
    }
}
