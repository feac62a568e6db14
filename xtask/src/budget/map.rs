//! What an image takes of flash and of RAM.

use crate::elf::{self, Section};
use crate::flight::number;
use crate::{Failure, places};
use serde_json::Value;
use std::fs;

/// What static data and stack together may take, bytes.
pub const RAM_LIMIT: u32 = 32 * 1024;

/// Where the emulated board's RAM begins.
const RAM: std::ops::Range<u32> = 0x2000_0000..0x2040_0000;

/// Prints the sections of an image, and what RAM a flight took in all.
pub fn print(name: &str, report: Option<&Value>) -> Result<(), Failure> {
    let path = places::image(name);
    let file = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let sections = elf::sections(&file).map_err(|why| format!("{}: {why}", path.display()))?;
    for section in sections.iter().filter(|section| section.size > 0) {
        println!("{:16} {:#010x} {:8} bytes", section.name, section.address, section.size);
    }
    let (flash, ram) = totals(&sections);
    println!("{:16} {:10} {flash:8} bytes", "flash", "");
    println!("{:16} {:10} {ram:8} bytes of {RAM_LIMIT}, stack not included", "static RAM", "");
    if let Some(bytes) = report.map(|report| number(report, "/ram_bytes")) {
        println!("{:16} {:10} {bytes:8} bytes of {RAM_LIMIT}, with the stack's high-water mark in flight", "RAM", "");
    }
    Ok(())
}

/// Bytes that the image takes of flash, and of RAM before it runs. First values of `.data` count in both.
pub fn totals(sections: &[Section]) -> (u32, u32) {
    let sum = |wanted: &dyn Fn(&&Section) -> bool| sections.iter().filter(wanted).map(|section| section.size).sum();
    (sum(&|section| section.is_loaded), sum(&|section| RAM.contains(&section.address)))
}

#[cfg(test)]
mod tests {
    use super::totals;
    use crate::elf::Section;

    #[test]
    fn first_values_count_in_flash_and_ram() {
        let section = |address, size, is_loaded| Section { name: String::new(), address, size, is_loaded };
        let sections = [section(0x400, 1000, true), section(0x2000_0000, 100, true), section(0x2000_0064, 10, false)];
        assert_eq!(totals(&sections), (1100, 110));
    }
}
