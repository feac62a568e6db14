//! Requests in, answers out: each request is done once.

mod work;

use super::frame::{Receiver, Unframed, decode, encode};
use super::message::{Answer, Counts, Envelope, Refused, Request, Welcome};
use super::stores::{Stores, Uploaded};
use super::wires::Wires;
use super::{FRAME_MAX, PIECE_MAX, SHORT_MAX, VERSION};
use work::{Done, Work};

/// Who a board is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Name, at most 32 bytes.
    pub board: &'static str,
    /// Another number after each reboot.
    pub boot: u32,
    /// Clock of the core, Hz; 0 where there is none to tell.
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

/// How far the board is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// No application yet.
    Loading,
    /// An application flies.
    Flying,
    /// An application was tried, or its session is over.
    Spent,
}

/// A board's end of the line.
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct Session<M> {
    machine: M,
    wires: &'static Wires,
    stores: Stores,
    room: [u32; 3],
    stage: Stage,
    current: Option<u32>,
    /// The last request done, and how long its answer is.
    last: u32,
    answer: [u8; FRAME_MAX],
    answer_length: usize,
    /// Answers that belong to no session.
    short: [u8; SHORT_MAX],
    receiver: Receiver,
    dropped: Dropped,
}

impl<M: Machine> Session<M> {
    /// A board that has just booted.
    pub fn new(machine: M, wires: &'static Wires, stores: Stores) -> Self {
        Session {
            machine,
            wires,
            room: stores.room(),
            stores,
            stage: Stage::Loading,
            current: None,
            last: 0,
            answer: [0; FRAME_MAX],
            answer_length: 0,
            short: [0; SHORT_MAX],
            receiver: Receiver::new(),
            dropped: Dropped::default(),
        }
    }

    /// What could not be used so far.
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }

    /// Takes a byte of the line; what is to be sent, if it was the last one of a request.
    pub fn take(&mut self, byte: u8) -> Option<Reply<'_>> {
        let body = match self.receiver.take(byte) {
            Unframed::Nothing => return None,
            Unframed::Bad => {
                self.dropped.bad = self.dropped.bad.wrapping_add(1);
                return None;
            }
            Unframed::Body(body) => body,
        };
        let Some(Envelope { session, id, message }) = decode::<Request<'_>>(body) else {
            self.dropped.bad = self.dropped.bad.wrapping_add(1);
            return None;
        };
        let identity = self.machine.identity();
        let short = |message: Answer<'_>, buffer: &'_ mut [u8]| {
            encode(&Envelope { session, id, message }, buffer).map_or(0, <[u8]>::len)
        };
        let (length, resets) = match message {
            // The welcome of another version would be misread, but its version is told by the part that never changes.
            Request::Hello { .. } => (short(Answer::Welcome(welcome(&identity, self.room)), &mut self.short), false),
            Request::Reset { boot } if boot == identity.boot => (short(Answer::Done, &mut self.short), true),
            // It was meant for the boot before this one.
            Request::Reset { .. } => return self.stale(),
            Request::Open if self.current != Some(session) && id == 1 => {
                if self.stage == Stage::Loading {
                    self.stores.clear();
                    (self.current, self.last) = (Some(session), id);
                    let envelope = Envelope { session, id, message: Answer::Done };
                    self.answer_length = encode(&envelope, &mut self.answer).map_or(0, <[u8]>::len);
                    return self.stored();
                }
                (short(Answer::Refused(Refused::Busy), &mut self.short), false)
            }
            _ if self.current != Some(session) => {
                (short(Answer::Stranger { boot: identity.boot }, &mut self.short), false)
            }
            _ if id == self.last => {
                self.dropped.repeated = self.dropped.repeated.wrapping_add(1);
                return self.stored();
            }
            _ if id != self.last.wrapping_add(1) => return self.stale(),
            request => {
                self.last = id;
                let mut work = Work {
                    machine: &mut self.machine,
                    wires: self.wires,
                    stores: &mut self.stores,
                    stage: &mut self.stage,
                };
                let done = work.request(request);
                let wires = self.wires;
                self.answer_length = match done {
                    Done::Answer(message) => encode(&Envelope { session, id, message }, &mut self.answer),
                    Done::Stepped(cost) => wires.fetch(|sent, next| {
                        let is_at_work = wires.is_at_work.get();
                        let message = Answer::Stepped { cost, next, is_at_work, sent };
                        encode(&Envelope { session, id, message }, &mut self.answer)
                    }),
                }
                .map_or(0, <[u8]>::len);
                if matches!(request, Request::Bye) {
                    self.current = None;
                }
                return self.stored();
            }
        };
        self.short.get(..length).map(|bytes| Reply { bytes, resets })
    }

    /// Neither done nor answered.
    fn stale(&mut self) -> Option<Reply<'_>> {
        self.dropped.stale = self.dropped.stale.wrapping_add(1);
        None
    }

    /// The answer to the last request done.
    fn stored(&self) -> Option<Reply<'_>> {
        self.answer.get(..self.answer_length).map(|bytes| Reply { bytes, resets: false })
    }
}

fn welcome(identity: &Identity, [configuration_room, tile_room, plan_room]: [u32; 3]) -> Welcome<'static> {
    Welcome {
        version: VERSION,
        boot: identity.boot,
        core_clock_hz: identity.core_clock_hz,
        counts: identity.counts,
        piece_max: PIECE_MAX as u16,
        configuration_room,
        tile_room,
        plan_room,
        board: identity.board,
        firmware: env!("CARGO_PKG_VERSION"),
    }
}
