//! A marked piece of work.

use core::fmt::{Arguments, Display};
use core::hint::black_box;

/// What a board lends the bench.
pub trait Stand {
    /// Prints a line.
    fn report(&mut self, line: Arguments<'_>);
    /// The processor's cycle counter, 32 bits, wrapping; `None` where it has none that counts.
    fn cycles(&mut self) -> Option<u32>;
}

/// Does `work` between the markers, and prints `region: WORKLOAD | STAGE | POSE` afterwards, with its cycles where the
/// board counts them. Regions are told apart by their order: nothing but this function may set markers.
pub fn region<R>(
    stand: &mut impl Stand,
    (workload, stage): (&str, &str),
    pose: impl Display,
    work: impl FnOnce() -> R,
) -> R {
    let begin = stand.cycles();
    begin_marker();
    // Whatever the work computes is computed before the second marker.
    let result = black_box(work());
    end_marker();
    match begin.zip(stand.cycles()) {
        None => stand.report(format_args!("region: {workload} | {stage} | {pose}")),
        Some((begin, end)) => {
            stand.report(format_args!("region: {workload} | {stage} | {pose} | {} cycles", end.wrapping_sub(begin)));
        }
    }
    result
}

/// `DBG #1`: does nothing on the architecture, seen by an emulator's plugin.
#[inline(always)]
fn begin_marker() {
    #[cfg(target_arch = "arm")]
    // SAFETY: a hint without effect. It may touch memory as far as the compiler knows, which keeps the work behind it.
    unsafe {
        core::arch::asm!("dbg #1", options(nostack, preserves_flags));
    }
}

/// `DBG #2`, the end.
#[inline(always)]
fn end_marker() {
    #[cfg(target_arch = "arm")]
    // SAFETY: as above; it keeps the work before it.
    unsafe {
        core::arch::asm!("dbg #2", options(nostack, preserves_flags));
    }
}
