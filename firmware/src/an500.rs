//! The emulated board: QEMU's `mps2-an500`, a Cortex-M7 with FPU and DSP instructions at 25 MHz peripheral clock.
//!
//! | module | what |
//! |---|---|
//! | [`time_driver`] | embassy's clock and alarm on two CMSDK timers |
//! | [`uart`] | the vehicle's link on UART 0 |
//! | [`doorbell`] | the simulator's knock on UART 1 |
//! | [`lockstep`] | camera, link and capture timer as the application sees them |
//! | [`line`] | the simulator's line on UART 0, for the image that is fed by nothing else |
//! | [`instructions`] | what a piece of work costs |
//! | [`psram`] | the memory shared with the simulator |
//! | [`idle`] | waiting, with the clock running or standing |
//! | [`stack`] | what RAM is in use |
//! | [`fault`] | panics and hard faults end the emulation with a failure |
//!
//! Nothing here knows the application. Emulated time is a function of executed instructions (`-icount shift=1`: 2 ns
//! each); see [`idle`] for what happens when there is nothing to execute.

pub mod doorbell;
pub mod fault;
pub mod lockstep;
pub mod idle;
pub mod instructions;
pub mod line;
pub mod psram;
pub mod byte_ring;
pub mod stack;
pub mod time_driver;
pub mod uart;

mod interrupts;
mod registers;
mod serial;

use core::sync::atomic::{AtomicBool, Ordering};
#[cfg(feature = "defmt")]
use defmt_semihosting as _;

#[cfg(feature = "defmt")]
defmt::timestamp!("{=u64:us}", embassy_time_driver::now());

/// Peripheral clock: timers count at this rate, whatever the core does.
pub const PERIPHERAL_HZ: u32 = 25_000_000;

/// Instructions in a count of a timer under `-icount shift=1`: 40 ns of 2 ns each.
pub const INSTRUCTIONS_PER_COUNT: u32 = 20;

/// Starts timers, UARTs and their interrupts. Calls after the first do nothing.
pub fn start() {
    static STARTED: AtomicBool = AtomicBool::new(false);
    if !STARTED.swap(true, Ordering::AcqRel) {
        time_driver::start();
        uart::start();
        doorbell::start();
        interrupts::enable();
    }
}

/// Ends the emulation: exit code 0 or 1.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}
