//! The flight computer's performance counters.

use super::{front_end, memory};
use crate::board::PerformanceCounters;
use crate::serial::wires::Wires;
use cortex_m::peripheral::{DCB, DWT};

/// Counts the core's cycles; in the simulator's mode the wires count overruns.
#[derive(Clone, Copy, Default)]
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct ChipCounters(pub Option<&'static Wires>);

/// Starts the cycle counter.
pub fn start(dcb: &mut DCB, dwt: &mut DWT) {
    dcb.enable_trace();
    // The Cortex-M7 wants its lock opened first, with a debugger or without.
    DWT::unlock();
    dwt.enable_cycle_counter();
}

impl PerformanceCounters for ChipCounters {
    /// The cost is in cycles of the core, interrupts included: rows must not wait.
    fn counted<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        let before = DWT::cycle_count();
        let result = work();
        (result, DWT::cycle_count().wrapping_sub(before))
    }

    fn overruns(&self) -> u32 {
        self.0.map_or_else(front_end::overruns, Wires::overruns)
    }

    fn memory(&self) -> (u32, u32) {
        (memory::static_bytes(), memory::stack_bytes())
    }
}
