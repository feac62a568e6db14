//! Access to a peripheral's registers, which change by themselves.

use core::ptr::{read_volatile, write_volatile};

/// A 32-bit register of the board.
#[derive(Clone, Copy, Debug)]
pub(super) struct Register(usize);

impl Register {
    /// The register at `address`.
    ///
    /// # Safety
    /// `address` is that of a 32-bit register of this board, and no Rust object lies there.
    pub(super) const unsafe fn new(address: usize) -> Self {
        Register(address)
    }

    /// Its value now.
    pub(super) fn read(self) -> u32 {
        // SAFETY: `new`'s caller promised a register here; reading one is sound at any time.
        unsafe { read_volatile(self.0 as *const u32) }
    }

    /// Sets it.
    pub(super) fn write(self, value: u32) {
        // SAFETY: `new`'s caller promised a register here; none of those used moves memory.
        unsafe { write_volatile(self.0 as *mut u32, value) }
    }
}
