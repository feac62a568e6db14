//! A board at the other end of a line: the same steps as on every link, each done once whatever the line does.
//!
//! The simulator holds the newest frame and hands over the rows that the board asks for. A board that boots in mid-flight
//! gets its configuration again and flies on; the frames it had not yet reported are counted as abandoned.

mod begin;
mod said;
mod talk;

use super::pace::Patience;
use super::{Account, Event, Flash, Link, LinkError, LinkTrouble, WorkCost};
use plumbline_firmware::serial::message::{self, Next, Request, Store};
use plumbline_firmware::serial::{PIECE_MAX, VERSION};
use plumbline_survey::error::InputError;
use said::{Failed, Said, Welcomed};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use talk::Talk;

/// Most reboots that a step and most that a beginning may take.
const REBOOTS_MAX: u32 = 5;

/// A board on a line.
#[derive(Debug)]
pub struct Serial {
    talk: Talk,
    path: PathBuf,
    board: Welcomed,
    /// Configuration and tile, as they are stored, plan and key where there is one.
    stores: Vec<(Store, Vec<u8>)>,
    /// The newest frame, until the board has taken all of it.
    frame: Option<(u32, Vec<u8>)>,
    /// The frame that the board has not yet reported.
    at_work: Option<u32>,
    /// What the board's work came to.
    work: WorkCost,
}

impl Serial {
    /// Opens the line, uploads what lies in flash and boots the application.
    ///
    /// # Errors
    /// [`LinkError::Input`] for all that the user can mend: the path, a board that is silent, or that refuses.
    pub fn open(flash: &Flash, path: &Path, patience: Patience) -> Result<Self, LinkError> {
        let stores = flash.stores()?;
        let all = [
            (Store::Configuration, stores.configuration),
            (Store::Tile, stores.tiles),
            (Store::Plan, stores.plan),
            (Store::Key, stores.key),
        ];
        let may_be_missing = |store: &Store| matches!(store, Store::Plan | Store::Key);
        let stores = all.into_iter().filter(|(store, bytes)| !(may_be_missing(store) && bytes.is_empty())).collect();
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        // Another number than that of an earlier simulator on the same line.
        let session = (now.as_nanos() as u32).rotate_left(11) ^ std::process::id();
        let talk = Talk::open(path.to_owned(), patience, session)?;
        let nobody = Welcomed {
            boot: 0,
            core_clock_hz: 0,
            counts: message::Counts::Nothing,
            piece_max: 0,
            configuration_capacity: 0,
            tile_capacity: 0,
            plan_capacity: 0,
            key_capacity: 0,
            board: String::new(),
        };
        let mut serial = Serial {
            talk,
            path: path.to_owned(),
            board: nobody,
            stores,
            frame: None,
            at_work: None,
            work: WorkCost::default(),
        };
        serial.begin().map_err(|error| serial.refuse(&error))?;
        Ok(serial)
    }

    /// What went wrong on the line so far.
    pub fn trouble(&self) -> LinkTrouble {
        self.talk.trouble
    }

    /// A beginning that failed is the user's to mend.
    fn refuse(&self, why: &str) -> LinkError {
        InputError::new(format!("--link serial:{}: {why}", self.path.display())).into()
    }

    /// A step on a board that does not boot meanwhile; what it sent goes to `sent`.
    fn try_step(&mut self, timer: u32, event: Event<'_>, sent: &mut Vec<u8>) -> Result<(), Failed> {
        let (event, mut rest) = match event {
            Event::Nothing => (message::Event::Nothing, &[][..]),
            Event::Bytes(bytes) => {
                let (first, rest) = bytes.split_at(bytes.len().min(PIECE_MAX));
                (message::Event::Bytes(first), rest)
            }
            Event::Pulse(tick) => (message::Event::Pulse(tick), &[][..]),
            Event::Edge { tick, rising } => (message::Event::Edge { tick, rising }, &[][..]),
            Event::Frame(frame) => {
                let (sequence, arrival, size) = (frame.sequence, frame.arrival, frame.size);
                (message::Event::Frame { sequence, arrival, size }, &[][..])
            }
        };
        self.settle(Request::Step { timer, event }, sent)?;
        while !rest.is_empty() {
            let (first, others) = rest.split_at(rest.len().min(PIECE_MAX));
            rest = others;
            self.settle(Request::Step { timer, event: message::Event::Bytes(first) }, sent)?;
        }
        Ok(())
    }

