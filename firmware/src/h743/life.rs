//! When the watchdog is fed: as long as every task shows life.
//!
//! Each task of the board is polled with a companion that wakes four times a second and leaves a mark; a mark shows that
//! the task's own poll returned since. The executor's loop feeds when all marks are there and takes them away. A task that
//! hangs keeps its mark back, a loop that hangs feeds nothing.

use core::sync::atomic::{AtomicU32, Ordering};

/// Time after which the watchdog resets, microseconds: four rounds of marks.
pub const TIMEOUT_US: u32 = 1_000_000;
/// From mark to mark, milliseconds.
pub const MARK_MS: u64 = 250;

/// The marks of up to 32 tasks.
#[derive(Debug, Default)]
pub struct Life {
    expected: AtomicU32,
    marks: AtomicU32,
}

impl Life {
    /// Nobody expected yet.
    pub const fn new() -> Life {
        Life { expected: AtomicU32::new(0), marks: AtomicU32::new(0) }
    }

    /// From now on task `task` is expected to show life.
    pub fn expect(&self, task: u8) {
        // Plain loads and stores: all of it happens in one thread.
        self.expected.store(self.expected.load(Ordering::Relaxed) | bit(task), Ordering::Relaxed);
    }

    /// Task `task` lives.
    pub fn mark(&self, task: u8) {
        self.marks.store(self.marks.load(Ordering::Relaxed) | bit(task), Ordering::Relaxed);
    }

    /// Whether all have shown life since this was last true; the marks begin anew.
    pub fn all(&self) -> bool {
        let expected = self.expected.load(Ordering::Relaxed);
        let is_whole = self.marks.load(Ordering::Relaxed) & expected == expected;
        if is_whole {
            self.marks.store(0, Ordering::Relaxed);
        }
        is_whole
    }

    /// Those that are missing, a bit each.
    pub fn missing(&self) -> u32 {
        self.expected.load(Ordering::Relaxed) & !self.marks.load(Ordering::Relaxed)
    }
}

fn bit(task: u8) -> u32 {
    1u32.checked_shl(task.into()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::Life;

    #[test]
    fn the_watchdog_is_fed_once_for_a_round_of_marks() {
        let life = Life::new();
        (0..5).for_each(|task| life.expect(task));
        for round in 0..3 {
            for task in 0..5 {
                assert!(!life.all(), "round {round}, before task {task}");
                life.mark(task);
            }
            assert!(life.all());
        }
    }

    #[test]
    fn one_task_that_hangs_is_enough() {
        for hanging in 0..5 {
            let life = Life::new();
            (0..5).for_each(|task| life.expect(task));
            // A round in which all lived leaves nothing behind for the next.
            (0..5).for_each(|task| life.mark(task));
            assert!(life.all());
            for _ in 0..100 {
                (0..5).filter(|task| *task != hanging).for_each(|task| life.mark(task));
                assert!(!life.all(), "{hanging}");
            }
            assert_eq!(life.missing(), 1 << hanging);
        }
    }

    #[test]
    fn a_stranger_does_not_count() {
        let life = Life::new();
        life.expect(0);
        life.mark(7);
        life.mark(40);
        assert!(!life.all());
    }
}
