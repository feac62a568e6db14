//! `cargo xtask test`: what must hold, step by step; `--all` takes the long ones in, `cargo xtask nightly` what is longer
//! than an hour.

use super::places::{self, THUMB};
use super::process::{cargo, run};
use super::set_up::Compiler;
use super::steps::{self, Outcome};
use super::{
    Failure, board, budget, build, flight, fuzz, lanes, mission, pages, panics, recording, selftest, set_up, signing,
};
use std::env;
use std::process::ExitCode;

/// How much is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Depth {
    Everyday,
    All,
    Nightly,
}
use Depth::{All, Everyday, Nightly};

/// A step: its name, the depths that it belongs to, first and last, and what it does.
type Step = (&'static str, (Depth, Depth), fn(&Compiler) -> Outcome);

/// Lanes of steps that run at the same time.
type Phase = &'static [&'static [Step]];

const EACH: (Depth, Depth) = (Everyday, Nightly);
const LONG: (Depth, Depth) = (All, Nightly);

/// One phase after the other. A phase in which a step fails is the last: the next ones need it.
///
/// The two lanes of each suit two cores: what cargo does for the host, in its development profile alone, and what is
/// compiled, linked and emulated for the boards, most of which is work for one core. The flight computer's images belong to
/// the long steps: they take a third profile, in which embassy-stm32 alone is minutes, and the emulated board's have the
/// application. So does clippy, which checks all that we depend on anew: four minutes of the cores.
const PHASES: [Phase; 3] = [
    &[&[("set-up", EACH, |_| set_up::emulator().map(drop).into())]],
    &[
        &[("build (host)", EACH, |_| build::host().into())],
        &[("build (emulated board)", EACH, |compiler| build::images(compiler).into())],
    ],
    &[
        &[
            ("format", EACH, |_| checked("rustfmt", "fmt", || run(cargo().args(["fmt", "--all", "--check"])))),
            ("tests", (Everyday, Everyday), |_| tests(&["--lib", "--bins", "--tests"])),
            ("tests, also the long ones, and examples", LONG, |_| tests(&["--", "--include-ignored"])),
            ("clippy (host)", LONG, |_| {
                clippy(&["--workspace", "--all-targets", "--features", "plumbline-tests/programs"], None)
            }),
            ("documentation", LONG, |_| {
                run(cargo().args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings")).into()
            }),
        ],
        &[
            ("clippy (emulated board)", LONG, |compiler| {
                clippy(&["--features", build::AN500, "--profile", places::PROFILE], Some(compiler))
            }),
            ("self-test of the emulated board", EACH, |_| selftest::selftest().into()),
            ("emulated flight equals the one in-process", EACH, |_| flight::flight().into()),
            ("memory map", EACH, |_| {
                let emulated = budget::map::print("an500", flight::flown().as_ref());
                emulated.and_then(|()| budget::map::print("serial", None)).into()
            }),
            ("nothing in a frame's way can panic", EACH, |_| panics::emulated().into()),
            ("budget", EACH, |compiler| budget::holds(compiler)),
            ("core alone", LONG, |compiler| core_alone(compiler, &["--no-default-features"]).into()),
            ("core alone with defmt", LONG, |compiler| {
                core_alone(compiler, &["--no-default-features", "--features", "defmt"]).into()
            }),
            ("flight computer: build", LONG, |compiler| build::h743(compiler).into()),
            ("flight computer: clippy", LONG, |compiler| {
                clippy(&["--features", "h743", "--profile", places::PROFILE_H743], Some(compiler))
            }),
            ("flight computer: map, sizes, stack", LONG, |_| board::check(flight::flown().as_ref()).into()),
            ("flight computer: what can panic", LONG, |_| panics::flight_computer().into()),
            ("flight computer: boot rehearsal", LONG, |_| board::rehearsal::rehearse()),
            ("missions as a ground station reads them", LONG, |_| mission::check()),
            ("pages in a browser", LONG, |_| pages::check()),
            ("recordings as another reader of MCAP has them", LONG, |_| recording::check()),
            ("signed messages as pymavlink has them", LONG, |_| signing::check()),
            ("ten million damaged inputs for each reader", (Nightly, Nightly), |_| fuzz::fuzz(&[]).into()),
        ],
    ],
];

/// `cargo xtask test [--all]`: every step of that depth. `cargo xtask test STEP`: that one alone, of what has been built and
/// flown before.
///
/// # Errors
/// A sentence on a step that there is none of.
pub fn test(arguments: &[String]) -> Result<ExitCode, Failure> {
    match arguments {
        [] => Ok(all(Everyday)),
        [all_of_them] if all_of_them == "--all" => Ok(all(All)),
        [name] => one(name),
        [_, extra, ..] => Err(format!("test takes --all or the name of one step, but got {extra:?} too")),
    }
}

/// `cargo xtask nightly`: all that `test --all` does, and what takes longer than an hour.
pub fn nightly() -> ExitCode {
    all(Nightly)
}

fn all(depth: Depth) -> ExitCode {
    let phases = PHASES.map(|phase| phase.iter().map(|lane| names(lane, depth)).collect::<Vec<_>>());
    let total = phases.iter().flatten().map(Vec::len).sum();
    // Before anything is built, ourselves included.
    let program = match env::current_exe() {
        Ok(program) => program,
        Err(error) => {
            eprintln!("this program does not find itself: {error}");
            return ExitCode::FAILURE;
        }
    };
    let mut done = Vec::new();
    for phase in phases {
        done.extend(lanes::run(&program, &phase));
        if done.iter().any(|step| matches!(step.outcome, Outcome::Failed(_))) {
            break;
        }
    }
    if steps::report(total, &done) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Names of a lane's steps that belong to a depth.
fn names(lane: &[Step], depth: Depth) -> Vec<&'static str> {
    lane.iter().filter(|(_, (first, last), _)| (*first..=*last).contains(&depth)).map(|(name, ..)| *name).collect()
}

fn one(name: &str) -> Result<ExitCode, Failure> {
    let steps = || PHASES.iter().flat_map(|phase| phase.iter()).flat_map(|lane| lane.iter());
    let Some((name, _, work)) = steps().find(|(known, ..)| *known == name) else {
        let names: Vec<&str> = steps().map(|(name, ..)| *name).collect();
        return Err(format!("test has no step {name:?}; it has {}", names.join("; ")));
    };
    let outcome = set_up::compiler().map_or_else(Outcome::Failed, |compiler| work(&compiler));
    if let Outcome::Failed(why) | Outcome::Skipped(why) = &outcome {
        eprintln!("{name}: {why}");
    }
    Ok(outcome.exit_code())
}

/// All tests, without a stop at the first that fails: those that the arguments choose.
fn tests(chosen: &[&str]) -> Outcome {
    run(cargo().args(["test", "--workspace", "--no-fail-fast"]).args(chosen)).into()
}

/// A check by a part of the toolchain that not every machine has.
fn checked(component: &str, verb: &str, check: impl FnOnce() -> Result<(), Failure>) -> Outcome {
    set_up::component(component, verb).map_or_else(Outcome::Skipped, |()| check().into())
}

/// Clippy of the host's crates, or of what only a board compiles. In the profile of its images, since cargo locks the
/// other.
fn clippy(what: &[&str], compiler: Option<&Compiler>) -> Outcome {
    if compiler.is_some_and(|compiler| !compiler.has_clippy()) {
        return Outcome::Skipped(format!("Debian's compiler for {THUMB} comes without a clippy of its version"));
    }
    let mut cargo = cargo();
    cargo.arg("clippy").args(what);
    if let Some(compiler) = compiler {
        compiler.apply(cargo.args(["--package", "plumbline-firmware"]));
    }
    checked("clippy", "clippy", || run(cargo.args(["--", "-D", "warnings"])))
}

/// The core by itself, with no other crate to turn on a feature for it.
fn core_alone(compiler: &Compiler, features: &[&str]) -> Result<(), Failure> {
    let mut cargo = cargo();
    cargo.args(["build", "--package", "plumbline-core", "--profile", places::PROFILE]).args(features);
    compiler.apply(&mut cargo);
    run(&mut cargo)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_depth_takes_in_the_one_before() {
        let of = |depth| {
            PHASES.iter().flat_map(|phase| phase.iter()).flat_map(|lane| names(lane, depth)).collect::<Vec<_>>()
        };
        let [everyday, all, nightly] = [Everyday, All, Nightly].map(of);
        assert!(everyday.iter().all(|step| all.contains(step) || *step == "tests"), "{everyday:?}");
        assert!(all.iter().all(|step| nightly.contains(step)) && nightly.len() > all.len(), "{nightly:?}");
        let mut steps: Vec<_> =
            PHASES.iter().flat_map(|phase| phase.iter()).flat_map(|lane| lane.iter()).map(|s| s.0).collect();
        steps.sort_unstable();
        let count = steps.len();
        steps.dedup();
        assert_eq!(steps.len(), count, "a step is asked for by its name");
    }
}
