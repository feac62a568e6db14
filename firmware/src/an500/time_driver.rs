//! embassy's clock: microseconds since start, on two CMSDK timers.
//!
//! Timer 0 counts down from its top for ever; its wraps are counted to make 64 bits. Timer 1 counts down once to the next
//! alarm. Both run at [`super::PERIPHERAL_HZ`].
//!
//! Time in which the program has nothing to do is not emulated: [`skip_to_alarm`] adds it to the clock.

use super::PERIPHERAL_HZ;
use super::registers::Register;
use core::cell::{Cell, RefCell};
use core::task::Waker;
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time_driver::{Driver, TICK_HZ};
use embassy_time_queue_utils::Queue;

/// CTRL: counting, with an interrupt at zero.
const RUN: u32 = 1 << 0 | 1 << 3;
/// CTRL: standing, the value kept.
const HALT: u32 = 1 << 3;
/// INTSTATUS and INTCLEAR.
const AT_ZERO: u32 = 1;

/// The counter starts this far before its first wrap, 1 ms, so that every run goes through one.
const FIRST_WRAP: u32 = PERIPHERAL_HZ / 1000;

const COUNTS_PER_TICK: u64 = PERIPHERAL_HZ as u64 / TICK_HZ;

/// A CMSDK timer.
struct Timer {
    control: Register,
    value: Register,
    reload: Register,
    interrupt: Register,
}

impl Timer {
    /// # Safety
    /// `base` is that of a CMSDK timer.
    const unsafe fn new(base: usize) -> Self {
        // SAFETY: the caller promised the timer; these are its registers.
        unsafe {
            Timer {
                control: Register::new(base),
                value: Register::new(base + 0x04),
                reload: Register::new(base + 0x08),
                interrupt: Register::new(base + 0x0c),
            }
        }
    }
}

// SAFETY: timer 0 of the board.
const COUNTER: Timer = unsafe { Timer::new(0x4000_0000) };
// SAFETY: timer 1 of the board.
const ALARM: Timer = unsafe { Timer::new(0x4000_1000) };

/// Timekeeping behind the clock.
struct AlarmDriver {
    state: CriticalSectionMutex<Timekeeping>,
}

struct Timekeeping {
    /// Finished periods of the counter.
    wraps: Cell<u32>,
    /// Counts that were skipped.
    skipped: Cell<u64>,
    /// When the next alarm is due, ticks; `u64::MAX` when there is none.
    next: Cell<u64>,
    queue: RefCell<Queue>,
}

embassy_time_driver::time_driver_impl!(static CLOCK: AlarmDriver = AlarmDriver {
    state: CriticalSectionMutex::new(Timekeeping {
        wraps: Cell::new(0),
        skipped: Cell::new(0),
        next: Cell::new(u64::MAX),
        queue: RefCell::new(Queue::new()),
    }),
});

impl Driver for AlarmDriver {
    fn now(&self) -> u64 {
        self.state.lock(Timekeeping::counts) / COUNTS_PER_TICK
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.state.lock(|state| {
            // Held for no longer than a call of this file, so it is never taken.
            if state.queue.try_borrow_mut().is_ok_and(|mut queue| queue.schedule_wake(at, waker)) {
                state.arm();
            }
        });
    }
}

impl Timekeeping {
    /// Counts since start, the skipped ones included. To be called with interrupts held off.
    fn counts(&self) -> u64 {
        let low = counter();
        // The flag rises when the timer stands at zero, one count before it wraps. It is read last: a count low enough
        // to lie behind the wrap then finds the flag set.
        let flagged = COUNTER.interrupt.read() & AT_ZERO != 0;
        let wrapped = flagged && low < 1 << 31;
        let counted = ((u64::from(self.wraps.get()) + u64::from(wrapped)) << 32) | u64::from(low);
        // Below the first value only before `start`.
        counted.saturating_sub(u64::from(!FIRST_WRAP)) + self.skipped.get()
    }

    /// Wakes what is due and sets the alarm for what is next.
    fn arm(&self) {
        let Ok(mut queue) = self.queue.try_borrow_mut() else { return };
        loop {
            let counts = self.counts();
            let next = queue.next_expiration(counts / COUNTS_PER_TICK);
            self.next.set(next);
            if next == u64::MAX {
                ALARM.control.write(HALT);
                return;
            }
            let wait = (next.saturating_mul(COUNTS_PER_TICK)).saturating_sub(self.counts());
            if wait > 0 {
                // A longer wait is cut: the interrupt finds nothing due and comes back here.
                ALARM.value.write(u32::try_from(wait).unwrap_or(u32::MAX));
                ALARM.control.write(RUN);
                return;
            }
        }
    }
}

/// Starts the counter.
pub(super) fn start() {
    COUNTER.reload.write(u32::MAX);
    COUNTER.value.write(FIRST_WRAP);
    COUNTER.control.write(RUN);
    ALARM.reload.write(0);
    ALARM.control.write(HALT);
}

/// Timer 0 stands at zero.
pub(super) fn on_wrap() {
    CLOCK.state.lock(|state| {
        while counter() == u32::MAX {}
        COUNTER.interrupt.write(AT_ZERO);
        state.wraps.set(state.wraps.get().wrapping_add(1));
    });
}

/// Timer 1 has reached zero.
pub(super) fn on_alarm() {
    CLOCK.state.lock(|state| {
        ALARM.interrupt.write(AT_ZERO);
        state.arm();
    });
}

/// Timer 0 counted upwards: [`super::PERIPHERAL_HZ`], wrapping every 171 s. The difference of two readings is a number
/// of instructions, times [`super::INSTRUCTIONS_PER_COUNT`].
pub fn counter() -> u32 {
    !COUNTER.value.read()
}

/// Does `work` with interrupts held off; its result, and the instructions it took by [`counter`].
pub fn measured<R>(work: impl FnOnce() -> R) -> (R, u32) {
    cortex_m::interrupt::free(|_| {
        let before = counter();
        let result = work();
        (result, counter().wrapping_sub(before) * super::INSTRUCTIONS_PER_COUNT)
    })
}

/// Whether a task waits for an instant: if not, only the world outside can wake the program.
pub fn alarm_pending() -> bool {
    CLOCK.state.lock(|state| state.next.get() != u64::MAX)
}

/// Sets the clock to the instant of the next alarm and wakes who waits for it; `false` if there is none.
pub(super) fn skip_to_alarm() -> bool {
    CLOCK.state.lock(|state| {
        let next = state.next.get();
        if next == u64::MAX {
            return false;
        }
        let ahead = next.saturating_mul(COUNTS_PER_TICK).saturating_sub(state.counts());
        state.skipped.set(state.skipped.get().saturating_add(ahead));
        state.arm();
        true
    })
}

/// Stops both timers: the clock stands.
pub(super) fn halt() {
    CLOCK.state.lock(|_| {
        ALARM.control.write(HALT);
        COUNTER.control.write(HALT);
    });
}

/// Lets the clock go on where it stood.
pub(super) fn resume() {
    CLOCK.state.lock(|state| {
        COUNTER.control.write(RUN);
        if state.next.get() != u64::MAX {
            ALARM.control.write(RUN);
        }
    });
}
