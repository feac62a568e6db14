//! What lies in flash, made into an application.

use super::fault;
use crate::app::App;
use crate::boot::{self, BootError};
use crate::h743::mt9v034::{SensorError, Setting, Wanted};
use crate::journal::Journal;
use crate::wire::signing::Signing;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::motion::{Moving, Rates, Velocity, image_motion};
use plumbline_core::navigation::Navigation;
use plumbline_core::pipeline::{Buffers, Memory};
use plumbline_core::stamp::{Polarity, Wired};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use static_cell::{ConstStaticCell, StaticCell};

// First address and end of each store in flash; memory.x says where they are.
unsafe extern "C" {
    static _configuration: u8;
    static _configuration_end: u8;
    static _plan: u8;
    static _plan_end: u8;
    static _key: u8;
    static _key_end: u8;
    static _tiles: u8;
    static _tiles_end: u8;
}

static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
static NAVIGATION: ConstStaticCell<Navigation> = ConstStaticCell::new(Navigation::new());
static FRAME_MEMORY: ConstStaticCell<[u8; FRAME_MEMORY_BYTES]> = ConstStaticCell::new([0; FRAME_MEMORY_BYTES]);
static APP: StaticCell<App<'static>> = StaticCell::new();

/// Why there is no application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grounded {
    /// What lies in flash was refused.
    Stores(BootError),
    /// Reading flash has ended in faults: a write that lost its power leaves words that no longer are what their check bits
    /// say.
    Unreadable,
    /// The configuration wants edges that this board does not have: it knows when it opens the shutter, no more.
    Edges,
    /// The sensor cannot do what the configuration wants of it.
    Sensor(SensorError),
}

impl Grounded {
    /// For the pilot, in parts.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Grounded::Stores(error) => error.words(),
            Grounded::Unreadable => ["configuration: ", "flash cannot be read"],
            Grounded::Edges => ["configuration: ", "no edge, or no exposure"],
            Grounded::Sensor(SensorError::Window) => ["sensor: ", "frame does not fit it"],
            Grounded::Sensor(SensorError::Exposure) => ["sensor: ", "exposure does not fit it"],
        }
    }
}

/// An application, and what the board must do for it.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "App has none")]
pub struct Booted {
    /// The application.
    pub app: &'static App<'static>,
    /// Size of the frames.
    pub frame: (u16, u16),
    /// The sensor's setting.
    pub setting: Setting,
    /// What the configuration takes for the opening edge.
    pub opens_on: Polarity,
    /// Whether the exposure blurs by more than half a pixel in what counts as ordinary flight.
    pub blurs: bool,
}

/// The regions of flash: configuration, tiles, plan, key.
pub fn stores() -> [&'static [u8]; 4] {
    let regions = [
        (&raw const _configuration, &raw const _configuration_end),
        (&raw const _tiles, &raw const _tiles_end),
        (&raw const _plan, &raw const _plan_end),
        (&raw const _key, &raw const _key_end),
    ];
    regions.map(|(start, end)| {
        // SAFETY: all are flash that nobody writes while this image runs.
        unsafe { core::slice::from_raw_parts(start.addr() as *const u8, end.addr() - start.addr()) }
    })
}

/// What an application works in. To be called once.
#[inline(always)]
pub fn memory() -> Memory<'static> {
    Memory { buffers: BUFFERS.take(), navigation: NAVIGATION.take(), frame: FRAME_MEMORY.take() }
}

/// Where it lies. To be called once.
#[inline(always)]
pub fn keep(app: App<'static>) -> &'static App<'static> {
    APP.uninit().write(app)
}

/// Reads the stores. A function of its own, so that what it builds is off the stack when the flight begins. To be called
/// once.
///
/// # Errors
/// [`Grounded`].
#[inline(never)]
pub fn boot(clock_hz: u32, signing: Option<Signing>, journal: &'static dyn Journal) -> Result<Booted, Grounded> {
    let [configuration, tiles, plan, _] = stores();
    let flight = boot::read(configuration, tiles, plan).map_err(Grounded::Stores)?;
    let (camera, shutter) = (flight.settings.camera, flight.stamps.shutter);
    let exposure = shutter.exposure.filter(|_| shutter.wired == Wired::Opening).ok_or(Grounded::Edges)?;
    let frame = (camera.cols(), camera.rows());
    let setting = Setting::new(&Wanted { frame, exposure_us: exposure.us, clock_hz }).map_err(Grounded::Sensor)?;
    if let Some(limits) = flight.stamps.exposure {
        setting.exposed(limits.least_us, clock_hz).map_err(Grounded::Sensor)?;
        setting.exposed(limits.longest_us, clock_hz).map_err(Grounded::Sensor)?;
    }
    let limit_us = image_motion(&camera, &ORDINARY, exposure.us).map_or(0, |motion| motion.exposure_max_us);
    let app = keep(flight.app(memory(), signing, journal).map_err(Grounded::Stores)?);
    app.keep_resets_in(fault::resets());
    Ok(Booted { app, frame, setting, opens_on: shutter.opens_on, blurs: exposure.us > limit_us })
}

/// Ordinary flight, against which the exposure is judged before there is one: 20 m/s, 50 m up, pitching and rolling at
/// 10 degrees a second each. Chosen.
const ORDINARY: Moving = Moving {
    attitude: Attitude { heading: Radians(0.0), pitch: Radians(0.0), roll: Radians(0.0) },
    follow_up: Radians(0.0),
    rates: Rates { heading: 0.0, pitch: 0.17, roll: 0.17, follow_up: 0.0 },
    velocity: Velocity { north: 20.0, up: 0.0, east: 0.0 },
    height_m: 50.0,
};
