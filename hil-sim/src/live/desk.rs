//! The firmware at a desk: on an autopilot's port in real time, with its stores and without a camera. What it finds wrong with
//! link, streams and parameters is found as on a board.

use super::LiveError;
use super::connection::{Arrival, Connection, Door, Side, Waiting, open};
use crate::ground_station::GroundStation;
use crate::link::{Event, Link};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Longest wait for bytes: the firmware's own timers run by the steps.
const LOOK: Duration = Duration::from_millis(2);
/// How long a closed connection is left alone. Chosen: an autopilot that boots anew takes longer.
const REST: Duration = Duration::from_millis(500);
/// An autopilot is waited for until an interrupt.
const FOR_EVER: Duration = Duration::from_hours(24 * 365);

/// Whoever sits at it.
pub trait Sitter: Waiting {
    /// A line that the firmware has for the pilot, with the seconds since it was switched on.
    fn hears(&mut self, at_s: f64, line: &str);
}

/// Has the firmware talk to who is behind `door`, after a loss once more, until an interrupt.
///
/// # Errors
/// One sentence: a door that cannot be opened, a firmware that is lost.
pub fn sit(link: &mut dyn Link, door: Door, sitter: &mut dyn Sitter) -> Result<(), LiveError> {
    let mut doors = [door];
    let mut board = Board { link, epoch: Instant::now(), station: GroundStation::default() };
    loop {
        let [stream] = match open(&mut doors, FOR_EVER, sitter) {
            Err(LiveError::Interrupted) => return Ok(()),
            opened => opened?,
        };
        let (sender, arrivals) = channel();
        let [door] = &doors;
        let connection = Connection::begin(stream, door.name(), Side::Autopilot, sender)?;
        match board.talk(connection, &arrivals, sitter) {
            Err(LiveError::Interrupted) => return Ok(()),
            Err(closed @ LiveError::Closed(_)) => sitter.waits(&format!("{closed}; waiting for it again")),
            other => other?,
        }
        std::thread::sleep(REST);
    }
}

/// The firmware, and a timer of its own.
struct Board<'l> {
    link: &'l mut dyn Link,
    epoch: Instant,
    station: GroundStation,
}

impl Board<'_> {
    /// Until the connection closes or somebody interrupts.
    fn talk(
        &mut self,
        mut connection: Connection,
        arrivals: &Receiver<Arrival>,
        sitter: &mut dyn Sitter,
    ) -> Result<(), LiveError> {
        let gone = LiveError::Closed(connection.name().to_owned());
        loop {
            let (at, bytes) = match arrivals.recv_timeout(LOOK) {
                Ok(Arrival::Bytes(_, at, bytes)) => (at, bytes),
                Err(RecvTimeoutError::Timeout) => (Instant::now(), Vec::new()),
                Ok(Arrival::Closed(_)) | Err(RecvTimeoutError::Disconnected) => return Err(gone),
            };
            let since = at.saturating_duration_since(self.epoch);
            let event = if bytes.is_empty() { Event::Nothing } else { Event::Bytes(&bytes) };
            let sent = self.link.step(since.as_micros() as u32, event)?;
            connection.send(&sent)?;
            self.station.take(&sent);
            self.station.vision.clear();
            for line in std::mem::take(&mut self.station.lines) {
                sitter.hears(since.as_secs_f64(), &line);
            }
            self.station.forget();
            if sitter.is_interrupted() {
                return Err(LiveError::Interrupted);
            }
        }
    }
}
