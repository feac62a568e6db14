//! The vehicle's link: UART 0, received by interrupt into a ring.
//!
//! When the ring is full the newest byte stays in the receiver, which makes the emulator hold back the sender. So no
//! byte is ever lost, and no interrupt comes until a reader has taken some.

use super::byte_ring::ByteRing;
use super::serial::Serial;
use core::future::poll_fn;
use core::task::Poll;

// SAFETY: UART 0 of the board.
const UART: Serial = unsafe { Serial::new(0x4000_4000) };

static RECEIVED: ByteRing = ByteRing::new();

/// Switches the UART on.
pub(super) fn start() {
    UART.start();
}

/// The receiver's interrupt.
pub(super) fn on_received() {
    UART.acknowledge();
    RECEIVED.fill(|| UART.receive());
}

/// Waits for bytes and moves as many as there are and fit into `buffer`; how many: at least one, unless `buffer` is
/// empty.
pub async fn read(buffer: &mut [u8]) -> usize {
    poll_fn(|context| {
        RECEIVED.register(context.waker());
        let count = RECEIVED.take(buffer);
        // The byte that found the ring full raised its interrupt then and will not do so again.
        RECEIVED.fill(|| UART.receive());
        if count > 0 || buffer.is_empty() { Poll::Ready(count) } else { Poll::Pending }
    })
    .await
}

/// Sends all of `bytes`; returns when the last one has been handed to the transmitter.
pub fn write(bytes: &[u8]) {
    for &byte in bytes {
        UART.send(byte);
    }
}

/// Bytes received since start, wrapping: all that left the receiver, read by a task or not.
pub fn received_total() -> u32 {
    RECEIVED.total()
}

/// Whether received bytes wait for a reader.
pub fn has_unread() -> bool {
    !RECEIVED.is_empty()
}
