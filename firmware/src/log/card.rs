//! Where on a card a log is written.
//!
//! There is no file system: a power loss can damage none. The log has the whole card, if it is blank (its first block all
//! zeros or all ones) or has logs already, or else the first MBR partition of type 0xDA ("not a file system"). A card with
//! anything else on it is left alone. Logs follow each other; each is found from the end of the one before, which is
//! searched for by the numbers in its blocks, so that neither a lost power nor blocks of older logs behind it can mislead.

use super::block::{BLOCK, Head, MAGIC, open};

/// A card, or part of one.
#[allow(async_fn_in_trait, reason = "one executor, one thread: futures need not be Send")]
pub trait BlockDevice {
    /// What may go wrong.
    type Error;
    /// Blocks of 512 bytes that it has.
    fn blocks(&self) -> u32;
    /// Reads block `index`.
    async fn read(&mut self, index: u32, block: &mut [u8; BLOCK]) -> Result<(), Self::Error>;
    /// Writes `blocks` from block `index` on.
    async fn write(&mut self, index: u32, blocks: &[[u8; BLOCK]]) -> Result<(), Self::Error>;
}

/// Blocks that a log may take: from `first`, ending before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// The first block.
    pub first: u32,
    /// One past the last.
    pub end: u32,
}

/// Why there is no area for a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoArea {
    /// The card cannot be read.
    Unreadable,
    /// Something else is on it.
    Foreign,
    /// Logs have filled it.
    Full,
}

/// The partition type that says "not a file system".
const NOT_A_FILE_SYSTEM: u8 = 0xda;
/// Damaged blocks in a row that do not end a log.
const TOLERATED: u32 = 4;

/// Where the next log goes.
///
/// # Errors
/// [`NoArea`].
pub async fn area<D: BlockDevice>(device: &mut D) -> Result<Area, NoArea> {
    let mut block = [0; BLOCK];
    device.read(0, &mut block).await.map_err(|_| NoArea::Unreadable)?;
    let is_blank = |byte: u8| block.iter().all(|&b| b == byte);
    let area = if block.starts_with(&MAGIC) || is_blank(0) || is_blank(0xff) {
        Area { first: 0, end: device.blocks() }
    } else {
        partition(&block).ok_or(NoArea::Foreign)?
    };
    let mut first = area.first;
    while first < area.end {
        match log_at(device, first).await? {
            Some(log) => first = first.saturating_add(length(device, first, log).await?),
            None => return Ok(Area { first, end: area.end.min(device.blocks()) }),
        }
    }
    Err(NoArea::Full)
}

/// The first partition that is meant for logs.
fn partition(block: &[u8; BLOCK]) -> Option<Area> {
    if !block.ends_with(&[0x55, 0xaa]) {
        return None;
    }
    let entries = block.get(446..510)?.chunks_exact(16);
    entries.filter(|entry| entry.get(4) == Some(&NOT_A_FILE_SYSTEM)).find_map(|entry| {
        let word = |at: usize| entry.get(at..).and_then(|b| b.first_chunk()).map(|&bytes| u32::from_le_bytes(bytes));
        let (first, blocks) = (word(8)?, word(12)?);
        (first > 0 && blocks > 0).then(|| Area { first, end: first.saturating_add(blocks) })
    })
}

async fn head<D: BlockDevice>(device: &mut D, index: u32) -> Result<Option<Head>, NoArea> {
    if index >= device.blocks() {
        return Ok(None);
    }
    let mut block = [0; BLOCK];
    device.read(index, &mut block).await.map_err(|_| NoArea::Unreadable)?;
    Ok(open(&block).ok().map(|(head, _)| head))
}

/// The number of the log that begins there, even where its first blocks are damaged.
async fn log_at<D: BlockDevice>(device: &mut D, first: u32) -> Result<Option<u32>, NoArea> {
    for sequence in 0..TOLERATED {
        let found = head(device, first.saturating_add(sequence)).await?;
        if let Some(head) = found.filter(|head| head.sequence == sequence) {
            return Ok(Some(head.log));
        }
    }
    Ok(None)
}

/// Blocks of the log that begins at `first`: the last one is between one that is there and one twice as far that is not.
async fn length<D: BlockDevice>(device: &mut D, first: u32, log: u32) -> Result<u32, NoArea> {
    let (mut there, mut beyond) = (0, 1);
    while has(device, first, log, beyond).await? {
        there = beyond;
        beyond = beyond.saturating_mul(2);
    }
    while beyond - there > 1 {
        let middle = there + (beyond - there) / 2;
        if has(device, first, log, middle).await? { there = middle } else { beyond = middle }
    }
    Ok(beyond)
}

/// Whether the log reaches its block `sequence`: it or one of the next is there.
async fn has<D: BlockDevice>(device: &mut D, first: u32, log: u32, sequence: u32) -> Result<bool, NoArea> {
    for sequence in sequence..sequence.saturating_add(TOLERATED) {
        let found = head(device, first.saturating_add(sequence)).await?;
        if found.is_some_and(|head| head.log == log && head.sequence == sequence) {
            return Ok(true);
        }
    }
    Ok(false)
}
