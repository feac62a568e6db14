//! When the watchdog is fed: as long as every task shows life.
//!
//! Each task of the board is polled with a companion that wakes four times a second and leaves a mark; a mark shows that
//! the task's own poll returned since. The executor's loop feeds when all marks are there and takes them away. A task that
//! hangs keeps its mark back, a loop that hangs feeds nothing.

use crate::task_list::{TASKS, Task};
use core::sync::atomic::{AtomicU32, Ordering};

/// Time after which the watchdog resets, microseconds: four rounds of marks.
pub const TIMEOUT_US: u32 = 1_000_000;
/// From mark to mark, milliseconds.
pub const MARK_MS: u64 = 250;

/// A task that the watchdog knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// The application's.
    Application(Task),
    /// The board's own.
    Board(BoardTask),
}

/// A task of the board itself. The card's is none of them: a card that hangs must not reset a board that flies well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardTask {
    /// Exposures.
    Trigger,
    /// The follow-up axis.
    Servo,
    /// The lamps.
    Lamps,
    /// The USB device.
    Usb,
    /// Listens for the simulator's greeting.
    Hello,
    /// What is said to the pilot.
    Notices,
    /// All that a board with refused stores does.
    Grounded,
    /// The simulator's line.
    Line,
}

impl Watched {
    fn bit(self) -> u32 {
        let number = match self {
            Watched::Application(task) => task as u32,
            Watched::Board(task) => TASKS as u32 + task as u32,
        };
        1u32.checked_shl(number).unwrap_or(0)
    }
}

/// The marks of all tasks, a bit each.
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

    /// From now on `task` is expected to show life.
    pub fn expect(&self, task: Watched) {
        // Plain loads and stores: all of it happens in one thread.
        self.expected.store(self.expected.load(Ordering::Relaxed) | task.bit(), Ordering::Relaxed);
    }

    /// `task` lives.
    pub fn mark(&self, task: Watched) {
        self.marks.store(self.marks.load(Ordering::Relaxed) | task.bit(), Ordering::Relaxed);
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
}

#[cfg(test)]
mod tests {
    use super::{BoardTask, Life, Watched};
    use crate::task_list::Task;

    /// Tasks of both kinds: the first and the last of the application's, and of the board's.
    const TASKS: [Watched; 4] = [
        Watched::Application(Task::Receive),
        Watched::Application(Task::Edges),
        Watched::Board(BoardTask::Trigger),
        Watched::Board(BoardTask::Line),
    ];

    fn expecting() -> Life {
        let life = Life::new();
        TASKS.into_iter().for_each(|task| life.expect(task));
        life
    }

    #[test]
    fn the_watchdog_is_fed_once_for_a_round_of_marks() {
        let life = expecting();
        for round in 0..3 {
            for task in TASKS {
                assert!(!life.all(), "round {round}, before {task:?}");
                life.mark(task);
            }
            assert!(life.all());
        }
    }

    #[test]
    fn one_task_that_hangs_is_enough() {
        for hanging in TASKS {
            let life = expecting();
            // A round in which all lived leaves nothing behind for the next.
            TASKS.into_iter().for_each(|task| life.mark(task));
            assert!(life.all());
            for _ in 0..100 {
                TASKS.into_iter().filter(|task| *task != hanging).for_each(|task| life.mark(task));
                assert!(!life.all(), "{hanging:?}");
            }
        }
    }

    #[test]
    fn a_task_that_is_not_expected_does_not_count() {
        let life = Life::new();
        life.expect(TASKS[0]);
        life.mark(TASKS[3]);
        assert!(!life.all());
    }
}
