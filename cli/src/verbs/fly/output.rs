//! `--out`, `--dump` and `--export`: what a flight leaves behind.

use super::Args;
use crate::dump;
use crate::files::{Files, check_extension, create_folder};
use crate::outcome::Failure;
use crate::pages::flight::Report;
use crate::recording;
use plumbline_sim::score;
use plumbline_sim::score::globe::tile;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::{write_file, write_files};
use std::path::{Path, PathBuf};

/// What a flight leaves behind in it.
const WRITTEN: [&str; 7] =
    ["fixes.csv", "poses.csv", "report.json", "report.html", "fixes.geojson", "track.kml", "tile.tif"];

/// A folder and a recording that can be written once the flight is over.
pub struct Output {
    folder: Option<PathBuf>,
    dump: u32,
    export: Option<PathBuf>,
}

impl Output {
    /// Refuses before the flight what could not be written after it. Nothing is created yet: a flight that fails
    /// leaves nothing behind.
    pub fn check(args: &Args) -> Result<Self, Failure> {
        let refuse = |sentence: String| Err(Failure::Input(InputError::new(sentence)));
        if args.dump.is_some() && args.out.is_none() && args.export.is_none() {
            return refuse("--dump needs --out, the folder for its pictures, or --export".to_owned());
        }
        Files::default()
            .may_read("--scenario", args.scenario.as_ref())
            .may_read("--firmware", args.firmware.as_ref())
            .may_read("--ground", args.ground.as_ref())
            .may_read("--dem", args.dem.as_ref())
            .may_read("--reference", args.reference.as_ref())
            .may_read("--replay", args.replay.as_ref())
            .may_read("--plan", args.plan.as_ref())
            .may_write_into("--out", args.out.as_ref(), &WRITTEN)
            .may_write_into("--dump", args.out.as_ref().filter(|_| args.dump.is_some()), &[dump::EVALUATED])
            .may_write("--log", args.log.as_ref())
            .may_write("--export", args.export.as_ref())
            .check()?;
        args.export.iter().try_for_each(|export| check_extension("--export", export, "mcap"))?;
        Ok(Output { folder: args.out.clone(), dump: args.dump.unwrap_or(0), export: args.export.clone() })
    }

    /// Writes what was asked for.
    pub fn write(&self, report: &Report<'_>) -> Result<(), Failure> {
        if let Some(path) = &self.export {
            write_file(path, &recording::mcap(report.setup, report.flight)?)?;
        }
        self.folder.as_ref().map_or(Ok(()), |folder| self.write_folder(folder, report))
    }

    /// Creates the folder if need be, and replaces the flight's own files in it.
    fn write_folder(&self, folder: &Path, report: &Report<'_>) -> Result<(), Failure> {
        let page = report.html()?;
        create_folder(folder)?;
        dump::write(folder, report.setup, report.flight, self.dump)?;
        // All of them or none: a full disk leaves no mixture of two flights.
        let texts = score::files(report.setup, report.flight, report.scored, report.summary)?;
        let texts = texts.into_iter().chain([("report.html", page)]).map(|(name, text)| (name, text.into_bytes()));
        let files: Vec<_> = texts.chain([("tile.tif", tile(report.setup)?)]).collect();
        let paths: Vec<_> = files.iter().map(|(name, bytes)| (folder.join(name), bytes)).collect();
        write_files(&paths.iter().map(|(path, bytes)| (path.as_path(), bytes.as_slice())).collect::<Vec<_>>())?;
        Ok(())
    }
}
