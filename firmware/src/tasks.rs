//! What makes embassy tasks of the application's list, for every board.
//!
//! A macro, since an embassy task cannot be generic: its memory is a static of its own type.

/// Makes an embassy task of each for the board `$board`, and `spawn_application`, which spawns them and says whether there was
/// memory for all: each can be spawned once.
#[macro_export]
macro_rules! embassy_tasks {
    ($board:ty, $($name:ident = $module:ident::$task:ident($($part:ident: $Part:ident),*))*) => {
        $(
            #[embassy_executor::task]
            async fn $task(
                app: &'static $crate::app::App<'static>,
                board: $board,
                $(mut $part: <$board as $crate::board::Board>::$Part,)*
            ) -> ! {
                use $crate::{app::$module, board::Board, task_list::Task};
                // In one piece: a variable for the work would take its memory a second time.
                Board::watched(board, Task::$name, $module::$task(app, $(&mut $part),*)).await
            }
        )*

        /// Spawns the application's tasks; whether there was memory for all.
        pub fn spawn_application(
            spawner: embassy_executor::Spawner,
            app: &'static $crate::app::App<'static>,
            parts: $crate::board::Parts<$board>,
        ) -> bool {
            let tasks = [$($task(app, parts.board, $(parts.$part),*).map(|task| spawner.spawn(task))),*];
            tasks.iter().all(Result::is_ok)
        }
    };
}
