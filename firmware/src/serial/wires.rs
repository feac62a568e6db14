//! Link and capture timer as the application sees them, fed by the steps of the simulator.

use super::message::{Event, Next};
use super::{PIECE_MAX, SENT_MAX};
use crate::board::{FrameStart, Reader, Timer, Writer};
use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::task::Poll;
use embassy_sync::waitqueue::MultiWakerRegistration;
use heapless::{Deque, Vec};
use plumbline_core::stamp::{Edge, Polarity};
use plumbline_core::units::Ticks;

/// Edges that may wait for the application; a step brings one.
const EDGES_MAX: usize = 8;
/// Tasks that may wait: one a stream, and some to spare.
const TASKS_MAX: usize = 8;

/// What the steps deliver and what they fetch. Lives for ever, used by one thread.
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct Wires {
    timer: Cell<u32>,
    received: RefCell<Taken>,
    sent: RefCell<Sent>,
    pulse: Cell<Option<u32>>,
    edges: RefCell<Deque<Edge, EDGES_MAX>>,
    /// A frame that has begun and that the application has not yet taken.
    pub(super) frame: Cell<Option<FrameStart>>,
    /// Rows that the application waits for: frame, and pixels taken of it.
    pub(super) wanted: Cell<Option<(u32, u32)>>,
    /// Rows just delivered.
    pub(super) rows: RefCell<Taken>,
    /// Whether the application works on a frame.
    pub(super) is_at_work: Cell<bool>,
    pub(super) overruns: Cell<u32>,
    wakers: RefCell<MultiWakerRegistration<TASKS_MAX>>,
}

/// Bytes that are taken from the front.
#[derive(Debug, Default)]
pub(super) struct Taken {
    bytes: Vec<u8, PIECE_MAX>,
    at: usize,
}

impl Taken {
    const fn new() -> Self {
        Taken { bytes: Vec::new(), at: 0 }
    }

    /// Replaces what was there by `bytes`; more than fit are dropped, which a frame's length rules out.
    pub(super) fn fill(&mut self, bytes: &[u8]) {
        self.bytes.clear();
        self.at = 0;
        // The messages' receiver takes no longer ones.
        let _ = self.bytes.extend_from_slice(bytes);
    }

    /// Moves what there is and fits into `buffer`; how much.
    pub(super) fn take(&mut self, buffer: &mut [u8]) -> usize {
        let rest = self.bytes.get(self.at..).unwrap_or(&[]);
        let count = rest.len().min(buffer.len());
        for (to, from) in buffer.iter_mut().zip(rest) {
            *to = *from;
        }
        self.at += count;
        count
    }
}

/// What the application sent and nobody fetched.
#[derive(Debug)]
struct Sent {
    bytes: [u8; SENT_MAX],
    from: usize,
    to: usize,
}

impl Sent {
    /// Takes what fits of `bytes`; how much.
    fn push(&mut self, bytes: &[u8]) -> usize {
        if self.to + bytes.len() > SENT_MAX {
            self.bytes.copy_within(self.from..self.to, 0);
            (self.from, self.to) = (0, self.to - self.from);
        }
        let free = self.bytes.get_mut(self.to..).unwrap_or(&mut []);
        let count = bytes.len().min(free.len());
        for (to, from) in free.iter_mut().zip(bytes) {
            *to = *from;
        }
        self.to += count;
        count
    }
}

impl Wires {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        Wires {
            timer: Cell::new(0),
            received: RefCell::new(Taken::new()),
            sent: RefCell::new(Sent { bytes: [0; SENT_MAX], from: 0, to: 0 }),
            pulse: Cell::new(None),
            edges: RefCell::new(Deque::new()),
            frame: Cell::new(None),
            wanted: Cell::new(None),
            rows: RefCell::new(Taken::new()),
            is_at_work: Cell::new(false),
            overruns: Cell::new(0),
            wakers: RefCell::new(MultiWakerRegistration::new()),
        }
    }

    /// Rows lost, for a board's counters.
    pub fn overruns(&self) -> u32 {
        self.overruns.get()
    }

    /// Waits until `ready` gives something. Every step wakes every waiter: there are six, and it cannot forget one.
    pub(super) async fn wait<T>(&self, mut ready: impl FnMut(&Self) -> Option<T>) -> T {
        poll_fn(|context| match ready(self) {
            Some(value) => Poll::Ready(value),
            None => {
                self.wakers.borrow_mut().register(context.waker());
                Poll::Pending
            }
        })
        .await
    }

    /// Lets a step happen.
    pub(super) fn step(&self, timer: u32, event: Event<'_>) {
        self.timer.set(timer);
        match event {
            Event::Nothing => {}
            Event::Bytes(bytes) => self.received.borrow_mut().fill(bytes),
            Event::Pulse(tick) => self.pulse.set(Some(tick)),
            Event::Edge { tick, rising } => {
                let polarity = if rising { Polarity::Rising } else { Polarity::Falling };
                // A ring that nobody empties loses edges as a timer's would.
                let _ = self.edges.borrow_mut().push_back(Edge { at: Ticks(tick), polarity });
            }
            Event::Frame { sequence, arrival, size } => {
                self.frame.set(Some(FrameStart { sequence, arrival: Ticks(arrival), size }));
            }
        }
        self.wake();
    }

    /// Lets rows arrive; whether they are the ones waited for.
    pub(super) fn deliver(&self, sequence: u32, offset: u32, bytes: &[u8]) -> bool {
        if bytes.is_empty() || self.wanted.get() != Some((sequence, offset)) {
            return false;
        }
        self.wanted.set(None);
        self.rows.borrow_mut().fill(bytes);
        self.wake();
        true
    }

    /// Fetches what the application sent, a piece of it, with what comes next.
    pub(super) fn fetch<R>(&self, with: impl FnOnce(&[u8], Next) -> R) -> R {
        let sent = &mut *self.sent.borrow_mut();
        let end = sent.to.min(sent.from + PIECE_MAX);
        let next = match (end < sent.to, self.wanted.get()) {
            (true, _) => Next::More,
            (false, Some((sequence, offset))) => Next::Rows { sequence, offset },
            (false, None) => Next::Idle,
        };
        let result = with(sent.bytes.get(sent.from..end).unwrap_or(&[]), next);
        sent.from = end;
        result
    }

    pub(super) fn wake(&self) {
        self.wakers.borrow_mut().wake();
    }
}

impl Default for Wires {
    fn default() -> Self {
        Self::new()
    }
}

/// Link and capture timer.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct Port(pub &'static Wires);

impl Reader for Port {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        self.0
            .wait(|wires| {
                let count = wires.received.borrow_mut().take(buffer);
                (count > 0).then_some(count)
            })
            .await
    }
}

impl Writer for Port {
    async fn write(&mut self, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let count = self
                .0
                .wait(|wires| {
                    let count = wires.sent.borrow_mut().push(rest);
                    (count > 0).then_some(count)
                })
                .await;
            rest = rest.get(count..).unwrap_or(&[]);
        }
    }
}

impl Timer for Port {
    fn now(&self) -> Ticks {
        Ticks(self.0.timer.get())
    }

    async fn until(&mut self, at: Ticks) {
        self.0.wait(|wires| (Ticks(wires.timer.get()).since(at) >= 0).then_some(())).await;
    }

    async fn pulse(&mut self) -> Ticks {
        Ticks(self.0.wait(|wires| wires.pulse.take()).await)
    }

    async fn edge(&mut self) -> Edge {
        self.0.wait(|wires| wires.edges.borrow_mut().pop_front()).await
    }
}
