//! The log as what drives the application: one cursor, from which its board and its journal draw alike.
//!
//! Each of the board's parts is ready only when the record at the cursor is theirs, and each event moves the cursor on when it
//! says what the record says. So the tasks can take things in no other order than they did in flight.

use super::read::Item;
use plumbline_core::auto_exposure::Command;
use plumbline_core::image::Run;
use plumbline_core::pipeline::Refusal;
use plumbline_core::stamp::{Edge, Polarity};
use plumbline_core::units::Ticks;
use plumbline_firmware::board::{FrameStart, FrontEnd, Reader, Rows, Timer, Writer};
use plumbline_firmware::journal::{Event, Gate, Journal};
use plumbline_firmware::log::journal::{RUNS_BYTES, record, runs_in};
use plumbline_firmware::log::record::Record;
use plumbline_firmware::wire::signing::Verdict as PacketVerdict;
use plumbline_firmware::wire::telemetry::{FrameReport, InstantReport, STAGES};
use std::cell::{Cell, RefCell};
use std::future::poll_fn;
use std::task::{Poll, Waker};

/// Longest record: a patch, its runs, and a few bytes.
const RECORD_MAX: usize = 8192;

/// The log under its cursor.
#[derive(Debug)]
pub struct Tape {
    items: Vec<Item>,
    at: Cell<usize>,
    tick: Cell<u32>,
    wakers: RefCell<Vec<Waker>>,
    verdict: RefCell<Verdict>,
}

/// How the replay compares.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// What each frame came to, this time.
    pub frames: Vec<(FrameReport, InstantReport)>,
    /// Frames that came to the same.
    pub same: usize,
    /// Frames or records that did not.
    pub different: usize,
    /// The first of them, in words.
    pub first_difference: Option<String>,
    /// Whether the application went another way, or beyond what the log tells, so that the rest says nothing.
    has_ended: bool,
}

impl Tape {
    /// At its beginning.
    pub fn new(items: Vec<Item>) -> Self {
        let (at, tick) = (Cell::new(0), Cell::new(0));
        Tape { items, at, tick, wakers: RefCell::default(), verdict: RefCell::default() }
    }

    /// Records passed.
    pub fn position(&self) -> usize {
        self.at.get()
    }

    /// What was found. Where the application has stopped before the end without a hole, it did not take what it took then.
    pub fn finish(&self) -> Verdict {
        if let Some(record) = self.record() {
            self.diverge(&format!("the application does not take {}", name(&record)));
        }
        self.verdict.borrow().clone()
    }

    /// The record at the cursor; nothing at a hole, at the end, and once the application has gone another way.
    fn record(&self) -> Option<Record<'_>> {
        match self.items.get(self.at.get())? {
            Item::Record(bytes) if !self.verdict.borrow().has_ended => Record::decode(bytes),
            _ => None,
        }
    }

    fn advance(&self) {
        self.at.set(self.at.get() + 1);
        for waker in self.wakers.take() {
            waker.wake();
        }
    }

    fn differ(&self, what: &str) {
        let mut verdict = self.verdict.borrow_mut();
        verdict.different += 1;
        verdict.first_difference.get_or_insert_with(|| format!("record {}: {what}", self.at.get()));
    }

    fn diverge(&self, what: &str) {
        self.differ(what);
        self.end();
    }

    fn end(&self) {
        self.verdict.borrow_mut().has_ended = true;
    }

    /// Waits for a record of which `ready` makes something.
    async fn wait<T>(&self, ready: impl Fn(Record<'_>) -> Option<T>) -> T {
        poll_fn(|context| self.poll(context.waker(), &ready)).await
    }

    fn poll<T>(&self, waker: &Waker, ready: impl Fn(Record<'_>) -> Option<T>) -> Poll<T> {
        match self.record().and_then(ready) {
            Some(value) => Poll::Ready(value),
            None => {
                self.wakers.borrow_mut().push(waker.clone());
                Poll::Pending
            }
        }
    }

    /// Moves on if the log says what `record` says.
    fn compare(&self, record: &Record<'_>) {
        let logged = match self.record() {
            Some(logged) => logged,
            // Beyond the log's end, or a hole in it, nothing is known.
            None => return self.end(),
        };
        match (record, logged) {
            (Record::Frame(report, instant, _), Record::Frame(..)) => {
                self.verdict.borrow_mut().frames.push((*report, *instant));
                if encoded(&without_cost(record)) == encoded(&without_cost(&logged)) {
                    self.verdict.borrow_mut().same += 1;
                } else {
                    self.differ(&format!("frame {} comes to something else", report.sequence));
                }
                self.advance();
            }
            _ if encoded(record) == encoded(&logged) => self.advance(),
            _ => {
                self.diverge(&format!("the application comes to {} where the log has {}", name(record), name(&logged)))
            }
        }
    }
}

fn encoded(record: &Record<'_>) -> Option<Vec<u8>> {
    let mut buffer = [0; RECORD_MAX];
    record.encode(&mut buffer).map(<[u8]>::to_vec)
}

/// What a frame cost depends on who computes.
fn without_cost<'a>(record: &Record<'a>) -> Record<'a> {
    match *record {
        Record::Frame(report, instant, fix) => {
            Record::Frame(FrameReport { instructions: [0; STAGES.len()], ..report }, instant, fix)
        }
        other => other,
    }
}

