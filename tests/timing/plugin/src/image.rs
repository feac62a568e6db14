//! The program's bytes, taken from its ELF file.
//!
//! QEMU offers them as well, but by a function whose arguments changed with version 3 of its interface, and in 7.2 with
//! the second half missing where an instruction lies across a border of 1 KiB.

/// Loaded segments of a 32-bit little-endian ELF file.
#[derive(Clone, Debug, Default)]
pub struct Image {
    segments: Vec<(u32, Vec<u8>)>,
}

const LOADED: u32 = 1;
const HEADER_BYTES: usize = 32;

impl Image {
    /// Reads `file`; `None` where it is no such file or cut short.
    pub fn parse(file: &[u8]) -> Option<Self> {
        if file.get(..6)? != b"\x7fELF\x01\x01" {
            return None;
        }
        let (table, size, count) = (word(file, 28)? as usize, half(file, 42)? as usize, half(file, 44)? as usize);
        let mut segments = Vec::new();
        for n in 0..count {
            let header = file.get(table + n * size..)?.get(..HEADER_BYTES)?;
            // Type, offset, address, physical address, bytes in the file. Code is never executed from a copy.
            if word(header, 0)? == LOADED {
                let (offset, address, bytes) =
                    (word(header, 4)? as usize, word(header, 8)?, word(header, 16)? as usize);
                segments.push((address, file.get(offset..)?.get(..bytes)?.to_vec()));
            }
        }
        Some(Image { segments })
    }

    /// The half word at `address`.
    pub fn half(&self, address: u32) -> Option<u16> {
        self.segments.iter().find_map(|(begin, bytes)| half(bytes, address.checked_sub(*begin)? as usize))
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..)?.get(..4)?.try_into().ok()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..)?.get(..2)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::Image;

    /// A file with one segment of four bytes at 0x400.
    fn file() -> Vec<u8> {
        let mut file = vec![0; 52];
        file[..6].copy_from_slice(b"\x7fELF\x01\x01");
        (file[28], file[42], file[44]) = (52, 32, 1);
        for word in [1u32, 84, 0x400, 0x400, 4, 4, 5, 4] {
            file.extend(word.to_le_bytes());
        }
        file.extend([0x01, 0x30, 0xaf, 0xf3]);
        file
    }

    #[test]
    fn halves_are_found_by_their_address() {
        let image = Image::parse(&file()).expect("a sound file");
        assert_eq!([0x3fe, 0x400, 0x402, 0x404].map(|at| image.half(at)), [None, Some(0x3001), Some(0xf3af), None]);
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let file = file();
        assert!((0..file.len()).all(|length| Image::parse(&file[..length]).is_none()));
    }
}
