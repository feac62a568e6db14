//! What is simulated around the board and what the board is not configured with: the camera's noise, the sensors' latencies,
//! the true boresight, the capture timer, ground and reference.

use super::bounds::Bounded;
use super::ground::Ground;
use super::land::{Changes, Land};
use super::navigation::Navigation;
use super::vehicle::Boresight;
use super::weather::Weather;
use serde::{Deserialize, Serialize};

/// Keys carry their units.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct World {
    /// Instants of an exposure that a frame is the mean of, spread evenly; 1 is mid-exposure alone, a sharp picture.
    pub exposure_samples: u32,
    /// White noise of the camera's pixels, DN of 255.
    pub noise_dn: f64,
    /// How bright it is.
    pub light: Light,
    /// How the camera is really mounted.
    pub mount: Mount,
    /// Attitude sensor.
    pub attitude: Attitude,
    /// Camera servo and its encoder.
    pub follow_up: FollowUp,
    /// Laser rangefinder.
    pub range: Range,
    /// Position prior.
    pub position: Position,
    /// The board's capture timer and the pulse per second.
    pub timer: Timer,
    /// The autopilot.
    pub autopilot: Autopilot,
    /// How the reference differs from the ground that is flown over.
    pub reference: Reference,
    /// What is flown over.
    pub ground: Ground,
    /// What procedural ground is like.
    pub land: Land,
    /// What has happened to it since the reference was made.
    pub changes: Changes,
    /// What stands between it and the camera.
    pub weather: Weather,
    /// How the autopilot finds its way, where the flight is kept by its fixes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub navigation: Option<Navigation>,
}

impl Default for World {
    fn default() -> Self {
        World {
            exposure_samples: 1,
            noise_dn: 3.0,
            light: Light::default(),
            mount: Mount::default(),
            attitude: Attitude::default(),
            follow_up: FollowUp::default(),
            range: Range::default(),
            position: Position::default(),
            timer: Timer::default(),
            autopilot: Autopilot::default(),
            reference: Reference::default(),
            ground: Ground::Procedural,
            land: Land::default(),
            changes: Changes::default(),
            weather: Weather::default(),
            navigation: None,
        }
    }
}

/// The light on the ground, stops above that at which a picture taken with `exposure_us` has the ground's own greys: a stop is a
/// factor of two.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Light {
    /// Constant part.
    pub stops: f64,
    /// At the first frame, beside the constant part.
    pub from_stops: f64,
    /// In the end, beside the constant part.
    pub to_stops: f64,
    /// Seconds from the first frame over which it changes from the one to the other; unless given, the whole flight.
    pub over_s: Option<f64>,
}

impl Light {
    /// Times the nominal light so many seconds after the first frame, in a flight of `flight_s`.
    #[must_use]
    pub fn at(&self, since_s: f64, flight_s: f64) -> f64 {
        let share = (since_s / self.over_s.unwrap_or(flight_s)).clamp(0.0, 1.0);
        (self.stops + self.from_stops + share * (self.to_stops - self.from_stops)).exp2()
    }
}

/// How the camera really sits in the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Mount {
    /// The boresight as it really is, where the board is configured with another: what `plumbline boresight` finds. As
    /// configured unless given.
    pub true_boresight: Option<Boresight>,
}

/// Attitude sensor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Attitude {
    /// From its stamp to its arrival.
    pub latency_us: u32,
    /// Time constant of the drift.
    pub drift_s: f64,
}

impl Default for Attitude {
    fn default() -> Self {
        Attitude { latency_us: 8000, drift_s: 30.0 }
    }
}

