//! What is uploaded before a flight: the blobs that stand for flash, of which the plan may be missing. What is in them is the application's affair.

use super::message::{Refused, Store};
use crate::stores::framing::checksum;

/// Room for all, as a board gives it.
#[derive(Debug)]
pub struct Stores {
    /// Camera, settings, georeference.
    configuration: Room,
    /// The reference tile.
    tile: Room,
    /// Where photos are to be taken.
    plan: Room,
}

/// What was uploaded, whole and checked.
#[derive(Clone, Copy, Debug)]
pub struct Uploaded {
    /// Camera, settings, georeference.
    pub configuration: &'static [u8],
    /// The reference tile.
    pub tile: &'static [u8],
    /// Where photos are to be taken; empty where that is not planned.
    pub plan: &'static [u8],
}

/// Room for one, and what is in it.
#[derive(Debug)]
struct Room {
    memory: &'static mut [u8],
    /// Length and CRC of what is to come.
    announced: Option<(usize, u32)>,
    filled: usize,
}

impl Stores {
    /// Empty ones in this memory.
    pub fn new(configuration: &'static mut [u8], tile: &'static mut [u8], plan: &'static mut [u8]) -> Self {
        let room = |memory| Room { memory, announced: None, filled: 0 };
        Stores { configuration: room(configuration), tile: room(tile), plan: room(plan) }
    }

    /// Bytes of room for configuration, tile and plan.
    pub fn room(&self) -> [u32; 3] {
        [&self.configuration, &self.tile, &self.plan].map(|room| room.memory.len() as u32)
    }

    /// Forgets what was announced and uploaded.
    pub fn clear(&mut self) {
        for room in [&mut self.configuration, &mut self.tile, &mut self.plan] {
            (room.announced, room.filled) = (None, 0);
        }
    }

    fn of(&mut self, store: Store) -> &mut Room {
        match store {
            Store::Configuration => &mut self.configuration,
            Store::Tile => &mut self.tile,
            Store::Plan => &mut self.plan,
        }
    }

    /// # Errors
    /// [`Refused::TooLarge`].
    pub fn announce(&mut self, store: Store, bytes: u32, crc: u32) -> Result<(), Refused<'static>> {
        let room = self.of(store);
        let size = room.memory.len();
        if bytes as usize > size {
            return Err(Refused::TooLarge { room: size as u32 });
        }
        (room.announced, room.filled) = (Some((bytes as usize, crc)), 0);
        Ok(())
    }

    /// Takes the next piece.
    ///
    /// # Errors
    /// [`Refused::Order`] for another than the next one, or more than was announced.
    pub fn piece(&mut self, store: Store, offset: u32, bytes: &[u8]) -> Result<(), Refused<'static>> {
        let room = self.of(store);
        let (length, _) = room.announced.ok_or(Refused::Order)?;
        let end = room.filled + bytes.len();
        if offset as usize != room.filled || end > length {
            return Err(Refused::Order);
        }
        room.memory.get_mut(room.filled..end).ok_or(Refused::Order)?.copy_from_slice(bytes);
        room.filled = end;
        Ok(())
    }

    /// Hands all over, for ever. A plan that was not announced is none.
    ///
    /// # Errors
    /// [`Refused::Damaged`] where one is not what was announced; nothing is handed over then.
    pub fn hand_over(&mut self) -> Result<Uploaded, Refused<'static>> {
        for store in [Store::Configuration, Store::Tile, Store::Plan] {
            let room = self.of(store);
            let may_be_missing = store == Store::Plan && room.announced.is_none();
            if !(room.is_whole() || may_be_missing) {
                return Err(Refused::Damaged(store));
            }
        }
        let (configuration, tile) = (self.configuration.hand_over(), self.tile.hand_over());
        Ok(Uploaded { configuration, tile, plan: self.plan.hand_over() })
    }
}

impl Room {
    fn is_whole(&self) -> bool {
        let filled = self.memory.get(..self.filled).unwrap_or(&[]);
        self.announced == Some((self.filled, checksum(filled)))
    }

    fn hand_over(&mut self) -> &'static [u8] {
        let memory: &'static mut [u8] = core::mem::take(&mut self.memory);
        memory.get(..self.filled).unwrap_or(&[])
    }
}
