//! The key store: what messages of the link are signed with. It is secret: it goes into no log, report or line of text.
//!
//! Its payload, little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 0..32 | the key |
//! | 32..40 | u64: the least time of a signature, units of 10 us since 2015-01-01; when the key was made, or 0 |
//!
//! The time is there for a board that has lost its own with its flash: what was signed with this key before is not taken then.

use super::StoreError;
use super::framing::{HEADER_BYTES, Kind, header, open};
use crate::wire::signature::Key;
use crate::wire::signing::clock::LATEST;

/// This store's magic and version.
pub const KIND: Kind = Kind { magic: *b"PLBK", version: 1 };
/// Bytes of the payload.
const PAYLOAD: usize = 40;
/// Bytes of the store.
pub const STORE_BYTES: usize = HEADER_BYTES + PAYLOAD;

/// What the store holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// The key.
    pub key: Key,
    /// The least time of a signature.
    pub first: u64,
}

/// The key in the store that `region` begins with; `None` where nothing is there: no region, erased flash, zeros. Any bytes
/// may come. Where a key was, but is damaged, nothing may fly as if there were none.
///
/// # Errors
/// [`StoreError`].
pub fn read(region: &[u8]) -> Result<Option<Stored>, StoreError> {
    let is_all = |byte: u8| region.iter().take(HEADER_BYTES).all(|&b| b == byte);
    if is_all(0xff) || is_all(0) {
        return Ok(None);
    }
    let payload: &[u8; PAYLOAD] = open(KIND, region)?.try_into().map_err(|_| StoreError::Encoding)?;
    let (Some(key), Some(first)) = (payload.first_chunk(), payload.last_chunk()) else {
        return Err(StoreError::Encoding);
    };
    let first = u64::from_le_bytes(*first);
    // A key of zeros is none, as MAVLink's SETUP_SIGNING has it; and who writes such a time has written something else.
    if *key == [0; 32] || first > LATEST {
        return Err(StoreError::Encoding);
    }
    Ok(Some(Stored { key: Key(*key), first }))
}

/// The whole store.
pub fn store(stored: &Stored) -> [u8; STORE_BYTES] {
    let first = stored.first.to_le_bytes();
    let head = header(KIND, &[&stored.key.0, &first]);
    let mut bytes = [0; STORE_BYTES];
    bytes.iter_mut().zip(head.iter().chain(&stored.key.0).chain(&first)).for_each(|(to, from)| *to = *from);
    bytes
}
