//! The application's tasks as an image of the emulated board spawns them.
//!
//! A macro, since a task cannot be generic: its memory is a static. Each of the two images flies on parts of its own.

/// Makes the application's six tasks for a front end, a port (both ends of the link, and the capture timer) and a gauge, and
/// `spawn_application`, which spawns them and says whether there was room for all.
#[macro_export]
macro_rules! application_tasks {
    ($front_end:ty, $port:ty, $gauge:ty) => {
        #[embassy_executor::task]
        async fn receive_task(app: &'static $crate::app::App<'static>, mut reader: $port, timer: $port) -> ! {
            $crate::app::receive::receive(app, &mut reader, &timer).await
        }

        #[embassy_executor::task]
        async fn camera_task(
            app: &'static $crate::app::App<'static>,
            mut front_end: $front_end,
            timer: $port,
            gauge: $gauge,
        ) -> ! {
            $crate::app::camera::camera(app, &mut front_end, &timer, &gauge).await
        }

        #[embassy_executor::task]
        async fn transmit_task(
            app: &'static $crate::app::App<'static>,
            mut writer: $port,
            timer: $port,
            gauge: $gauge,
        ) -> ! {
            $crate::app::transmit::transmit(app, &mut writer, &timer, &gauge).await
        }

        #[embassy_executor::task]
        async fn beat_task(app: &'static $crate::app::App<'static>, mut timer: $port) -> ! {
            $crate::app::beat::beat(app, &mut timer).await
        }

        #[embassy_executor::task]
        async fn pulses_task(app: &'static $crate::app::App<'static>, mut timer: $port) -> ! {
            $crate::app::edges::pulses(app, &mut timer).await
        }

        #[embassy_executor::task]
        async fn edges_task(app: &'static $crate::app::App<'static>, mut timer: $port) -> ! {
            $crate::app::edges::edges(app, &mut timer).await
        }

        fn spawn_application(
            spawner: embassy_executor::Spawner,
            app: &'static $crate::app::App<'static>,
            front_end: $front_end,
            port: $port,
            gauge: $gauge,
        ) -> bool {
            let tasks = [
                receive_task(app, port, port).map(|task| spawner.spawn(task)),
                camera_task(app, front_end, port, gauge).map(|task| spawner.spawn(task)),
                transmit_task(app, port, port, gauge).map(|task| spawner.spawn(task)),
                beat_task(app, port).map(|task| spawner.spawn(task)),
                pulses_task(app, port).map(|task| spawner.spawn(task)),
                edges_task(app, port).map(|task| spawner.spawn(task)),
            ];
            tasks.iter().all(Result::is_ok)
        }
    };
}
