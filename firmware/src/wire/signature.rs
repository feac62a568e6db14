//! The signature of a message (<https://mavlink.io/en/guide/message_signing.html>): [`SIGNATURE`] bytes behind its checksum.
//! They are the link's id, 48 bits of time in units of 10 us since 2015-01-01, and the first 48 bits of SHA-256 of the key, the
//! message from its first byte to the checksum, link id and time.

use core::hint::black_box;
use sha2::{Digest, Sha256};

/// Bytes behind the checksum of a signed message: link id, time, and [`DIGEST`].
pub const SIGNATURE: usize = 13;
/// Bytes of the hash in a signature.
pub const DIGEST: usize = 6;
/// The incompatibility flag of a signed message.
pub const SIGNED: u8 = 0x01;
/// A secret key. What it is, its `Debug` does not say.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key(pub [u8; 32]);

impl core::fmt::Debug for Key {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Key(..)")
    }
}

impl Key {
    /// The hash in the signature of `message`, from its first byte to its checksum, that ends in `tail`: link id and time.
    pub fn digest(&self, message: &[u8], tail: [u8; SIGNATURE - DIGEST]) -> [u8; DIGEST] {
        let whole: [u8; 32] =
            Sha256::new().chain_update(self.0).chain_update(message).chain_update(tail).finalize().into();
        whole.first_chunk().copied().unwrap_or_default()
    }
}

/// What is behind the checksum of a message, taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The sender's link.
    pub link: u8,
    /// Units of 10 us since 2015-01-01 00:00 GMT.
    pub stamp: u64,
    /// The hash.
    pub digest: [u8; DIGEST],
}

impl Signature {
    /// Of these bytes.
    pub fn of(bytes: [u8; SIGNATURE]) -> Self {
        let [link, t0, t1, t2, t3, t4, t5, digest @ ..] = bytes;
        Signature { link, stamp: u64::from_le_bytes([t0, t1, t2, t3, t4, t5, 0, 0]), digest }
    }

    /// As bytes; of the time its lower 48 bits.
    pub fn bytes(self) -> [u8; SIGNATURE] {
        let [link, t0, t1, t2, t3, t4, t5] = tail(self.link, self.stamp);
        let [d0, d1, d2, d3, d4, d5] = self.digest;
        [link, t0, t1, t2, t3, t4, t5, d0, d1, d2, d3, d4, d5]
    }
}

/// Link id and time as they are signed.
pub fn tail(link: u8, stamp: u64) -> [u8; SIGNATURE - DIGEST] {
    let [t0, t1, t2, t3, t4, t5, ..] = stamp.to_le_bytes();
    [link, t0, t1, t2, t3, t4, t5]
}

/// Compares in a time that does not depend on where they differ: else each byte could be guessed by itself.
pub fn is_same(a: [u8; DIGEST], b: [u8; DIGEST]) -> bool {
    black_box(a.iter().zip(b).fold(0, |differs, (a, b)| black_box(differs | (a ^ b)))) == 0
}
