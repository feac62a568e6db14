//! `cargo xtask compare`: the core's kernels on the host beside OpenCV's, error and time.
//!
//! The work is done by the program `compare-kernels` of the package `plumbline-tests`, which starts the script
//! `tests/timing/compare.py` itself; here is what both need.

use super::places;
use super::process::{cargo, run, succeeds};
use super::{Failure, failed};
use std::fs;
use std::process::{Command, ExitCode};

const PYTHON: &str = "python3";

/// Checks what is there, builds, runs: the exit code is that of the program.
///
/// # Errors
/// A sentence on what is missing, and how to get it.
pub fn compare(arguments: &[String]) -> Result<ExitCode, Failure> {
    let works = |code: &str| succeeds(Command::new(PYTHON).args(["-c", code]));
    match missing(works) {
        None => Ok(compared(arguments).unwrap_or_else(failed)),
        Some(sentence) => Err(sentence),
    }
}

/// What Python lacks, if anything; `works` says whether a line of it runs.
fn missing(works: impl Fn(&str) -> bool) -> Option<Failure> {
    if !works("pass") {
        return Some(format!("{PYTHON} is missing: install it with this system's package manager"));
    }
    let modules = [("numpy", "numpy"), ("cv2", "opencv-python-headless")];
    let lacking: Vec<_> = modules.into_iter().filter(|(module, _)| !works(&format!("import {module}"))).collect();
    let names = |pick: fn(&(&'static str, &'static str)) -> &'static str, between: &str| {
        lacking.iter().map(pick).collect::<Vec<_>>().join(between)
    };
    (!lacking.is_empty()).then(|| {
        let (modules, packages) = (names(|(module, _)| module, " and "), names(|(_, package)| package, " "));
        format!("{PYTHON} cannot import {modules}: type `{PYTHON} -m pip install {packages}`")
    })
}

fn compared(arguments: &[String]) -> Result<ExitCode, Failure> {
    run(cargo().args(["build", "--release", "--package", "plumbline-tests", "--bin", "compare-kernels"]))?;
    let folder = places::scratch().join("compare");
    // What an earlier run left there must not pass for this one's.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut command = Command::new(places::release("compare-kernels"));
    command.args(["--python", PYTHON, "--script"]).arg(places::root().join("tests/timing/compare.py"));
    command.arg("--folder").arg(&folder).args(arguments);
    let status = command.status().map_err(|error| format!("compare-kernels could not be started: {error}"))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

#[cfg(test)]
mod tests {
    use super::missing;

    #[test]
    fn what_is_missing_is_named_with_the_way_to_get_it() {
        assert_eq!(missing(|_| true), None);
        assert!(missing(|_| false).is_some_and(|sentence| sentence.starts_with("python3 is missing")));
        let without_cv2 = missing(|code| !code.contains("cv2")).unwrap_or_default();
        assert!(without_cv2.contains("import cv2") && without_cv2.contains("install opencv-python-headless"));
        let bare = missing(|code| !code.contains("import")).unwrap_or_default();
        assert!(bare.contains("numpy and cv2") && bare.contains("install numpy opencv-python-headless"), "{bare}");
    }
}
