//! The application on the emulated board: QEMU's `mps2-an500`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use cortex_m_rt::entry;
    use embassy_executor::raw::Executor;
    use plumbline_core::navigation::Navigation;
    use plumbline_core::pipeline::{Buffers, Memory};
    use plumbline_firmware::an500::idle::{EmulatedTime, wait_for_interrupt};
    use plumbline_firmware::an500::lockstep::{EmulatedFrontEnd, Lockstep, LockstepPeripherals, Port};
    use plumbline_firmware::an500::{self, doorbell, psram, time_driver};
    use plumbline_firmware::app::{App, grounded};
    use plumbline_firmware::board::Parts;
    use plumbline_firmware::boot::{self, BootError};
    use plumbline_firmware::journal::NoJournal;
    use plumbline_firmware::run::{self, Pending};
    use plumbline_firmware::shared_memory as at;
    use plumbline_firmware::stores::StoreError;
    use plumbline_firmware::wire::signing::Signing;
    use plumbline_firmware::{application_tasks, embassy_tasks};
    use static_cell::{ConstStaticCell, StaticCell};

    static PENDING: Pending = Pending::new();
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static PERIPHERALS: ConstStaticCell<LockstepPeripherals> = ConstStaticCell::new(LockstepPeripherals::new());
    static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
    static NAVIGATION: ConstStaticCell<Navigation> = ConstStaticCell::new(Navigation::new());
    static APP: StaticCell<App<'static>> = StaticCell::new();

    application_tasks!(embassy_tasks, Lockstep);

    #[embassy_executor::task]
    async fn drain_task(mut reader: Port) -> ! {
        grounded::drain(&mut reader).await
    }

    #[embassy_executor::task]
    async fn tell_task(reason: BootError, mut writer: Port, mut timer: Port) -> ! {
        grounded::report(reason.words(), &[], signing().ok().flatten(), &mut writer, &mut timer).await
    }

    /// What the key store begins.
    fn signing() -> Result<Option<Signing>, BootError> {
        // SAFETY: the stores stand for flash: the simulator does not change them after it has started us.
        boot::signing(unsafe { psram::bytes(at::KEY, at::KEY_BYTES) }.unwrap_or(&[]), 0)
    }

    /// Flash as the simulator has filled it. A function of its own, so that what it builds is off the stack when the flight
    /// begins.
    #[inline(never)]
    fn boot() -> Result<&'static App<'static>, BootError> {
        // SAFETY: the stores stand for flash: the simulator does not change them after it has started us.
        let configuration = unsafe { psram::bytes(at::CONFIGURATION, at::CONFIGURATION_BYTES) };
        // SAFETY: as above.
        let tiles = unsafe { psram::bytes(at::TILES, at::TILES_BYTES) };
        // SAFETY: as above.
        let plan = unsafe { psram::bytes(at::PLAN, at::PLAN_BYTES) }.unwrap_or(&[]);
        let configuration = configuration.ok_or(BootError::Configuration(StoreError::Nothing))?;
        let flight = boot::read(configuration, tiles.ok_or(BootError::Tiles(StoreError::Nothing))?, plan)?;
        // SAFETY: `boot` runs once.
        let frame = unsafe { psram::frame_memory() };
        let memory = Memory { buffers: BUFFERS.take(), navigation: NAVIGATION.take(), frame };
        Ok(APP.uninit().write(flight.app(memory, signing()?, &NoJournal)?))
    }

    #[entry]
    fn main() -> ! {
        an500::start();
        let executor = EXECUTOR.init(run::executor(&PENDING));
        let peripherals: &'static LockstepPeripherals = PERIPHERALS.take();
        let (port, spawner) = (Port(peripherals), executor.spawner());
        // Each task is spawned once, at boot: none of these can fail.
        let (spawned, status) = match boot() {
            Ok(app) => {
                let front_end = EmulatedFrontEnd::new(peripherals);
                let parts =
                    Parts { board: Lockstep, front_end, reader: port, writer: port, timer: port, counters: port };
                (spawn_application(spawner, app, parts), 1)
            }
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
        lockstep(executor, peripherals)
    }

    /// A step: receive its bytes, let its edges and frame happen, work until nothing is left to do, answer.
    ///
    /// No task runs before the first step: the capture timer has no reading yet.
    fn lockstep(executor: &'static Executor, peripherals: &'static LockstepPeripherals) -> ! {
        let no_task = Pending::new();
        while !doorbell::has_rung() {
            wait_for_interrupt(&no_task, EmulatedTime::Stands, doorbell::has_rung);
        }
        loop {
            settle(executor, || doorbell::has_rung() && LockstepPeripherals::has_all_bytes());
            peripherals.step();
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
                wait_for_interrupt(&PENDING, EmulatedTime::Runs, || false);
            } else if done() {
                return;
            } else {
                wait_for_interrupt(&PENDING, EmulatedTime::Stands, &done);
            }
        }
    }
}
