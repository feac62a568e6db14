//! The board's interrupt vectors.

use super::{doorbell, time_driver, uart};
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;

/// The interrupts in use, by their number at the NVIC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
enum Interrupt {
    Uart0Received = 0,
    Uart1Received = 2,
    Timer0 = 8,
    Timer1 = 9,
}

// SAFETY: each number is a line of its own on this board and below the length of `__INTERRUPTS`.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn DefaultHandler();
}

/// Where the core jumps to. cortex-m-rt places it behind the exceptions; its `device` feature wants this name.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut vectors: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
    vectors[Interrupt::Uart0Received as usize] = uart0_received;
    vectors[Interrupt::Uart1Received as usize] = uart1_received;
    vectors[Interrupt::Timer0 as usize] = timer0;
    vectors[Interrupt::Timer1 as usize] = timer1;
    vectors
};

extern "C" fn uart0_received() {
    uart::on_received();
}

extern "C" fn uart1_received() {
    doorbell::on_received();
}

extern "C" fn timer0() {
    time_driver::on_wrap();
}

extern "C" fn timer1() {
    time_driver::on_alarm();
}

/// Lets the interrupts through to the core.
pub(super) fn enable() {
    for interrupt in [Interrupt::Uart0Received, Interrupt::Uart1Received, Interrupt::Timer0, Interrupt::Timer1] {
        // SAFETY: every handler is in place, and no critical section relies on a mask at the NVIC.
        unsafe { NVIC::unmask(interrupt) };
    }
}
