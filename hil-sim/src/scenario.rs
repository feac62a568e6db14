//! A named flight: everything that decides what happens, in one TOML file.
//!
//! Every key has a default, and the defaults together are the default scene: V = 60°, 512 x 512 pixels, 100 to 150 m,
//! tilt uniform within ±10°, a servo that follows exactly, R = 5 m, attitude noise 0.1°, 10 % changed ground, 3 DN of
//! noise, 300 frames. A key that is not known is refused, so that a slip of the pen does not fly the default.
//! Degrees and milliseconds stand in the file only; what flies is in radians and microseconds.

mod built_in;
mod check;
mod faults;
pub mod footprint;
mod ground;
mod tables;
#[cfg(test)]
mod tests;

pub use built_in::{BUILT_IN, SURVEY};
pub(crate) use check::{line_of, sentence};
pub use faults::{AttitudeFaults, LinkFaults, Seconds};
pub use ground::Ground;
pub use tables::{
    Attitude, Camera, Distortion, EdgeSource, Flight, FollowUp, FollowUpMode, Mount, Plan, Position, Range, Reference,
    Replay, Shutter, Timer,
};

use serde::Deserialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// The sensors run this long before the first frame, microseconds: the board needs two pulses per second, a clock
/// offset and a position before it can fix anything.
pub const WARM_UP_US: u64 = 3_000_000;
/// The flight goes on this long after the last frame's interval, microseconds, so that the last frame gets its pose.
pub const COOL_DOWN_US: u64 = 1_000_000;

/// Puts the keys of `upper` over those of `lower`, table by table.
fn lay_over(lower: &mut toml::Table, upper: toml::Table) {
    for (key, value) in upper {
        match (lower.get_mut(&key), value) {
            (Some(toml::Value::Table(below)), toml::Value::Table(above)) => lay_over(below, above),
            (_, value) => {
                lower.insert(key, value);
            }
        }
    }
}

/// Why a scenario cannot be flown: one sentence without a full stop that names file, key and value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScenarioError(pub(crate) String);

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ScenarioError {}

/// A flight and the world it is flown in.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// What the report calls it.
    pub name: String,
    /// Every random number of the flight comes from this. Same seed, same bytes.
    pub seed: u64,
    /// Frames to take.
    pub frames: u32,
    /// Pixel size R of reference and patch, metres.
    pub resolution_m: f64,
    /// Search radius of the matching, pixels of the reference.
    pub search_px: u16,
    /// From one frame to the next, milliseconds.
    pub frame_interval_ms: u32,
    /// Each frame opens late by a random part of this, microseconds, so that frames and attitude samples, both driven
    /// by quartz, do not keep one phase for the whole flight.
    pub frame_jitter_us: u32,
    /// Shutter open to shutter close, microseconds.
    pub exposure_us: u32,
    /// Instants of an exposure that a frame is the mean of, spread evenly; 1 is mid-exposure alone, a sharp picture.
    pub exposure_samples: u32,
    /// From the exposure of the first row to that of the last, milliseconds; 0 is a global shutter. Stamp and truth are
    /// those of the middle row.
    pub rolling_shutter_ms: f64,
    /// White noise of the camera's pixels, DN of 255.
    pub noise_dn: f64,
    /// The camera that is simulated. A caller that reads `camera_file` puts what it says here.
    pub camera: Camera,
    /// A camera file instead of `[camera]`.
    pub camera_file: Option<PathBuf>,
    /// Which head of the camera file flies, counted from 1.
    pub head: Option<u8>,
    /// How it is mounted.
    pub mount: Mount,
    /// Where the vehicle goes and how it moves.
    pub flight: Flight,
    /// Attitude sensor.
    pub attitude: Attitude,
    /// Camera servo and its encoder.
    pub follow_up: FollowUp,
    /// Laser rangefinder.
    pub range: Range,
    /// Position prior.
    pub position: Position,
    /// How the reference differs from the ground that is flown over.
    pub reference: Reference,
    /// The shutter's line and the frames' arrival.
    pub shutter: Shutter,
    /// The board's capture timer and the pulse per second.
    pub timer: Timer,
    /// What is flown over.
    pub ground: Ground,
    /// A recorded attitude instead of a made-up one.
    pub replay: Option<Replay>,
    /// A plan that is flown: its strips, its photos, its camera.
    pub plan: Plan,
    /// What the attitude sensor does wrong.
    pub attitude_faults: AttitudeFaults,
    /// What goes wrong on the link.
    pub link_faults: LinkFaults,
}

