//! The board as the application sees it: a simulated camera front end, the link and the capture timer, all fed by
//! the steps of the simulator. See [`crate::shared_memory`] for the registers.

use super::{psram, stack, time_driver, uart};
use crate::board::{Board, FrameStart, FrontEnd, PerformanceCounters, Reader, Rows, Timer, Writer};
use crate::shared_memory as at;
use core::cell::Cell;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use plumbline_core::stamp::{Edge, Polarity};
use plumbline_core::units::Ticks;

/// A register; the offsets are constants inside the window.
fn register(offset: usize) -> u32 {
    psram::word(offset).unwrap_or(0)
}

/// What the steps deliver, and who waits for it. Lives for ever, used by one thread.
#[derive(Default)]
#[allow(missing_debug_implementations, reason = "embassy-sync's primitives have none")]
pub struct LockstepPeripherals {
    stepped: Signal<NoopRawMutex, ()>,
    pulse: Signal<NoopRawMutex, Ticks>,
    edge: Signal<NoopRawMutex, ()>,
    frame: Signal<NoopRawMutex, Incoming>,
    seen_edges: Cell<u32>,
    seen_pulses: Cell<u32>,
    seen_frames: Cell<u32>,
    overruns: Cell<u32>,
}

/// A frame about to be read out.
#[derive(Clone, Copy)]
struct Incoming {
    start: FrameStart,
    /// When its first row begins to arrive, on the emulator's clock.
    since: Instant,
}

impl LockstepPeripherals {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        LockstepPeripherals {
            stepped: Signal::new(),
            pulse: Signal::new(),
            edge: Signal::new(),
            frame: Signal::new(),
            seen_edges: Cell::new(0),
            seen_pulses: Cell::new(0),
            seen_frames: Cell::new(0),
            overruns: Cell::new(0),
        }
    }

    /// Whether every byte of the step has been received and read.
    pub fn has_all_bytes() -> bool {
        uart::received_total() == register(at::RECEIVED_TOTAL) && !uart::has_unread()
    }

    /// Lets the step's edges and frame happen.
    pub fn step(&self) {
        if self.seen_pulses.replace(register(at::PULSES)) != register(at::PULSES) {
            self.pulse.signal(Ticks(register(at::PULSE_TICK)));
        }
        if self.seen_edges.get() != register(at::EDGES) {
            self.edge.signal(());
        }
        if self.seen_frames.replace(register(at::FRAMES)) != register(at::FRAMES) {
            let arrival = Ticks(register(at::FRAME_ARRIVAL));
            let size = (register(at::FRAME_COLS) as u16, register(at::FRAME_ROWS) as u16);
            let start = FrameStart { sequence: register(at::FRAME_SEQUENCE), arrival, size };
            self.frame.signal(Incoming { start, since: Instant::now() });
        }
        self.stepped.signal(());
    }

    /// The next edge that has been latched. Those that the ring has lost are passed over.
    fn next_edge(&self) -> Option<Edge> {
        let waiting = register(at::EDGES).wrapping_sub(self.seen_edges.get());
        if waiting == 0 {
            return None;
        }
        let number = register(at::EDGES).wrapping_sub(waiting.min(at::EDGE_RING as u32));
        self.seen_edges.set(number.wrapping_add(1));
        let address = at::EDGE_WORDS + number as usize % at::EDGE_RING * 8;
        let polarity = if register(address + 4) == 1 { Polarity::Rising } else { Polarity::Falling };
        Some(Edge { at: Ticks(register(address)), polarity })
    }
}

/// The front end: a row can be read once the sensor has delivered it, and until the ring of rows comes round again.
#[allow(missing_debug_implementations, reason = "holds a LockstepPeripherals")]
pub struct EmulatedFrontEnd {
    peripherals: &'static LockstepPeripherals,
    frame: Option<Incoming>,
    row: u32,
}

impl EmulatedFrontEnd {
    /// The one front end.
    pub fn new(peripherals: &'static LockstepPeripherals) -> Self {
        EmulatedFrontEnd { peripherals, frame: None, row: 0 }
    }
}

impl FrontEnd for EmulatedFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        let incoming = self.peripherals.frame.wait().await;
        (self.frame, self.row) = (Some(incoming), 0);
        incoming.start
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        let Some(incoming) = &self.frame else { return Rows::End };
        let (cols, rows) = (incoming.start.size.0 as usize, incoming.start.size.1 as u32);
        let (first, end) = (self.row, self.row + count as u32);
        if end > rows {
            return Rows::End;
        }
        let row_time_ns = register(at::ROW_TIME_NS) as u64;
        let arrives_us = |row: u32| incoming.since.as_micros() + (row as u64 * row_time_ns).div_ceil(1000);
        // Row r is whole when r + 1 row times have passed, and overwritten a ring later.
        embassy_time::Timer::at(Instant::from_micros(arrives_us(end))).await;
        if Instant::now().as_micros() > arrives_us(first + 1 + register(at::RING_ROWS)) {
            self.peripherals.overruns.set(self.peripherals.overruns.get() + 1);
            return Rows::Overrun;
        }
        let offset = at::FRAME + first as usize * cols;
        self.row = end;
        // SAFETY: the simulator changes the frame only between steps, and the application does not keep rows.
        match unsafe { psram::bytes(offset, count as usize * cols) } {
            Some(pixels) => Rows::Pixels(pixels),
            None => Rows::End,
        }
    }

    /// The simulator takes the exposure from the telemetry.
    fn expose(&mut self, us: u32) -> Option<u32> {
        Some(us)
    }
}

/// Link and capture timer.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "holds a LockstepPeripherals")]
pub struct Port(pub &'static LockstepPeripherals);

/// The board behind the steps.
#[derive(Clone, Copy, Debug)]
pub struct Lockstep;

impl Board for Lockstep {
    type FrontEnd = EmulatedFrontEnd;
    type Reader = Port;
    type Writer = Port;
    type Timer = Port;
    type Counters = Port;
}

impl Reader for Port {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        uart::read(buffer).await
    }
}

impl Writer for Port {
    async fn write(&mut self, bytes: &[u8]) {
        uart::write(bytes);
    }
}

impl Timer for Port {
    fn now(&self) -> Ticks {
        Ticks(register(at::TIMER))
    }

    async fn until(&mut self, at: Ticks) {
        while self.now().since(at) < 0 {
            self.0.stepped.wait().await;
        }
    }

    async fn pulse(&mut self) -> Ticks {
        self.0.pulse.wait().await
    }

    async fn edge(&mut self) -> Edge {
        loop {
            if let Some(edge) = self.0.next_edge() {
                return edge;
            }
            self.0.edge.wait().await;
        }
    }
}

impl PerformanceCounters for Port {
    fn counted<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        time_driver::measured(work)
    }

    fn overruns(&self) -> u32 {
        self.0.overruns.get()
    }

    fn memory(&self) -> (u32, u32) {
        (stack::static_bytes(), stack::high_water_bytes())
    }
}
