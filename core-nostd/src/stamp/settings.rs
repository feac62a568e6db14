//! Settings of shutter, timer and pulses: wiring, calibrated delays, sigmas.

use super::EXPOSURE_MAX_US;

/// Direction of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Polarity {
    /// Up.
    Rising,
    /// Down.
    Falling,
}

/// Which of the shutter's edges reach the capture timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Wired {
    /// Both: a strobe output that is active while the shutter is open.
    Both = 0,
    /// The opening one: a trigger.
    Opening = 1,
    /// The closing one.
    Closing = 2,
    /// None: frames are stamped by their arrival.
    None = 3,
}

impl Wired {
    /// The wiring with this code.
    pub fn from_code(code: u8) -> Option<Self> {
        [Wired::Both, Wired::Opening, Wired::Closing, Wired::None].get(code as usize).copied()
    }

    /// Whether edges of a kind are latched.
    pub fn has(self, opens: bool) -> bool {
        match self {
            Wired::Both => true,
            Wired::Opening => opens,
            Wired::Closing => !opens,
            Wired::None => false,
        }
    }

    /// Number of latched edges of an exposure.
    pub fn count(self) -> u8 {
        match self {
            Wired::Both => 2,
            Wired::Opening | Wired::Closing => 1,
            Wired::None => 0,
        }
    }
}

/// The exposure that the camera is configured for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownExposure {
    /// Its length. The camera's clock and the timer's may differ by some ten parts per million of it.
    pub us: u32,
    /// Its repeatability, one sigma, microseconds.
    pub sigma_us: f32,
}

/// Shortest and longest exposure of a camera with commanded exposures, microseconds: the sensor's range, and the
/// user's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExposureLimits {
    /// Shortest.
    pub least_us: u32,
    /// Longest.
    pub longest_us: u32,
}

/// Shutter line and frame arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShutterSettings {
    /// The edges that are latched.
    pub wired: Wired,
    /// Which edge opens.
    pub opens_on: Polarity,
    /// Delay from the shutter's opening to its edge, calibrated; negative for a trigger that comes before.
    pub open_delay_us: i32,
    /// Delay from the shutter's closing to its edge, calibrated.
    pub close_delay_us: i32,
    /// An edge that follows another one sooner is a bounce. Shorter than any exposure.
    pub hold_off_us: u32,
    /// Jitter of an edge, one sigma, without the timer's rounding.
    pub edge_sigma_us: f32,
    /// The exposure, `None` if the camera chooses it itself.
    pub exposure: Option<KnownExposure>,
    /// Latency from the shutter's closing to the arrival of the first row, calibrated.
    pub readout_us: u32,
    /// Jitter of the arrival, one sigma.
    pub arrival_sigma_us: f32,
}

/// The timer's crystal and its references to the autopilot's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockSettings {
    /// Jitter of a pulse, one sigma, without the timer's rounding.
    pub pulse_sigma_us: f32,
    /// Tolerance of the crystal, one sigma.
    pub rate_sigma_ppm: f32,
    /// Random walk of its rate: parts per million in a second, growing with the root of time.
    pub rate_walk_ppm: f32,
    /// Error of a time exchange however quick it was, one sigma: the two ways take different times.
    pub timesync_sigma_us: f32,
    /// A stamp with a larger sigma is refused.
    pub sigma_max_us: f32,
}

/// All settings of stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampSettings {
    /// Shutter line and frame arrival.
    pub shutter: ShutterSettings,
    /// Timer and pulses.
    pub clock: ClockSettings,
    /// Range of the controlled exposure; `None` without control. The known exposure is the first one.
    pub exposure: Option<ExposureLimits>,
}

/// Why settings were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SettingsError {
    /// A sigma is negative, not a number or beyond a second.
    Sigma,
    /// A delay, a latency or the hold-off is beyond the longest exposure.
    Delay,
    /// The exposure is zero, longer than the longest possible, or beyond its limits, or these are in the wrong order.
    Exposure,
    /// The hold-off is as long as the exposure, or the delays would swap its edges.
    HoldOff,
    /// One edge or none is latched, or the exposure is controlled, and no exposure is known.
    NoExposure,
    /// The crystal's tolerance or walk is impossible for a crystal.
    Rate,
}

/// A second: a larger sigma is a mistaken unit.
const SIGMA_MAX_US: f32 = 1e6;
/// Ten times the worst crystal's tolerance.
const RATE_MAX_PPM: f32 = 1000.0;

impl ShutterSettings {
    /// The delay of an edge.
    pub fn delay_us(&self, opens: bool) -> i32 {
        if opens { self.open_delay_us } else { self.close_delay_us }
    }

    fn check(&self) -> Result<(), SettingsError> {
        let longest = EXPOSURE_MAX_US as u32;
        let delays = [self.open_delay_us.unsigned_abs(), self.close_delay_us.unsigned_abs(), self.hold_off_us];
        if delays.iter().any(|&delay| delay > longest) || self.readout_us > 2 * longest {
            return Err(SettingsError::Delay);
        }
        let exposure_sigma_us = self.exposure.map_or(0.0, |exposure| exposure.sigma_us);
        if ![self.edge_sigma_us, self.arrival_sigma_us, exposure_sigma_us].into_iter().all(is_sigma) {
            return Err(SettingsError::Sigma);
        }
        match self.exposure {
            None if self.wired == Wired::Both => Ok(()),
            None => Err(SettingsError::NoExposure),
            Some(known) if !(1..=longest).contains(&known.us) => Err(SettingsError::Exposure),
            Some(known) => {
                let closer_us = self.open_delay_us.saturating_sub(self.close_delay_us).max(0) as u32;
                let apart = known.us > self.hold_off_us.saturating_add(closer_us);
                if apart || self.wired == Wired::None { Ok(()) } else { Err(SettingsError::HoldOff) }
            }
        }
    }
}

impl StampSettings {
    /// # Errors
    /// [`SettingsError`].
    pub fn check(&self) -> Result<(), SettingsError> {
        self.shutter.check()?;
        if let Some(limits) = self.exposure {
            let known = self.shutter.exposure.ok_or(SettingsError::NoExposure)?;
            if !(limits.least_us..=limits.longest_us).contains(&known.us) {
                return Err(SettingsError::Exposure);
            }
            let at = |us| ShutterSettings { exposure: Some(KnownExposure { us, ..known }), ..self.shutter }.check();
            at(limits.least_us).and(at(limits.longest_us))?;
        }
        let clock = &self.clock;
        let sigmas = [clock.pulse_sigma_us, clock.timesync_sigma_us, clock.sigma_max_us];
        if !sigmas.into_iter().all(is_sigma) || clock.sigma_max_us == 0.0 {
            return Err(SettingsError::Sigma);
        }
        let is_rate = |ppm: f32| (0.0..=RATE_MAX_PPM).contains(&ppm);
        if is_rate(clock.rate_sigma_ppm) && clock.rate_sigma_ppm > 0.0 && is_rate(clock.rate_walk_ppm) {
            Ok(())
        } else {
            Err(SettingsError::Rate)
        }
    }
}

/// Whether a value can be a sigma; NaN cannot.
fn is_sigma(us: f32) -> bool {
    (0.0..=SIGMA_MAX_US).contains(&us)
}
