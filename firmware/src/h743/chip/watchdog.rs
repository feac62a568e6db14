//! Each task with a companion that marks its life for the watchdog.

use crate::h743::life::{BoardTask, Life, MARK_MS, Watched};
use embassy_futures::join::join;
use embassy_time::Timer;

/// Who lives.
pub static LIFE: Life = Life::new();

/// Does a task of the board's, and marks its life meanwhile.
pub fn watched<T>(task: BoardTask, work: impl Future<Output = T>) -> impl Future<Output = T> {
    marked(Watched::Board(task), true, work)
}

/// Does `work`, and marks the task's life meanwhile if that `is_expected`.
pub async fn marked<T>(task: Watched, is_expected: bool, work: impl Future<Output = T>) -> T {
    let marks = async {
        if !is_expected {
            return;
        }
        LIFE.expect(task);
        loop {
            LIFE.mark(task);
            Timer::after_millis(MARK_MS).await;
        }
    };
    join(work, marks).await.0
}
