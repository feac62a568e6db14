//! Sleeping until an interrupt.
//!
//! Under `-icount sleep=off` the emulator's clock jumps to the next timer event as soon as the core sleeps. That is what
//! a wait for an instant should do. A wait for the world outside (a byte, the doorbell) takes real time, which must not
//! show: then the clock stands.

use super::time_driver;
use crate::run::Pending;

/// What the clock does meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// It runs: an alarm may end the sleep. It stands all the same where no alarm is scheduled.
    Runs,
    /// It stands: only the world outside can end the sleep.
    Stands,
}

/// Sleeps until the next interrupt, unless a task is ready or `is_awake` says that there is something to do. Interrupts
/// are held off between that question and the sleep, in which a pending one ends it: none can slip through.
pub fn wait_for_interrupt(pending: &Pending, clock: Clock, is_awake: impl Fn() -> bool) {
    cortex_m::interrupt::free(|_| {
        if pending.is_set() || is_awake() {
            return;
        }
        let stands = clock == Clock::Stands || !time_driver::alarm_pending();
        if stands {
            time_driver::halt();
        }
        cortex_m::asm::wfi();
        if stands {
            time_driver::resume();
        }
    });
}
