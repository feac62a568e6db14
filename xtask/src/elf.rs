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

/// A function or an object by its name, as the compiler mangled it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Mangled.
    pub name: String,
    /// Where it lies when the program runs; the lowest bit of a function's address is set.
    pub address: u32,
    /// Bytes.
    pub size: u32,
    /// Whether it is a function.
    pub is_function: bool,
}

/// A piece of the file and where a programmer writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load {
    /// First address in flash.
    pub address: u32,
    /// First byte in the file.
    pub offset: u32,
    /// Bytes.
    pub size: u32,
}

/// A function and its machine code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Mangled.
    pub name: String,
    /// Where it lies.
    pub address: u32,
    /// Bytes, constants between its code included.
    pub size: u32,
    /// Its code, piece by piece with addresses: what the compiler marked as data is left out.
    pub code: Vec<(u32, Vec<u8>)>,
}

const SECTION_OCCUPIES_MEMORY: u32 = 2;
const SYMBOL_TABLE: u32 = 2;
const SYMBOL_BYTES: usize = 16;
const FUNCTION: u8 = 2;
const NO_BITS: u32 = 8;
const HEADER_BYTES: usize = 40;

/// The sections of `file` that occupy memory, in the file's order.
pub fn sections(file: &[u8]) -> Result<Vec<Section>, Failure> {
    read(file, read_sections)
}

/// The functions and objects that `file` names.
pub fn symbols(file: &[u8]) -> Result<Vec<Symbol>, Failure> {
    read(file, read_symbols)
}

/// The functions of `file` with their code.
pub fn functions(file: &[u8]) -> Result<Vec<Function>, Failure> {
    read(file, read_functions)
}

/// The pieces of `file` that go into flash, in the file's order.
pub fn loads(file: &[u8]) -> Result<Vec<Load>, Failure> {
    read(file, read_loads)
}

fn read<T>(file: &[u8], what: impl Fn(&[u8]) -> Option<T>) -> Result<T, Failure> {
    if file.get(..6) != Some(b"\x7fELF\x01\x01") {
        return Err("not a 32-bit little-endian ELF file".into());
    }
    what(file).ok_or_else(|| "the ELF file is cut short".into())
}

fn read_loads(file: &[u8]) -> Option<Vec<Load>> {
    const LOADABLE: u32 = 1;
    let table = word(file, 28)? as usize;
    let [entry_size, count] = [42, 44].map(|at| half(file, at).map(usize::from));
    let (entry_size, count) = (entry_size?, count?);
    let mut loads = Vec::new();
    for n in 0..count {
        let header = file.get(table.checked_add(n * entry_size)?..)?.get(..32)?;
        let load = Load { address: word(header, 12)?, offset: word(header, 4)?, size: word(header, 16)? };
        if word(header, 0)? == LOADABLE && load.size > 0 {
            file.get(load.offset as usize..)?.get(..load.size as usize)?;
            loads.push(load);
        }
    }
    Some(loads)
}

/// Headers of all sections, and which of them holds the sections' names.
fn headers(file: &[u8]) -> Option<(Vec<&[u8]>, usize)> {
    let table = word(file, 32)? as usize;
    let [entry_size, count, names] = [46, 48, 50].map(|at| half(file, at).map(usize::from));
    let (entry_size, count) = (entry_size?, count?);
    let header = |n: usize| file.get(table.checked_add(n * entry_size)?..)?.get(..HEADER_BYTES);
    Some(((0..count).map(header).collect::<Option<_>>()?, names?))
}

fn read_sections(file: &[u8]) -> Option<Vec<Section>> {
    let (headers, names) = headers(file)?;
    let names = file.get(word(headers.get(names)?, 16)? as usize..)?;
    let mut sections = Vec::new();
    for header in headers {
        if word(header, 8)? & SECTION_OCCUPIES_MEMORY != 0 {
            sections.push(Section {
                name: name(names, word(header, 0)?)?,
                address: word(header, 12)?,
                size: word(header, 20)?,
                is_loaded: word(header, 4)? != NO_BITS,
            });
        }
    }
    Some(sections)
}

fn read_symbols(file: &[u8]) -> Option<Vec<Symbol>> {
    let (headers, _) = headers(file)?;
    let mut symbols = Vec::new();
    for header in headers.iter().filter(|header| word(header, 4) == Some(SYMBOL_TABLE)) {
        let names = file.get(word(headers.get(word(header, 24)? as usize)?, 16)? as usize..)?;
        let table = file.get(word(header, 16)? as usize..)?.get(..word(header, 20)? as usize)?;
        for symbol in table.chunks_exact(SYMBOL_BYTES) {
            symbols.push(Symbol {
                name: name(names, word(symbol, 0)?)?,
                address: word(symbol, 4)?,
                size: word(symbol, 8)?,
                is_function: *symbol.get(12)? & 0xf == FUNCTION,
            });
        }
    }
    Some(symbols)
}

