//! Steps of a test run, told as they go.

use super::Failure;
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

/// A run of `total` steps.
#[derive(Debug)]
pub struct Steps {
    total: usize,
    done: Vec<(String, Outcome, Duration)>,
}

impl Steps {
    /// Before the first step.
    pub fn new(total: usize) -> Self {
        Steps { total, done: Vec::with_capacity(total) }
    }

    /// Does a step; whether it passed or was skipped.
    pub fn step(&mut self, name: &str, work: impl FnOnce() -> Outcome) -> bool {
        eprintln!("[{}/{}] {name}", self.done.len() + 1, self.total);
        let begin = Instant::now();
        let outcome = work();
        if let Outcome::Failed(why) | Outcome::Skipped(why) = &outcome {
            eprintln!("{name}: {why}");
        }
        let is_good = !matches!(outcome, Outcome::Failed(_));
        self.done.push((name.to_owned(), outcome, begin.elapsed()));
        is_good
    }

    /// Tells how it went, a line a step and one for all; whether nothing failed and nothing was left out.
    pub fn report(&self) -> bool {
        println!();
        for (name, outcome, time) in &self.done {
            let (word, why) = match outcome {
                Outcome::Passed => ("passed", String::new()),
                Outcome::Failed(why) => ("FAILED", format!(": {why}")),
                Outcome::Skipped(why) => ("skipped", format!(": {why}")),
            };
            println!("{word:8} {:7.1} s  {name}{why}", time.as_secs_f64());
        }
        let count = |wanted: fn(&Outcome) -> bool| self.done.iter().filter(|(_, outcome, _)| wanted(outcome)).count();
        let passed = count(|outcome| *outcome == Outcome::Passed);
        let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
        let skipped = count(|outcome| matches!(outcome, Outcome::Skipped(_)));
        let not_run = self.total.saturating_sub(self.done.len());
        let rest = [(skipped, "skipped"), (not_run, "not run")];
        let rest: String = rest.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!(", {n} {word}")).collect();
        println!("{passed} passed, {failed} failed{rest}");
        failed == 0 && not_run == 0
    }
}

impl From<Result<(), Failure>> for Outcome {
    fn from(result: Result<(), Failure>) -> Self {
        result.map_or_else(Outcome::Failed, |()| Outcome::Passed)
    }
}