fn name(record: &Record<'_>) -> String {
    match record {
        Record::Bytes(at, bytes) => format!("{} bytes at tick {at}", bytes.0.len()),
        Record::Pulse(at) => format!("a pulse at tick {at}"),
        Record::Edge(at, _) => format!("an edge at tick {at}"),
        Record::Beat(at) => format!("a beat at tick {at}"),
        Record::Start(sequence, ..) => format!("frame {sequence}'s first row"),
        Record::Begin => "the choice of what to keep of a frame".to_owned(),
        Record::Rows(0) => "a frame's rows".to_owned(),
        Record::Rows(code) => format!("rows refused with {code}"),
        Record::Pose(at) => format!("a pose at tick {at}"),
        Record::Asked(at) => format!("a time request at tick {at}"),
        Record::Refused(number, _) => format!("packet {number} of a read refused for its signature"),
        Record::Patch((cols, rows), ..) => format!("a patch of {cols} x {rows} with its runs"),
        Record::Frame(report, ..) => format!("frame {}'s report", report.sequence),
        Record::Exposure(from, _) => format!("an exposure from frame {from} on"),
        _ => "a record about the log itself".to_owned(),
    }
}

impl Journal for Tape {
    fn event(&self, event: Event<'_>) {
        self.compare(&record(&event));
    }

    fn patch(&self, size: (u16, u16), runs: &[Run], pixels: &mut [u8]) {
        let mut buffer = [0; RUNS_BYTES];
        let runs = runs_in(runs, &mut buffer);
        match self.record() {
            Some(Record::Patch(logged, logged_runs, logged_pixels))
                if logged == size && logged_runs.0 == runs && logged_pixels.0.len() == pixels.len() =>
            {
                pixels.copy_from_slice(logged_pixels.0);
                self.advance();
            }
            Some(logged) => {
                let (cols, rows) = size;
                self.diverge(&format!(
                    "the application comes to a patch of {cols} x {rows}, the log has {}",
                    name(&logged)
                ));
            }
            None => self.end(),
        }
    }

    /// A verdict follows the bytes that complete its packet, before anything else happens.
    fn verdict(&self, number: u8, _: PacketVerdict) -> PacketVerdict {
        match self.record() {
            Some(Record::Refused(which, code)) if which == number => {
                self.advance();
                // Of a code that is not known, at least that it was refused.
                PacketVerdict::from_code(code).unwrap_or(PacketVerdict::Wrong)
            }
            _ => PacketVerdict::Taken,
        }
    }