/// Camera servo and encoder.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FollowUp {
    /// Time constant of the servo, seconds; 0 follows exactly.
    pub servo_lag_s: f64,
    /// Whether the servo goes where the firmware tells it to, and not where it should; as with `[navigation]` it always does.
    pub servo_commanded: bool,
    /// Of a commanded servo: its fastest turn.
    pub servo_rate_deg_s: f64,
    /// How far it turns to each side; 180 is around and around.
    pub servo_limit_deg: f64,
    /// How far the camera turns without it.
    pub servo_backlash_deg: f64,
    /// Samples of the encoder a second.
    pub rate_hz: u32,
    /// From its stamp to its arrival.
    pub latency_us: u32,
}

impl Default for FollowUp {
    /// The servo's figures are those of an ordinary one: 60° in 0.2 s, some tenths of a degree of backlash.
    fn default() -> Self {
        FollowUp {
            servo_lag_s: 0.0,
            servo_commanded: false,
            servo_rate_deg_s: 300.0,
            servo_limit_deg: 180.0,
            servo_backlash_deg: 0.2,
            rate_hz: 100,
            latency_us: 5000,
        }
    }
}

/// Laser rangefinder.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Range {
    /// From its stamp to its arrival.
    pub latency_us: u32,
}

impl Default for Range {
    fn default() -> Self {
        Range { latency_us: 10_000 }
    }
}

/// Position prior.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Position {
    /// Time constant of its Gauss-Markov error.
    pub time_constant_s: f64,
    /// From its stamp to its arrival.
    pub latency_us: u32,
}

impl Default for Position {
    fn default() -> Self {
        Position { time_constant_s: 60.0, latency_us: 100_000 }
    }
}

/// The capture timer and what ties it to the autopilot's clock.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Timer {
    /// Its count at the autopilot's time 0. The default wraps 5 s into the flight.
    pub start_ticks: u32,
    /// How much faster than the autopilot's clock it runs at first, parts per million.
    pub drift_ppm: f64,
    /// Whether the pulse per second is wired.
    pub pps: bool,
    /// Whether the autopilot answers TIMESYNC, without which no pulse has a name.
    pub timesync: bool,
}

impl Default for Timer {
    fn default() -> Self {
        Timer { start_ticks: 4_290_000_000, drift_ppm: 20.0, pps: false, timesync: true }
    }
}

/// The autopilot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Autopilot {
    /// Its main loop a second: what is asked for as often or more often is denied.
    pub loop_rate_hz: u32,
}

impl Default for Autopilot {
    /// As ArduPilot is told where companions want attitudes at 200 Hz (SCHED_LOOP_RATE); a plane's own default is 50.
    fn default() -> Self {
        Autopilot { loop_rate_hz: 300 }
    }
}

/// How the reference differs from the ground: offset + gain · 255 (DN/255)^gamma, noise, and patches that changed. What is not
/// given depends on the ground: a procedural one has synthetic differences, over an orthophoto there are none.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reference {
    /// Exponent of the tone curve.
    pub gamma: Option<f64>,
    /// Gain after it.
    pub gain: Option<f64>,
    /// Offset after it, DN.
    pub offset_dn: Option<f64>,
    /// White noise, DN.
    pub noise_dn: Option<f64>,
    /// Share of the area that looks different today.
    pub changed_fraction: Option<f64>,
    /// How far it says that it lies beside where it does, east and north: the map's bias.
    pub bias_m: [f64; 2],
    /// How far beside the flight the ground lies that it shows as the ground under it, east and north.
    pub aside_m: [f64; 2],
    /// Seed of the procedural ground that it shows, where that is another one.
    pub other_seed: Option<u64>,
    /// Distance between the posts of its elevation model, which is that of the ground where it has one; 0 = no model.
    pub elevation_posts_m: f64,
    /// How much higher the posts say that the ground is than it is.
    pub elevation_bias_m: f64,
    /// EPSG code of the vertical datum that the posts are said to be above; 0 = not known.
    pub elevation_epsg: u32,
}

impl Default for Reference {
    /// Posts as far apart as those of the global models of one arc second.
    fn default() -> Self {
        Reference {
            gamma: None,
            gain: None,
            offset_dn: None,
            noise_dn: None,
            changed_fraction: None,
            bias_m: [0.0; 2],
            aside_m: [0.0; 2],
            other_seed: None,
            elevation_posts_m: 30.0,
            elevation_bias_m: 0.0,
            elevation_epsg: 0,
        }
    }
}

