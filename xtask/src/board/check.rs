//! One image: everything in its bank, hot code and nothing else in ITCM, the stack where it faults, sizes.

use super::Image;
use super::hot::{WORKERS, is_bridge, is_hot};
use super::map::{APPLICATION, BANK_2, BUFFERS, COMPARABLE, DTCM, FLASH_LIMIT, ITCM, RAM_LIMIT, SECTIONS};
use crate::Failure;

/// Bytes that interrupts add to a stack at most: two levels, each the core's frame with the floating-point registers (104)
/// and what a handler of ours or embassy's keeps (less than 152, by their prologues).
const INTERRUPTS: u32 = 2 * (104 + 152);

/// Checks an image that begins at `origin`.
///
/// # Errors
/// What lies where it should not.
pub fn image(image: &Image, origin: u32) -> Result<(), Failure> {
    for (name, bank) in SECTIONS {
        let section = image.section(name)?;
        if section.address < bank.start || section.address + section.size > bank.end {
            return Err(format!(
                "{name} at {:#010x} is not in {:#010x}..{:#010x}",
                section.address, bank.start, bank.end
            ));
        }
    }
    flash(image, origin)?;
    itcm(image)?;
    buffers(image)?;
    stack(image)
}

/// Vectors at the profile's base; nothing over the bootloader, bank 2 or the limit.
fn flash(image: &Image, origin: u32) -> Result<(), Failure> {
    let vectors = image.section(".vector_table")?;
    if vectors.address != origin {
        return Err(format!("the vectors are at {:#010x}, not at {origin:#010x}", vectors.address));
    }
    for load in &image.loads {
        if load.address < origin || load.address + load.size > BANK_2 {
            let end = load.address + load.size;
            return Err(format!(
                "{:#010x}..{end:#010x} is written outside {origin:#010x}..{BANK_2:#010x}",
                load.address
            ));
        }
    }
    let taken: u32 = image.loads.iter().map(|load| load.size).sum();
    if taken > FLASH_LIMIT {
        return Err(format!("{taken} bytes of flash are more than {FLASH_LIMIT}"));
    }
    let at = |offset: usize| {
        let first = image.loads.iter().find(|load| load.address == origin)?;
        let bytes = image.file.get(first.offset as usize + offset..)?.get(..4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (top, reset) = (at(0), at(4));
    if top != Some(image.address("_stack_start")?)
        || reset.map(|reset| reset & !1) != Some(image.address("Reset")? & !1)
    {
        return Err(format!("the first vectors are {top:x?} and {reset:x?}, not the stack's top and Reset"));
    }
    Ok(())
}

/// Hot functions and bridges in ITCM, nothing else there, and no hot function elsewhere.
fn itcm(image: &Image) -> Result<(), Failure> {
    for symbol in image.symbols.iter().filter(|symbol| symbol.is_function && symbol.size > 0) {
        let is_inside = ITCM.contains(&symbol.address);
        if is_inside && !is_hot(&symbol.name) && !is_bridge(&symbol.name) {
            return Err(format!("{} lies in ITCM and is not hot", symbol.name));
        }
        if !is_inside && is_hot(&symbol.name) {
            return Err(format!("{} is hot and lies at {:#010x}", symbol.name, symbol.address));
        }
    }
    for worker in WORKERS {
        let is_there = |name: &str| name.contains(worker) && is_hot(name);
        if !image.symbols.iter().any(|symbol| symbol.is_function && is_there(&symbol.name)) {
            return Err(format!("no function {worker} lies in ITCM: has it been inlined?"));
        }
    }
    Ok(())
}

/// Each named buffer in its bank.
fn buffers(image: &Image) -> Result<(), Failure> {
    for (name, bank) in BUFFERS {
        let symbol = image.symbols.iter().find(|symbol| symbol.name.contains(name) && symbol.size > 0);
        let symbol = symbol.ok_or_else(|| format!("there is no buffer {name}"))?;
        if symbol.address < bank.start || symbol.address + symbol.size > bank.end {
            return Err(format!(
                "{name} at {:#010x} is not in {:#010x}..{:#010x}",
                symbol.address, bank.start, bank.end
            ));
        }
    }
    Ok(())
}

/// The stack ends at the bottom of DTCM, below which the MPU's guard lies (firmware/src/h743/regions.rs has the test), and
/// no data lie in its room.
fn stack(image: &Image) -> Result<(), Failure> {
    let (end, start) = (image.address("_stack_end")?, image.address("_stack_start")?);
    if end != DTCM.start || start <= end || !start.is_multiple_of(8) {
        return Err(format!("the stack is {end:#010x}..{start:#010x} and does not run out of DTCM"));
    }
    let inside = image
        .sections
        .iter()
        .find(|section| section.size > 0 && DTCM.contains(&section.address) && section.address < start);
    inside.map_or(Ok(()), |section| Err(format!("{} lies in the stack's room", section.name)))
}

/// Bytes of the statics that the emulated board has too.
pub fn comparable(image: &Image) -> u32 {
    let is_one = |name: &str| COMPARABLE.iter().any(|one| name.contains(one));
    image.symbols.iter().filter(|symbol| !symbol.is_function && is_one(&symbol.name)).map(|symbol| symbol.size).sum()
}

/// Prints what an image takes, and fails where the stack has no room or the comparable RAM passes its limit. `emulated`:
/// what the emulated flight took of RAM, static and stack.
pub fn tell(image: &Image, emulated: Option<u32>) -> Result<(), Failure> {
    for section in image.sections.iter().filter(|section| section.size > 0) {
        println!("{:16} {:#010x} {:8} bytes", section.name, section.address, section.size);
    }
    let flash: u32 = image.loads.iter().map(|load| load.size).sum();
    println!("{:16} {:#010x} {flash:8} bytes of {FLASH_LIMIT}", "flash", APPLICATION);
    let room = image.address("_stack_start")? - image.address("_stack_end")?;
    let statics = comparable(image);
    let Some(emulated) = emulated else { return Ok(()) };
    let of_an500 = super::Image::read(&crate::places::image("an500"))?;
    let (_, below) = crate::budget::map::totals(&of_an500.sections);
    let deepest = emulated.saturating_sub(below) + INTERRUPTS;
    println!("{:16} {:10} {deepest:8} bytes of {room}: the emulated flight's, and two interrupts", "stack", "");
    let ram = statics + deepest;
    println!("{:16} {:10} {ram:8} bytes of {RAM_LIMIT}, drivers and frame not included", "RAM", "");
    match () {
        () if 2 * deepest > room => Err(format!("a stack of {deepest} bytes has less than its double in {room}")),
        () if ram > RAM_LIMIT => Err(format!("{ram} bytes of RAM are more than {RAM_LIMIT}")),
        () => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::map::BANK_1;
    use super::*;
    use crate::elf::{Load, Section, Symbol};

    fn good() -> Image {
        let section = |name: &str, address| Section { name: name.into(), address, size: 64, is_loaded: true };
        let symbol = |name: &str, address, is_function| Symbol { name: name.into(), address, size: 8, is_function };
        let mut symbols: Vec<Symbol> = BUFFERS.iter().map(|(name, bank)| symbol(name, bank.start, false)).collect();
        symbols.extend(WORKERS.iter().map(|name| symbol(&format!("_ZN14plumbline_core{name}17h0E"), 8, true)));
        symbols.push(symbol("_stack_end", 0x2000_0000, false));
        symbols.push(symbol("_stack_start", 0x2000_8000, false));
        symbols.push(symbol("Reset", 0x0800_0299, true));
        let mut sections: Vec<Section> = SECTIONS.iter().map(|(name, bank)| section(name, bank.start)).collect();
        for section in sections.iter_mut().filter(|section| section.address == DTCM.start) {
            section.address = 0x2000_8000;
        }
        sections.push(section(".vector_table", BANK_1));
        let file = [0x2000_8000u32, 0x0800_0299].iter().flat_map(|word| word.to_le_bytes()).collect();
        Image { sections, symbols, loads: vec![Load { address: BANK_1, offset: 0, size: 8 }], file }
    }

    fn broken(change: impl FnOnce(&mut Image)) -> Result<(), Failure> {
        let mut image = good();
        change(&mut image);
        super::image(&image, BANK_1)
    }

    #[test]
    fn a_good_image_passes() {
        assert_eq!(broken(|_| ()), Ok(()));
    }

    #[test]
    fn each_thing_in_a_wrong_place_is_found() {
        let moved = |name: &'static str, address| {
            broken(move |image| image.symbols.iter_mut().filter(|s| s.name == name).for_each(|s| s.address = address))
        };
        for (name, _) in BUFFERS {
            assert!(moved(name, 0x0809_0000).is_err(), "{name}");
        }
        for name in ["_stack_end", "_stack_start", "Reset"] {
            assert!(moved(name, 0x2000_4000).is_err(), "{name}");
        }
        for (n, (name, _)) in SECTIONS.iter().enumerate() {
            assert!(broken(|image| image.sections[n].address = 0x6000_0000).is_err(), "{name}");
            assert!(broken(|image| image.sections[n].size = 0x0200_0000).is_err(), "{name}");
        }
        assert!(broken(|image| image.symbols[BUFFERS.len()].address = 0x0800_1000).is_err(), "a hot function in flash");
        assert!(
            broken(|image| image.symbols[BUFFERS.len()].name = "_ZN4core3fmt".into()).is_err(),
            "a cold one in ITCM"
        );
        assert!(broken(|image| drop(image.symbols.remove(BUFFERS.len()))).is_err(), "an inlined one");
        assert!(broken(|image| image.loads[0].size = FLASH_LIMIT + 1).is_err());
        assert!(broken(|image| image.loads.push(Load { address: BANK_2 - 4, offset: 0, size: 8 })).is_err());
        assert!(super::image(&good(), APPLICATION).is_err(), "over the bootloader");
    }
}