impl Default for Scenario {
    fn default() -> Self {
        Scenario {
            name: "default".into(),
            seed: 1,
            frames: 300,
            resolution_m: 5.0,
            search_px: 10,
            frame_interval_ms: 250,
            frame_jitter_us: 5000,
            exposure_us: 2000,
            exposure_samples: 1,
            rolling_shutter_ms: 0.0,
            noise_dn: 3.0,
            camera: Camera::default(),
            camera_file: None,
            head: None,
            mount: Mount::default(),
            flight: Flight::default(),
            attitude: Attitude::default(),
            follow_up: FollowUp::default(),
            range: Range::default(),
            position: Position::default(),
            reference: Reference::default(),
            shutter: Shutter::default(),
            timer: Timer::default(),
            ground: Ground::Procedural,
            replay: None,
            plan: Plan::default(),
            attitude_faults: AttitudeFaults::default(),
            link_faults: LinkFaults::default(),
        }
    }
}

impl Scenario {
    /// The default scene.
    #[must_use]
    pub fn default_scene() -> Self {
        Scenario::default()
    }

    /// One sigma of the navigation's position along each axis, metres.
    #[must_use]
    pub fn position_sigma_m(&self) -> f64 {
        self.position.sigma_m.unwrap_or(2.0 * self.resolution_m)
    }

    /// Reads and checks a scenario file. `data`: the folder that `data:` at the start of a path stands for; other
    /// relative paths start at the scenario file's own folder.
    ///
    /// # Errors
    /// [`ScenarioError`]: the file cannot be read, is not TOML, has an unknown key or a value out of its range.
    pub fn load(path: &Path, data: Option<&Path>) -> Result<Self, ScenarioError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|error| ScenarioError(format!("{file}: cannot read the scenario ({error})")))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &file, folder, data)
    }

    /// As [`Scenario::load`], from the file's text. `file` is its name for messages, `folder` where its relative paths start.
    ///
    /// # Errors
    /// [`ScenarioError`].
    pub fn parse(text: &str, file: &str, folder: &Path, data: Option<&Path>) -> Result<Self, ScenarioError> {
        let table: toml::Table = toml::from_str(text).map_err(|error| sentence(file, text, &error))?;
        if table.contains_key("camera") && table.contains_key("camera_file") {
            return Err(ScenarioError(format!("{file}: both [camera] and camera_file are given, only one can fly")));
        }
        let mut scenario: Scenario = toml::from_str(text).map_err(|error| sentence(file, text, &error))?;
        scenario.resolve_paths(file, folder, data)?;
        scenario.check(file)?;
        Ok(scenario)
    }

    /// The scenario of a flight along the plan `file`: `text` over what plans are flown with, the built-in scenario `survey`.
    /// The other arguments are those of [`Scenario::parse`].
    ///
    /// # Errors
    /// [`ScenarioError`].
    pub fn parse_planned(
        plan: &Path,
        text: &str,
        file: &str,
        folder: &Path,
        data: Option<&Path>,
    ) -> Result<Self, ScenarioError> {
        // Unknown keys and wrong types are refused with their lines.
        let _: Scenario = toml::from_str(text).map_err(|error| sentence(file, text, &error))?;
        let refuse = |error: String| ScenarioError(format!("{file}: {error}"));
        let table = |text: &str| toml::from_str::<toml::Table>(text).map_err(|error| refuse(error.to_string()));
        let (mut whole, own) = (table(SURVEY)?, table(text)?);
        let has_resolution = own.contains_key("resolution_m");
        lay_over(&mut whole, own);
        let text = toml::to_string(&whole).map_err(|error| refuse(error.to_string()))?;
        let mut scenario = Self::parse(&text, file, folder, data)?;
        scenario.plan.file = Some(plan.to_owned());
        scenario.plan.has_resolution = has_resolution;
        Ok(scenario)
    }

    /// From power-on of the autopilot's clock to the end of the flight, microseconds.
    #[must_use]
    pub fn duration_us(&self) -> u64 {
        WARM_UP_US + u64::from(self.frames) * self.frame_interval_us() + COOL_DOWN_US
    }

    /// Instants at which row `row` is sampled, microseconds after mid-exposure of the middle row.
    pub fn sample_offsets_us(&self, row: usize) -> impl Iterator<Item = f64> + use<> {
        let (count, exposure_us) = (f64::from(self.exposure_samples), f64::from(self.exposure_us));
        let rows = f64::from(self.camera.rows);
        let late = if rows > 1.0 { row as f64 / (rows - 1.0) - 0.5 } else { 0.0 };
        let row_us = late * self.rolling_shutter_us() as f64;
        (0..self.exposure_samples).map(move |index| row_us + exposure_us * ((f64::from(index) + 0.5) / count - 0.5))
    }

    /// From the exposure of the first row to that of the last, microseconds.
    #[must_use]
    pub fn rolling_shutter_us(&self) -> u64 {
        (1000.0 * self.rolling_shutter_ms).round() as u64
    }

    /// From one frame to the next, microseconds.
    #[must_use]
    pub fn frame_interval_us(&self) -> u64 {
        u64::from(self.frame_interval_ms) * 1000
    }
}
