//! What is uploaded before a flight: the blobs that stand for flash, of which plan and key may be missing. What is in them is
//! the application's affair.

use super::message::{Refused, Store};
use crate::stores::framing::checksum;

/// Memory for all, as a board gives it.
#[derive(Debug)]
pub struct Stores {
    /// Camera, settings, georeference.
    configuration: Slot,
    /// The reference tile.
    tile: Slot,
    /// Where photos are to be taken.
    plan: Slot,
    /// What messages are signed with.
    key: Slot,
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
    /// What messages are signed with; empty where they are not.
    pub key: &'static [u8],
}

/// Memory for one, and what is in it.
#[derive(Debug)]
struct Slot {
    memory: &'static mut [u8],
    /// Length and CRC of what is to come.
    announced: Option<(usize, u32)>,
    filled: usize,
}

impl Stores {
    /// Empty ones in this memory.
    pub fn new(
        configuration: &'static mut [u8],
        tile: &'static mut [u8],
        plan: &'static mut [u8],
        key: &'static mut [u8],
    ) -> Self {
        let slot = |memory| Slot { memory, announced: None, filled: 0 };
        Stores { configuration: slot(configuration), tile: slot(tile), plan: slot(plan), key: slot(key) }
    }

    /// Bytes that configuration, tile, plan and key may have.
    pub fn capacities(&self) -> [u32; 4] {
        [&self.configuration, &self.tile, &self.plan, &self.key].map(|slot| slot.memory.len() as u32)
    }

    /// Forgets what was announced and uploaded.
    pub fn clear(&mut self) {
        for slot in [&mut self.configuration, &mut self.tile, &mut self.plan, &mut self.key] {
            (slot.announced, slot.filled) = (None, 0);
        }
    }

    fn of(&mut self, store: Store) -> &mut Slot {
        match store {
            Store::Configuration => &mut self.configuration,
            Store::Tile => &mut self.tile,
            Store::Plan => &mut self.plan,
            Store::Key => &mut self.key,
        }
    }

    /// # Errors
    /// [`Refused::TooLarge`].
    pub fn announce(&mut self, store: Store, bytes: u32, crc: u32) -> Result<(), Refused<'static>> {
        let slot = self.of(store);
        let size = slot.memory.len();
        if bytes as usize > size {
            return Err(Refused::TooLarge { capacity: size as u32 });
        }
        (slot.announced, slot.filled) = (Some((bytes as usize, crc)), 0);
        Ok(())
    }

    /// Takes the next piece.
    ///
    /// # Errors
    /// [`Refused::Order`] for another than the next one, or more than was announced.
    pub fn piece(&mut self, store: Store, offset: u32, bytes: &[u8]) -> Result<(), Refused<'static>> {
        let slot = self.of(store);
        let (length, _) = slot.announced.ok_or(Refused::Order)?;
        let end = slot.filled + bytes.len();
        if offset as usize != slot.filled || end > length {
            return Err(Refused::Order);
        }
        slot.memory.get_mut(slot.filled..end).ok_or(Refused::Order)?.copy_from_slice(bytes);
        slot.filled = end;
        Ok(())
    }

    /// Hands all over, for ever. A plan or a key that was not announced is none.
    ///
    /// # Errors
    /// [`Refused::Damaged`] where one is not what was announced; nothing is handed over then.
    pub fn hand_over(&mut self) -> Result<Uploaded, Refused<'static>> {
        for store in [Store::Configuration, Store::Tile, Store::Plan, Store::Key] {
            let slot = self.of(store);
            let may_be_missing = matches!(store, Store::Plan | Store::Key) && slot.announced.is_none();
            if !(slot.is_whole() || may_be_missing) {
                return Err(Refused::Damaged(store));
            }
        }
        let (configuration, tile) = (self.configuration.hand_over(), self.tile.hand_over());
        Ok(Uploaded { configuration, tile, plan: self.plan.hand_over(), key: self.key.hand_over() })
    }
}

impl Slot {
    fn is_whole(&self) -> bool {
        let filled = self.memory.get(..self.filled).unwrap_or(&[]);
        self.announced == Some((self.filled, checksum(filled)))
    }

    fn hand_over(&mut self) -> &'static [u8] {
        let memory: &'static mut [u8] = core::mem::take(&mut self.memory);
        memory.get(..self.filled).unwrap_or(&[])
    }
}
