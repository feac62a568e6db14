//! Running other programs.

use super::{Failure, places};
use std::env;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// cargo, as it started us, at the workspace's root and with the target folder as we see it. What is built here is mostly
/// built from nothing: keeping its parts for a next time would cost time now, and inlining between them.
pub fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(places::root()).env("CARGO_TARGET_DIR", places::target()).env("CARGO_INCREMENTAL", "0");
    command
}

/// A program of the package `plumbline-tests`, built in release.
pub fn program(name: &str) -> Result<Command, Failure> {
    run(cargo().args(["build", "--release", "--package", "plumbline-tests", "--features", "programs", "--bin", name]))?;
    Ok(Command::new(places::release(name)))
}

/// Runs `command` to its end, whose exit code is its own.
pub fn exit_code(command: &mut Command) -> Result<ExitCode, Failure> {
    let status = command.status().map_err(|error| format!("{} could not be started: {error}", name(command)))?;
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// Runs `command` to its end; anything but exit code 0 is a failure.
pub fn run(command: &mut Command) -> Result<(), Failure> {
    let status = command.status().map_err(|error| format!("{}: {error}", name(command)))?;
    if status.success() { Ok(()) } else { Err(format!("`{}` ended with {status}", line(command))) }
}

/// What `command` prints, without the white space around it, if it ends with exit code 0.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Whether `command` ends with exit code 0; quietly.
pub fn succeeds(command: &mut Command) -> bool {
    output(command).is_some()
}

fn name(command: &Command) -> String {
    Path::new(command.get_program()).file_name().unwrap_or(command.get_program()).to_string_lossy().into_owned()
}

/// The command as a person would type it.
fn line(command: &Command) -> String {
    let arguments = command.get_args().map(|argument| argument.to_string_lossy().into_owned());
    std::iter::once(name(command)).chain(arguments).collect::<Vec<_>>().join(" ")
}
