//! What a request has done.

use super::super::message::{Answer, Refused, Request};
use super::super::stores::Stores;
use super::super::wires::Wires;
use super::Machine;

/// How far the board is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// No application yet.
    Loading,
    /// An application flies.
    Flying,
    /// An application was tried, or its session is over.
    Spent,
}

/// What came of a request.
pub(super) enum Done {
    Answer(Answer<'static>),
    /// The application worked, at this cost.
    Stepped(u32),
}

/// What a request may touch: all but the message itself and its answer.
pub(super) struct Work<'s, M> {
    pub machine: &'s mut M,
    pub wires: &'static Wires,
    pub stores: &'s mut Stores,
    pub stage: &'s mut Stage,
}

impl<M: Machine> Work<'_, M> {
    pub fn request(&mut self, request: Request<'_>) -> Done {
        let answer =
            |result: Result<(), Refused<'static>>| Done::Answer(result.map_or_else(Answer::Refused, |()| Answer::Done));
        match (*self.stage, request) {
            (Stage::Loading, Request::Announce { store, bytes, crc }) => {
                answer(self.stores.announce(store, bytes, crc))
            }
            (Stage::Loading, Request::Piece { store, offset, bytes }) => {
                answer(self.stores.piece(store, offset, bytes))
            }
            (Stage::Loading, Request::Start) => answer(self.start()),
            (Stage::Flying, Request::Step { timer, event }) => {
                self.wires.step(timer, event);
                self.run()
            }
            // Rows that nobody waits for are passed over: the answer says what is wanted.
            (Stage::Flying, Request::Rows { sequence, offset, bytes }) => {
                self.wires.deliver(sequence, offset, bytes);
                self.run()
            }
            (Stage::Flying, Request::Continue) => {
                self.wires.wake();
                self.run()
            }
            (_, Request::Bye) => {
                if *self.stage == Stage::Flying {
                    *self.stage = Stage::Spent;
                }
                answer(Ok(()))
            }
            (Stage::Spent, _) => answer(Err(Refused::Busy)),
            _ => answer(Err(Refused::Order)),
        }
    }

    fn start(&mut self) -> Result<(), Refused<'static>> {
        let uploaded = self.stores.hand_over()?;
        *self.stage = Stage::Spent;
        self.machine.boot(uploaded, self.wires).map_err(Refused::Boot)?;
        *self.stage = Stage::Flying;
        Ok(())
    }

    fn run(&mut self) -> Done {
        let before = self.machine.count();
        self.machine.run();
        Done::Stepped(self.machine.count().wrapping_sub(before))
    }
}
