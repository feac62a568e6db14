//! The boot rehearsal: both images on an emulated core, register by register (`tests/board/rehearsal.py`).

use crate::places;
use crate::steps::Outcome;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitStatus};

/// What the script ends with where its emulator is missing.
const NO_UNICORN: i32 = 3;
/// That emulator, by pip.
const UNICORN: &str = "unicorn==2.1.4";

/// Boots each image once: with a mission on silicon of revision V, which runs at 480 MHz; with empty flash on revision Y,
/// which does not.
pub fn rehearse() -> Outcome {
    let mission = places::scratch().join("rehearsal-mission.bin");
    if let Err(error) = fs::create_dir_all(places::scratch()) {
        return Outcome::Failed(format!("{}: {error}", places::scratch().display()));
    }
    let Some(made) = python("mission.py", &[mission.as_os_str()]) else {
        return Outcome::Skipped("there is no python3".into());
    };
    if !made.success() {
        return Outcome::Failed("tests/board/mission.py could not write its mission".into());
    }
    let [behind, bare] = ["h743-dfu", "h743"].map(places::image_h743);
    let runs: [&[&OsStr]; 2] = [
        &[behind.as_os_str(), "0x08040000".as_ref(), "0x2003".as_ref(), mission.as_os_str()],
        &[bare.as_os_str(), "0x08000000".as_ref(), "0x1003".as_ref()],
    ];
    for arguments in runs {
        let rehearsed = || python("rehearsal.py", arguments).and_then(|status| status.code());
        let code = match rehearsed() {
            Some(NO_UNICORN) if install() => rehearsed(),
            code => code,
        };
        match code {
            Some(0) => {}
            Some(NO_UNICORN) => {
                return Outcome::Skipped("Python's unicorn is missing: type `pip install unicorn`".into());
            }
            _ => return Outcome::Failed("an image does not boot as it should, see above".into()),
        }
    }
    Outcome::Passed
}

/// Where Python finds what this step installs.
fn packages() -> PathBuf {
    places::scratch().join("python")
}

/// Installs the emulator for this step alone, where there is a pip; whether it could.
fn install() -> bool {
    let mut pip = Command::new("python3");
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--target"]).arg(packages());
    // Standard output belongs to the step.
    pip.arg(UNICORN).stdout(std::io::stderr()).status().is_ok_and(|status| status.success())
}

/// Runs a script of the board's tests; `None` where there is no Python.
fn python(script: &str, arguments: &[&OsStr]) -> Option<ExitStatus> {
    let path = places::root().join("tests/board").join(script);
    Command::new("python3").arg(path).args(arguments).env("PYTHONPATH", packages()).status().ok()
}
