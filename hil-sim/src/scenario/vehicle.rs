//! What a board is configured with: camera mount, sensors, shutter and search, as a calibration and the data sheets give them.
//! A settings file (`plumbline configuration --settings`) is this part of a scenario alone.

mod auto_exposure;
mod link;

use super::bounds::Bounded;
pub use auto_exposure::AutoExposure;
pub use link::{FixMessage, Link, Start, SwitchSource};
use plumbline_core::budget::REACQUIRE_PX;
use plumbline_core::pose::noise::LAGS;
use plumbline_core::stamp::EXPOSURE_MAX_US;
use plumbline_survey::camera_file::{ARM_MAX_M, BORESIGHT_MAX_DEG};
use serde::{Deserialize, Serialize};

/// Keys carry their units; angles are degrees in files and nowhere else.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Vehicle {
    /// Which head of the camera file flies, counted from 1.
    pub head: Option<u8>,
    /// Whether the firmware sends its patches down.
    pub send_patches: bool,
    /// Pixel size R of reference and patch, metres.
    pub resolution_m: f64,
    /// Search radius of the matching, pixels of the reference.
    pub search_px: u16,
    /// Shutter open to shutter close, microseconds.
    pub exposure_us: u32,
    /// Whether the firmware chooses the exposure.
    pub auto_exposure: AutoExposure,
    /// From the exposure of the first row to that of the last, milliseconds; 0 is a global shutter. Stamp and truth are
    /// those of the middle row.
    pub rolling_shutter_ms: f64,
    /// How the camera is mounted.
    pub mount: Mount,
    /// What the vehicle may do.
    pub flight: Flight,
    /// Attitude sensor.
    pub attitude: Attitude,
    /// Camera servo and its encoder.
    pub follow_up: FollowUp,
    /// Laser rangefinder, strapped down along the camera's axis.
    pub range: Range,
    /// Position prior.
    pub position: Position,
    /// The autopilot's altitude.
    pub altitude: Altitude,
    /// The shutter's line and the frames' arrival.
    pub shutter: Shutter,
    /// The board's capture timer and the pulse per second.
    pub timer: Timer,
    /// Who is on the link, and how fixes are sent.
    pub link: Link,
}

impl Default for Vehicle {
    fn default() -> Self {
        Vehicle {
            head: None,
            send_patches: true,
            resolution_m: 5.0,
            search_px: 10,
            exposure_us: 2000,
            auto_exposure: AutoExposure::default(),
            rolling_shutter_ms: 0.0,
            mount: Mount::default(),
            flight: Flight::default(),
            attitude: Attitude::default(),
            follow_up: FollowUp::default(),
            range: Range::default(),
            position: Position::default(),
            altitude: Altitude::default(),
            shutter: Shutter::default(),
            timer: Timer::default(),
            link: Link::default(),
        }
    }
}

/// How the camera sits in the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Mount {
    /// From the antenna, whose position is reported and corrected, to the camera: forward, right, down.
    pub lever_arm_m: [f64; 3],
    /// The camera against where the follow-up axis has it look, as the firmware is configured.
    pub boresight: Boresight,
}

/// φ, ω, κ of the vehicle from the camera, as `[boresight]` of a camera file has them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Boresight {
    /// About the forward axis.
    pub phi_deg: f64,
    /// About the right axis.
    pub omega_deg: f64,
    /// About the axis that looks up.
    pub kappa_deg: f64,
}

impl Boresight {
    /// φ, ω, κ, degrees.
    #[must_use]
    pub fn angles_deg(&self) -> [f64; 3] {
        [self.phi_deg, self.omega_deg, self.kappa_deg]
    }

    /// A camera that looks where the follow-up axis has it look.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Boresight::default()
    }

    pub(super) fn ranges(&self, keys: [&'static str; 3]) -> impl Iterator<Item = Bounded> + use<> {
        keys.into_iter().zip(self.angles_deg()).map(|(key, deg)| (key, deg, -BORESIGHT_MAX_DEG, BORESIGHT_MAX_DEG))
    }
}

/// What the vehicle may do.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Flight {
    /// Pitch and roll are uniform within plus and minus this.
    pub tilt_max_deg: f64,
    /// Slowest and fastest parts of pitch and roll, hertz.
    pub tilt_hz: [f64; 2],
    /// Root-mean-square horizontal speed; lower where the ground is too small to turn at it.
    pub speed_m_s: f64,
}

impl Default for Flight {
    fn default() -> Self {
        Flight { tilt_max_deg: 10.0, tilt_hz: [0.05, 0.25], speed_m_s: 35.0 }
    }
}

