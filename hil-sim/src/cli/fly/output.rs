//! `--out` and `--dump`: what a flight leaves behind.

use super::Args;
use crate::cli::{Failure, folder};
use plumbline_sim::dump;
use plumbline_sim::report::Report;
use plumbline_sim::score;
use plumbline_survey::error::InputError;
use plumbline_survey::output::write_file;
use std::path::PathBuf;

/// A folder that can be written to once the flight is over.
pub struct Output {
    folder: PathBuf,
    dump: u32,
}

impl Output {
    /// Refuses before the flight what could not be written after it. Nothing is created yet: a flight that fails
    /// leaves nothing behind.
    pub fn check(args: &Args) -> Result<Option<Self>, Failure> {
        let refuse = |sentence: String| Err(Failure::Input(InputError::new(sentence)));
        let Some(folder) = &args.out else {
            return match args.dump {
                Some(_) => refuse("--dump needs --out, the folder for its pictures".to_owned()),
                None => Ok(None),
            };
        };
        folder::check("--out", folder, &["fixes.csv", "poses.csv", "report.json", "report.html"])?;
        Ok(Some(Output { folder: folder.clone(), dump: args.dump.unwrap_or(0) }))
    }

    /// Creates the folder if need be, and replaces the flight's own files in it.
    pub fn write(&self, report: &Report<'_>) -> Result<(), Failure> {
        let page = report.html()?;
        folder::create(&self.folder)?;
        dump::write(&self.folder, report.stage, report.flight, self.dump)?;
        score::write(&self.folder, report.stage, report.flight, report.scored, report.summary)?;
        write_file(&self.folder.join("report.html"), page.as_bytes())?;
        Ok(())
    }
}
