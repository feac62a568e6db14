//! A line on which things go wrong: a proxy between the simulator and a board's socket, seeded and counted.
//!
//! It knows messages by the zeros between them, as whoever has cable and hands would not; so every kind of fault has a
//! rate of its own, in percent of the messages of both directions. What happens to which message depends on the order in
//! which they come, and that on time-outs: the same seed gives the same kind of trouble, not the same trouble.

use crate::link::line::Line;
use crate::noise::{stream, uniform};
use rand_chacha::ChaCha12Rng;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::collections::VecDeque;
use std::io;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the thread looks whether it is to stop.
const GLANCE: Duration = Duration::from_millis(10);
/// How long a receiver may refuse bytes.
const WRITE_PATIENCE: Duration = Duration::from_secs(2);

/// How often what goes wrong, in percent of the messages.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineFaults {
    /// Lost, half of them whole and half of them in part.
    pub lost: f64,
    /// Sent twice.
    pub doubled: f64,
    /// Sent after the next one.
    pub reordered: f64,
    /// A byte changed.
    pub corrupted: f64,
    /// Held back for [`LineFaults::stall`], and all that follow with it.
    pub stalled: f64,
    /// How long.
    pub stall: Duration,
    /// The line is unplugged, and plugged in [`LineFaults::absence`] later.
    pub cut: f64,
    /// How long it stays unplugged.
    pub absence: Duration,
    /// The board's power fails for a moment.
    pub rebooted: f64,
}

/// What was done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineFaultCounts {
    /// Messages that came in, both directions.
    pub messages: u64,
    /// See [`LineFaults`].
    pub lost: u64,
    /// See [`LineFaults`].
    pub doubled: u64,
    /// See [`LineFaults`].
    pub reordered: u64,
    /// See [`LineFaults`].
    pub corrupted: u64,
    /// See [`LineFaults`].
    pub stalled: u64,
    /// See [`LineFaults`].
    pub cut: u64,
    /// See [`LineFaults`].
    pub rebooted: u64,
}

/// A running proxy. Stopped when dropped.
#[derive(Debug)]
pub struct FaultyLine {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    counts: Arc<Mutex<LineFaultCounts>>,
    thread: Option<JoinHandle<()>>,
}

impl FaultyLine {
    /// Listens on a socket made at `path` and passes on to the one at `board`. `reboot` makes the board's power fail.
    ///
    /// # Errors
    /// A path that cannot be listened on.
    pub fn new(
        path: &Path,
        board: &Path,
        faults: LineFaults,
        seed: u64,
        reboot: impl Fn() + Send + 'static,
    ) -> io::Result<Self> {
        let listener = UnixListener::bind(path)?;
        listener.set_nonblocking(true)?;
        let (stop, counts) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(LineFaultCounts::default())));
        let mut proxy = Proxy {
            faults,
            rng: stream(seed, "fault.line"),
            counts: LineFaultCounts::default(),
            published: counts.clone(),
            reboot: Box::new(reboot),
        };
        let (board, is_over) = (board.to_owned(), stop.clone());
        let thread = std::thread::spawn(move || {
            while !is_over.load(Ordering::Acquire) {
                let plugged = listener.accept().and_then(|(host, _)| {
                    Ok([Line::new(host.into())?, Line::new(UnixStream::connect(&board)?.into())?])
                });
                match plugged {
                    Ok(lines) => {
                        proxy.pass(lines, &is_over);
                        std::thread::sleep(proxy.faults.absence);
                    }
                    Err(_) => std::thread::sleep(GLANCE),
                }
            }
        });
        Ok(FaultyLine { path: path.to_owned(), stop, counts, thread: Some(thread) })
    }

    /// What to give to `--link serial:`.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was done so far.
    pub fn counts(&self) -> LineFaultCounts {
        self.counts.lock().map_or_else(|poisoned| *poisoned.into_inner(), |counts| *counts)
    }
}

impl Drop for FaultyLine {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A thread that died has said why on stderr.
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.path);
    }
}

struct Proxy {
    faults: LineFaults,
    rng: ChaCha12Rng,
    counts: LineFaultCounts,
    published: Arc<Mutex<LineFaultCounts>>,
    reboot: Box<dyn Fn() + Send>,
}

