//! Where on a card a log begins.

use at_once::block_on;
use plumbline_firmware::log::block::{BLOCK, Head, NONE, seal};
use plumbline_firmware::log::card::{Area, BlockDevice, NoArea, area};
use std::convert::Infallible;

/// A card of a few hundred blocks.
struct Blocks(Vec<[u8; BLOCK]>);

impl BlockDevice for Blocks {
    type Error = Infallible;

    fn blocks(&self) -> u32 {
        self.0.len() as u32
    }

    async fn read(&mut self, index: u32, block: &mut [u8; BLOCK]) -> Result<(), Infallible> {
        *block = self.0[index as usize];
        Ok(())
    }

    async fn write(&mut self, index: u32, blocks: &[[u8; BLOCK]]) -> Result<(), Infallible> {
        self.0[index as usize..][..blocks.len()].copy_from_slice(blocks);
        Ok(())
    }
}

/// A card in memory never lets anybody wait.
mod at_once {
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    pub fn block_on<T>(future: impl Future<Output = T>) -> T {
        match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(value) => value,
            Poll::Pending => panic!("it waits"),
        }
    }
}

fn found(card: &mut Blocks) -> Result<Area, NoArea> {
    block_on(area(card))
}

/// Writes a log of so many blocks.
fn write(card: &mut Blocks, first: usize, log: u32, count: u32) {
    for sequence in 0..count {
        seal(&mut card.0[first + sequence as usize], Head { used: 0, log, sequence, first: NONE });
    }
}

#[test]
fn on_a_blank_card_at_its_beginning_and_behind_the_logs_that_are_there() {
    for blank in [0, 0xff] {
        let mut card = Blocks(vec![[blank; BLOCK]; 300]);
        let mut first = 0;
        for (log, count) in [(77, 1), (5, 2), (6, 100), (900, 33), (901, 64)] {
            assert_eq!(found(&mut card), Ok(Area { first: first as u32, end: 300 }), "{log}");
            write(&mut card, first, log, count);
            first += count as usize;
        }
        assert_eq!(found(&mut card), Ok(Area { first: 200, end: 300 }));
        write(&mut card, 200, 8, 100);
        assert_eq!(found(&mut card), Err(NoArea::Full));
    }
}

#[test]
fn older_blocks_behind_a_log_do_not_lengthen_it() {
    let mut card = Blocks(vec![[0; BLOCK]; 300]);
    write(&mut card, 0, 1, 250);
    // Blanked at its beginning, as one does, and used again.
    card.0[..50].fill([0; BLOCK]);
    assert_eq!(found(&mut card), Ok(Area { first: 0, end: 300 }));
    write(&mut card, 0, 2, 70);
    assert_eq!(found(&mut card), Ok(Area { first: 70, end: 300 }));
}

#[test]
fn damaged_blocks_do_not_shorten_a_log() {
    for bad in [0, 1, 63, 64, 98] {
        let mut card = Blocks(vec![[0; BLOCK]; 300]);
        write(&mut card, 0, 1, 100);
        card.0[bad][200] ^= 1;
        assert_eq!(found(&mut card), Ok(Area { first: 100, end: 300 }), "{bad}");
    }
}

#[test]
fn a_card_with_something_on_it_is_left_alone_but_for_its_partition() {
    let mut card = Blocks(vec![[0; BLOCK]; 300]);
    card.0[0][..3].copy_from_slice(&[0xeb, 0x58, 0x90]);
    assert_eq!(found(&mut card), Err(NoArea::Foreign));
    card.0[0][510..].copy_from_slice(&[0x55, 0xaa]);
    assert_eq!(found(&mut card), Err(NoArea::Foreign));
    // The second entry: type 0xDA, from block 40, 200 blocks.
    let entry = &mut card.0[0][462..478];
    entry[4] = 0x0c;
    entry[8..16].copy_from_slice(&[40, 0, 0, 0, 200, 0, 0, 0]);
    assert_eq!(found(&mut card), Err(NoArea::Foreign), "a partition with a file system");
    card.0[0][466] = 0xda;
    assert_eq!(found(&mut card), Ok(Area { first: 40, end: 240 }));
    write(&mut card, 40, 3, 10);
    assert_eq!(found(&mut card), Ok(Area { first: 50, end: 240 }));
}
