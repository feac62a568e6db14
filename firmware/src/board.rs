//! What a board must be able to do. The application knows nothing else of it.

use crate::task_list::Task;
use plumbline_core::stamp::Edge;
use plumbline_core::units::Ticks;

/// A frame whose first row has arrived; the others follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameStart {
    /// Number of the frame, counted by the front end from 0: a jump is a frame that was lost.
    pub sequence: u32,
    /// When its first row arrived.
    pub arrival: Ticks,
    /// Size the sensor delivers, (cols, rows).
    pub size: (u16, u16),
}

/// What the front end has to say to a request for rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows<'a> {
    /// The next rows' pixels, one row behind the other.
    Pixels(&'a [u8]),
    /// Not so many rows are left.
    End,
    /// A row was overwritten before it was read.
    Overrun,
}

/// The camera's front end: rows as the sensor delivers them.
#[allow(async_fn_in_trait, reason = "one executor, one thread: futures need not be Send")]
pub trait FrontEnd {
    /// Waits for the next frame's first row.
    async fn frame(&mut self) -> FrameStart;
    /// Waits for the frame's next `count` rows, a small part of its ring.
    async fn rows(&mut self, count: u16) -> Rows<'_>;
    /// Has the sensor expose for `us` from the frame on that comes [`LATENCY_FRAMES`] after the newest, while the next one has
    /// not begun; returns at once. What the sensor makes of it, whole microseconds; nothing where the board cannot.
    ///
    /// [`LATENCY_FRAMES`]: plumbline_core::auto_exposure::LATENCY_FRAMES
    fn expose(&mut self, us: u32) -> Option<u32>;
}

/// Where received bytes come from.
#[allow(async_fn_in_trait, reason = "one executor, one thread: futures need not be Send")]
pub trait Reader {
    /// Waits for bytes and moves at least one into `buffer`.
    async fn read(&mut self, buffer: &mut [u8]) -> usize;
}

/// Where bytes are sent to.
#[allow(async_fn_in_trait, reason = "one executor, one thread: futures need not be Send")]
pub trait Writer {
    /// Sends all of `bytes`.
    async fn write(&mut self, bytes: &[u8]);
}

/// The capture timer.
#[allow(async_fn_in_trait, reason = "one executor, one thread: futures need not be Send")]
pub trait Timer {
    /// Its reading now.
    fn now(&self) -> Ticks;
    /// Waits until it has passed `at`.
    async fn until(&mut self, at: Ticks);
    /// Waits for the next pulse per second; the tick it was latched at.
    async fn pulse(&mut self) -> Ticks;
    /// Waits for the next edge of the shutter's line, in the order in which they were latched and as they were: bounces
    /// and all.
    async fn edge(&mut self) -> Edge;
}

/// What the board counts of itself, for telemetry.
pub trait PerformanceCounters {
    /// Runs `work`, undisturbed by receive interrupts where the board can hold them off; its result, and its cost in the
    /// board's own unit: instructions on the emulated board, cycles of the core on the flight computer, 0 on the host.
    fn counted<R>(&self, work: impl FnOnce() -> R) -> (R, u32);
    /// Rows lost to overruns since start.
    fn overruns(&self) -> u32;
    /// Bytes of RAM: static, and the stack's high-water mark. Zeros where the board does not know.
    fn memory(&self) -> (u32, u32);
}

/// A board: what each of its parts is, and its watchdog. Parts that several tasks use are copied.
pub trait Board: Copy + 'static {
    /// Camera front end.
    type FrontEnd: FrontEnd + 'static;
    /// Receiving side of the link.
    type Reader: Reader + 'static;
    /// Sending side of the link.
    type Writer: Writer + 'static;
    /// Capture timer.
    type Timer: Timer + Copy + 'static;
    /// Performance counters.
    type Counters: PerformanceCounters + Copy + 'static;

    /// Does a task's work as the board's watchdog wants it, where it has one.
    fn watched<F: Future>(self, _: Task, work: F) -> impl Future<Output = F::Output> {
        work
    }
}

/// The parts of a board.
#[allow(missing_debug_implementations, reason = "drivers have none")]
pub struct Parts<B: Board> {
    /// The board itself.
    pub board: B,
    /// Camera front end.
    pub front_end: B::FrontEnd,
    /// Receiving side of the link.
    pub reader: B::Reader,
    /// Sending side of the link.
    pub writer: B::Writer,
    /// Capture timer.
    pub timer: B::Timer,
    /// Performance counters.
    pub counters: B::Counters,
}
