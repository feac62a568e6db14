//! That both profiles are the same program: same sections, same names and sizes, every address in flash shifted by the
//! same, none in RAM.

use super::Image;
use super::map::{APPLICATION, BANK_1};
use crate::Failure;

/// Compares the image behind the bootloader with the bare one.
///
/// # Errors
/// The first difference that is not an address.
pub fn program(behind: &Image, bare: &Image) -> Result<(), Failure> {
    let shifted =
        |address: u32| if (BANK_1..BANK_1 + 0x0020_0000).contains(&address) { address - BANK_1 } else { address };
    let origin = APPLICATION - BANK_1;
    if behind.sections.len() != bare.sections.len() || behind.symbols.len() != bare.symbols.len() {
        return Err("the two profiles differ in their sections or symbols".into());
    }
    for (a, b) in behind.sections.iter().zip(&bare.sections) {
        let is_moved = a.address == b.address || shifted(a.address) == shifted(b.address) + origin;
        if a.name != b.name || a.size != b.size || !is_moved {
            return Err(format!("{} differs between the profiles: {} bytes and {}", a.name, a.size, b.size));
        }
    }
    // By size and place: the hash in a name may be the program's own.
    let listed = |image: &Image, by: u32| {
        let mut all: Vec<(u32, u32, bool)> = image
            .symbols
            .iter()
            .filter(|symbol| symbol.size > 0)
            .map(|symbol| {
                let is_flash = (BANK_1..BANK_1 + 0x0020_0000).contains(&symbol.address);
                (if is_flash { symbol.address - by } else { symbol.address }, symbol.size, symbol.is_function)
            })
            .collect();
        all.sort_unstable();
        all
    };
    if listed(behind, origin) != listed(bare, 0) {
        return Err("a function or an object lies elsewhere, or has another size, in one of the two profiles".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::program;
    use crate::board::Image;
    use crate::elf::{Section, Symbol};

    fn image(origin: u32) -> Image {
        let section = |name: &str, address| Section { name: name.into(), address, size: 64, is_loaded: true };
        let symbol = |address| Symbol { name: String::new(), address, size: 8, is_function: true };
        Image {
            sections: vec![section(".text", origin + 0x400), section(".bss", 0x2000_8000)],
            symbols: vec![symbol(origin + 0x401), symbol(0x2000_8000)],
            loads: Vec::new(),
            file: Vec::new(),
        }
    }

    #[test]
    fn the_same_program_elsewhere_passes_and_another_does_not() {
        let (behind, bare) = (image(0x0804_0000), image(0x0800_0000));
        assert_eq!(program(&behind, &bare), Ok(()));
        let mut other = bare.clone();
        other.symbols[0].size = 12;
        assert!(program(&behind, &other).is_err());
        let mut other = bare.clone();
        other.symbols[1].address += 4;
        assert!(program(&behind, &other).is_err());
        let mut other = bare;
        other.sections[1].size += 4;
        assert!(program(&behind, &other).is_err());
    }
}
