//! Links to a firmware: the same steps, whoever runs it.
//!
//! Simulator and firmware go in lockstep. A step sets the capture timer, lets one thing happen (bytes arrive, a pulse,
//! a frame) and ends when the firmware has nothing left to do; what it sent meanwhile is the step's result. One event a
//! step makes the order of events the same on every link.

pub mod annotation;
pub mod device;
pub mod inproc;
pub mod line;
pub mod mirror;
pub mod mutants;
pub mod pace;
pub mod qemu;
pub mod serial;
pub(crate) mod tasks;

use plumbline_core::pipeline::SettingsError;
use plumbline_firmware::boot::{self, BootError};
use plumbline_firmware::serial::message::Counts;
use plumbline_firmware::stores::StoreError;
use plumbline_firmware::stores::configuration::{Configuration, STORE_MAX};
use plumbline_firmware::stores::tiles::TileHead;
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::fmt;

/// What happens in a step.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// Time passes.
    Nothing,
    /// Bytes from the autopilot.
    Bytes(&'a [u8]),
    /// A pulse per second, latched at this tick.
    Pulse(u32),
    /// An edge of the shutter's line.
    Edge {
        /// The tick that it was latched at.
        tick: u32,
        /// Which way the line went.
        rising: bool,
    },
    /// A frame whose first row has arrived.
    Frame(FrameEvent<'a>),
}

/// A frame as the front end hands it over.
#[derive(Clone, Copy, Debug)]
pub struct FrameEvent<'a> {
    /// Number of the frame.
    pub sequence: u32,
    /// Tick at which its first row arrived.
    pub arrival: u32,
    /// (cols, rows).
    pub size: (u16, u16),
    /// Row-major, row 0 forward.
    pub pixels: &'a [u8],
}

/// How the vehicle moves; nothing of the flight depends on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving {
    /// About the body's axes forward, right and down, radians a second.
    pub rates_rad_s: [f64; 3],
    /// The waypoint that is flown to, from 0 on, where the flight has such.
    pub waypoint: Option<usize>,
}

/// Why a link failed.
#[derive(Debug)]
pub enum LinkError {
    /// Something the user can mend: a missing image, an emulator that is not installed, a refused configuration.
    Input(InputError),
    /// The firmware stopped answering or broke the protocol.
    Lost(String),
    /// Somebody wanted the flight to end.
    Interrupted,
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LinkError::Input(error) => error.fmt(f),
            LinkError::Lost(why) => write!(f, "the firmware was lost: {why}"),
            LinkError::Interrupted => f.write_str("the flight was interrupted"),
        }
    }
}

impl std::error::Error for LinkError {}

impl From<InputError> for LinkError {
    fn from(error: InputError) -> Self {
        LinkError::Input(error)
    }
}

/// What a link says that cannot cut its board's power.
pub const NO_REBOOT: &str =
    "a fault of the unit power needs --link inproc without --log: elsewhere the simulator cannot cut the board's power";

/// A firmware that can be flown.
pub trait Link {
    /// One step: the capture timer reads `timer`, `event` happens, the firmware works until it is idle. The bytes it
    /// sent.
    ///
    /// # Errors
    /// [`LinkError`].
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError>;

    /// The firmware boots anew with what lies in its flash.
    ///
    /// # Errors
    /// [`LinkError::Input`] on a link that cannot cut its board's power.
    fn reboot(&mut self, _: &Flash) -> Result<(), LinkError> {
        Err(LinkError::Input(InputError::new(NO_REBOOT)))
    }

    /// What the link itself has to tell of the flight so far.
    fn account(&self) -> Account {
        Account::default()
    }

    /// Something of the simulator's for the firmware's log, where the link keeps one.
    fn annotate(&mut self, _: &[u8]) {}

    /// How the vehicle moves, for whoever watches: worked out where somebody does.
    fn show(&mut self, _: &dyn Fn() -> Moving) {}

    /// Closes the firmware's log; all of it, where the link keeps one.
    fn close_log(&mut self) -> Vec<u8> {
        Vec::new()
    }
}

/// What a link reports of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// What the costs in the firmware's reports count.
    pub counts: Counts,
    /// Clock of the firmware's core, where there is one to tell.
    pub core_clock_hz: Option<u32>,
    /// Name of the board and version of its firmware, where it reported them.
    pub board: Option<String>,
    /// What went wrong; `None` on a link on which nothing can.
    pub trouble: Option<LinkTrouble>,
    /// What the board's work came to, tasks and executor included, where it counts.
    pub work: Option<WorkCost>,
}