    /// A request, and what the board wants because of it, until it wants nothing more.
    fn settle(&mut self, request: Request<'_>, sent: &mut Vec<u8>) -> Result<(), Failed> {
        let piece_max = self.board.piece_max.clamp(1, PIECE_MAX);
        let mut said = self.talk.ask(request)?;
        loop {
            let (next, is_at_work) = match said {
                Said::Stepped { cost, next, is_at_work, sent: more } => {
                    sent.extend(more);
                    self.work.count(cost);
                    (next, is_at_work)
                }
                Said::Done => return Err(Failed::Lost("an answer to another request".to_owned())),
                Said::Refused(refusal) => return Err(Failed::Lost(format!("a step was refused: {refusal:?}"))),
            };
            // Its report may still be on the board.
            if !is_at_work && next != Next::More {
                self.at_work = None;
            }
            said = match next {
                Next::Idle => {
                    // Taken by now, unless the board is at work on the one before.
                    if self.frame.as_ref().is_some_and(|(held, _)| !is_at_work || self.at_work == Some(*held)) {
                        self.frame = None;
                    }
                    return Ok(());
                }
                Next::More => self.talk.ask(Request::Continue)?,
                Next::Rows { sequence, offset } => {
                    self.at_work = Some(sequence);
                    let pixels = self.frame.as_ref().filter(|(held, _)| *held == sequence).map(|(_, pixels)| pixels);
                    let rest = pixels.and_then(|pixels| pixels.get(offset as usize..)).unwrap_or(&[]);
                    if rest.is_empty() {
                        return Err(Failed::Lost(format!(
                            "the board asks for rows of frame {sequence} that are not there"
                        )));
                    }
                    let bytes = &rest[..rest.len().min(piece_max)];
                    self.talk.ask(Request::Rows { sequence, offset, bytes })?
                }
            };
        }
    }

    /// Counts the frames that a reboot took.
    fn abandon(&mut self) {
        let held = self.frame.take().map(|(held, _)| held);
        let at_work = self.at_work.take().filter(|&at_work| Some(at_work) != held);
        self.talk.trouble.frames_abandoned += u64::from(held.is_some()) + u64::from(at_work.is_some());
        self.talk.trouble.reboots += 1;
    }

    fn lost(&self, why: &str) -> LinkError {
        LinkError::Lost(format!("{why} (so far: {})", self.talk.trouble))
    }
}

impl Link for Serial {
    fn step(&mut self, timer: u32, event: Event<'_>) -> Result<Vec<u8>, LinkError> {
        if let Event::Frame(frame) = event {
            self.frame = Some((frame.sequence, frame.pixels.to_vec()));
        }
        let mut sent = Vec::new();
        for _ in 0..REBOOTS_MAX {
            match self.try_step(timer, event, &mut sent) {
                Ok(()) => return Ok(sent),
                Err(Failed::Rebooted) => {
                    self.abandon();
                    self.begin().map_err(|why| self.lost(&why))?;
                    // The sensor does not expose twice.
                    if matches!(event, Event::Frame(_)) {
                        return Ok(sent);
                    }
                }
                Err(failed) => return Err(self.lost(&sentence(failed))),
            }
        }
        Err(self.lost("the board boots again and again"))
    }

    fn account(&self) -> Account {
        let hz = self.board.core_clock_hz;
        Account {
            counts: self.board.counts,
            core_clock_hz: (hz > 0).then_some(hz),
            board: Some(self.board.board.clone()),
            work: (self.board.counts != message::Counts::Nothing).then_some(self.work),
            trouble: Some(self.talk.trouble),
        }
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        self.talk.bye();
    }
}

fn sentence(failed: Failed) -> String {
    match failed {
        Failed::Rebooted => "the board booted anew".to_owned(),
        Failed::OtherVersion(theirs) => {
            format!("its firmware speaks version {theirs} of the protocol, this command version {VERSION}")
        }
        Failed::Lost(why) => why,
    }
}
