//! The line to the autopilot: its own port in flight, USB in the simulator's hands.

use super::{link, usb};
use crate::board::{Reader, Writer};

/// Receiving side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum Receiver {
    /// In flight.
    Link(link::Receiver),
    /// In the simulator's hands.
    Usb(usb::Receiver),
}

/// Sending side.
#[allow(missing_debug_implementations, reason = "drivers")]
pub enum Sender {
    /// In flight.
    Link(link::Sender),
    /// In the simulator's hands.
    Usb(usb::Sender),
}

impl Reader for Receiver {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        match self {
            Receiver::Link(line) => line.read(buffer).await,
            Receiver::Usb(line) => line.read(buffer).await,
        }
    }
}

impl Writer for Sender {
    async fn write(&mut self, bytes: &[u8]) {
        match self {
            Sender::Link(line) => line.write(bytes).await,
            Sender::Usb(line) => line.write(bytes).await,
        }
    }
}
