//! What lies in flash, made into an application.

use super::mt9v034::{SensorError, Setting, Wanted};
use crate::app::{App, Line};
use crate::mission::{ENCODED_MAX, Mission, MissionError};
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::motion::{Moving, Rates, Velocity, image_motion};
use plumbline_core::pipeline::{Buffers, Pipeline};
use plumbline_core::stamp::{Polarity, Stamper, Wired};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::Radians;
use static_cell::{ConstStaticCell, StaticCell};

/// Bank 2 of the flash: the mission in its first sector, the tile in the others.
const MISSION: usize = 0x0810_0000;
const TILE: usize = 0x0812_0000;
const TILE_BYTES: usize = 7 * 128 * 1024;

static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
static FRAME_MEMORY: ConstStaticCell<[u8; FRAME_MEMORY_BYTES]> = ConstStaticCell::new([0; FRAME_MEMORY_BYTES]);
static APP: StaticCell<App<'static>> = StaticCell::new();

/// Why there is no application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grounded {
    /// What lies in flash was refused.
    Mission(MissionError),
    /// The mission wants edges that this board does not have: it knows when it opens the shutter, no more.
    Edges,
    /// The sensor cannot do what the mission wants of it.
    Sensor(SensorError),
}

impl Grounded {
    /// For the pilot.
    pub fn line(self) -> Line {
        Line::new(match self {
            Grounded::Mission(MissionError::Encoding) => "no fixes: no mission in flash, or damaged",
            Grounded::Mission(MissionError::Camera) => "no fixes: the mission's camera is impossible",
            Grounded::Mission(MissionError::Settings) => "no fixes: the mission's settings do not fit",
            Grounded::Mission(MissionError::Tile) => "no fixes: the mission's tile is unusable",
            Grounded::Edges => "no fixes: needs opening edge, known exposure",
            Grounded::Sensor(SensorError::Window) => "no fixes: frame does not fit the sensor",
            Grounded::Sensor(SensorError::Exposure) => "no fixes: exposure does not fit the sensor",
        })
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
    /// What the mission takes for the opening edge.
    pub opens_on: Polarity,
    /// Whether the exposure blurs by more than half a pixel in what counts as ordinary flight.
    pub blurs: bool,
}

/// Reads the mission. A function of its own, so that what it builds is off the stack when the flight begins. To be called
/// once.
///
/// # Errors
/// [`Grounded`].
#[inline(never)]
pub fn boot(clock_hz: u32) -> Result<Booted, Grounded> {
    // SAFETY: both stand in flash, which nobody writes while this image runs.
    let (bytes, pixels) = unsafe {
        (
            core::slice::from_raw_parts(MISSION as *const u8, ENCODED_MAX),
            core::slice::from_raw_parts(TILE as *const u8, TILE_BYTES),
        )
    };
    let mission = Mission::decode(bytes).map_err(Grounded::Mission)?;
    let settings = mission.settings().map_err(Grounded::Mission)?;
    let stamps = mission.stamp_settings().map_err(Grounded::Mission)?;
    let area = usize::from(mission.tile.0) * usize::from(mission.tile.1);
    let pixels = pixels.get(..area).ok_or(Grounded::Mission(MissionError::Tile))?;
    let tile = mission.tile(pixels).map_err(Grounded::Mission)?;
    let exposure = stamps.shutter.exposure.filter(|_| stamps.shutter.wired == Wired::Opening).ok_or(Grounded::Edges)?;
    let wanted = Wanted { frame: mission.frame, exposure_us: exposure.us, clock_hz };
    let setting = Setting::new(&wanted).map_err(Grounded::Sensor)?;
    let limit_us = image_motion(&settings.camera, &ORDINARY, exposure.us).map_or(0, |motion| motion.exposure_max_us);
    let pipeline = Pipeline::new(settings, tile, BUFFERS.take(), FRAME_MEMORY.take())
        .map_err(|_| Grounded::Mission(MissionError::Settings))?;
    let app = APP.uninit().write(App::new(pipeline, Stamper::new(&stamps), mission.send_patches));
    let blurs = exposure.us > limit_us;
    Ok(Booted { app, frame: mission.frame, setting, opens_on: stamps.shutter.opens_on, blurs })
}

/// Ordinary flight, against which the exposure is judged before there is one: 20 m/s, 50 m up, turning at 10 degrees a
/// second.
const ORDINARY: Moving = Moving {
    attitude: Attitude { heading: Radians(0.0), pitch: Radians(0.0), roll: Radians(0.0) },
    follow_up: Radians(0.0),
    rates: Rates { heading: 0.0, pitch: 0.17, roll: 0.17, follow_up: 0.0 },
    velocity: Velocity { north: 20.0, up: 0.0, east: 0.0 },
    height_m: 50.0,
};
