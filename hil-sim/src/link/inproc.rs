//! The application on the host: the firmware's own tasks on embassy's executor, in this process.

mod recorder;

pub use recorder::{Card, Log, RING};

use super::{Event, Flash, Link, LinkError, NO_REBOOT, Stores, tasks};
use embassy_executor::raw::Executor;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::pipeline::Memory;
use plumbline_core::stamp::{Edge, Polarity};
use plumbline_core::units::Ticks;
use plumbline_firmware::app::App;
use plumbline_firmware::board::{FrameStart, FrontEnd, Reader, Rows, Timer, Writer};
use plumbline_firmware::boot;
use plumbline_firmware::journal::{Journal, NoJournal};
use plumbline_firmware::log::card::area;
use plumbline_firmware::log::writer::write_out;
use plumbline_firmware::run::{self, Pending};
use plumbline_survey::error::InputError;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::future::poll_fn;
use std::task::{Poll, Waker};

/// A firmware in this process. Its tasks never end and embassy wants them for ever, so each flight leaks its
/// application, some tens of kilobytes, the tile and the plan.
#[allow(missing_debug_implementations, reason = "an executor has none")]
pub struct InProcess {
    executor: &'static Executor,
    pending: &'static Pending,
    wires: &'static Wires,
    log: Option<(&'static Log, Card)>,
}

/// What the board's parts share with the simulator.
#[derive(Default)]
struct Wires {
    timer: Cell<u32>,
    received: RefCell<VecDeque<u8>>,
    sent: RefCell<Vec<u8>>,
    pulse: Cell<Option<u32>>,
    edges: RefCell<VecDeque<Edge>>,
    frame: RefCell<Option<(FrameStart, Vec<u8>)>>,
    wakers: RefCell<Vec<Waker>>,
    /// State of a small generator, 0 on a tidy board.
    untidy: Cell<u32>,
}

impl Wires {
    /// Waits until `ready` gives something. Every step wakes every waiter: there are six, and it cannot forget one.
    async fn wait<T>(&self, mut ready: impl FnMut(&Self) -> Option<T>) -> T {
        poll_fn(|context| match ready(self) {
            Some(value) => Poll::Ready(value),
            None => {
                self.wakers.borrow_mut().push(context.waker().clone());
                Poll::Pending
            }
        })
        .await
    }

    fn wake(&self) {
        let mut wakers = self.wakers.take();
        for index in (1..wakers.len()).rev() {
            wakers.swap(index, index - self.any(index as u32 + 1) as usize);
        }
        for waker in wakers {
            waker.wake();
        }
    }

    /// A number below `bound` on an untidy board, else 0: xorshift32, good enough for disorder.
    fn any(&self, bound: u32) -> u32 {
        let mut x = self.untidy.get();
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        self.untidy.set(x);
        x % bound
    }
}

/// What an application works in, for as long as this process lasts; `frame_memory`: bytes of what stands for the frame.
pub(crate) fn memory(frame_memory: usize) -> Memory<'static> {
    Memory {
        buffers: Box::leak(Box::default()),
        navigation: Box::leak(Box::default()),
        frame: vec![0; frame_memory].leak(),
    }
}

impl InProcess {
    /// Boots the application with what lies in its flash.
    ///
    /// # Errors
    /// [`LinkError::Input`] for stores that the firmware refuses.
    pub fn new(flash: &Flash) -> Result<Self, LinkError> {
        Ok(Self::boot(&flash.stores()?, false))
    }

    /// As [`InProcess::new`], with a log beside it.
    ///
    /// # Errors
    /// [`LinkError::Input`].
    pub fn logged(flash: &Flash) -> Result<Self, LinkError> {
        Ok(Self::boot(&flash.stores()?, true))
    }

    /// Boots with these stores, as a board does: where they are refused the vehicle is grounded and says why.
    pub fn boot(stores: &Stores, is_logged: bool) -> Self {
        let pending: &'static Pending = Box::leak(Box::default());
        let executor: &'static Executor = Box::leak(Box::new(run::executor(pending)));
        // Tiles stay where they are, as in flash; of the configuration nothing is kept.
        let tiles: &'static [u8] = Box::leak(stores.tiles.clone().into_boxed_slice());
        let plan: &'static [u8] = Box::leak(stores.plan.clone().into_boxed_slice());
        let memory = memory(FRAME_MEMORY_BYTES);
        let log = is_logged.then(|| (&*Box::leak(Box::new(recorder::log(stores, tiles))), Card::default()));
        let journal: &'static dyn Journal = log.as_ref().map_or(&NoJournal, |(log, _)| *log);
        let link = InProcess { executor, pending, wires: Box::leak(Box::default()), log };
        if let Some((log, card)) = link.log.clone() {
            tasks::endless(executor, async move {
                let mut card = card;
                let Ok(area) = area(&mut card).await else { return };
                write_out(log, &mut card, area).await;
            });
        }
        let signing = boot::signing(&stores.key, 0);
        let known = signing.clone().ok().flatten();
        let flight = boot::read(&stores.configuration, tiles, plan);
        let signed = signing.and_then(|signing| Ok((signing, flight?)));
        match signed.and_then(|(signing, flight)| flight.app(memory, signing, journal)) {
            Ok(app) => link.fly(Box::leak(Box::new(app))),
            Err(reason) => tasks::spawn_grounded(executor, reason, known, Port(link.wires)),
        }
        link
    }