/// What a board's work came to, in what it counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WorkCost {
    /// Steps and pieces of steps.
    pub steps: u64,
    /// All of them.
    pub total: u64,
    /// The most expensive one.
    pub max: u32,
}

impl WorkCost {
    /// Counts one.
    pub fn count(&mut self, cost: u32) {
        (self.steps, self.total, self.max) = (self.steps + 1, self.total + u64::from(cost), self.max.max(cost));
    }
}

/// What went wrong on a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LinkTrouble {
    /// Requests sent again.
    pub resends: u64,
    /// Waits for an answer that ended without one.
    pub timeouts: u64,
    /// Messages dropped: a wrong CRC, or no message at all.
    pub bad_checksum: u64,
    /// Answers to requests that had been answered.
    pub stale: u64,
    /// Lines opened anew.
    pub reconnects: u64,
    /// Reboots of the board in mid-flight.
    pub reboots: u64,
    /// Frames that a reboot took: not yet handed over whole, or not yet reported.
    pub frames_abandoned: u64,
}

impl fmt::Display for LinkTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} resends, {} time-outs, {} bad checksums, {} stale answers, {} reconnects, {} reboots, {} frames abandoned",
            self.resends,
            self.timeouts,
            self.bad_checksum,
            self.stale,
            self.reconnects,
            self.reboots,
            self.frames_abandoned
        )
    }
}

/// What a firmware needs before it boots: what lies in its flash.
#[derive(Clone, Debug)]
pub struct Flash {
    /// Camera, calibration, settings.
    pub configuration: Configuration,
    /// The tile's size and where it lies.
    pub head: TileHead,
    /// The tile's pixels, row-major.
    pub tile: Vec<u8>,
    /// The posts of its elevation model, as they are stored; empty without one.
    pub posts: Vec<u8>,
    /// The plan store; empty where photos are not planned.
    pub plan: Vec<u8>,
    /// The key store; empty where messages are not signed.
    pub key: Vec<u8>,
}

/// The stores, as they lie in flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stores {
    /// The configuration store.
    pub configuration: Vec<u8>,
    /// The tile store.
    pub tiles: Vec<u8>,
    /// The plan store, or nothing.
    pub plan: Vec<u8>,
    /// The key store, or nothing.
    pub key: Vec<u8>,
}

impl Flash {
    /// The stores.
    ///
    /// # Errors
    /// [`InputError`] when configuration, tile or plan cannot be flown; the firmware would refuse them at boot.
    pub fn stores(&self) -> Result<Stores, InputError> {
        let mut buffer = [0; STORE_MAX];
        let refusal = |error| {
            InputError::new(format!("the firmware refuses what lies in flash: {}", why(error, &self.configuration)))
        };
        let configuration =
            self.configuration.store(&mut buffer).map_err(|error| refusal(BootError::Configuration(error)))?.to_vec();
        let tiles =
            tile_store(&self.head, &self.tile, &self.posts).map_err(|error| refusal(BootError::Tiles(error)))?;
        let stores = Stores { configuration, tiles, plan: self.plan.clone(), key: self.key.clone() };
        stores.check().map_err(refusal)?;
        Ok(stores)
    }
}

impl Stores {
    /// Whether the firmware flies with them.
    ///
    /// # Errors
    /// Why it is grounded.
    pub fn check(&self) -> Result<(), BootError> {
        boot::read(&self.configuration, &self.tiles, &self.plan)?;
        boot::signing(&self.key, 0).map(|_| ())
    }
}

/// The tile store of a head, its pixels, and the posts of its elevation model, which are none without one.
///
/// # Errors
/// [`StoreError::Reference`] where they do not belong together or are unusable.
pub fn tile_store(head: &TileHead, pixels: &[u8], posts: &[u8]) -> Result<Vec<u8>, StoreError> {
    let (before, gap) = head.before(pixels, posts)?;
    Ok([&before[..], pixels, gap, posts].concat())
}

/// Why the firmware refuses its stores, with what would be right where that can be told.
pub fn why(error: BootError, configuration: &Configuration) -> String {
    let BootError::Configuration(StoreError::Settings(SettingsError::PixelsNotSquare)) = error else {
        return error.to_string();
    };
    let (cols, rows) = configuration.frame;
    let (across, along) = (f64::from(configuration.fov_rad.0), f64::from(configuration.fov_rad.1));
    let wanted = 2.0 * ((0.5 * across).tan() * f64::from(rows) / f64::from(cols)).atan();
    format!(
        "{error}: fov_v_deg is {:.4}, and {:.4} would go with fov_h_deg = {:.4} and {cols} x {rows} pixels, to a thousandth",
        along.to_degrees(),
        wanted.to_degrees(),
        across.to_degrees()
    )
}
