//! Steps of a test run: how one ends, and what is told of all.

use super::Failure;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// How a step ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All well.
    Passed,
    /// Why not.
    Failed(Failure),
    /// Not done on this machine, and why.
    Skipped(String),
}

/// The exit code of a step that was not done, where it runs as a process of its own.
pub const SKIPPED: u8 = 3;

impl Outcome {
    /// For the process of one step.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Outcome::Passed => ExitCode::SUCCESS,
            Outcome::Failed(_) => ExitCode::FAILURE,
            Outcome::Skipped(_) => ExitCode::from(SKIPPED),
        }
    }
}

/// A step that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Done {
    /// Its name.
    pub name: String,
    /// How.
    pub outcome: Outcome,
    /// How long it took.
    pub time: Duration,
}

/// Does a step here and now, and says why if it does not pass.
pub fn step(name: &str, work: impl FnOnce() -> Outcome) -> Done {
    let begin = Instant::now();
    let outcome = work();
    if let Outcome::Failed(why) | Outcome::Skipped(why) = &outcome {
        eprintln!("{name}: {why}");
    }
    Done { name: name.to_owned(), outcome, time: begin.elapsed() }
}

/// Tells how `total` steps went, a line a step and one for all; whether nothing failed and nothing was left out.
pub fn report(total: usize, steps: &[Done]) -> bool {
    println!();
    for Done { name, outcome, time } in steps {
        let (word, why) = match outcome {
            Outcome::Passed => ("passed", String::new()),
            Outcome::Failed(why) => ("FAILED", format!(": {why}")),
            Outcome::Skipped(why) => ("skipped", format!(": {why}")),
        };
        println!("{word:8} {:7.1} s  {name}{why}", time.as_secs_f64());
    }
    let count = |wanted: fn(&Outcome) -> bool| steps.iter().filter(|done| wanted(&done.outcome)).count();
    let passed = count(|outcome| *outcome == Outcome::Passed);
    let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let skipped = count(|outcome| matches!(outcome, Outcome::Skipped(_)));
    let not_run = total.saturating_sub(steps.len());
    let rest = [(skipped, "skipped"), (not_run, "not run")];
    let rest: String = rest.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!(", {n} {word}")).collect();
    println!("{passed} passed, {failed} failed{rest}");
    failed == 0 && not_run == 0
}

impl From<Result<(), Failure>> for Outcome {
    fn from(result: Result<(), Failure>) -> Self {
        result.map_or_else(Outcome::Failed, |()| Outcome::Passed)
    }
}
