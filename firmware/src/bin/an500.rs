//! The application on the emulated board: QEMU's `mps2-an500`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use cortex_m_rt::entry;
    use embassy_executor::raw::Executor;
    use plumbline_core::pipeline::Buffers;
    use plumbline_firmware::an500::front_desk::{Camera, FrontDesk, Port};
    use plumbline_firmware::an500::idle::{Clock, wait_for_interrupt};
    use plumbline_firmware::an500::{self, doorbell, psram, time_driver};
    use plumbline_firmware::app::{App, grounded};
    use plumbline_firmware::boot::{self, BootError};
    use plumbline_firmware::journal::NoJournal;
    use plumbline_firmware::run::{self, Pending};
    use plumbline_firmware::stores::StoreError;
    use plumbline_firmware::window as at;
    use static_cell::{ConstStaticCell, StaticCell};

    static PENDING: Pending = Pending::new();
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static DESK: ConstStaticCell<FrontDesk> = ConstStaticCell::new(FrontDesk::new());
    static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
    static APP: StaticCell<App<'static>> = StaticCell::new();

    plumbline_firmware::application_tasks!(Camera, Port, Port);

    #[embassy_executor::task]
    async fn drain_task(mut reader: Port) -> ! {
        grounded::drain(&mut reader).await
    }

    #[embassy_executor::task]
    async fn tell_task(reason: BootError, mut writer: Port, mut timer: Port) -> ! {
        grounded::tell(reason.words(), &[], &mut writer, &mut timer).await
    }

    /// Flash as the simulator has filled it. A function of its own, so that what it builds is off the stack when the flight
    /// begins.
    #[inline(never)]
    fn boot() -> Result<&'static App<'static>, BootError> {
        // SAFETY: the stores stand for flash: the simulator does not change them after it has started us.
        let mission = unsafe { psram::bytes(at::MISSION, at::MISSION_BYTES) };
        // SAFETY: as above.
        let tiles = unsafe { psram::bytes(at::TILES, at::TILES_BYTES) };
        // SAFETY: as above.
        let plan = unsafe { psram::bytes(at::PLAN, at::PLAN_BYTES) }.unwrap_or(&[]);
        let mission = mission.ok_or(BootError::Mission(StoreError::Nothing))?;
        let flight = boot::read(mission, tiles.ok_or(BootError::Tiles(StoreError::Nothing))?, plan)?;
        // SAFETY: `boot` runs once.
        let frame_memory = unsafe { psram::frame_memory() };
        Ok(APP.uninit().write(flight.app(BUFFERS.take(), frame_memory, &NoJournal)?))
    }

    #[entry]
    fn main() -> ! {
        an500::start();
        let executor = EXECUTOR.init(run::executor(&PENDING));
        let desk: &'static FrontDesk = DESK.take();
        let (port, spawner) = (Port(desk), executor.spawner());
        // Each task is spawned once, at boot: none of these can fail.
        let (spawned, status) = match boot() {
            Ok(app) => (spawn_application(spawner, app, Camera::new(desk), port, port), 1),
            Err(reason) => {
                let tasks = [
                    drain_task(port).map(|task| spawner.spawn(task)),
                    tell_task(reason, port, port).map(|task| spawner.spawn(task)),
                ];
                (tasks.iter().all(Result::is_ok), reason.code())
            }
        };
        let status = if spawned { status } else { 0 };
        psram::set_word(at::STATUS, status);
        lockstep(executor, desk)
    }

    /// A step: receive its bytes, let its edges and frame happen, work until nothing is left to do, answer.
    ///
    /// No task runs before the first step: the capture timer has no reading yet.
    fn lockstep(executor: &'static Executor, desk: &'static FrontDesk) -> ! {
        let no_task = Pending::new();
        while !doorbell::has_rung() {
            wait_for_interrupt(&no_task, Clock::Stands, doorbell::has_rung);
        }
        loop {
            settle(executor, || doorbell::has_rung() && FrontDesk::has_all_bytes());
            desk.step();
            settle(executor, || true);
            psram::set_word(at::STEP_DONE, psram::word(at::STEP).unwrap_or(0));
            doorbell::take();
            doorbell::answer();
        }
    }

    /// Runs tasks until none is ready, none waits for an instant, and the world is as `done` wants it.
    fn settle(executor: &'static Executor, done: impl Fn() -> bool) {
        loop {
            run::until_idle(executor, &PENDING);
            if time_driver::alarm_pending() {
                wait_for_interrupt(&PENDING, Clock::Runs, || false);
            } else if done() {
                return;
            } else {
                wait_for_interrupt(&PENDING, Clock::Stands, &done);
            }
        }
    }
}
