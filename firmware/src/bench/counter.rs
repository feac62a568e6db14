//! The cycle counter of the core's data watchpoint unit.

use cortex_m::peripheral::{DCB, DWT};

/// A counter that has been seen to count.
#[derive(Debug)]
pub struct Counter(());

impl Counter {
    /// Starts it. `None` where it stands still, as under QEMU, which reads all of its registers as 0.
    pub fn start(dcb: &mut DCB, dwt: &mut DWT) -> Option<Self> {
        if !DWT::has_cycle_counter() {
            return None;
        }
        dcb.enable_trace();
        dwt.enable_cycle_counter();
        let before = DWT::cycle_count();
        cortex_m::asm::delay(100);
        (DWT::cycle_count() != before).then_some(Counter(()))
    }

    /// Cycles since it was started, wrapping.
    pub fn now(&self) -> u32 {
        DWT::cycle_count()
    }
}
