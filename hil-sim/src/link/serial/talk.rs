//! Requests and their answers over a line that may lose, double, delay and damage them, and be unplugged.

use super::super::LinkTrouble;
use super::super::line::Line;
use super::super::pace::{Pace, Patience};
use plumbline_firmware::serial::frame::{Receiver, Unframed, decode, encode, version};
use plumbline_firmware::serial::message::{Answer, Counts, Envelope, Next, Refused, Request, Store};
use plumbline_firmware::serial::{FRAME_MAX, VERSION};
use plumbline_survey::error::InputError;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Requests longer than this are timed apart: on a slow line they take longer.
const LONG_BYTES: usize = 256;
/// How often an absent line is tried.
const RETRY: Duration = Duration::from_millis(50);
/// Most times that a line may be unplugged during one request.
const UNPLUGGED_MAX: u32 = 20;

/// Why a request was not answered.
#[derive(Debug)]
pub enum Failed {
    /// The board knows nothing of the session: it has booted anew.
    Rebooted,
    /// The board speaks another version.
    OtherVersion(u16),
    /// It is silent, or gone.
    Lost(String),
}

/// An answer that stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Said {
    Done,
    Refused(Refusal),
    Stepped { cost: u32, next: Next, is_at_work: bool, sent: Vec<u8> },
}

/// Why a request was not done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    Busy,
    /// The room there is, bytes.
    TooLarge(u32),
    /// A sentence's part.
    Because(String),
}

/// Who the board is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Welcomed {
    pub boot: u32,
    pub core_clock_hz: u32,
    pub counts: Counts,
    pub piece_max: usize,
    pub mission_room: usize,
    pub tile_room: usize,
    /// Name of the board and version of its firmware.
    pub board: String,
}

/// The simulator's end of the line.
#[derive(Debug)]
pub struct Talk {
    path: PathBuf,
    line: Option<Line>,
    pub patience: Patience,
    pub session: u32,
    id: u32,
    /// The boot number of the board that the session is with.
    boot: Option<u32>,
    receiver: Receiver,
    paces: [Pace; 2],
    pub trouble: LinkTrouble,
    buffer: Vec<u8>,
}

/// What became of a wait.
enum Heard<T> {
    Answer(T),
    Silence,
    Unplugged,
}

impl Talk {
    /// # Errors
    /// A path that is no line.
    pub fn open(path: PathBuf, patience: Patience, session: u32) -> Result<Self, InputError> {
        let line = Some(Line::open(&path)?);
        let paces = [Pace::new(&patience); 2];
        Ok(Talk {
            path,
            line,
            patience,
            session,
            id: 0,
            boot: None,
            receiver: Receiver::new(),
            paces,
            trouble: LinkTrouble::default(),
            buffer: vec![0; FRAME_MAX],
        })
    }

    /// Begins a session of another number.
    pub fn next_session(&mut self, boot: u32) {
        (self.session, self.id, self.boot) = (self.session.wrapping_add(1), 0, Some(boot));
    }

    /// Asks until it is answered or the board is lost.
    pub fn ask(&mut self, request: Request<'_>) -> Result<Said, Failed> {
        self.id = self.id.wrapping_add(1);
        let (session, id) = (self.session, self.id);
        let bytes = bytes_of(&Envelope { session, id, message: request }, &mut self.buffer)?;
        let pace = usize::from(bytes.len() > LONG_BYTES);
        let (mut since, mut tries, mut unplugged) = (Instant::now(), 0, 0);
        loop {
            let sent_at = Instant::now();
            let wait = self.paces[pace].timeout();
            match self.send_and_hear(&bytes, wait, |envelope| matches(envelope, session, id)) {
                Heard::Answer(answer) => {
                    // Which of several requests was answered is not known.
                    if tries == 0 {
                        self.paces[pace].answered(sent_at.elapsed(), &self.patience);
                    }
                    return answer;
                }
                Heard::Silence => {
                    self.trouble.timeouts += 1;
                    self.paces[pace].missed(&self.patience);
                    if since.elapsed() > self.patience.stall {
                        let silent_s = since.elapsed().as_secs_f64();
                        return Err(Failed::Lost(format!("no answer for {silent_s:.1} s")));
                    }
                }
                Heard::Unplugged => {
                    unplugged += 1;
                    if unplugged > UNPLUGGED_MAX {
                        return Err(Failed::Lost("the line is unplugged again and again".to_owned()));
                    }
                    self.plug_in()?;
                    since = Instant::now();
                }
            }
            (tries, self.trouble.resends) = (tries + 1, self.trouble.resends + 1);
        }
    }

