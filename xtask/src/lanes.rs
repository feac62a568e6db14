//! Lanes of steps: each lane does its own in order, all lanes at the same time. A step is a process of its own, so that
//! what it says comes in one piece.

use super::steps::{Done, Outcome, SKIPPED};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

/// Runs lanes of steps, which are what `program test NAME` does; what became of each, lane after lane. A failure stops
/// nothing: the other steps find what they find.
pub fn run(program: &Path, lanes: &[Vec<&str>]) -> Vec<Done> {
    // Held while a step's piece is written.
    let screen = Mutex::new(());
    let lane = |names: &[&str]| -> Vec<Done> { names.iter().map(|name| apart(program, name, &screen)).collect() };
    thread::scope(|scope| {
        let running: Vec<_> = lanes.iter().map(|names| scope.spawn(|| lane(names))).collect();
        running.into_iter().flat_map(|lane| lane.join().unwrap_or_default()).collect()
    })
}

/// One step in a process of its own.
fn apart(program: &Path, name: &str, screen: &Mutex<()>) -> Done {
    eprintln!("begins: {name}");
    let begin = Instant::now();
    let (outcome, said, busy) = match said(Command::new(program).args(["test", name])) {
        Ok((status, said, busy)) => (outcome(name, status, &said), said, busy),
        Err(error) => (Outcome::Failed(format!("the step could not be run: {error}")), String::new(), None),
    };
    let time = begin.elapsed();
    let _screen = screen.lock();
    // A closed standard error is no reason to stop testing.
    let _ = write!(std::io::stderr().lock(), "\n[{name}] {:.1} s\n{said}", time.as_secs_f64());
    Done { name: name.to_owned(), outcome, time, busy }
}

/// How a process ended, what it said, both outputs in their order, and what it took of the cores.
fn said(command: &mut Command) -> std::io::Result<(ExitStatus, String, Option<Duration>)> {
    let (mut read, write) = std::io::pipe()?;
    let mut process = command.stdin(Stdio::null()).stdout(write.try_clone()?).stderr(write).spawn()?;
    // Our own ends of the pipe are to be closed, or there is no end to be read.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut said = Vec::new();
    read.read_to_end(&mut said)?;
    // The system adds a process's time to ours when it is waited for: one at a time, so that the difference is this one's.
    let _ending = ENDING.lock();
    let before = busy();
    let status = process.wait()?;
    let busy = before.zip(busy()).map(|(before, after)| after - before);
    Ok((status, String::from_utf8_lossy(&said).into_owned(), busy))
}

/// Held while a step's process is waited for.
static ENDING: Mutex<()> = Mutex::new(());

/// What all processes that have been waited for took of the cores, and theirs: the 16th and 17th figure of Linux's
/// `/proc/self/stat`, hundredths of a second on every architecture (`USER_HZ`). The second figure is a name in parentheses.
fn busy() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let figures: Vec<u64> = stat.rsplit_once(')')?.1.split_whitespace().skip(13).take(2).flat_map(str::parse).collect();
    (figures.len() == 2).then(|| Duration::from_millis(10 * figures.iter().sum::<u64>()))
}

/// What a step's process came to. Why it did not pass is the last thing it said, after its name.
fn outcome(name: &str, status: ExitStatus, said: &str) -> Outcome {
    let begin = format!("{name}: ");
    let why = said.match_indices(&begin).filter(|(at, _)| *at == 0 || said[..*at].ends_with('\n')).last();
    let why = why.map(|(at, _)| said[at + begin.len()..].trim_end().to_owned());
    match (status.code(), why) {
        (Some(0), _) => Outcome::Passed,
        (Some(code), Some(why)) if code == i32::from(SKIPPED) => Outcome::Skipped(why),
        (_, why) => Outcome::Failed(why.unwrap_or_else(|| format!("ended with {status} and did not say why"))),
    }
}

#[cfg(test)]
mod tests {
    use super::{Outcome, outcome, run, said};
    use std::os::unix::process::ExitStatusExt;
    use std::path::Path;
    use std::process::ExitStatus;

    #[test]
    fn a_steps_last_words_say_why() {
        let exited = |code: i32, said: &str| outcome("budget", ExitStatus::from_raw(code << 8), said);
        assert_eq!(exited(0, "budget: all well\n"), Outcome::Passed);
        let said = "a figure\nbudget: first\nbudget: a gate fails\n  no budget: by far\n";
        assert_eq!(exited(1, said), Outcome::Failed("a gate fails\n  no budget: by far".into()));
        assert_eq!(exited(3, "budget: no emulator\n"), Outcome::Skipped("no emulator".into()));
        assert!(matches!(exited(101, "panicked\n"), Outcome::Failed(_)));
        assert!(matches!(exited(3, ""), Outcome::Failed(_)), "nothing is left out without a reason");
        let killed = outcome("budget", ExitStatus::from_raw(9), "");
        assert!(matches!(killed, Outcome::Failed(why) if why.contains("signal: 9")));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_steps_time_of_the_cores_is_its_own() {
        let work = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done";
        let took = |work: &str| said(std::process::Command::new("sh").args(["-c", work])).unwrap().2.unwrap();
        let (busy, idle) = (took(work), took("sleep 0.3"));
        assert!(busy > std::time::Duration::from_millis(50) && idle < busy, "{busy:?} {idle:?}");
    }

    #[test]
    fn every_step_of_every_lane_is_run_in_order() {
        let names = |program: &str| {
            let steps = run(Path::new(program), &[vec!["a", "b"], vec!["c"]]);
            steps.into_iter().map(|done| (done.name, done.outcome == Outcome::Passed)).collect::<Vec<_>>()
        };
        let all = |is_good| ["a", "b", "c"].map(|name| (name.to_owned(), is_good));
        assert_eq!(names("true"), all(true));
        assert_eq!(names("false"), all(false), "a failure stops nothing");
        assert_eq!(names("/there/is/none"), all(false));
    }
}
