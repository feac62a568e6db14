//! What lies in flash: two stores, and a third for who flies a plan, each behind a header that says what it is and whether it
//! is whole.
//!
//! [`mission`]: camera, calibration and settings. [`tiles`]: the reference and where it lies. [`plan`]: where photos are to be
//! taken. All are written on the ground and read at boot, in place: nothing is copied. A store that is refused leaves the vehicle without fixes
//! and with a reason ([`crate::app::grounded`]), never with wrong ones.

pub mod framing;
pub mod mission;
pub mod plan;
pub mod tiles;

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
    Camera,
    /// The settings do not fit each other or this build.
    Settings,
    /// The settings of shutter, timer and pulses do not fit each other.
    Stamps,
    /// The reference's size, resolution or georeference is unusable.
    Reference,
    /// The plan's strips, places or limits cannot be flown.
    Plan,
}

impl StoreError {
    /// In a few words, after the store's name.
    pub fn words(self) -> &'static str {
        match self {
            StoreError::Nothing => "nothing there",
            StoreError::Magic => "something else",
            StoreError::Header => "header damaged",
            StoreError::Version => "unknown format",
            StoreError::Length => "cut short",
            StoreError::Payload => "content damaged",
            StoreError::Encoding => "malformed",
            StoreError::Camera => "impossible camera",
            StoreError::Settings => "impossible settings",
            StoreError::Stamps => "impossible shutter",
            StoreError::Reference => "impossible reference",
            StoreError::Plan => "impossible plan",
        }
    }
}