impl World {
    /// Each value that has bounds.
    pub(super) fn ranges(&self) -> Vec<Bounded> {
        let (follow_up, reference) = (&self.follow_up, &self.reference);
        let mut ranges = vec![
            ("exposure_samples", self.exposure_samples.into(), 1.0, 1000.0),
            ("noise_dn", self.noise_dn, 0.0, 255.0),
            ("light.stops", self.light.stops, -10.0, 10.0),
            ("light.from_stops", self.light.from_stops, -10.0, 10.0),
            ("light.to_stops", self.light.to_stops, -10.0, 10.0),
            ("light.over_s", self.light.over_s.unwrap_or(1.0), 1e-3, 1e6),
            ("attitude.latency_us", self.attitude.latency_us.into(), 0.0, 1e7),
            ("attitude.drift_s", self.attitude.drift_s, 1e-3, 1e6),
            ("follow_up.servo_lag_s", follow_up.servo_lag_s, 0.0, 60.0),
            ("follow_up.servo_rate_deg_s", follow_up.servo_rate_deg_s, 1.0, 1e5),
            ("follow_up.servo_limit_deg", follow_up.servo_limit_deg, 1.0, 180.0),
            ("follow_up.servo_backlash_deg", follow_up.servo_backlash_deg, 0.0, 10.0),
            // Its messages stamp whole milliseconds.
            ("follow_up.rate_hz", follow_up.rate_hz.into(), 1.0, 1000.0),
            ("follow_up.latency_us", follow_up.latency_us.into(), 0.0, 1e7),
            ("range.latency_us", self.range.latency_us.into(), 0.0, 1e7),
            ("position.time_constant_s", self.position.time_constant_s, 1e-3, 1e6),
            ("position.latency_us", self.position.latency_us.into(), 0.0, 1e7),
            ("autopilot.loop_rate_hz", self.autopilot.loop_rate_hz.into(), 1.0, 20_000.0),
            ("timer.drift_ppm", self.timer.drift_ppm, -500.0, 500.0),
            ("reference.gamma", reference.gamma.unwrap_or(1.0), 0.05, 20.0),
            ("reference.gain", reference.gain.unwrap_or(1.0), 0.01, 100.0),
            ("reference.offset_dn", reference.offset_dn.unwrap_or(0.0), -255.0, 255.0),
            ("reference.noise_dn", reference.noise_dn.unwrap_or(0.0), 0.0, 255.0),
            ("reference.bias_m", reference.bias_m[0], -1000.0, 1000.0),
            ("reference.bias_m", reference.bias_m[1], -1000.0, 1000.0),
            ("reference.aside_m", reference.aside_m[0], -1e5, 1e5),
            ("reference.aside_m", reference.aside_m[1], -1e5, 1e5),
            ("reference.elevation_posts_m", reference.elevation_posts_m, 0.0, 1000.0),
            ("reference.elevation_bias_m", reference.elevation_bias_m, -1000.0, 1000.0),
            // As large as the codes of the register are.
            ("reference.elevation_epsg", reference.elevation_epsg.into(), 0.0, 32_767.0),
            ("reference.changed_fraction", reference.changed_fraction.unwrap_or(0.0), 0.0, 1.0),
        ];
        let keys = ["mount.true_boresight.phi_deg", "mount.true_boresight.omega_deg", "mount.true_boresight.kappa_deg"];
        ranges.extend(self.land.ranges());
        ranges.extend(self.changes.ranges());
        ranges.extend(self.weather.ranges());
        ranges.extend(self.navigation.iter().flat_map(Navigation::ranges));
        ranges.extend(self.mount.true_boresight.iter().flat_map(|truly| truly.ranges(keys)));
        ranges
    }
}
