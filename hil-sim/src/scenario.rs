//! A named flight: everything that decides what happens, in one TOML file.
//!
//! Every key has a default, and the defaults together are the default scene: V = 60°, 512 x 512 pixels, 100 to 150 m,
//! tilt uniform within ±10°, a servo that follows exactly, R = 5 m, attitude noise 0.1°, 10 % changed ground, 3 DN of
//! noise, 300 frames. A key that is not known is refused, so that a misspelt key does not leave its default in force.
//! Degrees and milliseconds stand in the file only; what flies is in radians and microseconds.

mod bounds;
mod built_in;
mod camera;
mod check;
mod faults;
pub mod footprint;
mod ground;
mod instead;
mod land;
mod navigation;
mod payload;
mod read;
mod resolved;
mod run;
mod set;
#[cfg(test)]
mod tests;
mod timed;
pub mod vehicle;
mod weather;
pub mod world;

pub use built_in::{BUILT_IN, LIVE, SURVEY};
pub use camera::{Camera, Frame};
pub use faults::{AttitudeFaults, AutopilotFaults, Faults, LinkFaults, Seconds, WrongParameters, is_during};
pub use ground::Ground;
pub use instead::Instead;
pub use land::{Changes, Land, Season};
pub use navigation::{Grade, Navigation};
pub use payload::{Mounting, Payload};
pub use read::Reader;
pub use run::{COOL_DOWN_US, FRAMES_MAX, Live, Replay, Run, WARM_UP_US};
pub use set::Setting;
pub use timed::{Fault, FaultList, KINDS, Kind, Value, What};
pub use vehicle::{AutoExposure, Boresight, EdgeSource, FixMessage, FollowUpMode, Start, SwitchSource, Vehicle};
pub use weather::Weather;
pub use world::{Light, World};

use plumbline_survey::error::InputError;
use std::path::Path;

/// A flight and the world it is flown in; the default is the default scene. The keys of one
/// sensor form one table in the file and are divided among the fields below.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What messages call it: its file.
    pub file: String,
    /// The camera that is simulated.
    pub camera: Camera,
    /// What the board is configured with.
    pub vehicle: Vehicle,
    /// What is simulated around it.
    pub world: World,
    /// This run.
    pub run: Run,
    /// What goes wrong.
    pub faults: Faults,
}

impl Default for Scenario {
    fn default() -> Self {
        Scenario {
            file: "the default scene".into(),
            camera: Camera::default(),
            vehicle: Vehicle::default(),
            world: World::default(),
            run: Run::default(),
            faults: Faults::default(),
        }
    }
}

impl Scenario {
    /// The default scene for that many frames.
    #[must_use]
    pub fn of_frames(frames: u32) -> Self {
        Self::seeded(Run::default().seed, frames)
    }

    /// The default scene with another seed, for that many frames.
    #[must_use]
    pub fn seeded(seed: u64, frames: u32) -> Self {
        Scenario { run: Run { seed, frames, ..Run::default() }, ..Scenario::default() }
    }

    /// Checks and takes a scenario's text. `file` is its name for messages, `folder` where its relative paths start, `data`
    /// the folder that `data:` at the start of a path stands for.
    ///
    /// # Errors
    /// [`InputError`]: it is not TOML, has an unknown key or a value out of its range.
    pub fn parse(text: &str, file: &str, folder: &Path, data: Option<&Path>) -> Result<Self, InputError> {
        let mut scenario = Self::read(text, file)?;
        scenario.resolve_paths(folder, data)?;
        scenario.check()?;
        Ok(scenario)
    }

    /// What a text says, its keys and their types checked, but no value.
    fn read(text: &str, file: &str) -> Result<Self, InputError> {
        Self::read_from(Reader::new(text, file), file)
    }

    /// Whether all keys of a text are a scenario's.
    pub(crate) fn reads(text: &str) -> bool {
        Self::read(text, "").is_ok()
    }

    /// As [`Self::read`], of a text that nobody has written: messages name no line of it.
    fn read_unlined(text: &str, file: &str) -> Result<Self, InputError> {
        Self::read_from(Reader::new(text, file).unlined(), file)
    }

    fn read_from(mut reader: Reader<'_>, file: &str) -> Result<Self, InputError> {
        let source: camera::Source = reader.part()?;
        let scenario = Scenario {
            file: file.into(),
            camera: source.try_into().map_err(|why| InputError::new(format!("{file}: {why}")))?,
            vehicle: reader.part()?,
            world: reader.part()?,
            run: reader.part()?,
            faults: reader.part()?,
        };
        reader.finish(|| "is no key of a scenario")?;
        Ok(scenario)
    }

    /// As [`Self::parse`], of a flight along a plan: `text` over what plans are flown with, the built-in scenario `survey`.
    /// Whether it says a resolution; otherwise the plan decides.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn parse_planned(
        text: &str,
        file: &str,
        folder: &Path,
        data: Option<&Path>,
    ) -> Result<(Self, bool), InputError> {
        let scenario = Self::parse_over(SURVEY, text, file, folder, data)?;
        Ok((scenario, Self::table(text, file)?.contains_key("resolution_m")))
    }

    /// As [`Self::parse`]: `text` over the built-in scenario `base`, key by key.
    ///
    /// # Errors
    /// [`InputError`].
    pub fn parse_over(
        base: &str,
        text: &str,
        file: &str,
        folder: &Path,
        data: Option<&Path>,
    ) -> Result<Self, InputError> {
        // What is wrong is told with the line of the file itself.
        Self::read(text, file)?;
        let mut whole = Self::table(base, file)?;
        lay_over(&mut whole, Self::table(text, file)?);
        let text = toml::to_string(&whole).map_err(|error| InputError::new(format!("{file}: {error}")))?;
        Self::parse(&text, file, folder, data)
    }

    fn table(text: &str, file: &str) -> Result<toml::Table, InputError> {
        toml::from_str(text).map_err(|error| InputError::new(format!("{file}: {error}")))
    }

    /// Instants at which row `row` of `rows` is sampled in an exposure of `exposure_us`, microseconds after mid-exposure of the
    /// middle row.
    pub fn sample_offsets_us(&self, exposure_us: u32, row: usize, rows: u32) -> impl Iterator<Item = f64> + use<> {
        let samples = self.world.exposure_samples;
        let (count, exposure_us) = (f64::from(samples), f64::from(exposure_us));
        let rows = f64::from(rows);
        let late = if rows > 1.0 { row as f64 / (rows - 1.0) - 0.5 } else { 0.0 };
        let row_us = late * self.vehicle.rolling_shutter_us() as f64;
        (0..samples).map(move |index| row_us + exposure_us * ((f64::from(index) + 0.5) / count - 0.5))
    }

    /// What the camera makes of the ground's grey in an exposure of `exposure_us` at an instant of the flight: the light and the
    /// exposure, over those at which it is the grey itself.
    #[must_use]
    pub fn gain(&self, exposure_us: u32, at_us: u64) -> f64 {
        let since_s = 1e-6 * (at_us as f64 - WARM_UP_US as f64);
        let flight_s = 1e-6 * (u64::from(self.run.frames) * self.run.frame_interval_us()) as f64;
        self.world.light.at(since_s, flight_s) * f64::from(exposure_us) / f64::from(self.vehicle.exposure_us)
    }
}

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