    /// A command follows the rows that it comes of, before anything else happens.
    fn exposure(&self, _: Option<Command>) -> Option<Command> {
        let Some(Record::Exposure(from, us)) = self.record() else { return None };
        self.advance();
        Some(Command { from, us })
    }

    fn gate(&self, gate: Gate, waker: &Waker) -> Poll<()> {
        self.poll(waker, |record| {
            let is_mine = match gate {
                Gate::Beat => matches!(record, Record::Beat(_)),
                Gate::Begin => matches!(record, Record::Begin),
                Gate::Pose => matches!(record, Record::Pose(_)),
                Gate::Asked => matches!(record, Record::Asked(_)),
            };
            is_mine.then_some(())
        })
    }
}

/// Link and timer of the board.
#[derive(Clone, Copy, Debug)]
pub struct Part(pub &'static Tape);

impl Reader for Part {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        let bytes = self.0.wait(|r| if let Record::Bytes(_, bytes) = r { Some(bytes.0.to_vec()) } else { None }).await;
        buffer.iter_mut().zip(&bytes).for_each(|(to, from)| *to = *from);
        bytes.len().min(buffer.len())
    }
}

impl Writer for Part {
    async fn write(&mut self, _: &[u8]) {}
}

impl Timer for Part {
    fn now(&self) -> Ticks {
        if let Some(Record::Bytes(at, _) | Record::Beat(at) | Record::Pose(at) | Record::Asked(at)) = self.0.record() {
            self.0.tick.set(at);
        }
        Ticks(self.0.tick.get())
    }

    async fn until(&mut self, _: Ticks) {
        self.0.wait(|record| matches!(record, Record::Beat(_)).then_some(())).await;
    }

    async fn pulse(&mut self) -> Ticks {
        self.0.wait(|record| if let Record::Pulse(at) = record { Some(Ticks(at)) } else { None }).await
    }

    async fn edge(&mut self) -> Edge {
        let polarity = |rising: bool| if rising { Polarity::Rising } else { Polarity::Falling };
        let edge = |at, rising| Edge { at: Ticks(at), polarity: polarity(rising) };
        self.0.wait(|record| if let Record::Edge(at, rising) = record { Some(edge(at, rising)) } else { None }).await
    }
}

/// The board's front end.
#[derive(Debug)]
pub struct TapeFrontEnd {
    tape: &'static Tape,
    cols: u16,
    pixels: Vec<u8>,
    /// Grey of this frame's pixels, and of the last one that was whole: only the same picture again has the same.
    grey: u8,
    whole: u8,
}

impl TapeFrontEnd {
    /// The one front end.
    pub fn new(tape: &'static Tape) -> Self {
        TapeFrontEnd { tape, cols: 0, pixels: Vec::new(), grey: 0, whole: 0 }
    }
}

impl FrontEnd for TapeFrontEnd {
    async fn frame(&mut self) -> FrameStart {
        let start = self.tape.wait(|record| match record {
            Record::Start(sequence, arrival, size) => Some(FrameStart { sequence, arrival: Ticks(arrival), size }),
            _ => None,
        });
        let start = start.await;
        self.cols = start.size.0;
        self.grey = self.grey.wrapping_add(1);
        start
    }

    /// No pixels were logged, and none are needed: what the rectifier makes of these is thrown away.
    async fn rows(&mut self, count: u16) -> Rows<'_> {
        let code = self.tape.wait(|record| if let Record::Rows(code) = record { Some(code) } else { None }).await;
        match Refusal::from_code(code) {
            None | Some(Refusal::Repeated) => {
                self.whole = if code == 0 { self.grey } else { self.whole };
                self.pixels.clear();
                self.pixels.resize(usize::from(count) * usize::from(self.cols), self.whole);
                Rows::Pixels(&self.pixels)
            }
            Some(Refusal::Overrun) => Rows::Overrun,
            Some(_) => Rows::End,
        }
    }

    /// What the board made of it is in the log.
    fn expose(&mut self, us: u32) -> Option<u32> {
        Some(us)
    }
}
