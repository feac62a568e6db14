//! The boot rehearsal: both images on an emulated core, register by register (`tests/board/rehearsal.py`).

use super::map::{APPLICATION, BANK_1};
use crate::process::run;
use crate::steps::Outcome;
use crate::{Failure, places, python};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The emulator that the script drives.
const UNICORN: python::Module = ("unicorn", "unicorn==2.1.4");

/// Boots each image once: with a configuration on silicon of revision V, which runs at 480 MHz; with empty flash on revision Y,
/// which does not.
pub fn rehearse() -> Outcome {
    python::with(&[UNICORN]).map_or_else(Outcome::Skipped, |python| rehearsed(&python).into())
}

fn rehearsed(python: &Path) -> Result<(), Failure> {
    let script = |name: &str, arguments: &[&OsStr]| {
        run(Command::new(python).arg(places::root().join("tests/board").join(name)).args(arguments))
    };
    let configuration = places::scratch().join("rehearsal-configuration.bin");
    fs::create_dir_all(places::scratch()).map_err(|error| format!("{}: {error}", places::scratch().display()))?;
    script("configuration.py", &[configuration.as_os_str()])?;
    let [behind, bare] = ["h743-dfu", "h743"].map(places::image_h743);
    let [application, bank_1] = [APPLICATION, BANK_1].map(|origin| format!("{origin:#010x}"));
    script("rehearsal.py", &[behind.as_os_str(), application.as_ref(), "0x2003".as_ref(), configuration.as_os_str()])?;
    script("rehearsal.py", &[bare.as_os_str(), bank_1.as_ref(), "0x1003".as_ref()])
}
