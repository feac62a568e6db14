//! `cargo xtask compare`: the core's kernels on the host beside OpenCV's, error and time; with `--matching` its matchers beside
//! each other, with `--register` how far orthophotos lie apart.
//!
//! The work is done by the program `compare-kernels` of the package `plumbline-tests`, which starts the script
//! `tests/timing/compare.py` itself; here is what both need.

use super::process::{cargo, program, run};
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
        return program("match-years", &others);
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
    let status = Command::new(python).arg(script).arg("--out").args(arguments).status();
    let status = status.map_err(|error| format!("the script could not be started: {error}"))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

fn compared(python: &Path, arguments: &[String]) -> Result<ExitCode, Failure> {
    let what = ["--package", "plumbline-tests", "--features", "programs", "--bin", "compare-kernels"];
    run(cargo().args(["build", "--release"]).args(what))?;
    let folder = places::scratch().join("compare");
    // What an earlier run left there must not pass for this one's.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut command = Command::new(places::release("compare-kernels"));
    command.arg("--python").arg(python).arg("--script").arg(places::root().join("tests/timing/compare.py"));
    command.arg("--folder").arg(&folder).args(arguments);
    let status = command.status().map_err(|error| format!("compare-kernels could not be started: {error}"))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}
