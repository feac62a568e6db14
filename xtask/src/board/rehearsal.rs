//! The boot rehearsal: both images on an emulated core, register by register (`tests/board/rehearsal.py`).

use crate::places;
use crate::steps::Outcome;
use std::process::Command;

/// Image, start of flash, silicon revision: V, which runs at 480 MHz, and Y, which does not.
const RUNS: [(&str, &str, &str); 2] = [("h743-dfu", "0x08040000", "0x2003"), ("h743", "0x08000000", "0x1003")];
/// What the script ends with where its emulator is missing.
const NO_UNICORN: i32 = 3;

/// Boots each image once.
pub fn rehearse() -> Outcome {
    for (image, origin, revision) in RUNS {
        let mut command = Command::new("python3");
        command.current_dir(places::root()).arg("tests/board/rehearsal.py").arg(places::image_h743(image));
        match command.args([origin, revision]).status() {
            Err(_) => return Outcome::Skipped("there is no python3".into()),
            Ok(status) if status.code() == Some(NO_UNICORN) => {
                return Outcome::Skipped("Python's unicorn is missing: type `pip install unicorn`".into());
            }
            Ok(status) if !status.success() => return Outcome::Failed(format!("{image} does not boot as it should")),
            Ok(_) => {}
        }
    }
    Outcome::Passed
}
