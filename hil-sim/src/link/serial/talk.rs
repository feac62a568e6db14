//! Requests and their answers over a line that may lose, double, delay and damage them, and be unplugged.

use super::super::LinkTrouble;
use super::super::line::Line;
use super::super::pace::{Pace, Patience};
use super::said::{Failed, Said, Welcomed, matches};
use plumbline_firmware::serial::frame::{Receiver, Unframed, decode, encode, version};
use plumbline_firmware::serial::message::{Answer, Envelope, Request};
use plumbline_firmware::serial::{FRAME_MAX, GREETING, VERSION};
use plumbline_survey::error::InputError;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Requests longer than this are timed apart: on a slow line they take longer.
const LONG_BYTES: usize = 256;
/// How often an absent line is tried.
const RETRY: Duration = Duration::from_millis(50);
/// Most times that a line may be unplugged during one request.
const UNPLUGGED_MAX: u32 = 20;

/// The simulator's end of the line.
#[derive(Debug)]
pub struct Talk {
    path: PathBuf,
    line: Option<Line>,
    pub patience: Patience,
    pub session: u32,
    id: u32,
    /// Numbers of requests outside of the session, counting down.
    outside: u32,
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
            outside: u32::MAX,
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
                        // A board that has booted meanwhile may have taken a late message of this session for its first.
                        let welcomed = self.hello(self.patience.most);
                        return match welcomed {
                            Ok(welcomed) if self.boot.is_some_and(|boot| boot != welcomed.boot) => {
                                Err(Failed::Rebooted)
                            }
                            _ => Err(Failed::Lost(format!("no answer for {silent_s:.1} s"))),
                        };
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
        let id = self.number_outside();
        let hello =
            bytes_of(&Envelope { session, id, message: Request::Hello { version: VERSION } }, &mut self.buffer)?;
        // A board in flight has to hear the greeting first. It restarts, and its port goes and comes.
        let bytes = [GREETING, &hello].concat();
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
                Answer::Welcome(welcome) if (envelope.session, envelope.id) == (session, id) => {
                    Some(Ok(welcome.into()))
                }
                _ => None,
            });
            match heard {
                Heard::Answer(welcomed) => return welcomed,
                Heard::Silence => {}
                Heard::Unplugged => {
                    (self.line, self.receiver) = (None, Receiver::new());
                    // One that opens and fails at once would be opened without a pause.
                    std::thread::sleep(RETRY.min(left));
                }
            }
        }
    }

    /// Asks the board of this boot to reboot, and waits until it has; who it is then.
    pub fn reset(&mut self, boot: u32) -> Result<Welcomed, Failed> {
        let end = Instant::now() + self.patience.absence;
        while Instant::now() < end {
            let (session, id) = (self.session, self.number_outside());
            let bytes = bytes_of(&Envelope { session, id, message: Request::Reset { boot } }, &mut self.buffer)?;
            let is_answer = |envelope: &Envelope<Answer<'_>>| {
                (envelope.id == id && envelope.message == Answer::Done).then_some(Ok(()))
            };
            // Whether it is heard or not: the next hello tells.
            if let Heard::Unplugged = self.send_and_hear(&bytes, self.patience.first, is_answer) {
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

    /// A number that no request of the session has, nor an earlier one outside of it.
    fn number_outside(&mut self) -> u32 {
        self.outside = self.outside.wrapping_sub(1);
        self.outside
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
