//! `cargo xtask test`: all that must hold.

use super::places::{self, THUMB};
use super::process::{cargo, run};
use super::set_up::Compiler;
use super::steps::{self, Outcome};
use super::{Failure, board, budget, build, flight, lanes, panics, selftest, set_up};
use std::env;
use std::process::{Command, ExitCode};

/// A step that follows the building: its name, and what it does.
type Step = (&'static str, fn(&Compiler) -> Outcome);

/// The first step, which the others need.
const BUILD: &str = "set-up and build";

/// What cargo does for the host. It keeps all cores busy but for the end of each thing that it does.
const HOST: [Step; 4] = [
    ("format", |_| run(cargo().args(["fmt", "--all", "--check"])).into()),
    ("clippy (host)", |_| clippy(&["--workspace", "--all-targets"], None).into()),
    ("tests", |_| run(cargo().args(["test", "--workspace"])).into()),
    ("documentation", |_| documentation().into()),
];

/// What is compiled, linked and emulated for the boards: most of it work for one core at a time.
const BOARDS: [Step; 11] = [
    ("flight computer: build and clippy", board_built),
    ("clippy (firmware)", firmware_checked),
    ("core alone", |compiler| core_alone(compiler, &["--no-default-features"]).into()),
    ("core alone with defmt", |compiler| {
        core_alone(compiler, &["--no-default-features", "--features", "defmt"]).into()
    }),
    ("self-test of the emulated board", |_| selftest::selftest().into()),
    ("emulated flight equals the one in-process", |_| flight::flight().into()),
    ("memory map", |_| {
        let emulated = budget::map::print("an500", flight::flown().as_ref());
        emulated.and_then(|()| budget::map::print("serial", None)).into()
    }),
    ("nothing in a frame's way can panic", |_| panics::tell().into()),
    ("flight computer: map, sizes, stack", |_| board::check(flight::flown().as_ref()).into()),
    ("flight computer: boot rehearsal", |_| board::rehearsal::rehearse()),
    ("budget", |compiler| match budget::holds(compiler) {
        Ok(budget::Verdict::Holds) => Outcome::Passed,
        Ok(budget::Verdict::Fails) => Outcome::Failed("a gate fails, see above".to_owned()),
        Ok(budget::Verdict::OtherCompiler(why)) => Outcome::Skipped(why),
        Err(why) => Outcome::Failed(why),
    }),
];

/// `cargo xtask test`: every step, building first; two lanes of steps after that. `cargo xtask test STEP`: that one alone, of
/// what has been built and flown before.
///
/// # Errors
/// A sentence on a step that there is none of.
pub fn test(arguments: &[String]) -> Result<ExitCode, Failure> {
    match arguments {
        [] => Ok(all()),
        [name] => one(name),
        [_, extra, ..] => Err(format!("test takes the name of one step, but got {extra:?} too")),
    }
}

fn all() -> ExitCode {
    let lanes: [&[Step]; 2] = [&HOST, &BOARDS];
    let total = 1 + lanes.iter().map(|lane| lane.len()).sum::<usize>();
    // Before anything is built, ourselves included.
    let program = env::current_exe();
    eprintln!("begins: {BUILD}");
    let built = steps::step(BUILD, || {
        set_up::emulator().and_then(|()| set_up::checkers()).and_then(|()| build::build()).map(drop).into()
    });
    let mut done = vec![built];
    match program {
        Ok(program) if done[0].outcome == Outcome::Passed => {
            let lanes = lanes.map(|lane| lane.iter().map(|(name, _)| *name).collect::<Vec<_>>());
            done.extend(lanes::run(&program, &lanes.each_ref().map(|lane| &lane[..])));
        }
        Ok(_) => {}
        Err(error) => eprintln!("this program does not find itself: {error}"),
    }
    if steps::report(total, &done) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn one(name: &str) -> Result<ExitCode, Failure> {
    let steps = HOST.iter().chain(&BOARDS);
    let Some((name, work)) = steps.clone().find(|(known, _)| *known == name) else {
        let names: Vec<&str> = steps.map(|(name, _)| *name).collect();
        return Err(format!("test has no step {name:?}; it has {}", names.join("; ")));
    };
    let done = steps::step(name, || set_up::compiler().map_or_else(Outcome::Failed, |compiler| work(&compiler)));
    Ok(done.outcome.exit_code())
}

/// Clippy of what only the emulated board compiles. In the images' profile, since the host's lane keeps the other locked.
fn firmware_checked(compiler: &Compiler) -> Outcome {
    if !compiler.has_clippy() {
        return Outcome::Skipped(format!("Debian's compiler for {THUMB} comes without a clippy of its version"));
    }
    let package = ["--package", "plumbline-firmware", "--features", build::AN500, "--profile", places::PROFILE];
    clippy(&package, Some(compiler)).into()
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

fn documentation() -> Result<(), Failure> {
    run(cargo().args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))
}
