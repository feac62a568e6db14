//! The application's tasks on the host.

use embassy_executor::raw::{Executor, TaskStorage};
use plumbline_firmware::app::{App, grounded};
use plumbline_firmware::application_tasks;
use plumbline_firmware::board::{Board, FrontEnd, Parts, PerformanceCounters, Reader, Timer, Writer};
use plumbline_firmware::boot::BootError;
use plumbline_firmware::wire::signing::Signing;
use std::marker::PhantomData;

/// A host process that acts as a board: a front end, and a port that is both ends of the link and the capture timer.
struct Host<F, P>(PhantomData<fn() -> (F, P)>);

impl<F, P> Clone for Host<F, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F, P> Copy for Host<F, P> {}

impl<F: FrontEnd + 'static, P: Reader + Writer + Timer + Copy + 'static> Board for Host<F, P> {
    type FrontEnd = F;
    type Reader = P;
    type Writer = P;
    type Timer = P;
    type Counters = NoCounters;
}

/// Spawns all of them.
pub fn spawn<P: Reader + Writer + Timer + Copy + 'static>(
    executor: &'static Executor,
    app: &'static App<'static>,
    port: P,
    front_end: impl FrontEnd + 'static,
) {
    let (reader, writer, timer) = (port, port, port);
    let parts = Parts { board: Host(PhantomData), front_end, reader, writer, timer, counters: NoCounters };
    macro_rules! spawn {
        ($($name:ident = $module:ident::$task:ident($($part:ident: $Part:ident),*))*) => {
            $({
                $(let mut $part = parts.$part;)*
                endless(executor, async move { plumbline_firmware::app::$module::$task(app, $(&mut $part),*).await });
            })*
        };
    }
    application_tasks!(spawn);
}

/// Spawns those of a vehicle whose stores were refused.
pub fn spawn_grounded<P: Reader + Writer + Timer + Copy + 'static>(
    executor: &'static Executor,
    reason: BootError,
    signing: Option<Signing>,
    port: P,
) {
    let (mut reader, mut writer, mut timer) = (port, port, port);
    endless(executor, async move { grounded::drain(&mut reader).await });
    endless(executor, async move { grounded::report(reason.words(), &[], signing, &mut writer, &mut timer).await });
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
#[derive(Clone, Copy)]
struct NoCounters;

impl PerformanceCounters for NoCounters {
    fn counted<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        (work(), 0)
    }

    fn overruns(&self) -> u32 {
        0
    }

    fn memory(&self) -> (u32, u32) {
        (0, 0)
    }
}
