//! The host as a board.

use super::super::tasks;
use crate::link::inproc::memory;
use embassy_executor::raw::Executor;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_firmware::run::{self, Pending};
use plumbline_firmware::serial::boot::application;
use plumbline_firmware::serial::front_end::LineFrontEnd;
use plumbline_firmware::serial::message::Counts;
use plumbline_firmware::serial::session::{Identity, Machine, Session};
use plumbline_firmware::serial::stores::{Stores, Uploaded};
use plumbline_firmware::serial::wires::{Port, Wires};

/// Room for the tile, bytes: a square of 2,850 pixels.
const TILE_ROOM: usize = plumbline_firmware::shared_memory::TILES_BYTES;
/// Room for the configuration, bytes.
const CONFIGURATION_ROOM: usize = 4096;
/// Room for the plan, bytes: 8,000 photos.
const PLAN_ROOM: usize = 64 * 1024;
/// Room for the key, bytes.
const KEY_ROOM: usize = 128;
/// Room for rows: the largest boxes there are, 64 rows, of the widest frame there is room for.
const ROWS_ROOM: usize = 64 * 2816 + 4096;

/// A board that has just booted. Its memory is never given back, as its application's tasks never end.
pub fn power_on(boot: u32) -> Session<Host> {
    let wires: &'static Wires = Box::leak(Box::default());
    let pending: &'static Pending = Box::leak(Box::default());
    let executor: &'static Executor = Box::leak(Box::new(run::executor(pending)));
    // Zeroed pages cost nothing until they are used.
    let room = |bytes: usize| vec![0; bytes].leak();
    let stores = Stores::new(room(CONFIGURATION_ROOM), room(TILE_ROOM), room(PLAN_ROOM), room(KEY_ROOM));
    Session::new(Host { boot, executor, pending }, wires, stores)
}

/// The host as a board.
pub struct Host {
    boot: u32,
    executor: &'static Executor,
    pending: &'static Pending,
}

impl Machine for Host {
    fn identity(&self) -> Identity {
        Identity { board: "host", boot: self.boot, core_clock_hz: 0, counts: Counts::Nothing }
    }

    fn boot(&mut self, uploaded: Uploaded, wires: &'static Wires) -> Result<(), [&'static str; 2]> {
        let memory = memory(FRAME_MEMORY_BYTES);
        let app = Box::leak(Box::new(application(uploaded, memory)?));
        let front_end = LineFrontEnd::new(wires, vec![0; ROWS_ROOM].leak());
        tasks::spawn(self.executor, app, Port(wires), front_end);
        Ok(())
    }

    fn run(&mut self) {
        run::until_idle(self.executor, self.pending);
    }

    fn count(&self) -> u32 {
        0
    }
}
