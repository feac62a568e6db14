//! The executor's loop, the same on every machine.
//!
//! embassy's raw executor is polled until it has nothing to do; what happens then (sleep until an interrupt, hand
//! control back to the simulator) is the board's affair. The executor's pender sets a flag; the flag's address is the
//! executor's context, so several executors may live in one process.

use core::sync::atomic::{AtomicBool, Ordering};
use embassy_executor::raw::Executor;

/// Set when a task was woken since the last poll.
#[derive(Debug, Default)]
pub struct Pending(AtomicBool);

impl Pending {
    /// Nothing woken yet.
    pub const fn new() -> Self {
        Pending(AtomicBool::new(false))
    }

    /// Whether a task waits to be polled.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// An executor that reports to `pending`.
pub fn executor(pending: &'static Pending) -> Executor {
    Executor::new(core::ptr::from_ref(pending).cast_mut().cast())
}

/// Polls `executor` until no task is ready.
pub fn until_idle(executor: &'static Executor, pending: &'static Pending) {
    loop {
        pending.0.store(false, Ordering::Release);
        // SAFETY: the executor was made by `executor` above and is polled from this loop only, never from within a
        // task or an interrupt.
        unsafe { executor.poll() };
        if !pending.is_set() {
            return;
        }
    }
}

/// Called by embassy when a task becomes ready, from tasks and interrupts alike.
#[unsafe(export_name = "__pender")]
fn pender(context: *mut ()) {
    // SAFETY: `executor` passes the address of a `Pending` that lives for ever, and atomics may be shared.
    let pending = unsafe { &*context.cast::<Pending>() };
    pending.0.store(true, Ordering::Release);
}
