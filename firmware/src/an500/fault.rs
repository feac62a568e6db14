//! The end of a program that cannot go on: says why on the emulator's standard error and exits with 1.
//!
//! Plain text goes to standard error, since standard output carries defmt's frames.

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::eprintln;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    eprintln!("firmware: {info}");
    super::exit(false)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    eprintln!("firmware: hard fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr());
    super::exit(false)
}

#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    eprintln!("firmware: interrupt {number} has no handler");
    super::exit(false)
}