/// Attitude sensor. Each of heading, pitch and roll has noise of its own: white, plus a first-order Gauss-Markov drift.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Attitude {
    /// Samples a second.
    pub rate_hz: u32,
    /// How much older than its stamp a value is: the sensor's own filters.
    pub delay_us: u32,
    /// Whole samples that the firmware's pose lags behind the newest.
    pub lag: u8,
    /// White noise, one sigma.
    pub white_deg: f64,
    /// Drift, one sigma.
    pub drift_deg: f64,
    /// White noise of the heading; that of pitch and roll unless given.
    pub heading_white_deg: Option<f64>,
    /// Drift of the heading; that of pitch and roll unless given.
    pub heading_drift_deg: Option<f64>,
    /// Of an attitude that is found from accelerometers and a velocity: one sigma of that velocity's error, which in a turn
    /// becomes tilt, and heading with it.
    pub turn_velocity_sigma_m_s: f64,
}

impl Default for Attitude {
    fn default() -> Self {
        Attitude {
            rate_hz: 200,
            delay_us: 0,
            lag: 2,
            white_deg: 0.1,
            drift_deg: 0.0,
            heading_white_deg: None,
            heading_drift_deg: None,
            turn_velocity_sigma_m_s: 0.0,
        }
    }
}

/// What the camera does about the heading, and what the firmware is configured for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FollowUpMode {
    /// A servo follows; the firmware computes the follow-up angle.
    #[default]
    Followed,
    /// A servo follows; the firmware reads its encoder.
    Measured,
    /// No servo: the follow-up angle is zero.
    Fixed,
}

/// Camera servo and encoder. The encoder sends in the mode "measured" only.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FollowUp {
    /// Which of the three.
    pub mode: FollowUpMode,
    /// White noise of the encoder, one sigma.
    pub noise_deg: f64,
    /// As for attitude.
    pub delay_us: u32,
}

impl Default for FollowUp {
    fn default() -> Self {
        FollowUp { mode: FollowUpMode::Followed, noise_deg: 0.05, delay_us: 0 }
    }
}

/// What the autopilot's altitude is worth against the elevation model: the board is told.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Altitude {
    /// Of its bias, one sigma.
    pub sigma_m: f64,
    /// Of its scale, one sigma, as a share.
    pub scale_sigma: f64,
}

impl Default for Altitude {
    /// A barometer that was set elsewhere or some hours ago, and air that is 10 degrees warmer or colder than the standard's.
    fn default() -> Self {
        Altitude { sigma_m: 15.0, scale_sigma: 0.04 }
    }
}

/// Laser rangefinder.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Range {
    /// White noise of the slant, one sigma.
    pub sigma_m: f64,
    /// Samples a second.
    pub rate_hz: u32,
    /// As for attitude.
    pub delay_us: u32,
}

impl Default for Range {
    fn default() -> Self {
        Range { sigma_m: 0.03, rate_hz: 50, delay_us: 0 }
    }
}

/// Position prior, as a vehicle without satellite navigation has it: good to a few pixels, drifting.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Position {
    /// Gauss-Markov error of each of east, north and up, one sigma; two pixels of the reference unless given, so that
    /// the usual search of ten covers five sigmas.
    pub sigma_m: Option<f64>,
    /// White noise of each of east, north and up, one sigma.
    pub white_m: f64,
    /// White noise of each velocity, one sigma.
    pub velocity_sigma_m_s: f64,
    /// Samples a second.
    pub rate_hz: u32,
    /// As for attitude.
    pub delay_us: u32,
}

impl Default for Position {
    fn default() -> Self {
        Position { sigma_m: None, white_m: 0.0, velocity_sigma_m_s: 0.1, rate_hz: 5, delay_us: 0 }
    }
}

/// Which of the shutter's edges are wired to the capture timer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EdgeSource {
    /// Both.
    #[default]
    Both,
    /// The opening one.
    One,
    /// None: frames are stamped by their arrival.
    None,
}

/// The shutter's line, and the way of a frame to the board. The firmware is configured with delays, latency and sigmas, as a
/// calibration would find them.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Shutter {
    /// Which edges are wired.
    pub edges: EdgeSource,
    /// White noise of each edge, one sigma.
    pub edge_jitter_us: f64,
    /// From the shutter's opening to its edge.
    pub open_delay_us: i32,
    /// From the shutter's closing to its edge.
    pub close_delay_us: i32,
    /// White noise of the exposure's length, one sigma, rounded to whole microseconds.
    pub exposure_jitter_us: f64,
    /// From the shutter's closing to the arrival of the first row.
    pub arrival_latency_us: u32,
    /// White noise of the arrival, one sigma; none is off by more than four.
    pub arrival_jitter_us: f64,
}

impl Default for Shutter {
    fn default() -> Self {
        Shutter {
            edges: EdgeSource::Both,
            edge_jitter_us: 1.0,
            open_delay_us: 0,
            close_delay_us: 0,
            exposure_jitter_us: 0.0,
            arrival_latency_us: 50,
            arrival_jitter_us: 5.0,
        }
    }
}

/// The free-running 32-bit capture timer of 1 MHz, and the pulse per second that ties it to the autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Timer {
    /// Random walk of its rate, one sigma in a second, parts per million.
    pub rate_walk_ppm: f64,
    /// White noise of the pulse, one sigma.
    pub pps_jitter_us: f64,
}

