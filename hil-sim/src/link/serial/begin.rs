//! The beginning of a flight, and its beginning anew after a reboot: who is there, what it has room for, the upload.

use super::said::{Failed, Refusal, Said, Welcomed};
use super::{REBOOTS_MAX, Serial, sentence};
use plumbline_firmware::serial::PIECE_MAX;
use plumbline_firmware::serial::message::{Request, Store};
use plumbline_firmware::stores::framing::checksum;

impl Serial {
    /// A session with a board that has just booted, flash uploaded, the application started. Why not, otherwise.
    pub(super) fn begin(&mut self) -> Result<(), String> {
        let mut welcomed = self.talk.hello(self.talk.patience.hello).map_err(sentence)?;
        for _ in 0..REBOOTS_MAX {
            self.check(&welcomed)?;
            self.board = welcomed;
            self.talk.next_session(self.board.boot);
            match self.load() {
                Ok(Said::Done) => return Ok(()),
                Ok(Said::Refused(Refusal::Busy)) => welcomed = self.talk.reset(self.board.boot).map_err(sentence)?,
                Ok(Said::Refused(Refusal::Because(why))) => {
                    return Err(format!("the firmware refuses this configuration: {why}"));
                }
                Ok(Said::Refused(Refusal::TooLarge(room))) => {
                    return Err(format!("the board has room for {room} bytes only"));
                }
                Ok(Said::Stepped { .. }) => return Err("an answer to another request".to_owned()),
                Err(Failed::Rebooted) => welcomed = self.talk.hello(self.talk.patience.absence).map_err(sentence)?,
                Err(failed) => return Err(sentence(failed)),
            }
        }
        Err(format!("the board booted {REBOOTS_MAX} times and did not take the configuration"))
    }

    fn check(&self, welcomed: &Welcomed) -> Result<(), String> {
        for (store, bytes) in &self.stores {
            let (name, room) = match store {
                Store::Configuration => ("configuration", welcomed.configuration_capacity),
                Store::Tile => ("reference tile", welcomed.tile_capacity),
                Store::Plan => ("plan", welcomed.plan_capacity),
                Store::Key => ("key", welcomed.key_capacity),
            };
            if bytes.len() > room {
                let length = bytes.len();
                return Err(format!("the {name} has {length} bytes, and the board has room for {room}"));
            }
        }
        Ok(())
    }

    /// Opens a session, uploads, starts; the first answer that is not `Done`, or the last one.
    fn load(&mut self) -> Result<Said, Failed> {
        let opened = self.talk.ask(Request::Open)?;
        if opened != Said::Done {
            return Ok(opened);
        }
        let piece_max = self.board.piece_max.clamp(1, PIECE_MAX);
        for &(store, ref bytes) in &self.stores {
            let announced = Request::Announce { store, bytes: bytes.len() as u32, crc: checksum(bytes) };
            let announced = self.talk.ask(announced)?;
            if announced != Said::Done {
                return Ok(announced);
            }
            for (number, bytes) in bytes.chunks(piece_max).enumerate() {
                let offset = (number * piece_max) as u32;
                let taken = self.talk.ask(Request::Piece { store, offset, bytes })?;
                if taken != Said::Done {
                    return Ok(taken);
                }
            }
        }
        self.talk.ask(Request::Start)
    }
}