    /// Asks a board that may not be there who it is, for as long as `patience`.
    pub fn hello(&mut self, patience: Duration) -> Result<Welcomed, Failed> {
        let end = Instant::now() + patience;
        let session = self.session;
        // Any number that no request of the session has.
        let id = u32::MAX;
        let bytes =
            bytes_of(&Envelope { session, id, message: Request::Hello { version: VERSION } }, &mut self.buffer)?;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(Failed::Lost("nobody answers".to_owned()));
            }
            if self.line.is_none() {
                self.line = Line::open(&self.path).ok();
                if self.line.is_none() {
                    std::thread::sleep(RETRY.min(left));
                    continue;
                }
            }
            let wait = self.patience.first.min(left);
            let heard = self.send_and_hear(&bytes, wait, |envelope| match envelope.message {
                Answer::Welcome(welcome) if envelope.id == id && envelope.session == session => Some(Ok(Welcomed {
                    boot: welcome.boot,
                    core_clock_hz: welcome.core_clock_hz,
                    counts: welcome.counts,
                    piece_max: welcome.piece_max.into(),
                    mission_room: welcome.mission_room as usize,
                    tile_room: welcome.tile_room as usize,
                    board: format!("{} {}", welcome.board, welcome.firmware),
                })),
                _ => None,
            });
            match heard {
                Heard::Answer(welcomed) => return welcomed,
                Heard::Silence => {}
                Heard::Unplugged => self.line = None,
            }
        }
    }

    /// Asks the board of this boot to reboot, and waits until it has; who it is then.
    pub fn reset(&mut self, boot: u32) -> Result<Welcomed, Failed> {
        let end = Instant::now() + self.patience.absence;
        let request = Request::Reset { boot };
        let bytes = bytes_of(&Envelope { session: self.session, id: u32::MAX, message: request }, &mut self.buffer)?;
        while Instant::now() < end {
            // Its answer, if it comes, says nothing that the next hello does not say.
            if let Some(line) = &mut self.line
                && line.write_all(&bytes, self.patience.most).is_err()
            {
                self.line = None;
            }
            match self.hello(self.patience.hello.min(end.saturating_duration_since(Instant::now()))) {
                Ok(welcomed) if welcomed.boot != boot => return Ok(welcomed),
                Ok(_) => std::thread::sleep(RETRY),
                Err(Failed::Lost(_)) => {}
                Err(other) => return Err(other),
            }
        }
        Err(Failed::Lost("it does not reboot when it is asked to".to_owned()))
    }

    /// Says good-bye without waiting: who does not hear it will be asked for a reset.
    pub fn bye(&mut self) {
        self.id = self.id.wrapping_add(1);
        let envelope = Envelope { session: self.session, id: self.id, message: Request::Bye };
        if let (Ok(bytes), Some(line)) = (bytes_of(&envelope, &mut self.buffer), &mut self.line) {
            let _ = line.write_all(&bytes, self.patience.least);
        }
    }

    /// Waits for the line to come back, and asks who is there.
    fn plug_in(&mut self) -> Result<(), Failed> {
        self.line = None;
        self.receiver = Receiver::new();
        self.trouble.reconnects += 1;
        let absence_s = self.patience.absence.as_secs();
        let welcomed = self.hello(self.patience.absence).map_err(|failed| match failed {
            Failed::Lost(_) => {
                Failed::Lost(format!("the line was unplugged and did not come back within {absence_s} s"))
            }
            other => other,
        })?;
        if self.boot.is_some_and(|boot| boot != welcomed.boot) { Err(Failed::Rebooted) } else { Ok(()) }
    }

    /// Sends, and waits for the answer that `wanted` takes. All others are stale.
    fn send_and_hear<T>(
        &mut self,
        bytes: &[u8],
        patience: Duration,
        wanted: impl Fn(&Envelope<Answer<'_>>) -> Option<Result<T, Failed>>,
    ) -> Heard<Result<T, Failed>> {
        let Some(line) = &mut self.line else { return Heard::Unplugged };
        // A line that takes no bytes is as silent as one that brings none.
        match line.write_all(bytes, self.patience.most) {
            Ok(()) => {}
            Err(error) if error.kind() == std::io::ErrorKind::TimedOut => return Heard::Silence,
            Err(_) => return Heard::Unplugged,
        }
        let end = Instant::now() + patience;
        let mut buffer = [0; 4096];
        loop {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Heard::Silence;
            }
            let Ok(count) = line.read(&mut buffer, left) else { return Heard::Unplugged };
            let mut answer = None;
            for &byte in &buffer[..count] {
                let body = match self.receiver.take(byte) {
                    Unframed::Nothing => continue,
                    Unframed::Bad => {
                        self.trouble.bad_checksum += 1;
                        continue;
                    }
                    Unframed::Body(body) => body,
                };
                match (decode::<Answer<'_>>(body), version(body)) {
                    (_, Some(other)) if other != VERSION => answer = Some(Err(Failed::OtherVersion(other))),
                    (None, _) => self.trouble.bad_checksum += 1,
                    (Some(envelope), _) => match wanted(&envelope) {
                        // What follows an answer in the same breath is stale.
                        Some(wanted) if answer.is_none() => answer = Some(wanted),
                        _ => self.trouble.stale += 1,
                    },
                }
            }
            if let Some(answer) = answer {
                return Heard::Answer(answer);
            }
        }
    }
}

fn bytes_of(envelope: &Envelope<Request<'_>>, buffer: &mut [u8]) -> Result<Vec<u8>, Failed> {
    let bytes = encode(envelope, buffer).ok_or_else(|| Failed::Lost("a request was too long".to_owned()))?;
    Ok(bytes.to_vec())
}

/// The answer to a request of a session.
fn matches(envelope: &Envelope<Answer<'_>>, session: u32, id: u32) -> Option<Result<Said, Failed>> {
    if (envelope.session, envelope.id) != (session, id) {
        return None;
    }
    Some(match envelope.message {
        Answer::Stranger { .. } => Err(Failed::Rebooted),
        Answer::Done => Ok(Said::Done),
        Answer::Stepped { cost, next, is_at_work, sent } => {
            Ok(Said::Stepped { cost, next, is_at_work, sent: sent.to_vec() })
        }
        Answer::Refused(refused) => Ok(Said::Refused(match refused {
            Refused::Busy => Refusal::Busy,
            Refused::TooLarge { room } => Refusal::TooLarge(room),
            Refused::Damaged(Store::Mission) => Refusal::Because("the mission did not arrive whole".to_owned()),
            Refused::Damaged(Store::Tile) => Refusal::Because("the tile did not arrive whole".to_owned()),
            Refused::Boot(why) => Refusal::Because(why.concat()),
            Refused::Order => Refusal::Because("a request out of order".to_owned()),
        })),
        Answer::Welcome(_) => return None,
    })
}
