//! `cargo xtask compare`: the core's kernels on the host beside OpenCV's, error and time; with `--matching` its matchers beside
//! each other, with `--register` how far orthophotos lie apart.
//!
//! The work is done by the program `compare-kernels` of the package `plumbline-tests`, which starts the script
//! `tests/timing/compare.py` itself; here is what both need.

use super::process::{exit_code, program};
use super::{Failure, failed, places, python};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

/// What the script imports.
const MODULES: [python::Module; 2] = [("numpy", "numpy"), ("cv2", "opencv-python-headless")];

/// Builds and runs: the exit code is that of the program.
///
/// # Errors
/// A sentence on what Python lacks.
pub fn compare(arguments: &[String]) -> Result<ExitCode, Failure> {
    if let Some(at) = arguments.iter().position(|argument| argument == "--matching") {
        let others: Vec<&String> = arguments.iter().take(at).chain(arguments.iter().skip(at + 1)).collect();
        return exit_code(program("match-years")?.args(&others));
    }
    if let [first, others @ ..] = arguments
        && first == "--register"
    {
        return registered(others);
    }
    python::with(&MODULES).map(|python| compared(&python, arguments).unwrap_or_else(failed))
}

/// How far orthophotos lie apart, by `tests/years/displacements.py`.
const REGISTERING: [python::Module; 3] = [("numpy", "numpy"), ("cv2", "opencv-python-headless"), ("PIL", "pillow")];

/// Writes the table that `--matching --displacements` judges by: `--register OUT.csv ORTHO ORTHO ...`.
fn registered(arguments: &[String]) -> Result<ExitCode, Failure> {
    let python = python::with(&REGISTERING)?;
    let script = places::root().join("tests/years/displacements.py");
    exit_code(Command::new(python).arg(script).arg("--out").args(arguments))
}

fn compared(python: &Path, arguments: &[String]) -> Result<ExitCode, Failure> {
    let mut command = program("compare-kernels")?;
    let folder = places::scratch().join("compare");
    // What an earlier run left there must not pass for this one's.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    command.arg("--python").arg(python).arg("--script").arg(places::root().join("tests/timing/compare.py"));
    exit_code(command.arg("--folder").arg(&folder).args(arguments))
}
