//! A recording of a flight (`plumbline fly --export`), read by another author's reader (`tests/recording/read.py`).

use super::process::run;
use super::steps::Outcome;
use super::{Failure, places, python};
use std::fs;
use std::path::Path;
use std::process::Command;

/// What the script imports.
const MODULES: [python::Module; 2] = [("jsonschema", "jsonschema==4.26.0"), ("mcap", "mcap==1.6.0")];

/// Flies, exports and has the recording read.
pub fn check() -> Outcome {
    python::with(&MODULES).map_or_else(Outcome::Skipped, |python| flown_and_read(&python).into())
}

fn flown_and_read(python: &Path) -> Result<(), Failure> {
    let folder = places::scratch().join("recording");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut fly = Command::new(places::tested("plumbline"));
    fly.args(["fly", "--frames", "12", "--fault", "attitude.off@4..5", "--dump", "2"]);
    run(fly.args(["--out", ".", "--export", "flight.mcap"]).current_dir(&folder))?;
    run(Command::new(python).arg(places::root().join("tests/recording/read.py")).arg(folder))
}
