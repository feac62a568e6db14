//! Real frames through the board's own chain: what a user does before he trusts it.
//!
//! The frames of a flight, where the vehicle's navigation had each of them and how the camera was turned, are handed to the firmware as
//! a flight is: attitudes, positions, a laser's range over the elevation model, the frames themselves. Nothing is made up: the
//! navigation says what the table says, and the pictures are the files. Key frames, filter and every refusal are those of the board.
//! A table has no times; frames are taken to be a constant interval apart, and the vehicle to fly smoothly from one to the next.
//!
//! A fix is right within 1.5 pixels of the truth, or of the flight's median offset from the navigation where no truth is known: a
//! single map cannot tell a navigation's constant error from its own. What an offset does when the camera turns can be told: a tilted
//! camera's turns with the heading, a shifted map's stays ([`platform`]).

pub mod judge;
pub mod meant;
pub mod platform;
pub mod refined;
mod words;

use crate::configuration::settings::keys;
use crate::link::LinkError;
use crate::link::inproc::InProcess;
use crate::run::{Flight, Keep, Observer, fly};
use crate::scenario::{Camera, FollowUpMode, Ground, LIVE, Run, Scenario, World};
use crate::setup::Setup;
use crate::setup::frames::FramesToFly;
use crate::setup::frames::table::Table;
use judge::{Figures, Verdict};
use platform::Platform;
use plumbline_survey::error::InputError;
use plumbline_survey::io::{data, input};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Speed that no vehicle with a mapping camera exceeds, metres a second: frames are taken to be so far apart in time that none is needed
/// beyond it. Chosen.
const SPEED_MAX_M_S: f64 = 40.0;
/// Pixels of a patch along the shorter side of the footprint at most, unless a resolution is asked for: three quarters of what the board
/// holds, so that heading and tilt leave some of it.
const PATCH_PX: f64 = 0.75 * plumbline_core::budget::PATCH_MAX_PX as f64;

/// What is evaluated.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The camera file.
    pub camera: PathBuf,
    /// Orthophoto that the reference is made of.
    pub reference: PathBuf,
    /// Elevation model of the ground, in the orthophoto's reference system.
    pub dem: Option<PathBuf>,
    /// Settings over those of live flights.
    pub settings: Option<PathBuf>,
    /// Pixel side of reference and patches, metres; as the settings say, or chosen for the camera's height.
    pub resolution_m: Option<f64>,
    /// Search radius, pixels.
    pub search_px: Option<u16>,
    /// From one frame to the next, seconds; chosen by the longest way between two unless given.
    pub interval_s: Option<f64>,
}

impl Evaluation {
    /// Prepares the flight of `table`'s frames. `boresight_deg`: φ, ω, κ of the camera as it is found to sit, where that is not as its
    /// file says.
    ///
    /// # Errors
    /// One sentence for files that are missing or broken, frames of another size than the camera's, a reference that shows none of the
    /// places.
    pub fn prepare(&self, table: &Table, boresight_deg: Option<[f64; 3]>) -> Result<Setup, InputError> {
        let mut scenario = self.scenario(table)?;
        if let Some(search_px) = self.search_px {
            scenario.vehicle.search_px = search_px;
        }
        let given_m = self.resolution_m.or(self.settings.as_ref().map(|_| scenario.vehicle.resolution_m));
        Setup::of_frames(scenario, &FramesToFly { table, resolution_m: given_m, patch_px: PATCH_PX, boresight_deg })
    }

    /// Settings over those of live flights, and nothing that is made up.
    fn scenario(&self, table: &Table) -> Result<Scenario, InputError> {
        let (text, file) = match &self.settings {
            Some(path) => (input::text(path)?, path.display().to_string()),
            None => (String::new(), "live".to_owned()),
        };
        keys(&text, &file)?;
        let folder = self.settings.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let given = Scenario::parse_over(LIVE, &text, &file, folder, data::shared_data().as_deref())?;
        let mut vehicle = given.vehicle;
        // The attitude in the table is the camera's, and its shutter has closed.
        vehicle.follow_up.mode = FollowUpMode::Fixed;
        vehicle.auto_exposure.is_on = false;
        vehicle.send_patches = false;
        let ground = Ground::Ortho { ortho: self.reference.clone(), dem: self.dem.clone(), reference: None };
        let world = World { noise_dn: 0.0, ground, ..World::default() };
        let longest_m = table.steps_m().fold(0.0, f64::max);
        let interval_s = self.interval_s.unwrap_or((longest_m / SPEED_MAX_M_S).ceil().max(1.0));
        let run = Run {
            name: "evaluate".to_owned(),
            frames: table.rows.len() as u32,
            frame_interval_ms: (1000.0 * interval_s).round() as u32,
            frame_jitter_us: 0,
            ..Run::default()
        };
        let camera = Camera::File(self.camera.clone());
        Ok(Scenario { file: "evaluate".to_owned(), camera, vehicle, world, run, ..Scenario::default() })
    }
}

/// Flies what was prepared through the firmware in this process.
///
/// # Errors
/// [`LinkError`]: a picture that has gone, an interrupt.
pub fn flown(setup: &Setup, observer: &mut dyn Observer) -> Result<Flight, LinkError> {
    let mut link = InProcess::new(&setup.flash)?;
    Ok(fly(setup, &mut link, Keep::default(), observer)?)
}

/// `report.json` of an evaluation.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// With the camera as its file has it.
    #[serde(flatten)]
    pub figures: Figures,
    /// What errors are counted from.
    pub judged_against: &'static str,
    /// Side of a pixel, metres.
    pub resolution_m: f64,
    /// The grid's.
    pub epsg: u32,
    /// What the flight says of camera and map.
    pub platform: Platform,
    /// What the heights seem to be instead of metres above the ground, and what to type; `null` where they are believed.
    pub heights: Option<String>,
    /// As much of the attitude: headings of another side of the camera or counted otherwise, tilts of the other sign or swapped.
    pub headings: Option<String>,
    /// With the camera as it is found to sit; `null` where it sits as its file says, the flight cannot tell, or it makes the fixes no better.
    pub corrected: Option<Figures>,
}

impl Summary {
    /// Of a flight, judged without and with what was found of the camera.
    #[must_use]
    pub fn new(setup: &Setup, table: &Table, verdicts: (&Verdict, Option<&Verdict>), platform: Platform) -> Self {
        let (verdict, corrected) = verdicts;
        Summary {
            figures: verdict.figures(),
            judged_against: if table.knows_truth() { "truth" } else { "median_offset" },
            resolution_m: verdict.resolution_m,
            epsg: setup.flash.head.georeference.epsg,
            platform,
            heights: None,
            headings: None,
            corrected: corrected.map(Verdict::figures),
        }
    }
}
