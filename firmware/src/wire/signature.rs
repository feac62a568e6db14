//! The signature of a message (<https://mavlink.io/en/guide/message_signing.html>): [`SIGNATURE`] bytes behind its checksum.
//! They are the link's id, 48 bits of time in units of 10 us since 2015-01-01, and the first 48 bits of SHA-256 of the key, the
//! message from its first byte to the checksum, link id and time.

use core::hint::black_box;
use core::iter::repeat_n;
use sha2::compress256;

/// Bytes that SHA-256 hashes at a time, and the state that it begins with (FIPS 180-4, 5.3.3).
const BLOCK: usize = 64;
const INITIAL: [u32; 8] =
    [0x6a09_e667, 0xbb67_ae85, 0x3c6e_f372, 0xa54f_f53a, 0x510e_527f, 0x9b05_688c, 0x1f83_d9ab, 0x5be0_cd19];

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
    // By the function that hashes a block, and padded here: the crate's own buffer of a block can panic.
    pub fn digest(&self, message: &[u8], tail: [u8; SIGNATURE - DIGEST]) -> [u8; DIGEST] {
        let length = self.0.len() + message.len() + tail.len();
        // Behind the end a one, zeros, and in the last 8 bytes of a block the length in bits (FIPS 180-4, 5.1.1).
        let zeros = repeat_n(0, 55usize.wrapping_sub(length) % BLOCK);
        let end = [0x80].into_iter().chain(zeros).chain((8 * length as u64).to_be_bytes());
        let mut padded = self.0.iter().chain(message).copied().chain(tail).chain(end);
        let mut state = INITIAL;
        loop {
            let mut block = [0; BLOCK];
            if block.iter_mut().zip(&mut padded).map(|(to, from)| *to = from).count() == 0 {
                break;
            }
            compress256(&mut state, &[block.into()]);
        }
        let [first, second, ..] = state.map(u32::to_be_bytes);
        let ([d0, d1, d2, d3], [d4, d5, ..]) = (first, second);
        [d0, d1, d2, d3, d4, d5]
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
