//! Figures of the board itself.

use super::{camera, memory};
use crate::board::Gauge;
use cortex_m::peripheral::{DCB, DWT};

/// Counts the core's cycles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures;

/// Starts the cycle counter.
pub fn start(dcb: &mut DCB, dwt: &mut DWT) {
    dcb.enable_trace();
    // The Cortex-M7 wants its lock opened first, with a debugger or without.
    DWT::unlock();
    dwt.enable_cycle_counter();
}

impl Gauge for Figures {
    /// The cost is in cycles of the core, interrupts included: rows must not wait.
    fn measured<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        let before = DWT::cycle_count();
        let result = work();
        (result, DWT::cycle_count().wrapping_sub(before))
    }

    fn overruns(&self) -> u32 {
        camera::overruns()
    }

    fn memory(&self) -> (u32, u32) {
        (memory::static_bytes(), memory::stack_bytes())
    }
}
