//! The few fields of a 32-bit little-endian ELF file that say how big an image is.

use super::Failure;

/// A section that takes room on the board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its name, with the dot.
    pub name: String,
    /// Where it lies when the program runs.
    pub address: u32,
    /// Bytes.
    pub size: u32,
    /// Whether the file holds its bytes; `.bss` has none.
    pub is_loaded: bool,
}

const SECTION_OCCUPIES_MEMORY: u32 = 2;
const NO_BITS: u32 = 8;
const HEADER_BYTES: usize = 40;

/// The sections of `file` that occupy memory, in the file's order.
pub fn sections(file: &[u8]) -> Result<Vec<Section>, Failure> {
    if file.get(..6) != Some(b"\x7fELF\x01\x01") {
        return Err("not a 32-bit little-endian ELF file".into());
    }
    read(file).ok_or_else(|| "the ELF file is cut short".into())
}

fn read(file: &[u8]) -> Option<Vec<Section>> {
    let table = word(file, 32)? as usize;
    let [entry_size, count, names] = [46, 48, 50].map(|at| half(file, at).map(usize::from));
    let (entry_size, count) = (entry_size?, count?);
    let header = |n: usize| file.get(table.checked_add(n * entry_size)?..)?.get(..HEADER_BYTES);
    let names = file.get(word(header(names?)?, 16)? as usize..)?;
    let mut sections = Vec::new();
    for n in 0..count {
        let header = header(n)?;
        if word(header, 8)? & SECTION_OCCUPIES_MEMORY != 0 {
            let name = names.get(word(header, 0)? as usize..)?.split(|&byte| byte == 0).next()?;
            sections.push(Section {
                name: String::from_utf8_lossy(name).into_owned(),
                address: word(header, 12)?,
                size: word(header, 20)?,
                is_loaded: word(header, 4)? != NO_BITS,
            });
        }
    }
    Some(sections)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::{Section, sections};

    /// A file with a null section, `.bss` and the names.
    fn file() -> Vec<u8> {
        let mut file = vec![0; 52];
        file[..6].copy_from_slice(b"\x7fELF\x01\x01");
        file[32] = 64;
        (file[46], file[48], file[50]) = (40, 3, 2);
        file.extend(b"\0.bss\0.names");
        let mut header = |words: [u32; 10]| file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        header([0; 10]);
        header([1, 8, 3, 0x2000_0000, 64, 1234, 0, 0, 4, 0]);
        header([6, 3, 0, 0, 52, 12, 0, 0, 1, 0]);
        file
    }

    #[test]
    fn a_section_is_read_and_one_that_takes_no_memory_is_not() {
        let bss = Section { name: ".bss".into(), address: 0x2000_0000, size: 1234, is_loaded: false };
        assert_eq!(sections(&file()), Ok(vec![bss]));
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let file = file();
        assert!((0..file.len()).all(|length| sections(&file[..length]).is_err()));
        assert!(sections(b"\x7fELF\x02\x01").is_err());
    }
}
