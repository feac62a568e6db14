//! Blocks from the ring to the card, in the background.

use super::block::BLOCK;
use super::card::{Area, BlockDevice};
use super::journal::LogJournal;

/// Blocks written at a time: cards are slow to begin.
const BATCH: usize = 8;
/// So often a write is tried.
const TRIES: u32 = 3;

/// Why a log ended before its flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEnd {
    /// The card is full.
    Full,
    /// The card does not take a block.
    Broken,
}

/// Writes for ever, or as long as the card goes along. When it does not, the ring fills up, and what comes then is counted as
/// lost; nothing else notices.
pub async fn write_out<D: BlockDevice, const N: usize>(log: &LogJournal<'_, N>, device: &mut D, area: Area) -> LogEnd {
    let mut batch = [[0; BLOCK]; BATCH];
    let mut at = area.first;
    loop {
        let waiting = log.waiting(&mut batch);
        let blocks = batch.get(..waiting.min(area.end.saturating_sub(at) as usize)).unwrap_or(&[]);
        if waiting == 0 {
            log.more().await;
            continue;
        }
        if blocks.is_empty() {
            return LogEnd::Full;
        }
        let mut tries = 0;
        while device.write(at, blocks).await.is_err() {
            tries += 1;
            if tries == TRIES {
                return LogEnd::Broken;
            }
        }
        at = at.saturating_add(blocks.len() as u32);
        log.release(blocks.len());
    }
}
