//! The parts of the board as the application sees them: the chip's own in flight, the simulator's wires in its mode. One
//! type for both, so that the application is in the image once.

use super::capture::CaptureTimer;
use super::counters::ChipCounters;
use super::front_end::DcmiFrontEnd;
use super::link;
use super::watchdog::marked;
use crate::board::{Board, FrameStart, FrontEnd, Reader, Rows, Timer, Writer};
use crate::h743::life::Watched;
use crate::serial::front_end::LineFrontEnd;
use crate::serial::wires::Port;
use crate::task_list::Task;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use plumbline_core::stamp::Edge;
use plumbline_core::units::Ticks;

/// Whose parts the application has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The chip's own.
    Flight,
    /// The simulator's wires.
    Simulator,
}

impl Board for Mode {
    type FrontEnd = BoardFrontEnd;
    type Reader = BoardReader;
    type Writer = BoardWriter;
    type Timer = BoardTimer;
    type Counters = ChipCounters;

    /// In the simulator's mode tasks work when the simulator steps them, and the line alone shows life.
    fn watched<F: Future>(self, task: Task, work: F) -> impl Future<Output = F::Output> {
        marked(Watched::Application(task), self == Mode::Flight, work)
    }
}

/// Receiving side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum BoardReader {
    /// In flight.
    Link(link::LinkReader),
    /// In the simulator's mode.
    Serial(Port),
}

/// Sending side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum BoardWriter {
    /// In flight.
    Link(link::LinkWriter),
    /// In the simulator's mode.
    Serial(Port),
}

impl Reader for BoardReader {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        match self {
            BoardReader::Link(line) => line.read(buffer).await,
            BoardReader::Serial(line) => line.read(buffer).await,
        }
    }
}

impl Writer for BoardWriter {
    async fn write(&mut self, bytes: &[u8]) {
        match self {
            BoardWriter::Link(line) => line.write(bytes).await,
            BoardWriter::Serial(line) => line.write(bytes).await,
        }
    }
}

/// The capture timer.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "holds wires")]
pub enum BoardTimer {
    /// In flight.
    Chip,
    /// In the simulator's mode.
    Serial(Port),
}

impl Timer for BoardTimer {
    fn now(&self) -> Ticks {
        match self {
            BoardTimer::Chip => CaptureTimer.now(),
            BoardTimer::Serial(port) => port.now(),
        }
    }

    async fn until(&mut self, at: Ticks) {
        match self {
            BoardTimer::Chip => CaptureTimer.until(at).await,
            BoardTimer::Serial(port) => port.until(at).await,
        }
    }

    async fn pulse(&mut self) -> Ticks {
        match self {
            BoardTimer::Chip => CaptureTimer.pulse().await,
            BoardTimer::Serial(port) => port.pulse().await,
        }
    }

    async fn edge(&mut self) -> Edge {
        match self {
            BoardTimer::Chip => CaptureTimer.edge().await,
            BoardTimer::Serial(port) => port.edge().await,
        }
    }
}

/// The camera's front end.
#[allow(missing_debug_implementations, reason = "holds buffers")]
pub enum BoardFrontEnd {
    /// In flight, where its sensor has woken: [`awake`].
    Chip(Option<DcmiFrontEnd>),
    /// In the simulator's mode.
    Serial(LineFrontEnd),
}

static AWAKE: Signal<CriticalSectionRawMutex, DcmiFrontEnd> = Signal::new();

/// Hands over the front end, once its sensor has woken.
pub fn awake(front_end: DcmiFrontEnd) {
    AWAKE.signal(front_end);
}

impl FrontEnd for BoardFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        match self {
            BoardFrontEnd::Chip(Some(front_end)) => front_end.frame().await,
            BoardFrontEnd::Chip(asleep) => asleep.insert(AWAKE.wait().await).frame().await,
            BoardFrontEnd::Serial(front_end) => front_end.frame().await,
        }
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        match self {
            BoardFrontEnd::Chip(Some(front_end)) => front_end.rows(count).await,
            BoardFrontEnd::Chip(None) => Rows::End,
            BoardFrontEnd::Serial(front_end) => front_end.rows(count).await,
        }
    }

    fn expose(&mut self, us: u32) -> Option<u32> {
        match self {
            BoardFrontEnd::Chip(front_end) => front_end.as_mut()?.expose(us),
            BoardFrontEnd::Serial(front_end) => front_end.expose(us),
        }
    }
}
