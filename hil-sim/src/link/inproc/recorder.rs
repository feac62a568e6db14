//! A log beside a flight in this process: the firmware's own writer onto a card in memory.

use crate::link::Stores;
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_firmware::log::block::BLOCK;
use plumbline_firmware::log::card::BlockDevice;
use plumbline_firmware::log::journal::LogJournal;
use plumbline_firmware::stores::framing::checksum;
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

/// Blocks that the firmware keeps in RAM, 16 KiB.
pub const RING: usize = 32;
/// The firmware's log.
pub type Log = LogJournal<'static, RING>;

/// A card in memory, as large as it has to be.
#[derive(Clone, Debug, Default)]
pub struct Card {
    blocks: Rc<RefCell<Vec<[u8; BLOCK]>>>,
    busy: Rc<Cell<bool>>,
    waiting: Rc<RefCell<Vec<Waker>>>,
}

impl Card {
    /// All that was written.
    pub fn bytes(&self) -> Vec<u8> {
        self.blocks.borrow().as_flattened().to_vec()
    }

    /// A card that takes nothing while it is busy.
    pub fn set_busy(&self, busy: bool) {
        self.busy.set(busy);
        self.waiting.take().into_iter().for_each(Waker::wake);
    }
}

impl BlockDevice for Card {
    type Error = Infallible;

    fn blocks(&self) -> u32 {
        u32::MAX
    }

    async fn read(&mut self, index: u32, block: &mut [u8; BLOCK]) -> Result<(), Infallible> {
        *block = self.blocks.borrow().get(index as usize).copied().unwrap_or([0; BLOCK]);
        Ok(())
    }

    async fn write(&mut self, index: u32, blocks: &[[u8; BLOCK]]) -> Result<(), Infallible> {
        poll_fn(|context| {
            if self.busy.get() {
                self.waiting.borrow_mut().push(context.waker().clone());
                return Poll::Pending;
            }
            Poll::Ready(())
        })
        .await;
        let mut card = self.blocks.borrow_mut();
        let end = index as usize + blocks.len();
        if card.len() < end {
            card.resize(end, [0; BLOCK]);
        }
        card[index as usize..end].copy_from_slice(blocks);
        Ok(())
    }
}

/// A log of an application that boots from `stores`, whose tiles stay at `tiles`. Its number follows from them.
pub fn log(stores: &Stores, tiles: &'static [u8]) -> Log {
    let number = checksum(&stores.configuration) ^ checksum(tiles).rotate_left(1);
    LogJournal::new(number, &stores.configuration, tiles, FRAME_MEMORY_BYTES, Box::leak(Box::new([[0; BLOCK]; RING])))
}
