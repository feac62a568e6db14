//! What the program does while it has nothing to do.
//!
//! A wait for an instant takes no time at all: the clock is set forward. The emulator could do that itself (`-icount
//! sleep=off`), but its main loop then looks at the sleeping core before the last instructions are accounted for, and
//! now and then sets its clock a few instructions off. A wait for the world outside (a byte, the doorbell) takes real
//! time, which must not show: both timers stand. So the core never sleeps while a timer runs, and a program that is fed
//! the same bytes in the same steps sees the same instants.

use super::time_driver;
use crate::run::Pending;

/// What the clock does meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmulatedTime {
    /// It runs: the next alarm, if there is one, ends the wait at once.
    Runs,
    /// It stands: only the world outside can end the wait.
    Stands,
}

/// Waits for the next alarm or interrupt, unless a task is ready or `is_awake` says that there is something to do.
/// Interrupts are held off between that question and the sleep, in which a pending one ends it: none can slip through.
pub fn wait_for_interrupt(pending: &Pending, time: EmulatedTime, is_awake: impl Fn() -> bool) {
    cortex_m::interrupt::free(|_| {
        if pending.is_set() || is_awake() || (time == EmulatedTime::Runs && time_driver::skip_to_alarm()) {
            return;
        }
        time_driver::halt();
        cortex_m::asm::dsb();
        cortex_m::asm::wfi();
        time_driver::resume();
    });
}