/// One way of the line.
#[derive(Default)]
struct Way {
    /// The message that is coming in.
    partial: Vec<u8>,
    /// Kept back to follow the next one.
    kept: Option<Vec<u8>>,
    /// When to pass on what.
    queue: VecDeque<(Instant, Vec<u8>)>,
    stalled_until: Option<Instant>,
}

impl Proxy {
    /// Passes messages both ways until one end or the line itself is unplugged.
    fn pass(&mut self, mut lines: [Line; 2], is_over: &AtomicBool) {
        let mut ways = [Way::default(), Way::default()];
        let mut buffer = [0; 4096];
        while !is_over.load(Ordering::Acquire) {
            let now = Instant::now();
            let due = ways.iter().filter_map(|way| way.queue.front()).map(|(at, _)| at.saturating_duration_since(now));
            let wait = due.min().map_or(GLANCE, |due| due.min(GLANCE));
            let timeout = Timespec { tv_sec: 0, tv_nsec: wait.subsec_nanos().into() };
            let mut ends = [PollFd::new(&lines[0], PollFlags::IN), PollFd::new(&lines[1], PollFlags::IN)];
            if poll(&mut ends, Some(&timeout)).is_err() {
                return;
            }
            let ready = ends.map(|end| !end.revents().is_empty());
            for from in 0..2 {
                if ready[from] {
                    let Ok(count) = lines[from].read(&mut buffer, Duration::ZERO) else { return };
                    for &byte in &buffer[..count] {
                        let partial = &mut ways[from].partial;
                        partial.push(byte);
                        if byte == 0 && partial.iter().any(|&byte| byte != 0) {
                            let message = std::mem::take(partial);
                            if self.message(&mut ways[from], message) {
                                return;
                            }
                        }
                    }
                }
                let now = Instant::now();
                while let Some((_, bytes)) = ways[from].queue.pop_front_if(|(at, _)| *at <= now) {
                    if lines[1 - from].write_all(&bytes, WRITE_PATIENCE).is_err() {
                        return;
                    }
                }
            }
        }
    }

    /// Does its faults to a message; whether the line is unplugged.
    fn message(&mut self, way: &mut Way, mut message: Vec<u8>) -> bool {
        self.counts.messages += 1;
        let faults = self.faults;
        if self.happens(faults.rebooted) {
            self.counts.rebooted += 1;
            (self.reboot)();
        }
        if self.happens(faults.cut) {
            self.counts.cut += 1;
            self.tell();
            return true;
        }
        let now = Instant::now();
        if self.happens(faults.stalled) {
            self.counts.stalled += 1;
            way.stalled_until = Some(now + faults.stall);
        }
        if self.happens(faults.corrupted) {
            self.counts.corrupted += 1;
            let at = self.below(message.len());
            message[at] ^= 1 + self.below(255) as u8;
        }
        if self.happens(faults.lost) {
            self.counts.lost += 1;
            let from = self.below(message.len());
            let to = from + 1 + self.below(message.len() - from);
            if self.happens(50.0) {
                message.drain(from..to);
            } else {
                message.clear();
            }
        }
        let at = way.stalled_until.filter(|&until| until > now).unwrap_or(now);
        let is_doubled = self.happens(faults.doubled);
        if self.happens(faults.reordered) && way.kept.is_none() {
            self.counts.reordered += 1;
            way.kept = Some(message);
        } else {
            if is_doubled {
                self.counts.doubled += 1;
                way.queue.push_back((at, message.clone()));
            }
            way.queue.push_back((at, message));
            way.queue.extend(way.kept.take().map(|kept| (at, kept)));
        }
        self.tell();
        false
    }

    fn tell(&self) {
        if let Ok(mut published) = self.published.lock() {
            *published = self.counts;
        }
    }

    fn happens(&mut self, percent: f64) -> bool {
        percent > 0.0 && uniform(&mut self.rng) * 100.0 < percent
    }

    /// A number below `end`.
    fn below(&mut self, end: usize) -> usize {
        ((uniform(&mut self.rng) * end as f64) as usize).min(end.saturating_sub(1))
    }
}
