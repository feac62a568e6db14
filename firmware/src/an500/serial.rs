//! A CMSDK UART: one byte of buffer each way.

use super::registers::Register;

/// STATE: the transmitter's buffer is taken; the receiver's is.
const TRANSMIT_FULL: u32 = 1 << 0;
const RECEIVE_FULL: u32 = 1 << 1;
/// CTRL: both directions on, an interrupt for each byte received.
const ENABLE: u32 = 1 << 0 | 1 << 1 | 1 << 3;
/// INTSTATUS: the receiver's.
const RECEIVED: u32 = 1 << 1;
/// The smallest divider there is: emulated bytes take no time on the line.
const DIVIDER: u32 = 16;

/// One of the board's UARTs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Serial {
    data: Register,
    state: Register,
    control: Register,
    interrupt: Register,
    divider: Register,
}

impl Serial {
    /// The UART at `base`.
    ///
    /// # Safety
    /// `base` is that of a CMSDK UART.
    pub(super) const unsafe fn new(base: usize) -> Self {
        // SAFETY: the caller promised the UART; these are its registers.
        unsafe {
            Serial {
                data: Register::new(base),
                state: Register::new(base + 0x04),
                control: Register::new(base + 0x08),
                interrupt: Register::new(base + 0x0c),
                divider: Register::new(base + 0x10),
            }
        }
    }

    /// Switches it on.
    pub(super) fn start(self) {
        self.divider.write(DIVIDER);
        self.control.write(ENABLE);
    }

    /// Takes back the interrupt request. To be done before [`Serial::receive`], or a byte that comes between the two
    /// would go unnoticed.
    pub(super) fn acknowledge(self) {
        self.interrupt.write(RECEIVED);
    }

    /// The byte in the receiver, if any. The sender is held back as long as it stays there.
    pub(super) fn receive(self) -> Option<u8> {
        (self.state.read() & RECEIVE_FULL != 0).then(|| self.data.read() as u8)
    }

    /// Sends a byte. Waits for the one before to leave, which takes long only if nobody reads at the other end.
    pub(super) fn send(self, byte: u8) {
        while self.state.read() & TRANSMIT_FULL != 0 {}
        self.data.write(u32::from(byte));
    }
}
