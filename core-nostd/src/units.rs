//! Units that cross a public border.
//!
//! Inside a function a suffix (`_rad`, `_m`, `_px`, `_us`) says the unit; between modules these tuple structs do, so
//! that a tick of the capture timer cannot be taken for a microsecond of flight, nor a degree for a radian.

/// An angle in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Radians(pub f32);

/// A length in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Metres(pub f32);

/// An instant on the autopilot's clock: microseconds since it booted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Micros(pub u64);

/// A reading of the free-running 32-bit capture timer, nominally 1 MHz. It wraps every 71.6 minutes, so two readings
/// can be compared only while they are less than 35.8 minutes apart, and never by `<`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ticks(pub u32);

impl Radians {
    /// From degrees, which live only in files, command lines and logs.
    pub fn from_degrees(degrees: f32) -> Self {
        Radians(degrees * (core::f32::consts::PI / 180.0))
    }

    /// To degrees, for display.
    pub fn to_degrees(self) -> f32 {
        self.0 * (180.0 / core::f32::consts::PI)
    }

    /// The direction within ±π.
    pub fn wrapped(self) -> Self {
        let turn = 2.0 * core::f32::consts::PI;
        Radians(self.0 - turn * crate::math::round(self.0 / turn))
    }
}

impl Ticks {
    /// Signed distance `self - earlier` in ticks, right across a wrap.
    pub fn since(self, earlier: Ticks) -> i32 {
        self.0.wrapping_sub(earlier.0) as i32
    }
}

impl Micros {
    /// Signed distance `self - earlier` in microseconds, saturating at about ±35 minutes.
    pub fn since(self, earlier: Micros) -> i32 {
        let difference = self.0.wrapping_sub(earlier.0) as i64;
        difference.clamp(i32::MIN as i64, i32::MAX as i64) as i32
    }
}
