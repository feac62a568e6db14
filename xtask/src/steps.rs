//! Steps of a test run: how one ends, and what is told of all.

use super::{Failure, places};
use std::fmt::Write;
use std::process::ExitCode;
use std::time::Duration;

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
    /// What it and all that it started took of the cores, user and system, where the machine tells.
    pub busy: Option<Duration>,
}

/// Tells how `total` steps went, and keeps that in `steps.txt` of the scratch folder; whether nothing failed and nothing
/// was left out.
pub fn report(total: usize, steps: &[Done]) -> bool {
    let table = table(total, steps);
    print!("\n{table}");
    let path = places::scratch().join("steps.txt");
    if let Err(error) = std::fs::create_dir_all(places::scratch()).and_then(|()| std::fs::write(&path, &table)) {
        eprintln!("{}: {error}", path.display());
    }
    steps.len() == total && !steps.iter().any(|done| matches!(done.outcome, Outcome::Failed(_)))
}

/// A line a step, with its time by the clock and that of the cores, and one for all.
fn table(total: usize, steps: &[Done]) -> String {
    let mut table = "           clock    cores  step\n".to_owned();
    for Done { name, outcome, time, busy } in steps {
        let (word, why) = match outcome {
            Outcome::Passed => ("passed", String::new()),
            Outcome::Failed(why) => ("FAILED", format!(": {why}")),
            Outcome::Skipped(why) => ("skipped", format!(": {why}")),
        };
        let busy = busy.map_or("-".to_owned(), |busy| format!("{:.1} s", busy.as_secs_f64()));
        let _ = writeln!(table, "{word:8}{:6.1} s {busy:>8}  {name}{why}", time.as_secs_f64());
    }
    let count = |wanted: fn(&Outcome) -> bool| steps.iter().filter(|done| wanted(&done.outcome)).count();
    let passed = count(|outcome| *outcome == Outcome::Passed);
    let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let skipped = count(|outcome| matches!(outcome, Outcome::Skipped(_)));
    let not_run = total.saturating_sub(steps.len());
    let rest = [(skipped, "skipped"), (not_run, "not run")];
    let rest: String = rest.iter().filter(|(n, _)| *n > 0).map(|(n, word)| format!(", {n} {word}")).collect();
    let minutes = steps.iter().filter_map(|done| done.busy).sum::<Duration>().as_secs_f64() / 60.0;
    let _ = writeln!(table, "{passed} passed, {failed} failed{rest}; {minutes:.1} minutes of the cores");
    table
}

impl From<Result<(), Failure>> for Outcome {
    fn from(result: Result<(), Failure>) -> Self {
        result.map_or_else(Outcome::Failed, |()| Outcome::Passed)
    }
}

#[cfg(test)]
mod tests {
    use super::{Done, Outcome, table};
    use std::time::Duration;

    #[test]
    fn a_table_tells_both_times_and_what_did_not_run() {
        let step = |name: &str, outcome, busy| Done {
            name: name.into(),
            outcome,
            time: Duration::from_secs(2),
            busy: Some(Duration::from_secs(busy)),
        };
        let steps = [step("a", Outcome::Passed, 90), step("b", Outcome::Skipped("no python3".into()), 30)];
        assert_eq!(
            table(3, &steps),
            "           clock    cores  step\npassed     2.0 s   90.0 s  a\nskipped    2.0 s   30.0 s  b: no python3\n\
             1 passed, 0 failed, 1 skipped, 1 not run; 2.0 minutes of the cores\n"
        );
    }
}
