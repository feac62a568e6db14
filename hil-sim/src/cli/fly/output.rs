//! `--out` and `--dump`: what a flight leaves behind.

use super::Args;
use crate::cli::Failure;
use plumbline_sim::dump;
use plumbline_sim::report::Report;
use plumbline_sim::score;
use plumbline_survey::error::InputError;
use plumbline_survey::output::{check_file, write_file};
use std::path::{Path, PathBuf};

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
        if folder.exists() && !folder.is_dir() {
            return refuse(format!("--out {} is not a folder", folder.display()));
        }
        let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.exists() && !parent.is_dir() {
            return refuse(format!("--out {}: the folder {} does not exist", folder.display(), parent.display()));
        }
        if folder.is_dir() {
            for name in ["fixes.csv", "poses.csv", "report.json", "report.html"] {
                check_file(&folder.join(name))?;
            }
        }
        Ok(Some(Output { folder: folder.clone(), dump: args.dump.unwrap_or(0) }))
    }

    /// Creates the folder if need be, and replaces the flight's own files in it.
    pub fn write(&self, report: &Report<'_>) -> Result<(), Failure> {
        let page = report.html()?;
        if !self.folder.is_dir() {
            std::fs::create_dir(&self.folder)
                .map_err(|error| InputError::new(format!("cannot create {}: {error}", self.folder.display())))?;
        }
        dump::write(&self.folder, report.stage, report.flight, self.dump)?;
        score::write(&self.folder, report.stage, report.flight, report.scored, report.summary)?;
        write_file(&self.folder.join("report.html"), page.as_bytes())?;
        Ok(())
    }
}
