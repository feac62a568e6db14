//! `cargo xtask test`: all that must hold.

use super::places::{self, THUMB};
use super::process::{cargo, run};
use super::set_up::Compiler;
use super::steps::{Outcome, Steps};
use super::{Failure, board, budget, build, flight, panics, selftest, set_up};
use std::process::{Command, ExitCode};

/// Runs every step, building first, and goes on after a failure unless it was the building.
pub fn test() -> ExitCode {
    let mut steps = Steps::new(18);
    if all(&mut steps) & steps.report() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// All steps in order; whether none had to be left out.
fn all(steps: &mut Steps) -> bool {
    let mut compiler = None;
    let is_built = steps.step("set-up and build", || {
        let built = set_up::emulator().and_then(|()| set_up::checkers()).and_then(|()| build::build());
        built.map(|way| compiler = Some(way)).into()
    });
    let (true, Some(compiler)) = (is_built, compiler) else { return false };

    steps.step("format", || run(cargo().args(["fmt", "--all", "--check"])).into());
    steps.step("clippy (host)", || clippy(&["--workspace", "--all-targets"], None).into());
    steps.step("clippy (firmware)", || {
        if !compiler.has_clippy() {
            return Outcome::Skipped(format!("Debian's compiler for {THUMB} comes without a clippy of its version"));
        }
        clippy(&["--package", "plumbline-firmware", "--features", build::AN500], Some(&compiler)).into()
    });
    steps.step("flight computer: build and clippy", || board_built(&compiler));
    steps.step("core alone", || core_alone(&compiler, &["--no-default-features"]).into());
    steps.step("core alone with defmt", || {
        core_alone(&compiler, &["--no-default-features", "--features", "defmt"]).into()
    });
    steps.step("tests of the core", || run(cargo().args(["test", "--package", "plumbline-core"])).into());
    steps.step("tests of the workspace", || run(cargo().args(["test", "--workspace"])).into());
    steps.step("a thousand frames over a bad line", || bad_line().into());
    steps.step("self-test of the emulated board", || selftest::selftest().into());
    let mut flown = None;
    steps.step("emulated flight equals the one in-process", || {
        flight::flight().map(|report| flown = Some(report)).into()
    });
    steps.step("memory map", || {
        budget::map::print("an500", flown.as_ref()).and_then(|()| budget::map::print("serial", None)).into()
    });
    steps.step("nothing in a frame's way can panic", || panics::tell().into());
    steps.step("flight computer: map, sizes, stack", || board::check(flown.as_ref()).into());
    steps.step("flight computer: boot rehearsal", board::rehearsal::rehearse);
    steps.step("budget", || match budget::holds(&compiler) {
        Ok(budget::Verdict::Holds) => Ok(()).into(),
        Ok(budget::Verdict::Fails) => Err("a gate fails, see above".to_owned()).into(),
        Ok(budget::Verdict::OtherCompiler(why)) => Outcome::Skipped(why),
        Err(why) => Err(why).into(),
    });
    steps.step("documentation", || documentation().into());
    true
}

/// Both images, and clippy of what only they compile.
fn board_built(compiler: &Compiler) -> Outcome {
    if let Err(why) = build::h743(compiler) {
        return Outcome::Failed(why);
    }
    if !compiler.has_clippy() {
        return Outcome::Skipped(format!("built; Debian's compiler for {THUMB} comes without a clippy of its version"));
    }
    let package = ["--package", "plumbline-firmware", "--features", "h743", "--profile", places::PROFILE_H743];
    clippy(&package, Some(compiler)).into()
}

fn clippy(what: &[&str], compiler: Option<&Compiler>) -> Result<(), Failure> {
    let mut cargo = cargo();
    cargo.arg("clippy").args(what);
    if let Some(compiler) = compiler {
        compiler.apply(&mut cargo);
    }
    run(cargo.args(["--", "-D", "warnings"]))
}

/// The core by itself, with no other crate to turn on a feature for it.
fn core_alone(compiler: &Compiler, features: &[&str]) -> Result<(), Failure> {
    let mut cargo: Command = cargo();
    cargo.args(["build", "--package", "plumbline-core", "--profile", places::PROFILE]).args(features);
    compiler.apply(&mut cargo);
    run(&mut cargo)
}

/// What takes too long without optimisation.
fn bad_line() -> Result<(), Failure> {
    run(cargo().args(["test", "--release", "--package", "plumbline-tests", "--test", "serial", "--", "--ignored"]))
}

fn documentation() -> Result<(), Failure> {
    run(cargo().args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}
