//! A block of the log: 512 bytes, what a card writes as one, good or damaged by itself. Little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 0..4 | magic `PLBL` |
//! | 4..6 | version of the format |
//! | 6..8 | bytes of payload in use |
//! | 8..12 | the log's number, drawn anew for each |
//! | 12..16 | the block's number in the log, from 0 |
//! | 16..18 | where in the payload the first record begins; 65535 where none does |
//! | 18..20 | zeros |
//! | 20..508 | payload: a part of the stream of records |
//! | 508..512 | CRC-32 (ISO-HDLC) of bytes 0..508 |
//!
//! The stream of records runs on from block to block. Where a block is missing, reading goes on at the first record that
//! begins behind it.

use crate::stores::framing::checksum;

/// Bytes of a block.
pub const BLOCK: usize = 512;
/// First bytes.
pub const MAGIC: [u8; 4] = *b"PLBL";
/// Of the format of blocks and records.
pub const VERSION: u16 = 2;
/// Where the payload begins.
pub const HEAD: usize = 20;
/// Bytes of payload.
pub const PAYLOAD: usize = BLOCK - HEAD - 4;
/// No record begins in this block.
pub const NONE: u16 = u16::MAX;
const CHECKED: usize = BLOCK - 4;

/// What a block's head says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Bytes of payload in use.
    pub used: u16,
    /// The log's number.
    pub log: u32,
    /// The block's number in it.
    pub sequence: u32,
    /// Where the first record begins, or [`NONE`].
    pub first: u16,
}

/// Puts head and checksum around the payload that `block` holds.
pub fn seal(block: &mut [u8; BLOCK], head: Head) {
    put_head(block, head);
    put_checksum(block);
}

/// Puts the head before the payload that `block` holds.
pub fn put_head(block: &mut [u8; BLOCK], head: Head) {
    let mut put = |at: usize, bytes: &[u8]| {
        block.iter_mut().skip(at).zip(bytes).for_each(|(to, from)| *to = *from);
    };
    put(0, &MAGIC);
    put(4, &VERSION.to_le_bytes());
    put(6, &head.used.to_le_bytes());
    put(8, &head.log.to_le_bytes());
    put(12, &head.sequence.to_le_bytes());
    put(16, &head.first.to_le_bytes());
    put(18, &[0; 2]);
}

/// Puts the checksum behind head and payload.
pub fn put_checksum(block: &mut [u8; BLOCK]) {
    let (checked, own) = block.split_at_mut(CHECKED);
    own.copy_from_slice(&checksum(checked).to_le_bytes());
}

/// Why a block is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockError {
    /// Never written by a log.
    Magic,
    /// Written by one, and damaged since.
    Damaged,
    /// Whole, and of a format that this build does not know.
    Version(u16),
}

/// Head and payload of a block. Any bytes may come.
///
/// # Errors
/// [`BlockError`].
pub fn open(block: &[u8; BLOCK]) -> Result<(Head, &[u8]), BlockError> {
    if !block.starts_with(&MAGIC) {
        return Err(BlockError::Magic);
    }
    let word = |at: usize| block.get(at..).and_then(|b| b.first_chunk()).map_or(0, |&bytes| u32::from_le_bytes(bytes));
    if checksum(block.get(..CHECKED).unwrap_or(&[])) != word(CHECKED) {
        return Err(BlockError::Damaged);
    }
    if word(4) as u16 != VERSION {
        return Err(BlockError::Version(word(4) as u16));
    }
    let head = Head { used: (word(4) >> 16) as u16, log: word(8), sequence: word(12), first: word(16) as u16 };
    let payload = block.get(HEAD..HEAD + head.used as usize).filter(|_| head.used as usize <= PAYLOAD);
    Ok((head, payload.ok_or(BlockError::Damaged)?))
}
