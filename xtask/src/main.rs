//! `cargo xtask VERB`: sets up what is missing, builds, flies, tests, counts, compares.

mod board;
mod budget;
mod build;
mod compare;
mod elf;
mod flash;
mod flight;
mod fly;
mod fuzz;
mod lanes;
mod panics;
mod places;
mod process;
mod selftest;
mod set_up;
mod steps;
mod test;
mod thumb;

use std::process::ExitCode;

/// Why a verb failed: one sentence.
type Failure = String;

fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let verb = args.next().unwrap_or_default();
    let rest: Vec<String> = args.collect();
    let outcome = match verb.as_str() {
        "build" => none_left(&rest).map(|()| build::all().map_or_else(failed, |()| ExitCode::SUCCESS)),
        "fly" => Ok(fly::fly(&rest).unwrap_or_else(failed)),
        "budget" => budget::budget(&rest),
        "flash" => flash::flash(&rest),
        "compare" => compare::compare(&rest),
        "fuzz" => Ok(fuzz::fuzz(&rest).map_or_else(failed, |()| ExitCode::SUCCESS)),
        "panics" => none_left(&rest).map(|()| panics::tell().map_or_else(failed, |()| ExitCode::SUCCESS)),
        "test" => test::test(&rest),
        "" => Err(format!("cargo xtask needs a verb: {VERBS}")),
        unknown => Err(format!("cargo xtask knows no verb {unknown:?}; it knows {VERBS}")),
    };
    outcome.unwrap_or_else(|sentence| {
        eprintln!("{sentence}");
        ExitCode::from(2)
    })
}

const VERBS: &str = "build (all images and the plumbline command), fly [options of plumbline fly], budget [--json] \
    [--overwrite] [--against REVISION], flash [--probe] [--bare] [--camera FILE.toml [--settings FILE.toml]] \
    [--mission FILE] [--tiles FILE], compare [--json] [--frame PICTURE ...], fuzz [--inputs N] [--seed S] \
    [--target READER], panics, and test [STEP]";

fn none_left(rest: &[String]) -> Result<(), Failure> {
    rest.first().map_or(Ok(()), |extra| Err(format!("this verb takes no arguments, but got {extra:?}")))
}

fn failed(sentence: Failure) -> ExitCode {
    eprintln!("{sentence}");
    ExitCode::from(1)
}
