//! The header in front of a store, 32 bytes, a flash word of the STM32H7, little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 0..4 | magic: `PLBM` the configuration, `PLBT` the reference tile, `PLBP` the plan, `PLBK` the key |
//! | 4..6 | version of the payload's format |
//! | 6..8 | zeros |
//! | 8..12 | bytes of payload, which follows the header |
//! | 12..16 | CRC-32 (ISO-HDLC, that of zip) of the payload |
//! | 16..28 | zeros |
//! | 28..32 | the same CRC of bytes 0..28 |
//!
//! What lies behind the payload is not read: a store may be read from a region of flash that is larger.

use super::StoreError;

/// Bytes of the header.
pub const HEADER_BYTES: usize = 32;
/// Bytes that the header's own checksum covers.
const CHECKED: usize = HEADER_BYTES - 4;

/// CRC-32/ISO-HDLC, of stores, log and line.
pub(crate) const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// The checksum of all stores, of the log and of the line.
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Which store, in which format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// First bytes.
    pub magic: [u8; 4],
    /// Of the payload's format.
    pub version: u16,
}

/// The payload of the store of this `kind` that `region` begins with.
///
/// # Errors
/// [`StoreError`], of which this function gives those up to [`StoreError::Payload`].
pub fn open(kind: Kind, region: &[u8]) -> Result<&[u8], StoreError> {
    let (payload, sum) = payload(kind, region)?;
    if checksum(payload) == sum { Ok(payload) } else { Err(StoreError::Payload) }
}

/// The payload behind a header that holds, and the checksum that it should have.
fn payload(kind: Kind, region: &[u8]) -> Result<(&[u8], u32), StoreError> {
    let (header, rest) = region.split_first_chunk::<HEADER_BYTES>().ok_or(StoreError::Nothing)?;
    let is_all = |byte: u8| header.iter().all(|&b| b == byte);
    if is_all(0xff) || is_all(0) {
        return Err(StoreError::Nothing);
    }
    let word = |at: usize| header.get(at..).and_then(|b| b.first_chunk()).map_or(0, |&bytes| u32::from_le_bytes(bytes));
    if !header.starts_with(&kind.magic) {
        return Err(StoreError::Magic);
    }
    if checksum(header.get(..CHECKED).unwrap_or(&[])) != word(CHECKED) {
        return Err(StoreError::Header);
    }
    // The upper half of this word is zeros.
    if word(4) != u32::from(kind.version) {
        return Err(StoreError::Version);
    }
    let payload = rest.get(..word(8) as usize).ok_or(StoreError::Length)?;
    Ok((payload, word(12)))
}

/// The header for a payload, whose parts follow each other.
pub fn header(kind: Kind, payload: &[&[u8]]) -> [u8; HEADER_BYTES] {
    let mut digest = CRC.digest();
    payload.iter().for_each(|part| digest.update(part));
    let length: usize = payload.iter().map(|part| part.len()).sum();
    let mut header = [0; HEADER_BYTES];
    let mut put = |at: usize, bytes: &[u8]| {
        for (to, from) in header.iter_mut().skip(at).zip(bytes) {
            *to = *from;
        }
    };
    put(0, &kind.magic);
    put(4, &kind.version.to_le_bytes());
    put(8, &(length as u32).to_le_bytes());
    put(12, &digest.finalize().to_le_bytes());
    let (checked, own) = header.split_at_mut(CHECKED);
    own.copy_from_slice(&checksum(checked).to_le_bytes());
    header
}

/// Bytes of the whole store that `region` begins with, header included, if its header holds; for who keeps or copies
/// stores without reading them.
pub fn extent(kind: Kind, region: &[u8]) -> Option<usize> {
    payload(kind, region).ok().map(|(payload, _)| HEADER_BYTES + payload.len())
}
