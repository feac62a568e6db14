//! The application's tasks on the host.

use embassy_executor::raw::{Executor, TaskStorage};
use plumbline_firmware::app::{App, beat, camera, edges, grounded, receive, transmit};
use plumbline_firmware::board::{FrontEnd, Gauge, Reader, Timer, Writer};
use plumbline_firmware::boot::BootError;

/// Spawns all of them, each with ends of its own.
pub fn spawn<P: Reader + Writer + Timer + 'static>(
    executor: &'static Executor,
    app: &'static App<'static>,
    port: impl Fn() -> P,
    front_end: impl FrontEnd + 'static,
) {
    let (mut reader, timer) = (port(), port());
    endless(executor, async move { receive::receive(app, &mut reader, &timer).await });
    let (mut front_end, timer) = (front_end, port());
    endless(executor, async move { camera::camera(app, &mut front_end, &timer, &HostGauge).await });
    let (mut writer, timer) = (port(), port());
    endless(executor, async move { transmit::transmit(app, &mut writer, &timer, &HostGauge).await });
    let mut timer = port();
    endless(executor, async move { beat::beat(app, &mut timer).await });
    let mut timer = port();
    endless(executor, async move { edges::pulses(app, &mut timer).await });
    let mut timer = port();
    endless(executor, async move { edges::edges(app, &mut timer).await });
}

/// Spawns those of a vehicle whose stores were refused.
pub fn spawn_grounded<P: Reader + Writer + Timer + 'static>(
    executor: &'static Executor,
    reason: BootError,
    port: impl Fn() -> P,
) {
    let mut reader = port();
    endless(executor, async move { grounded::drain(&mut reader).await });
    let (mut writer, mut timer) = (port(), port());
    endless(executor, async move { grounded::tell(reason.words(), &[], &mut writer, &mut timer).await });
}

/// Spawns a task that never ends.
pub fn endless<F: Future + 'static>(executor: &'static Executor, task: F) {
    let storage: &'static TaskStorage<F> = Box::leak(Box::new(TaskStorage::new()));
    // A storage made a line above is free: the spawn cannot fail.
    if let Ok(token) = storage.spawn(|| task) {
        executor.spawner().spawn(token);
    }
}

/// No counters and no memory limits on the host.
struct HostGauge;

impl Gauge for HostGauge {
    fn measured<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        (work(), 0)
    }

    fn overruns(&self) -> u32 {
        0
    }

    fn memory(&self) -> (u32, u32) {
        (0, 0)
    }
}