    /// The log's card; nothing without a log.
    pub fn card(&self) -> Option<&Card> {
        self.log.as_ref().map(|(_, card)| card)
    }

    /// Has this happen without letting the firmware work yet: [`Link::step`] does both.
    pub fn happen(&mut self, timer: u32, event: Event<'_>) {
        self.wires.timer.set(timer);
        match event {
            Event::Nothing => {}
            Event::Bytes(bytes) => self.wires.received.borrow_mut().extend(bytes),
            Event::Pulse(tick) => self.wires.pulse.set(Some(tick)),
            Event::Edge { tick, rising } => {
                let polarity = if rising { Polarity::Rising } else { Polarity::Falling };
                self.wires.edges.borrow_mut().push_back(Edge { at: Ticks(tick), polarity });
            }
            Event::Frame(frame) => {
                let arrival = Ticks(frame.arrival);
                let start = FrameStart { sequence: frame.sequence, arrival, size: frame.size };
                *self.wires.frame.borrow_mut() = Some((start, frame.pixels.to_vec()));
            }
        }
    }

    /// Lets the firmware work until nothing is left to do; what it sent.
    pub fn work(&mut self) -> Vec<u8> {
        self.wires.wake();
        run::until_idle(self.executor, self.pending);
        self.wires.sent.take()
    }

    /// Makes the board untidy, as interrupts do: its timer goes on while the firmware works, bytes come in portions, rows and
    /// sending let others work between them, and tasks are woken in any order. All of it follows from `seed`.
    pub fn untidy(&mut self, seed: u32) {
        self.wires.untidy.set(seed.max(1));
    }

    fn fly(&self, app: &'static App<'static>) {
        let front_end = HostFrontEnd { wires: self.wires, size: (0, 0), pixels: Vec::new(), row: 0 };
        tasks::spawn(self.executor, app, Port(self.wires), front_end);
    }
}

impl Link for InProcess {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        self.happen(timer, event);
        Ok(self.work())
    }

    fn reboot(&mut self, flash: &Flash) -> Result<(), LinkError> {
        if self.log.is_some() {
            return Err(LinkError::Input(InputError::new(NO_REBOOT)));
        }
        *self = InProcess::new(flash)?;
        Ok(())
    }

    fn annotate(&mut self, bytes: &[u8]) {
        if let Some((log, _)) = &self.log {
            log.annotate(bytes);
        }
    }

    fn close_log(&mut self) -> Vec<u8> {
        let Some((log, card)) = &self.log else { return Vec::new() };
        log.close();
        run::until_idle(self.executor, self.pending);
        card.bytes()
    }
}

/// Lets others work.
async fn others() {
    let mut has_waited = false;
    poll_fn(|context| {
        context.waker().wake_by_ref();
        if std::mem::replace(&mut has_waited, true) { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
}

/// Link and timer.
#[derive(Clone, Copy)]
struct Port(&'static Wires);

impl Reader for Port {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        self.0
            .wait(|wires| {
                let mut received = wires.received.borrow_mut();
                let whole = received.len().min(buffer.len());
                let count = if whole > 1 { whole - wires.any(whole as u32) as usize } else { whole };
                for (to, from) in buffer.iter_mut().zip(received.drain(..count)) {
                    *to = from;
                }
                (count > 0).then_some(count)
            })
            .await
    }
}

impl Writer for Port {
    async fn write(&mut self, bytes: &[u8]) {
        if self.0.any(3) == 1 {
            others().await;
        }
        self.0.sent.borrow_mut().extend_from_slice(bytes);
    }
}

impl Timer for Port {
    fn now(&self) -> Ticks {
        self.0.timer.set(self.0.timer.get().wrapping_add(self.0.any(5)));
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

/// The front end: all rows are there at once, the host has no row time.
struct HostFrontEnd {
    wires: &'static Wires,
    size: (u16, u16),
    pixels: Vec<u8>,
    row: usize,
}

impl FrontEnd for HostFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        let (start, pixels) = self.wires.wait(|wires| wires.frame.take()).await;
        (self.size, self.pixels, self.row) = (start.size, pixels, 0);
        start
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        if self.wires.any(20) == 1 {
            others().await;
        }
        let cols = self.size.0 as usize;
        let from = self.row * cols;
        self.row += count as usize;
        match self.pixels.get(from..self.row * cols) {
            Some(pixels) if cols > 0 => Rows::Pixels(pixels),
            _ => Rows::End,
        }
    }

    /// The simulator takes the exposure from the telemetry.
    fn expose(&mut self, us: u32) -> Option<u32> {
        Some(us)
    }
}
