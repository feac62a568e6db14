//! Counting instructions: what a piece of work costs, the same in every run.
//!
//! A timer of its own is started for each count. Differences of the free-running one would depend on where in a count of
//! 20 instructions the work begins, and that on when bytes arrived.

use super::INSTRUCTIONS_PER_COUNT;
use super::registers::Register;

// SAFETY: the first half of the board's CMSDK dual timer, which nothing else uses.
const LOAD: Register = unsafe { Register::new(0x4000_2000) };
// SAFETY: as above.
const VALUE: Register = unsafe { Register::new(0x4000_2004) };
// SAFETY: as above.
const CONTROL: Register = unsafe { Register::new(0x4000_2008) };

/// CONTROL: counting, 32 bits wide, free-running, without an interrupt.
const RUN: u32 = 1 << 7 | 1 << 1;

/// Does `work` with interrupts held off; its result, and the instructions it took under `-icount shift=1`, rounded down
/// to [`INSTRUCTIONS_PER_COUNT`]. Work of more than 171 s of emulated time wraps. Not to be nested.
pub fn counted<R>(work: impl FnOnce() -> R) -> (R, u32) {
    cortex_m::interrupt::free(|_| {
        CONTROL.write(RUN);
        LOAD.write(u32::MAX);
        let result = work();
        let counts = u32::MAX - VALUE.read();
        // Left running, it would be one more event that the emulator's clock jumps to.
        CONTROL.write(0);
        (result, counts.wrapping_mul(INSTRUCTIONS_PER_COUNT))
    })
}