impl Default for Timer {
    fn default() -> Self {
        Timer { rate_walk_ppm: 0.01, pps_jitter_us: 0.5 }
    }
}

impl Vehicle {
    /// One sigma of the navigation's position along each axis, metres.
    #[must_use]
    pub fn position_sigma_m(&self) -> f64 {
        self.position.sigma_m.unwrap_or(2.0 * self.resolution_m)
    }

    /// From the exposure of the first row to that of the last, microseconds.
    #[must_use]
    pub fn rolling_shutter_us(&self) -> u64 {
        (1000.0 * self.rolling_shutter_ms).round() as u64
    }

    /// Shortest and longest exposure that a frame may have, microseconds.
    #[must_use]
    pub fn exposures_us(&self) -> [u32; 2] {
        let AutoExposure { is_on, least_us, longest_us } = self.auto_exposure;
        if is_on { [least_us, longest_us] } else { [self.exposure_us; 2] }
    }

    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let (attitude, follow_up, position) = (&self.attitude, &self.follow_up, &self.position);
        let mut ranges = vec![
            ("resolution_m", self.resolution_m, 0.01, 1000.0),
            ("search_px", self.search_px.into(), 1.0, REACQUIRE_PX as f64),
            ("exposure_us", self.exposure_us.into(), 1.0, EXPOSURE_MAX_US.into()),
            ("rolling_shutter_ms", self.rolling_shutter_ms, 0.0, 1000.0),
            ("flight.tilt_max_deg", self.flight.tilt_max_deg, 0.0, 80.0),
            ("flight.speed_m_s", self.flight.speed_m_s, 0.0, 1000.0),
            ("attitude.rate_hz", attitude.rate_hz.into(), 1.0, 10_000.0),
            ("attitude.delay_us", attitude.delay_us.into(), 0.0, 1e6),
            ("attitude.lag", attitude.lag.into(), 0.0, (LAGS - 1) as f64),
            ("attitude.white_deg", attitude.white_deg, 0.0, 90.0),
            ("attitude.drift_deg", attitude.drift_deg, 0.0, 90.0),
            ("attitude.heading_white_deg", attitude.heading_white_deg.unwrap_or(0.0), 0.0, 90.0),
            ("attitude.heading_drift_deg", attitude.heading_drift_deg.unwrap_or(0.0), 0.0, 90.0),
            ("attitude.turn_velocity_sigma_m_s", attitude.turn_velocity_sigma_m_s, 0.0, 100.0),
            ("follow_up.noise_deg", follow_up.noise_deg, 0.0, 90.0),
            ("follow_up.delay_us", follow_up.delay_us.into(), 0.0, 1e6),
            ("range.sigma_m", self.range.sigma_m, 0.0, 1000.0),
            ("range.rate_hz", self.range.rate_hz.into(), 1.0, 1000.0),
            ("range.delay_us", self.range.delay_us.into(), 0.0, 1e6),
            ("position.sigma_m", position.sigma_m.unwrap_or(0.0), 0.0, 1e5),
            ("position.white_m", position.white_m, 0.0, 1e5),
            ("position.velocity_sigma_m_s", position.velocity_sigma_m_s, 0.0, 1000.0),
            ("position.rate_hz", position.rate_hz.into(), 1.0, 1000.0),
            ("position.delay_us", position.delay_us.into(), 0.0, 1e6),
            ("altitude.sigma_m", self.altitude.sigma_m, 0.0, 1e4),
            ("altitude.scale_sigma", self.altitude.scale_sigma, 0.0, 1.0),
            ("shutter.edge_jitter_us", self.shutter.edge_jitter_us, 0.0, 1e4),
            ("shutter.open_delay_us", self.shutter.open_delay_us.into(), -1e5, 1e5),
            ("shutter.close_delay_us", self.shutter.close_delay_us.into(), -1e5, 1e5),
            ("shutter.exposure_jitter_us", self.shutter.exposure_jitter_us, 0.0, 1e4),
            ("shutter.arrival_latency_us", self.shutter.arrival_latency_us.into(), 1.0, 1e6),
            ("shutter.arrival_jitter_us", self.shutter.arrival_jitter_us, 0.0, 1e5),
            ("timer.rate_walk_ppm", self.timer.rate_walk_ppm, 0.0, 10.0),
            ("timer.pps_jitter_us", self.timer.pps_jitter_us, 0.0, 1e4),
        ];
        ranges.extend(self.auto_exposure.ranges());
        ranges.extend(self.link.ranges());
        ranges.extend(self.flight.tilt_hz.map(|hz| ("flight.tilt_hz", hz, 1e-3, 10.0)));
        ranges.extend(self.mount.lever_arm_m.map(|m| ("mount.lever_arm_m", m, -ARM_MAX_M, ARM_MAX_M)));
        let keys = ["mount.boresight.phi_deg", "mount.boresight.omega_deg", "mount.boresight.kappa_deg"];
        ranges.extend(self.mount.boresight.ranges(keys));
        ranges
    }
}
