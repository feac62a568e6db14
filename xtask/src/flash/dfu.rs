//! A DFU file: the bytes of one partition from its start, and the suffix of DFU 1.1, appendix B.

use crate::Failure;
use std::ops::Range;

/// The camera's bootloader.
pub const VENDOR: u16 = 0x37c5;
/// See [`VENDOR`].
pub const PRODUCT: u16 = 0x9204;
/// What erased flash reads as.
const ERASED: u8 = 0xff;

/// The file that writes `pieces` (address, bytes) into a partition. Gaps are erased.
///
/// # Errors
/// A piece outside the partition, or two that overlap.
pub fn file<'a>(pieces: impl Iterator<Item = (u32, &'a [u8])>, partition: Range<u32>) -> Result<Vec<u8>, Failure> {
    let mut pieces: Vec<(u32, &[u8])> = pieces.collect();
    pieces.sort_unstable_by_key(|(address, _)| *address);
    let mut file = Vec::new();
    for (address, bytes) in pieces {
        let offset = address.checked_sub(partition.start).map(|offset| offset as usize);
        let room = partition.len();
        match offset {
            Some(offset) if offset >= file.len() && offset + bytes.len() <= room => {
                file.resize(offset, ERASED);
                file.extend_from_slice(bytes);
            }
            _ => return Err(format!("{} bytes at {address:#010x} do not fit the bootloader's partition", bytes.len())),
        }
    }
    file.extend(0xffffu16.to_le_bytes());
    file.extend(PRODUCT.to_le_bytes());
    file.extend(VENDOR.to_le_bytes());
    file.extend(0x0100u16.to_le_bytes());
    file.extend(b"UFD\x10");
    let sum = crc(&file);
    file.extend(sum.to_le_bytes());
    Ok(file)
}

/// CRC-32 as the suffix has it: not inverted at the end.
pub fn crc(bytes: &[u8]) -> u32 {
    bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    })
}

#[cfg(test)]
mod tests {
    use super::file;

    const PARTITION: std::ops::Range<u32> = 0x0804_0000..0x0804_1000;

    #[test]
    fn the_suffix_is_that_of_the_standard() {
        let made = file([(0x0804_0000, &b"plumbline"[..])].into_iter(), PARTITION).unwrap();
        // The sum is zlib's crc32, not inverted, over bytes and suffix.
        let suffix = [0xff, 0xff, 0x04, 0x92, 0xc5, 0x37, 0x00, 0x01, b'U', b'F', b'D', 16];
        assert_eq!(made[..9], *b"plumbline");
        assert_eq!(made[9..21], suffix);
        assert_eq!(u32::from_le_bytes(made[21..].try_into().unwrap()), 0xc362_992b);
    }

    #[test]
    fn gaps_are_erased_and_order_does_not_matter() {
        let made = file([(0x0804_0006, &[3u8][..]), (0x0804_0000, &[1, 2][..])].into_iter(), PARTITION).unwrap();
        assert_eq!(made[..7], [1, 2, 0xff, 0xff, 0xff, 0xff, 3]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for (address, length) in [(0x0803_ffff, 1), (0x0804_0fff, 2), (0x0804_1000, 1), (0x0800_0000, 16)] {
            assert!(file([(address, &vec![0; length][..])].into_iter(), PARTITION).is_err(), "{address:x}");
        }
        let overlap = [(0x0804_0000, &[0u8; 8][..]), (0x0804_0007, &[0; 8][..])];
        assert!(file(overlap.into_iter(), PARTITION).is_err());
    }
}
