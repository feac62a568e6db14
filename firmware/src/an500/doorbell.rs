//! The doorbell: a byte on UART 1 says that a step is prepared in the shared memory, a byte back that it is done.

use super::serial::Serial;
use core::sync::atomic::{AtomicU32, Ordering};

// SAFETY: UART 1 of the board.
const UART: Serial = unsafe { Serial::new(0x4000_5000) };

/// Rings not yet taken.
static RINGS: AtomicU32 = AtomicU32::new(0);

/// Switches the UART on.
pub(super) fn start() {
    UART.start();
}

/// The receiver's interrupt.
pub(super) fn on_received() {
    UART.acknowledge();
    while UART.receive().is_some() {
        RINGS.fetch_add(1, Ordering::AcqRel);
    }
}

/// Whether somebody rang since the last [`take`].
pub fn has_rung() -> bool {
    RINGS.load(Ordering::Acquire) > 0
}

/// Takes one ring; whether there was one.
pub fn take() -> bool {
    RINGS.fetch_update(Ordering::AcqRel, Ordering::Acquire, |rings| rings.checked_sub(1)).is_ok()
}

/// Answers one ring.
pub fn answer() {
    UART.send(b'.');
}
