//! Which requests are done, repeated or refused, and their answers.

use super::super::frame::encode;
use super::super::message::{Answer, Envelope, Refused, Request, Welcome};
use super::super::stores::Stores;
use super::super::wires::Wires;
use super::super::{FRAME_MAX, PIECE_MAX, SHORT_MAX, VERSION};
use super::work::{Done, Stage, Work};
use super::{Dropped, Identity, Machine, Reply};

/// The session with one host, and the answer that it may ask for once more.
pub(super) struct Dialogue<M> {
    machine: M,
    wires: &'static Wires,
    stores: Stores,
    capacities: [u32; 4],
    stage: Stage,
    current: Option<u32>,
    /// The last request done, and how long its answer is.
    last: u32,
    answer: [u8; FRAME_MAX],
    answer_length: usize,
    /// Answers that belong to no session.
    short: [u8; SHORT_MAX],
    pub(super) dropped: Dropped,
}

impl<M: Machine> Dialogue<M> {
    pub(super) fn new(machine: M, wires: &'static Wires, stores: Stores) -> Self {
        Dialogue {
            machine,
            wires,
            capacities: stores.capacities(),
            stores,
            stage: Stage::Loading,
            current: None,
            last: 0,
            answer: [0; FRAME_MAX],
            answer_length: 0,
            short: [0; SHORT_MAX],
            dropped: Dropped::default(),
        }
    }

    /// What arrived is no request.
    pub(super) fn bad(&mut self) -> Option<Reply<'_>> {
        self.dropped.bad = self.dropped.bad.wrapping_add(1);
        None
    }

    pub(super) fn reply(&mut self, request: Envelope<Request<'_>>) -> Option<Reply<'_>> {
        let Envelope { session, id, message } = request;
        let identity = self.machine.identity();
        let mut resets = false;
        let answer = match message {
            // The welcome of another version would be misread, but its version is in the part that never changes.
            Request::Hello { .. } => Answer::Welcome(welcome(&identity, self.capacities)),
            Request::Reset { boot } if boot == identity.boot => {
                resets = true;
                Answer::Done
            }
            // It was meant for the boot before this one.
            Request::Reset { .. } => return self.stale(),
            Request::Open if self.current != Some(session) && id == 1 => {
                if self.stage == Stage::Loading {
                    return self.open(session, id);
                }
                Answer::Refused(Refused::Busy)
            }
            _ if self.current != Some(session) => Answer::Stranger { boot: identity.boot },
            _ if id == self.last => {
                self.dropped.repeated = self.dropped.repeated.wrapping_add(1);
                return self.stored();
            }
            _ if id != self.last.wrapping_add(1) => return self.stale(),
            request => return self.done(session, id, request),
        };
        let length = encode(&Envelope { session, id, message: answer }, &mut self.short).map_or(0, <[u8]>::len);
        self.short.get(..length).map(|bytes| Reply { bytes, resets })
    }

    /// Begins a session.
    fn open(&mut self, session: u32, id: u32) -> Option<Reply<'_>> {
        self.stores.clear();
        (self.current, self.last) = (Some(session), id);
        let envelope = Envelope { session, id, message: Answer::Done };
        self.answer_length = encode(&envelope, &mut self.answer).map_or(0, <[u8]>::len);
        self.stored()
    }

    /// Does the session's next request.
    fn done(&mut self, session: u32, id: u32, request: Request<'_>) -> Option<Reply<'_>> {
        self.last = id;
        let wires = self.wires;
        let mut work = Work { machine: &mut self.machine, wires, stores: &mut self.stores, stage: &mut self.stage };
        self.answer_length = match work.request(request) {
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
        self.stored()
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

fn welcome(identity: &Identity, capacities: [u32; 4]) -> Welcome<'static> {
    let [configuration_capacity, tile_capacity, plan_capacity, key_capacity] = capacities;
    Welcome {
        version: VERSION,
        boot: identity.boot,
        core_clock_hz: identity.core_clock_hz,
        counts: identity.counts,
        piece_max: PIECE_MAX as u16,
        configuration_capacity,
        tile_capacity,
        plan_capacity,
        key_capacity,
        board: identity.board,
        firmware: env!("CARGO_PKG_VERSION"),
    }
}
