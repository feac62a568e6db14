//! The parts of the board as the application sees them: the chip's own in flight, the simulator's wires in its mode. One
//! type for both, so that the application is in the image once.

use super::camera::Camera;
use super::capture::CaptureTimer;
use super::link;
use crate::board::{FrameStart, FrontEnd, Reader, Rows, Timer, Writer};
use crate::serial::camera::Camera as Fed;
use crate::serial::wires::Port;
use plumbline_core::stamp::Edge;
use plumbline_core::units::Ticks;

/// Receiving side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum Receiver {
    /// In flight.
    Link(link::Receiver),
    /// In the simulator's mode.
    Serial(Port),
}

/// Sending side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum Sender {
    /// In flight.
    Link(link::Sender),
    /// In the simulator's mode.
    Serial(Port),
}

impl Reader for Receiver {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        match self {
            Receiver::Link(line) => line.read(buffer).await,
            Receiver::Serial(line) => line.read(buffer).await,
        }
    }
}

impl Writer for Sender {
    async fn write(&mut self, bytes: &[u8]) {
        match self {
            Sender::Link(line) => line.write(bytes).await,
            Sender::Serial(line) => line.write(bytes).await,
        }
    }
}

/// The capture timer.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "holds wires")]
pub enum Clock {
    /// In flight.
    Chip,
    /// In the simulator's mode.
    Serial(Port),
}

impl Timer for Clock {
    fn now(&self) -> Ticks {
        match self {
            Clock::Chip => CaptureTimer.now(),
            Clock::Serial(port) => port.now(),
        }
    }

    async fn until(&mut self, at: Ticks) {
        match self {
            Clock::Chip => CaptureTimer.until(at).await,
            Clock::Serial(port) => port.until(at).await,
        }
    }

    async fn pulse(&mut self) -> Ticks {
        match self {
            Clock::Chip => CaptureTimer.pulse().await,
            Clock::Serial(port) => port.pulse().await,
        }
    }

    async fn edge(&mut self) -> Edge {
        match self {
            Clock::Chip => CaptureTimer.edge().await,
            Clock::Serial(port) => port.edge().await,
        }
    }
}

/// The camera's front end.
#[allow(missing_debug_implementations, reason = "holds buffers")]
pub enum Eye {
    /// In flight.
    Chip(Camera),
    /// In the simulator's mode.
    Serial(Fed),
}

impl FrontEnd for Eye {
    async fn frame(&mut self) -> FrameStart {
        match self {
            Eye::Chip(camera) => camera.frame().await,
            Eye::Serial(camera) => camera.frame().await,
        }
    }

    async fn rows(&mut self, count: u16) -> Rows<'_> {
        match self {
            Eye::Chip(camera) => camera.rows(count).await,
            Eye::Serial(camera) => camera.rows(count).await,
        }
    }
}
