//! The application on the emulated board: QEMU's `mps2-an500`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use cortex_m_rt::entry;
    use embassy_executor::raw::Executor;
    use plumbline_core::pipeline::{Buffers, Pipeline};
    use plumbline_core::stamp::Stamper;
    use plumbline_firmware::an500::front_desk::{Camera, FrontDesk, Port};
    use plumbline_firmware::an500::idle::{Clock, wait_for_interrupt};
    use plumbline_firmware::an500::{self, doorbell, psram, time_driver};
    use plumbline_firmware::app::{App, beat, camera, edges, receive, transmit};
    use plumbline_firmware::mission::{Mission, MissionError};
    use plumbline_firmware::run::{self, Pending};
    use plumbline_firmware::window as at;
    use static_cell::{ConstStaticCell, StaticCell};

    static PENDING: Pending = Pending::new();
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static DESK: ConstStaticCell<FrontDesk> = ConstStaticCell::new(FrontDesk::new());
    static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
    static APP: StaticCell<App<'static>> = StaticCell::new();

    #[embassy_executor::task]
    async fn receive_task(app: &'static App<'static>, mut reader: Port, timer: Port) -> ! {
        receive::receive(app, &mut reader, &timer).await
    }

    #[embassy_executor::task]
    async fn camera_task(app: &'static App<'static>, mut front_end: Camera, port: Port) -> ! {
        camera::camera(app, &mut front_end, &port, &port).await
    }

    #[embassy_executor::task]
    async fn transmit_task(app: &'static App<'static>, mut writer: Port, port: Port) -> ! {
        transmit::transmit(app, &mut writer, &port, &port).await
    }

    #[embassy_executor::task]
    async fn beat_task(app: &'static App<'static>, mut timer: Port) -> ! {
        beat::beat(app, &mut timer).await
    }

    #[embassy_executor::task]
    async fn pulses_task(app: &'static App<'static>, mut timer: Port) -> ! {
        edges::pulses(app, &mut timer).await
    }

    #[embassy_executor::task]
    async fn edges_task(app: &'static App<'static>, mut timer: Port) -> ! {
        edges::edges(app, &mut timer).await
    }

    /// Flash as the simulator has filled it: mission and tile. A function of its own, so that what it builds is off the
    /// stack when the flight begins.
    #[inline(never)]
    fn boot() -> Result<&'static App<'static>, MissionError> {
        let length = psram::word(at::MISSION_BYTES).unwrap_or(0) as usize;
        // SAFETY: mission and tile stand for flash: the simulator does not change them after it has started us.
        let bytes = unsafe { psram::bytes(at::MISSION, length) }.ok_or(MissionError::Encoding)?;
        let mission = Mission::decode(bytes)?;
        let area = mission.tile.0 as usize * mission.tile.1 as usize;
        // SAFETY: as above.
        let pixels = unsafe { psram::bytes(at::TILE, area) }.ok_or(MissionError::Tile)?;
        let settings = mission.settings()?;
        let stamper = Stamper::new(&mission.stamp_settings()?);
        let tile = mission.tile(pixels)?;
        // SAFETY: `boot` runs once.
        let frame_memory = unsafe { psram::frame_memory() };
        let pipeline =
            Pipeline::new(settings, tile, BUFFERS.take(), frame_memory).map_err(|_| MissionError::Settings)?;
        Ok(APP.uninit().write(App::new(pipeline, stamper, mission.send_patches)))
    }

    #[entry]
    fn main() -> ! {
        an500::start();
        let executor = EXECUTOR.init(run::executor(&PENDING));
        let desk: &'static FrontDesk = DESK.take();
        let status = match boot() {
            Ok(app) => {
                let port = Port(desk);
                let spawner = executor.spawner();
                // Each task is spawned once, at boot: none of these can fail.
                let tasks = [
                    receive_task(app, port, port).map(|task| spawner.spawn(task)),
                    camera_task(app, Camera::new(desk), port).map(|task| spawner.spawn(task)),
                    transmit_task(app, port, port).map(|task| spawner.spawn(task)),
                    beat_task(app, port).map(|task| spawner.spawn(task)),
                    pulses_task(app, port).map(|task| spawner.spawn(task)),
                    edges_task(app, port).map(|task| spawner.spawn(task)),
                ];
                if tasks.iter().all(Result::is_ok) { 1 } else { 0 }
            }
            Err(error) => 2 + error as u32,
        };
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
