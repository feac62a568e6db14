//! The progress of every command: on standard error, with the time that is left. A person at a terminal sees a bar; elsewhere a
//! line now and then says that the work goes on.

use crate::outcome::note;
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::Deref;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// From one line to the next. Chosen: work of some seconds says nothing, and an hour's log has some hundreds of lines.
const EVERY: Duration = Duration::from_secs(10);

/// A bar, or its lines where nobody sees it.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    /// Its end ends the lines.
    _lines: Sender<()>,
}

/// A bar over `count` times `what`.
pub fn bar(count: u64, what: &'static str) -> Bar {
    let bar = styled(ProgressBar::new(count), "{msg} {pos} of {len} {wide_bar} {eta} left").with_message(what);
    Bar::new(bar)
}

/// For work whose end cannot be foreseen: what it is at.
pub fn spinner() -> Bar {
    Bar::new(styled(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}"))
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl Bar {
    fn new(bar: ProgressBar) -> Self {
        let (lines, end) = channel();
        if bar.is_hidden() {
            let shown = bar.clone();
            thread::spawn(move || lines_of(&shown, &end, EVERY, |line| note(&line)));
        }
        Bar { bar, _lines: lines }
    }
}

/// Says how far a bar is, a line every so often, until the bar is done or its other end is gone.
fn lines_of(shown: &ProgressBar, end: &Receiver<()>, every: Duration, say: impl Fn(String)) {
    let mut began = (shown.message(), Instant::now());
    while end.recv_timeout(every) == Err(RecvTimeoutError::Timeout) && !shown.is_finished() {
        let (what, of) = (shown.message(), shown.length());
        // Other work, since the last line at the earliest.
        if of.is_some() && what != began.0 {
            began = (what.clone(), Instant::now().checked_sub(every).unwrap_or(began.1));
        }
        say(line(&what, shown.position(), of, began.1.elapsed()));
    }
}

impl Deref for Bar {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.bar
    }
}

/// How far the work is after some time, and how long it will take from here where that can be told.
fn line(what: &str, done: u64, of: Option<u64>, elapsed: Duration) -> String {
    let of = of.filter(|of| *of > 0 && done <= *of);
    let Some(of) = of else {
        let what = if what.is_empty() { "at work" } else { what };
        return format!("plumbline: {what}, {} so far", time(elapsed.as_secs_f64()));
    };
    let share = format!("plumbline: {what} {done} of {of}, {:.0} %", 100.0 * done as f64 / of as f64);
    if done == 0 {
        return share;
    }
    let left_s = elapsed.as_secs_f64() * (of - done) as f64 / done as f64;
    format!("{share}, about {} left", time(left_s))
}

fn time(seconds: f64) -> String {
    match seconds.round() as u64 {
        seconds @ ..120 => format!("{seconds} s"),
        seconds => format!("{} min", (seconds + 30) / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_far_and_how_long() {
        let after = |seconds| Duration::from_secs(seconds);
        assert_eq!(line("frame", 300, Some(1500), after(10)), "plumbline: frame 300 of 1500, 20 %, about 40 s left");
        assert_eq!(line("frame", 1, Some(1500), after(10)), "plumbline: frame 1 of 1500, 0 %, about 250 min left");
        assert_eq!(line("frame", 0, Some(1500), after(10)), "plumbline: frame 0 of 1500, 0 %");
        assert_eq!(line("iteration 3", 0, None, after(130)), "plumbline: iteration 3, 2 min so far");
        assert_eq!(line("", 0, Some(0), after(20)), "plumbline: at work, 20 s so far");
    }

    /// Off a terminal: a line every so often, and the last one before the work is done.
    #[test]
    fn long_work_says_that_it_goes_on() {
        let every = Duration::from_millis(5);
        let shown = ProgressBar::hidden();
        shown.set_length(40);
        shown.set_message("frame");
        shown.set_position(10);
        let (lines, end) = channel();
        let (said, heard) = channel();
        let work = shown.clone();
        thread::spawn(move || lines_of(&shown, &end, every, |line| drop(said.send(line))));
        for _ in 0..2 {
            let line = heard.recv_timeout(Duration::from_secs(60)).expect("a line");
            assert!(line.starts_with("plumbline: frame 10 of 40, 25 %, about "), "{line}");
        }
        work.finish();
        assert!(heard.iter().take(1000).count() < 1000, "it ends with the work");
        drop(lines);
    }
}
