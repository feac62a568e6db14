//! What a plan is handed out as.

use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use plumbline_survey::plan::place::Place;
use plumbline_survey::plan::{PlanFile, Planned};
use std::path::Path;

/// The files that may be written.
pub const FILES: [&str; 6] = ["plan.json", "plan.plan", "plan.geojson", "plan.kml", "coverage.tif", "report.html"];

/// A plan on its way out.
#[derive(Debug)]
pub struct Outputs<'p> {
    /// The plan with its rasters.
    pub planned: &'p Planned<'p>,
    /// The same as a file.
    pub file: &'p PlanFile,
    /// Where it lies.
    pub place: &'p Place,
    /// Whether the autopilot's mission has every photo.
    pub trigger_items: bool,
}

impl Outputs<'_> {
    /// All files, whole, before the first is written.
    ///
    /// # Errors
    /// What a file cannot express.
    pub fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
        let json = serde_json::to_string_pretty(self.file)
            .map_err(|error| InputError::new(format!("the plan cannot be written as JSON: {error}")))?;
        Ok(vec![("plan.json", format!("{json}\n").into_bytes())])
    }
}

/// Writes the files, all or none.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Path, files: &[(&'static str, Vec<u8>)]) -> Result<(), InputError> {
    for (name, _) in files {
        check_file(&folder.join(name))?;
    }
    files.iter().try_for_each(|(name, bytes)| write_file(&folder.join(name), bytes))
}
