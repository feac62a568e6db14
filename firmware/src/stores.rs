//! What lies in flash: two stores, a third for who flies a plan and a fourth for who signs messages, each behind a header that
//! says what it is and whether it is whole.
//!
//! [`configuration`]: camera, calibration and settings. [`tiles`]: the reference and where it lies. [`plan`]: where photos are
//! to be taken. [`key`]: what messages are signed with; [`bounds`]: how far their time is reserved, which alone the board writes
//! itself. All are written on the ground and read at boot, in place: nothing is copied. A store that is refused leaves the
//! vehicle without fixes and with a reason ([`crate::app::grounded`]), never with wrong ones.

pub mod bounds;
pub mod configuration;
pub mod framing;
pub mod key;
pub mod plan;
pub mod tiles;

use plumbline_core::camera::CameraError;
use plumbline_core::pipeline::SettingsError;
use plumbline_core::stamp;
use plumbline_core::tile::TileError;

/// Why a store was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// Erased flash, or zeros, or less than a header.
    Nothing,
    /// Something else, such as the other store.
    Magic,
    /// The header's checksum fails.
    Header,
    /// A format that this build does not know.
    Version,
    /// The header's length is more than there is.
    Length,
    /// The payload's checksum fails.
    Payload,
    /// The payload is not what the format says, though whole: another length, an unknown number for a choice.
    Encoding,
    /// The camera's figures cannot be a camera's.
    Camera(CameraError),
    /// The settings do not fit each other or this build.
    Settings(SettingsError),
    /// The settings of the link cannot be meant.
    Link,
    /// The settings of shutter, timer and pulses do not fit each other.
    Stamps(stamp::SettingsError),
    /// The reference's size, resolution, georeference or elevation model is unusable.
    Reference(TileError),
    /// The plan's strips, points or limits cannot be flown.
    Plan,
}

impl StoreError {
    /// In a few words, after the store's name: at most 25 characters, so that the pilot's line holds them.
    pub fn words(self) -> &'static str {
        use stamp::SettingsError as Stamp;
        match self {
            StoreError::Nothing => "nothing there",
            StoreError::Magic => "something else",
            StoreError::Header => "header damaged",
            StoreError::Version => "unknown format",
            StoreError::Length => "cut short",
            StoreError::Payload => "content damaged",
            StoreError::Encoding => "malformed",
            StoreError::Camera(CameraError::Size) => "impossible frame size",
            StoreError::Camera(CameraError::FieldOfView) => "impossible field of view",
            StoreError::Camera(CameraError::NotFinite) => "impossible lens",
            StoreError::Settings(SettingsError::Search) => "impossible search radius",
            StoreError::Settings(SettingsError::Sigma) => "impossible sigma",
            StoreError::Settings(SettingsError::PixelsNotSquare) => "pixels are not square",
            StoreError::Settings(SettingsError::FrameMemory) => "too little frame memory",
            StoreError::Settings(SettingsError::Motion) => "impossible motion",
            StoreError::Settings(SettingsError::Mount) => "impossible mount",
            StoreError::Settings(SettingsError::Readout) => "impossible readout",
            StoreError::Settings(SettingsError::Limit) => "impossible time limit",
            StoreError::Settings(SettingsError::Lag) => "impossible lag",
            StoreError::Stamps(Stamp::Sigma) => "impossible jitter",
            StoreError::Stamps(Stamp::Delay) => "impossible delay",
            StoreError::Stamps(Stamp::Exposure) => "impossible exposure",
            StoreError::Stamps(Stamp::HoldOff) => "impossible hold-off",
            StoreError::Stamps(Stamp::NoExposure) => "exposure is not known",
            StoreError::Stamps(Stamp::Rate) => "impossible crystal",
            StoreError::Link => "impossible link",
            StoreError::Reference(TileError::Size) => "pixels are missing",
            StoreError::Reference(TileError::Georeference) => "impossible georeference",
            StoreError::Reference(TileError::Elevation) => "bad elevation model",
            StoreError::Plan => "impossible plan",
        }
    }

    /// A number for each: below 16 what is wrong, above the finer reason.
    pub(crate) fn code(self) -> u32 {
        match self {
            StoreError::Nothing => 0,
            StoreError::Magic => 1,
            StoreError::Header => 2,
            StoreError::Version => 3,
            StoreError::Length => 4,
            StoreError::Payload => 5,
            StoreError::Encoding => 6,
            StoreError::Camera(error) => 7 | (error as u32) << 8,
            StoreError::Settings(error) => 8 | (error as u32) << 8,
            StoreError::Stamps(error) => 9 | (error as u32) << 8,
            StoreError::Reference(error) => 10 | (error as u32) << 8,
            StoreError::Plan => 11,
            StoreError::Link => 12,
        }
    }
}
