//! RAM and flash.

use super::figures::{APPLICATION, FLASH, Figure, RAM, RAM_WITHOUT_NAVIGATION, STAGE};
use super::map::totals;
use crate::elf::{self, Symbol};
use crate::{Failure, flight, places};
use std::fs;

/// Frames of the flight whose stack is measured.
const FRAMES: usize = 20;

/// Figures of the application and of the part of it that rectifies.
pub fn figures() -> Result<Vec<Figure>, Failure> {
    let application = image("an500")?;
    let (sections, symbols) = (elf::sections(&application)?, elf::symbols(&application)?);
    let (flash, _) = totals(&sections);
    // Frame and tile lie in the external memory, which no section takes.
    let ram = flight::ram_bytes(FRAMES)?;
    let navigation = symbols.iter().find(|symbol| symbol.name.contains(NAVIGATION)).map(|symbol| symbol.size);
    let navigation = navigation.ok_or("the image has no static of the navigation's")?;
    // The bench keeps the stage's functions apart, which the application has inlined.
    let stage = elf::symbols(&image("bench")?)?
        .iter()
        .filter(|symbol| rectifies(symbol))
        .map(|symbol| symbol.size)
        .sum::<u32>();
    if stage == 0 {
        return Err("the bench image has no function of the rectification".into());
    }
    Ok(vec![
        Figure::new(APPLICATION, RAM, f64::from(ram)),
        Figure::new(APPLICATION, RAM_WITHOUT_NAVIGATION, f64::from(ram - navigation)),
        Figure::new(APPLICATION, FLASH, f64::from(flash)),
        Figure::new(STAGE, FLASH, f64::from(stage)),
    ])
}

fn image(name: &str) -> Result<Vec<u8>, Failure> {
    let path = places::image(name);
    fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The static in which the application keeps what it knows from one frame to the next.
const NAVIGATION: &str = "5board10NAVIGATION";

/// Modules of the core whose functions and constants belong to the stage, and the bench's two functions that the compiler
/// inlines them into. Both ways of mangling put a name's length before it.
const MODULES: [(&str, &[&str]); 2] = [
    ("14plumbline_core", &["6reduce", "7rectify", "10homography", MAP]),
    ("18plumbline_firmware", &["5bench7rectify6reduce", "5bench7rectify8resample"]),
];

/// The situation's map, which takes in the making of the homography.
const MAP: &str = "8pipeline9situation9Situation10homography";

/// Whether a symbol is the stage's. Numeric constants without a name and libm's functions are not counted.
fn rectifies(symbol: &Symbol) -> bool {
    MODULES.iter().any(|(package, modules)| {
        let inside = symbol.name.split_once(package).map(|(_, inside)| inside);
        inside.is_some_and(|inside| modules.iter().any(|module| inside.starts_with(module)))
    })
}

#[cfg(test)]
mod tests {
    use super::rectifies;
    use crate::elf::Symbol;

    #[test]
    fn the_stage_is_told_by_its_modules() {
        let is = |name: &str| rectifies(&Symbol { name: name.into(), address: 0, size: 4, is_function: true });
        assert!(is("_ZN14plumbline_core7rectify12rectify_into17h0123456789abcdefE"));
        assert!(is("_RNvNtCs1_14plumbline_core7rectify12rectify_into"));
        assert!(is("_ZN18plumbline_firmware5bench7rectify8resample17h0123456789abcdefE"));
        assert!(is("_ZN14plumbline_core8pipeline9situation9Situation10homography17h0123456789abcdefE"));
        assert!(!is("_ZN14plumbline_core8matching11correlation6locate17h0123456789abcdefE"));
        assert!(!is("_ZN18plumbline_firmware5bench7rectify3run17h0123456789abcdefE"));
        assert!(!is("memset"));
    }
}
