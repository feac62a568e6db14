//! The tables and figures of papers by this project's own code, and where and why they differ.
//!
//! [`paper_000`] is image motion and mid-exposure, [`paper_001`] the semi-parametric fit, [`paper_004`] flight lines. Of
//! paper 003 [`table_1`] is geometry alone, [`table_2`] a Monte Carlo of three kernels ([`baselines`] on [`setting`]) with
//! their [`memory`] and [`timing`], [`table_3`] a flight in-process; [`figure_1`] and [`figure_3`] are its pictures.
//! [`text`] is how the rows look to a person. A figure that does not reproduce stays in the list with the reason.

pub mod figure_1;
pub mod figure_3;
pub mod kernel;
pub mod memory;
pub mod paper_000;
pub mod paper_001;
pub mod paper_002;
pub mod paper_004;
pub mod resample;
pub mod baselines;
mod row;
pub mod setting;
pub mod table_1;
pub mod table_2;
pub mod table_3;
pub mod text;
pub mod timing;

use plumbline_core::camera::CameraError;
use plumbline_sim::link::LinkError;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use plumbline_survey::io::picture::write_grey_png;
pub use row::Row;
use serde::Serialize;
use std::path::Path;
use table_3::Flown;

/// Every random number of Table 2 and figure 3 comes from this; Table 3 has its scenario's seed.
pub const SEED: u64 = 3;

/// Everything that was reproduced.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seed of Table 2 and figure 3.
    pub seed: u64,
    /// Trials of the Monte Carlo of Table 2.
    pub trials: usize,
    /// Seed of the flight of Table 3.
    pub flight_seed: u64,
    /// Frames of that flight.
    pub frames: u32,
    /// The rows, table by table.
    pub rows: Vec<Row>,
}

impl Reproduction {
    /// Paper 003, with Table 3 from a flight.
    ///
    /// # Errors
    /// None for the cameras of the tables; the core's own check is passed on.
    pub fn of_003(flown: &Flown) -> Result<Self, LinkError> {
        let mut rows = table_1::rows().map_err(refused)?;
        rows.extend(table_2::rows(SEED).map_err(refused)?);
        rows.extend(table_3::rows(flown));
        let scenario = &flown.setup.scenario;
        Ok(Reproduction {
            paper: "003",
            seed: SEED,
            trials: table_2::TRIALS,
            flight_seed: scenario.run.seed,
            frames: scenario.run.frames,
            rows,
        })
    }
}

/// Writes figures 1 and 3 into `folder`.
///
/// # Errors
/// A folder that cannot be written to.
pub fn write_figures(folder: &Path, flown: &Flown) -> Result<(), LinkError> {
    write_file(&folder.join("figure_1.svg"), figure_1::svg().map_err(refused)?.as_bytes())?;
    for (letter, picture) in figure_3::pictures(&flown.setup.ground, SEED).map_err(refused)? {
        write_grey_png(&folder.join(format!("figure_3{letter}.png")), &picture)?;
    }
    Ok(())
}

/// Writes figures 3 to 5 of paper 000 into `folder`.
///
/// # Errors
/// A folder that cannot be written to.
pub fn write_figures_000(folder: &Path, reproduction: &paper_000::Reproduction) -> Result<(), InputError> {
    for (name, svg) in paper_000::figures::figures(&reproduction.sweep) {
        write_file(&folder.join(name), svg.as_bytes())?;
    }
    Ok(())
}

fn refused(error: CameraError) -> LinkError {
    LinkError::Input(InputError::new(format!("the core refuses the camera: {error:?}")))
}
