//! Python with the modules that a check needs: the user's own where it has them, what it lacks in an environment under
//! `target/tools`, so that nothing of the user's changes.

use super::Failure;
use super::debian::{Machine, Wanted};
use super::process::{output, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A module by the name it is imported by, and what pip calls it.
pub type Module = (&'static str, &'static str);

/// A Python that imports `modules`.
///
/// # Errors
/// What is missing, and what pip says of it.
pub fn with(modules: &[Module]) -> Result<PathBuf, Failure> {
    let machine = Machine::here();
    let environment = machine.tools.join("python");
    let python = environment.join("bin").join("python3");
    if !succeeds(Command::new(&python).arg("--version")) {
        if !succeeds(machine.command("python3").arg("--version")) {
            return Err("python3 is missing: install it with this system's package manager".into());
        }
        // Without pip, since Debian's own python3 cannot bring it along.
        let made = ["-m", "venv", "--clear", "--system-site-packages", "--without-pip"];
        machine.said(machine.command("python3").args(made).arg(&environment))?;
    }
    let lacking: Vec<&str> =
        modules.iter().filter(|(name, _)| !imports(&python, name)).map(|(_, requirement)| *requirement).collect();
    if !lacking.is_empty() {
        eprintln!("installing {} under {}", lacking.join(", "), environment.display());
        let pip = pip(&machine, &python)?;
        let options = ["install", "--quiet", "--disable-pip-version-check", "--no-input"];
        machine.said(machine.command(&python).envs(pip).args(["-m", "pip"]).args(options).args(&lacking))?;
    }
    match modules.iter().find(|(name, _)| !imports(&python, name)) {
        None => Ok(python),
        Some((name, _)) => Err(format!("{} cannot import {name}", python.display())),
    }
}

fn imports(python: &Path, module: &str) -> bool {
    succeeds(Command::new(python).args(["-c", &format!("import {module}")]))
}

/// The variables by which `python -m pip` runs: none where there is a pip, or Python brings one; else Debian's, from its
/// wheel.
fn pip(machine: &Machine, python: &Path) -> Result<Option<(&'static str, PathBuf)>, Failure> {
    let runs = |arguments: [&str; 2]| output(Command::new(python).arg("-m").args(arguments)).is_some();
    if runs(["pip", "--version"]) || runs(["ensurepip", "--default-pip"]) {
        return Ok(None);
    }
    const PACKAGE: &str = "python3-pip-whl";
    let wheel = || {
        let files = std::fs::read_dir(machine.tools.join(PACKAGE).join("usr/share/python-wheels")).ok()?;
        files.flatten().map(|file| file.path()).find(|path| path.to_string_lossy().contains("/pip-"))
    };
    if wheel().is_none() {
        machine.unpack(&Wanted { packages: &[PACKAGE], programs: &[] }, || wheel().is_some())?;
    }
    Ok(wheel().map(|wheel| ("PYTHONPATH", wheel)))
}
