//! The simulator's mode: the application flies what comes over USB, on the wires of [`crate::serial`] in place of the
//! board's own camera, timer and link.
//!
//! The line runs on the board's executor, the application on one of its own, which a step runs until it is idle. What both
//! need beside the application lies in RAM that a flight uses for its DMA, or not at all. A reset ends the mode, unless the
//! simulator asked for it.

use super::counters::ChipCounters;
use super::fault;
use super::memory::Buffer;
use super::port::{BoardFrontEnd, BoardReader, BoardTimer, BoardWriter, Mode};
use super::watchdog::watched;
use super::{boot, tasks, usb};
use crate::board::Parts;
use crate::h743::life::BoardTask;
use crate::run::{self, Pending};
use crate::serial::boot::application;
use crate::serial::front_end::LineFrontEnd;
use crate::serial::message::Counts;
use crate::serial::serve::{End, serve};
use crate::serial::session::{Identity, Machine, Session};
use crate::serial::stores::{Stores, Uploaded};
use crate::serial::wires::{Port, Wires};
use core::sync::atomic::AtomicBool;
use cortex_m::peripheral::DWT;
use embassy_executor::raw::Executor;
use static_cell::StaticCell;

/// Capacities, bytes: the configuration store; the plan store; the key store; the tile store, 384 KiB; rows, the largest boxes there are,
/// 64 rows of the sensor's 752 pixels, and a piece.
const CONFIGURATION: usize = 4096;
const PLAN: usize = 16 * 1024;
const KEY: usize = 128;
const TILES: usize = 384 * 1024;
const ROWS: usize = 64 * 752 + 4096;

#[unsafe(link_section = ".sram123.simulator_wires")]
static WIRES: Buffer<Wires> = Buffer::new();
#[unsafe(link_section = ".sram123.simulator_session")]
static SESSION: Buffer<Session<Board>> = Buffer::new();
#[unsafe(link_section = ".sram123.simulator_rows")]
static MEMORY_ROWS: Buffer<[u8; ROWS]> = Buffer::new();
#[unsafe(link_section = ".sram123.simulator_configuration")]
static MEMORY_CONFIGURATION: Buffer<[u8; CONFIGURATION]> = Buffer::new();
#[unsafe(link_section = ".sram123.simulator_plan")]
static MEMORY_PLAN: Buffer<[u8; PLAN]> = Buffer::new();
#[unsafe(link_section = ".sram123.simulator_key")]
static MEMORY_KEY: Buffer<[u8; KEY]> = Buffer::new();
#[unsafe(link_section = ".axisram.simulator_tiles")]
static MEMORY_TILES: Buffer<[u8; TILES]> = Buffer::new();
static TAKEN: [AtomicBool; 7] = [const { AtomicBool::new(false) }; 7];

static PENDING: Pending = Pending::new();
static EXECUTOR: StaticCell<Executor> = StaticCell::new();

/// The flight computer under the session.
struct Board {
    clock_hz: u32,
    boot: u32,
    executor: &'static Executor,
}

impl Machine for Board {
    fn identity(&self) -> Identity {
        Identity { board: "OpenMV Cam H7", boot: self.boot, core_clock_hz: self.clock_hz, counts: Counts::Cycles }
    }

    #[inline(never)]
    fn boot(&mut self, uploaded: Uploaded, wires: &'static Wires) -> Result<(), [&'static str; 2]> {
        let rows = MEMORY_ROWS.take(&TAKEN[2]).ok_or(["the board: ", "its rows are taken"])?;
        let app = boot::keep(application(uploaded, boot::memory())?);
        let port = Port(wires);
        let parts = Parts {
            board: Mode::Simulator,
            front_end: BoardFrontEnd::Serial(LineFrontEnd::new(wires, rows)),
            reader: BoardReader::Serial(port),
            writer: BoardWriter::Serial(port),
            timer: BoardTimer::Serial(port),
            counters: ChipCounters(Some(wires)),
        };
        let is_spawned = tasks::spawn_application(self.executor.spawner(), app, parts);
        if is_spawned { Ok(()) } else { Err(["the board: ", "no room for a task"]) }
    }

    fn run(&mut self) {
        run::until_idle(self.executor, &PENDING);
    }

    fn count(&self) -> u32 {
        DWT::cycle_count()
    }
}

/// The simulator's line.
#[embassy_executor::task]
pub async fn line_task(clock_hz: u32, mut line_in: usb::UsbReader, mut line_out: usb::UsbWriter) {
    let memories = MEMORY_CONFIGURATION.take(&TAKEN[3]).zip(MEMORY_TILES.take(&TAKEN[4]));
    let wires = WIRES.put(&TAKEN[0], Wires::new);
    let others = MEMORY_PLAN.take(&TAKEN[5]).zip(MEMORY_KEY.take(&TAKEN[6]));
    let (Some((configuration, tiles)), Some((plan, key)), Some(wires)) = (memories, others, wires) else { return };
    let wires: &'static Wires = wires;
    let board = Board { clock_hz, boot: fault::boots(), executor: EXECUTOR.init(run::executor(&PENDING)) };
    let session = SESSION.put(&TAKEN[1], || Session::new(board, wires, Stores::new(configuration, tiles, plan, key)));
    let Some(session) = session else { return };
    let work = async {
        // An unplugged line is waited for by its receiver.
        while serve(session, &mut line_in, &mut line_out).await != End::Reset {}
        // The answer is on its way to the host.
        embassy_time::Timer::after_millis(50).await;
        fault::restart_as_simulator()
    };
    watched(BoardTask::Line, work).await
}