fn read_functions(file: &[u8]) -> Option<Vec<Function>> {
    let (headers, _) = headers(file)?;
    // Places where code or data begins within a section: `$t` and `$d`.
    let mut marks: Vec<(u32, bool)> = Vec::new();
    let mut functions: Vec<(String, u32, u32)> = Vec::new();
    for header in headers.iter().filter(|header| word(header, 4) == Some(SYMBOL_TABLE)) {
        let names = file.get(word(headers.get(word(header, 24)? as usize)?, 16)? as usize..)?;
        let table = file.get(word(header, 16)? as usize..)?.get(..word(header, 20)? as usize)?;
        for symbol in table.chunks_exact(SYMBOL_BYTES) {
            let (name, value, size) = (name(names, word(symbol, 0)?)?, word(symbol, 4)?, word(symbol, 8)?);
            match name.get(..2) {
                Some("$t") => marks.push((value, true)),
                Some("$d") => marks.push((value, false)),
                // The lowest bit of a function's address says Thumb.
                _ if symbol.get(12)? & 0xf == FUNCTION => functions.push((name, value & !1, size)),
                _ => {}
            }
        }
    }
    marks.sort_unstable();
    let code = |from: u32, to: u32| {
        headers.iter().find_map(|header| {
            let (address, size) = (word(header, 12)?, word(header, 20)?);
            let is_there = word(header, 8)? & SECTION_OCCUPIES_MEMORY != 0 && word(header, 4)? != NO_BITS;
            let holds = is_there && from >= address && to <= address.checked_add(size)?;
            let at = (word(header, 16)? as usize).checked_add(from.wrapping_sub(address) as usize)?;
            if holds { file.get(at..at.checked_add((to - from) as usize)?).map(<[u8]>::to_vec) } else { None }
        })
    };
    let pieces = |address: u32, size: u32| {
        let end = address.checked_add(size)?;
        let first = marks.partition_point(|(at, _)| *at <= address).saturating_sub(1);
        let inside = marks.iter().skip(first).take_while(|(at, _)| *at < end);
        let mut pieces = Vec::new();
        for (nth, (at, is_code)) in inside.enumerate() {
            let to = marks.get(first + nth + 1).map_or(end, |(next, _)| (*next).min(end));
            let from = (*at).max(address);
            if *is_code && from < to {
                pieces.push((from, code(from, to)?));
            }
        }
        Some(pieces)
    };
    functions
        .into_iter()
        .map(|(name, address, size)| Some(Function { name, address, size, code: pieces(address, size)? }))
        .collect()
}

/// The string that begins at `at`.
fn name(strings: &[u8], at: u32) -> Option<String> {
    let bytes = strings.get(at as usize..)?.split(|&byte| byte == 0).next()?;
    Some(String::from_utf8_lossy(bytes).into_owned())
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::{Load, Section, Symbol, loads, sections, symbols};

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
    fn symbols_are_read_with_their_sizes() {
        let mut file = file();
        // The null section becomes a symbol table of one symbol behind all headers, with the names' section as strings.
        let at = file.len();
        for (offset, word) in [(4, 2u32), (16, at as u32), (20, 16), (24, 2)] {
            file[64 + offset..64 + offset + 4].copy_from_slice(&word.to_le_bytes());
        }
        file.extend([6u32, 0x400, 120, 2].iter().flat_map(|word| word.to_le_bytes()));
        assert_eq!(
            symbols(&file),
            Ok(vec![Symbol { name: ".names".into(), address: 0x400, size: 120, is_function: true }])
        );
        assert!(symbols(&file[..file.len() - 1]).is_err());
    }

    #[test]
    fn what_goes_into_flash_is_read() {
        let mut file = file();
        let at = file.len() as u32;
        file[28..32].copy_from_slice(&at.to_le_bytes());
        (file[42], file[44]) = (32, 2);
        // Of two segments the first holds the file's first 16 bytes, the second none.
        for segment in
            [[1u32, 0, 0x2000_0000, 0x0800_0000, 16, 16, 5, 4], [1, 0, 0x2000_0010, 0x2000_0010, 0, 64, 6, 4]]
        {
            file.extend(segment.iter().flat_map(|word| word.to_le_bytes()));
        }
        assert_eq!(loads(&file), Ok(vec![Load { address: 0x0800_0000, offset: 0, size: 16 }]));
        assert!(loads(&file[..file.len() - 1]).is_err());
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let file = file();
        assert!((0..file.len()).all(|length| sections(&file[..length]).is_err()));
        assert!(sections(b"\x7fELF\x02\x01").is_err());
    }
}
