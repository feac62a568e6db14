//! The simulator's line on the emulated board: QEMU's `mps2-an500` as a board on a serial port, UART 0.
//!
//! Nothing but the line comes from the simulator. The PSRAM, which the other image shares with it, is plain memory here.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use core::mem::MaybeUninit;
    use cortex_m_rt::entry;
    use embassy_executor::raw::Executor;
    use plumbline_core::navigation::Navigation;
    use plumbline_core::pipeline::{Buffers, Memory};
    use plumbline_firmware::an500::idle::{EmulatedTime, wait_for_interrupt};
    use plumbline_firmware::an500::line::{LineCounters, OnLine, Uart, reboot};
    use plumbline_firmware::an500::{self, INSTRUCTIONS_PER_COUNT, psram, time_driver};
    use plumbline_firmware::app::App;
    use plumbline_firmware::board::Parts;
    use plumbline_firmware::run::{self, Pending};
    use plumbline_firmware::serial::boot::application;
    use plumbline_firmware::serial::front_end::LineFrontEnd;
    use plumbline_firmware::serial::message::Counts;
    use plumbline_firmware::serial::serve::{End, serve};
    use plumbline_firmware::serial::session::{Identity, Machine, Session};
    use plumbline_firmware::serial::stores::{Stores, Uploaded};
    use plumbline_firmware::serial::wires::{Port, Wires};
    use plumbline_firmware::shared_memory as at;
    use plumbline_firmware::{application_tasks, embassy_tasks};
    use static_cell::{ConstStaticCell, StaticCell};

    /// What lies in the PSRAM: its start and size, bytes.
    const CONFIGURATION: (usize, usize) = (at::CONFIGURATION, at::CONFIGURATION_BYTES);
    const PLAN: (usize, usize) = (at::PLAN, at::PLAN_BYTES);
    const KEY: (usize, usize) = (at::KEY, at::KEY_BYTES);
    const ROWS: (usize, usize) = (0x1_0000, 0x3_0000);
    const TILE: (usize, usize) = (at::TILES, at::TILES_BYTES);

    /// The application's executor, and that of the line around it.
    static FLIGHT: Pending = Pending::new();
    static LINE: Pending = Pending::new();
    static FLIGHT_EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static LINE_EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static WIRES: ConstStaticCell<Wires> = ConstStaticCell::new(Wires::new());
    static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
    static NAVIGATION: ConstStaticCell<Navigation> = ConstStaticCell::new(Navigation::new());
    static APP: StaticCell<App<'static>> = StaticCell::new();
    static SESSION: StaticCell<Session<Emulated>> = StaticCell::new();

    /// Boots since power-on, behind a word that says that it is one. A reset leaves RAM as it is.
    #[unsafe(link_section = ".uninit.boots")]
    static mut BOOTS: MaybeUninit<(u32, u32)> = MaybeUninit::uninit();
    const MARK: u32 = 0x504c_4244;

    application_tasks!(embassy_tasks, OnLine);

    #[embassy_executor::task]
    async fn line_task(session: &'static mut Session<Emulated>) {
        loop {
            // A UART is never unplugged.
            if serve(session, &mut Uart, &mut Uart).await == End::Reset {
                reboot();
            }
        }
    }

    /// The emulated board.
    struct Emulated {
        boot: u32,
        executor: &'static Executor,
    }

    impl Machine for Emulated {
        fn identity(&self) -> Identity {
            // Emulated time is made of instructions: the core has no clock of its own.
            Identity { board: "mps2-an500", boot: self.boot, core_clock_hz: 0, counts: Counts::Instructions }
        }

        #[inline(never)]
        fn boot(&mut self, uploaded: Uploaded, wires: &'static Wires) -> Result<(), [&'static str; 2]> {
            // SAFETY: a session boots once at most, and nothing else uses these parts of the PSRAM.
            let (frame, rows) = unsafe { (psram::frame_memory(), psram::memory(ROWS.0, ROWS.1)) };
            let memory = Memory { buffers: BUFFERS.take(), navigation: NAVIGATION.take(), frame };
            let app: &'static App<'static> = APP.uninit().write(application(uploaded, memory)?);
            let (port, counters) = (Port(wires), LineCounters(wires));
            let front_end = LineFrontEnd::new(wires, rows.ok_or(["the board", "has no room for rows"])?);
            let parts = Parts { board: OnLine, front_end, reader: port, writer: port, timer: port, counters };
            let is_spawned = spawn_application(self.executor.spawner(), app, parts);
            if is_spawned { Ok(()) } else { Err(["the board", "has no room for a task"]) }
        }

        fn run(&mut self) {
            run::until_idle(self.executor, &FLIGHT);
        }

        fn count(&self) -> u32 {
            time_driver::counter().wrapping_mul(INSTRUCTIONS_PER_COUNT)
        }
    }

    /// This boot's number.
    fn boots() -> u32 {
        let boots = &raw mut BOOTS;
        // SAFETY: called once, before anything else runs; any bits are two words.
        unsafe {
            let (mark, before) = boots.cast::<(u32, u32)>().read_volatile();
            let boot = if mark == MARK { before.wrapping_add(1) } else { 1 };
            boots.cast::<(u32, u32)>().write_volatile((MARK, boot));
            boot
        }
    }

    #[entry]
    fn main() -> ! {
        let boot = boots();
        an500::start();
        let executor = FLIGHT_EXECUTOR.init(run::executor(&FLIGHT));
        let line = LINE_EXECUTOR.init(run::executor(&LINE));
        // SAFETY: `main` runs once, and nothing else uses these parts of the PSRAM.
        let memories = unsafe { [CONFIGURATION, TILE, PLAN, KEY].map(|(start, size)| psram::memory(start, size)) };
        if let [Some(configuration), Some(tile), Some(plan), Some(key)] = memories {
            let machine = Emulated { boot, executor };
            let stores = Stores::new(configuration, tile, plan, key);
            let session = SESSION.init_with(|| Session::new(machine, WIRES.take(), stores));
            if let Ok(task) = line_task(session) {
                line.spawner().spawn(task);
            }
        }
        loop {
            run::until_idle(line, &LINE);
            wait_for_interrupt(&LINE, EmulatedTime::Stands, || false);
        }
    }
}
