//! `cargo xtask VERB`: sets up what is missing, builds, flies, tests, counts, compares.

mod board;
mod budget;
mod build;
mod compare;
mod debian;
mod elf;
mod figures;
mod flash;
mod flight;
mod fly;
mod fuzz;
mod lanes;
mod mission;
mod pages;
mod panics;
mod places;
mod process;
mod python;
mod recording;
mod release;
mod selftest;
mod set_up;
mod signing;
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
    let is_help = |argument: &str| ["--help", "-h"].contains(&argument);
    if verb == "help" || is_help(&verb) || rest.iter().any(|argument| is_help(argument)) {
        println!("{}", help(&verb));
        return ExitCode::SUCCESS;
    }
    let outcome = match verb.as_str() {
        "build" => none_left(&rest).map(|()| build::all().map_or_else(failed, |()| ExitCode::SUCCESS)),
        "fly" => Ok(fly::fly(&rest).unwrap_or_else(failed)),
        "budget" => budget::budget(&rest),
        "flash" => flash::flash(&rest),
        "campaign" => process::program("campaign").and_then(|mut program| process::exit_code(program.args(&rest))),
        "compare" => compare::compare(&rest),
        "figures" => none_left(&rest).map(|()| figures::figures().map_or_else(failed, |()| ExitCode::SUCCESS)),
        "fuzz" => Ok(fuzz::fuzz(&rest).map_or_else(failed, |()| ExitCode::SUCCESS)),
        "panics" => none_left(&rest).map(|()| {
            let both = panics::emulated().and_then(|()| panics::flight_computer());
            both.map_or_else(failed, |()| ExitCode::SUCCESS)
        }),
        "release" => Ok(release::release(&rest).map_or_else(failed, |()| ExitCode::SUCCESS)),
        "test" => test::test(&rest),
        "nightly" => none_left(&rest).map(|()| test::nightly()),
        "" => Err(help("")),
        unknown => Err(format!("cargo xtask knows no verb {unknown:?}\n{}", help(""))),
    };
    outcome.unwrap_or_else(|sentence| {
        eprintln!("{sentence}");
        ExitCode::from(2)
    })
}

/// Each verb with its arguments and what it does.
const VERBS: [(&str, &str); 13] = [
    ("build", "all images, and the command plumbline in release"),
    ("fly [OPTIONS OF plumbline fly]", "builds, then flies in the emulator unless told otherwise"),
    ("test [--all | STEP]", "all that must hold: every day, with the long steps, or one step of what has been built"),
    ("nightly", "test --all, and what takes longer than an hour"),
    ("budget [--json] [--overwrite] [--against REVISION]", "what a frame costs, beside what it may cost"),
    (
        "flash [--probe | --bare] [--camera FILE.toml [--settings FILE.toml] | --configuration FILE] [--plan FILE] [--tiles FILE]",
        "writes the flight computer",
    ),
    (
        "campaign [--scenario NAME] [--seeds N] [--seed FIRST] [--frames N] [--set KEY=VALUE] [--fault \"UNIT.TYPE=VALUE@FROM..TO ...\"] [--each-fault FROM..TO [--kind WORD] [--sound]] [--between ORTHO ORTHO ...] [--frames-csv FILE]",
        "many flights and what their fixes are worth: wrong ones, coverage, covariance, recovery from faults",
    ),
    ("compare [--json] [--frame PICTURE ...]", "the core's kernels beside OpenCV's, error and time"),
    ("compare --matching ORTHO ORTHO ...", "the core's matchers between years: coverage, wrong ones, risk"),
    ("figures", "what flights and the budget measure, into docs/figures.md"),
    ("fuzz [--inputs N] [--seed S] [--target READER]", "damaged inputs for each reader of bytes"),
    ("release [TARGET ...]", "archives of the command for x86-64 and arm64, under target/archives"),
    ("panics", "which functions in a frame's way could panic"),
];

/// Help on a verb; on all, where there is none of that name.
fn help(verb: &str) -> String {
    let is_it = |line: &str| line.split(' ').next() == Some(verb);
    let is_known = VERBS.iter().any(|(line, _)| is_it(line));
    let lines = VERBS.iter().filter(|(line, _)| !is_known || is_it(line));
    "cargo xtask VERB".to_owned() + &lines.map(|(line, what)| format!("\n  {line}\n      {what}")).collect::<String>()
}

fn none_left(rest: &[String]) -> Result<(), Failure> {
    rest.first().map_or(Ok(()), |extra| Err(format!("this verb takes no arguments, but got {extra:?}")))
}

fn failed(sentence: Failure) -> ExitCode {
    eprintln!("{sentence}");
    ExitCode::from(1)
}
