//! The settings of the stamps as they are stored.

use crate::stores::StoreError;
use plumbline_core::stamp::{
    ClockSettings, ExposureLimits, KnownExposure, Polarity, ShutterSettings, StampSettings, Wired,
};
use serde::{Deserialize, Serialize};

/// Shutter line, capture timer and pulses. Times in microseconds, rates in parts per million; the meaning of each field is
/// that of [`StampSettings`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stamps {
    /// [`Wired`]: 0 both edges, 1 the opening one, 2 the closing one, 3 none.
    pub wired: u8,
    /// Whether the rising edge opens.
    pub opens_rising: bool,
    /// Delays of the opening and the closing edge.
    pub delays_us: (i32, i32),
    /// Hold-off.
    pub hold_off_us: u32,
    /// Jitter of an edge.
    pub edge_sigma_us: f32,
    /// Known exposure with its sigma.
    pub exposure_us: Option<(u32, f32)>,
    /// Latency of the first row after the shutter's closing, and its jitter.
    pub readout_us: (u32, f32),
    /// Jitter of a pulse.
    pub pulse_sigma_us: f32,
    /// The crystal's tolerance, and its walk in a second.
    pub rate_ppm: (f32, f32),
    /// What a time exchange may be off.
    pub timesync_sigma_us: f32,
    /// Largest sigma of a stamp.
    pub sigma_max_us: f32,
    /// Shortest and longest exposure where it is controlled.
    pub exposure_limits_us: Option<(u32, u32)>,
}

impl Stamps {
    /// The core's settings.
    pub(super) fn settings(&self) -> Result<StampSettings, StoreError> {
        let settings = StampSettings {
            shutter: ShutterSettings {
                wired: Wired::from_code(self.wired).ok_or(StoreError::Encoding)?,
                opens_on: if self.opens_rising { Polarity::Rising } else { Polarity::Falling },
                open_delay_us: self.delays_us.0,
                close_delay_us: self.delays_us.1,
                hold_off_us: self.hold_off_us,
                edge_sigma_us: self.edge_sigma_us,
                exposure: self.exposure_us.map(|(us, sigma_us)| KnownExposure { us, sigma_us }),
                readout_us: self.readout_us.0,
                arrival_sigma_us: self.readout_us.1,
            },
            clock: ClockSettings {
                pulse_sigma_us: self.pulse_sigma_us,
                rate_sigma_ppm: self.rate_ppm.0,
                rate_walk_ppm: self.rate_ppm.1,
                timesync_sigma_us: self.timesync_sigma_us,
                sigma_max_us: self.sigma_max_us,
            },
            exposure: self.exposure_limits_us.map(|(least_us, longest_us)| ExposureLimits { least_us, longest_us }),
        };
        settings.check().map(|()| settings).map_err(StoreError::Stamps)
    }
}
