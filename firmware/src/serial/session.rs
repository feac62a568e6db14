//! Requests in, answers out: each request is done once.

mod dialogue;
mod work;

use super::frame::{Receiver, Unframed, decode};
use super::message::Counts;
use super::stores::{Stores, Uploaded};
use super::wires::Wires;
use dialogue::Dialogue;

/// Who a board is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Name, at most 32 bytes.
    pub board: &'static str,
    /// Another number after each reboot.
    pub boot: u32,
    /// Clock of the core, Hz; 0 where there is none.
    pub core_clock_hz: u32,
    /// What its counters and [`Machine::count`] count.
    pub counts: Counts,
}

/// What a session needs of a board.
pub trait Machine {
    /// Who it is.
    fn identity(&self) -> Identity;
    /// Makes the application of what was uploaded ([`super::boot::application`]) and spawns its tasks on an executor of
    /// its own, the ends of `wires` in their hands. Called once at most.
    ///
    /// # Errors
    /// Why it cannot fly, at most 64 bytes.
    fn boot(&mut self, uploaded: Uploaded, wires: &'static Wires) -> Result<(), [&'static str; 2]>;
    /// Runs the application until it is idle ([`crate::run::until_idle`]).
    fn run(&mut self);
    /// A counter that wraps, of what [`Identity::counts`] says; 0 for ever where nothing is counted.
    fn count(&self) -> u32;
}

/// What is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reply<'a> {
    /// These bytes.
    pub bytes: &'a [u8],
    /// And then the board is to reboot.
    pub resets: bool,
}

/// What a board has received so far that could not be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// No COBS, too long, a wrong CRC, no request.
    pub bad: u32,
    /// Requests of the session that are neither the last nor the next.
    pub stale: u32,
    /// Requests answered before, whose answer was repeated.
    pub repeated: u32,
}

/// A board's end of the line.
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct Session<M> {
    receiver: Receiver,
    dialogue: Dialogue<M>,
}

impl<M: Machine> Session<M> {
    /// A board that has just booted.
    pub fn new(machine: M, wires: &'static Wires, stores: Stores) -> Self {
        Session { receiver: Receiver::new(), dialogue: Dialogue::new(machine, wires, stores) }
    }

    /// What could not be used so far.
    pub fn dropped(&self) -> Dropped {
        self.dialogue.dropped
    }

    /// Takes a byte of the line; what is to be sent, if it was the last one of a request.
    pub fn take(&mut self, byte: u8) -> Option<Reply<'_>> {
        let request = match self.receiver.take(byte) {
            Unframed::Nothing => return None,
            Unframed::Bad => None,
            Unframed::Body(body) => decode(body),
        };
        match request {
            Some(request) => self.dialogue.reply(request),
            None => self.dialogue.bad(),
        }
    }
}
