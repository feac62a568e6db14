//! `cargo xtask test`: all that must hold.

use super::places::{self, THUMB};
use super::process::{cargo, run};
use super::set_up::Compiler;
use super::steps::{self, Outcome};
use super::{Failure, board, budget, build, flight, lanes, panics, selftest, set_up};
use std::env;
use std::process::{Command, ExitCode};
use std::thread;

/// A step that follows the building: its name, and what it does.
type Step = (&'static str, fn(&Compiler) -> Outcome);

/// The first steps, which the others need.
const SET_UP: &str = "set-up";
const BUILD: &str = "build";

/// What needs nothing built, beside the building: linking the images keeps one core busy only.
const BESIDE: [Step; 2] = [
    ("format", |_| run(cargo().args(["fmt", "--all", "--check"])).into()),
    ("clippy (host)", |_| clippy(&["--workspace", "--all-targets"], None).into()),
];

/// What cargo does for the host. It keeps all cores busy but for the end of each thing that it does.
const HOST: [Step; 2] =
    [("tests", |_| run(cargo().args(["test", "--workspace"])).into()), ("documentation", |_| documentation().into())];

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

/// `cargo xtask test`: every step, building first and what can be done beside it; two lanes of steps after that. `cargo xtask test STEP`: that one alone, of
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
    let total = 2 + BESIDE.len() + lanes.iter().map(|lane| lane.len()).sum::<usize>();
    let names = |lane: &[Step]| lane.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    // Before anything is built, ourselves included.
    let program = match env::current_exe() {
        Ok(program) => program,
        Err(error) => {
            eprintln!("this program does not find itself: {error}");
            return ExitCode::FAILURE;
        }
    };
    let mut done = vec![steps::step(SET_UP, || set_up::emulator().and_then(|()| set_up::checkers()).into())];
    if done[0].outcome == Outcome::Passed {
        eprintln!("begins: {BUILD}");
        let beside = thread::scope(|scope| {
            let beside = scope.spawn(|| lanes::run(&program, &[&names(&BESIDE)]));
            done.push(steps::step(BUILD, || build::build().map(drop).into()));
            beside.join().unwrap_or_default()
        });
        done.extend(beside);
    }
    if done.get(1).is_some_and(|built| built.outcome == Outcome::Passed) {
        let lanes = lanes.map(names);
        done.extend(lanes::run(&program, &lanes.each_ref().map(|lane| &lane[..])));
    }
    if steps::report(total, &done) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn one(name: &str) -> Result<ExitCode, Failure> {
    let steps = BESIDE.iter().chain(&HOST).chain(&BOARDS);
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
