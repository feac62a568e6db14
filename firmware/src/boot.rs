//! From what lies in flash to the application, the same on every board.

use crate::app::{App, Companion};
use crate::autopilot::requests::Intervals;
use crate::journal::Journal;
use crate::stores::plan::Plan;
use crate::stores::{StoreError, configuration, key, plan, tiles};
use crate::wire::signing::Signing;
use plumbline_core::budget::SEARCH_MAX_PX;
use plumbline_core::pipeline::{Memory, Pipeline, Settings, SettingsError};
use plumbline_core::stamp::StampSettings;
use plumbline_core::tile::Tile;

/// Why a vehicle flies without fixes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootError {
    /// The configuration store was refused.
    Configuration(StoreError),
    /// The tile store was refused.
    Tiles(StoreError),
    /// The plan store was refused.
    Plan(StoreError),
    /// The key store was refused.
    Key(StoreError),
    /// All are good, but the plan reaches beyond the reference's grid.
    Astray,
    /// Either is good, but the reference is smaller than what the configuration searches.
    Misfit,
    /// The board lends less frame memory than a search needs.
    FrameMemory,
}

impl BootError {
    /// The reason, in parts that make one line of less than 50 characters.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            BootError::Configuration(error) => ["configuration: ", error.words()],
            BootError::Tiles(error) => ["tile store: ", error.words()],
            BootError::Plan(error) => ["plan store: ", error.words()],
            BootError::Key(error) => ["key store: ", error.words()],
            BootError::Astray => ["plan store: ", "far from the reference"],
            BootError::Misfit => ["tile store: ", "smaller than the search"],
            BootError::FrameMemory => ["board: ", "too little frame memory"],
        }
    }

    /// A number for a status word: never 0.
    pub fn code(self) -> u32 {
        match self {
            BootError::Configuration(error) => 0x10 + error.code(),
            BootError::Tiles(error) => 0x20 + error.code(),
            BootError::Misfit => 0x30,
            BootError::FrameMemory => 0x31,
            BootError::Astray => 0x32,
            BootError::Plan(error) => 0x40 + error.code(),
            BootError::Key(error) => 0x50 + error.code(),
        }
    }
}

impl From<SettingsError> for BootError {
    fn from(error: SettingsError) -> Self {
        match error {
            SettingsError::FrameMemory => BootError::FrameMemory,
            error => BootError::Configuration(StoreError::Settings(error)),
        }
    }
}

impl core::fmt::Display for BootError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.words().into_iter().try_for_each(|part| f.write_str(part))
    }
}

/// What the stores say, checked.
#[derive(Clone, Copy, Debug)]
pub struct Flight<'f> {
    /// The core's settings.
    pub settings: Settings,
    /// What stamps depend on.
    pub stamps: StampSettings,
    /// The reference, where it lies in flash.
    pub tile: Tile<'f>,
    /// Where photos are to be taken, if that is planned; otherwise they come as the camera takes them.
    pub plan: Option<Plan<'f>>,
    /// Whether rectified patches are sent.
    pub send_patches: bool,
    /// Who is on the link, and how fixes are sent.
    pub link: Companion,
}

/// Least side of a patch that the reference must hold beside the search, pixels.
const PATCH_PX: usize = 16;

/// Reads the stores, each from the region of flash that it begins; that of the plan may be empty. Any bytes may come.
///
/// # Errors
/// [`BootError`].
// Inlined, what it works with would lie on the stack below the building of the application.
#[inline(never)]
pub fn read<'f>(configuration: &[u8], tiles: &'f [u8], plan: &'f [u8]) -> Result<Flight<'f>, BootError> {
    let configuration = configuration::read(configuration).map_err(BootError::Configuration)?;
    let settings = configuration.settings().map_err(BootError::Configuration)?;
    let stamps = configuration.stamp_settings().map_err(BootError::Configuration)?;
    let tile = tiles::read(tiles).map_err(BootError::Tiles)?;
    let needed = PATCH_PX + 2 * (settings.search_px as usize).min(SEARCH_MAX_PX);
    let (cols, rows) = tile.size();
    if (cols.min(rows) as usize) < needed {
        return Err(BootError::Misfit);
    }
    let plan = plan::read(plan).map_err(BootError::Plan)?;
    if plan.is_some_and(|plan| !plan.on(tile.georeference()).is_within()) {
        return Err(BootError::Astray);
    }
    let fixes = configuration.link.fixes().map_err(BootError::Configuration)?;
    let link = Companion {
        speakers: configuration.link.speakers(),
        fixes,
        switching: configuration.link.switching().map_err(BootError::Configuration)?,
        start: configuration.link.start().map_err(BootError::Configuration)?,
        intervals: Intervals {
            attitude_us: settings.motions.attitude.interval_us,
            position_us: settings.motions.position.interval_us,
            range_us: configuration.link.range_interval_us,
        },
    };
    Ok(Flight { settings, stamps, tile, plan, send_patches: configuration.send_patches, link })
}

/// Reads the key store from the region of flash that it begins, which may be empty, and begins to sign where there is a key. Any
/// bytes may come. `stamp`: the newest time that the board knows, units of 10 us since 2015.
///
/// # Errors
/// [`BootError::Key`]: where a key is there, but damaged, nothing flies unsigned.
pub fn signing(key: &[u8], stamp: u64) -> Result<Option<Signing>, BootError> {
    let stored = key::read(key).map_err(BootError::Key)?;
    Ok(stored.map(|stored| Signing::new(stored.key, stamp.max(stored.first))))
}

impl<'t> Flight<'t> {
    /// The application; `signing` signs its messages, `journal` records all that decides.
    ///
    /// # Errors
    /// [`BootError::FrameMemory`]; settings that [`read`] has not checked may be refused as well.
    // Inlined, it is built where it is to lie; otherwise boot carries copies of it over the stack.
    #[inline(always)]
    pub fn app(
        self,
        memory: Memory<'t>,
        signing: Option<Signing>,
        journal: &'t dyn Journal,
    ) -> Result<App<'t>, BootError> {
        let Flight { settings, stamps, tile, plan, send_patches, link } = self;
        let pipeline = Pipeline::new(settings, tile, memory)?;
        Ok(App::new(pipeline, &stamps, plan, send_patches, &link, signing, journal))
    }
}
