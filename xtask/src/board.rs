//! The flight computer's images, proved from what the linker made: what lies where, how big, and that both profiles are
//! the same program.

pub mod check;
pub mod hot;
pub mod map;
pub mod probe;
pub mod rehearsal;
pub mod same;

use crate::elf::{self, Load, Section, Symbol};
use crate::{Failure, build, flight, places};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// An image as the linker made it.
#[derive(Clone, Debug)]
pub struct Image {
    /// Sections that occupy memory.
    pub sections: Vec<Section>,
    /// Functions and objects.
    pub symbols: Vec<Symbol>,
    /// What goes into flash.
    pub loads: Vec<Load>,
    /// The file.
    pub file: Vec<u8>,
}

impl Image {
    /// Reads an image's file.
    ///
    /// # Errors
    /// The file's name and what is wrong with it.
    pub fn read(path: &Path) -> Result<Image, Failure> {
        let named = |why: String| format!("{}: {why}", path.display());
        let file = fs::read(path).map_err(|error| named(error.to_string()))?;
        let sections = elf::sections(&file).map_err(named)?;
        let symbols = elf::symbols(&file).map_err(named)?;
        let loads = elf::loads(&file).map_err(named)?;
        Ok(Image { sections, symbols, loads, file })
    }

    /// The section of this name.
    pub fn section(&self, name: &str) -> Result<&Section, Failure> {
        self.sections.iter().find(|section| section.name == name).ok_or_else(|| format!("there is no section {name}"))
    }

    /// The address of this name.
    pub fn address(&self, name: &str) -> Result<u32, Failure> {
        let symbol = self.symbols.iter().find(|symbol| symbol.name == name);
        symbol.map(|symbol| symbol.address).ok_or_else(|| format!("there is no symbol {name}"))
    }
}

/// Checks both images, which have been built, and prints what they take. `flown`: the report of an emulated flight, whose
/// stack is the deepest known.
pub fn check(flown: Option<&Value>) -> Result<(), Failure> {
    let mut images = Vec::new();
    for (name, origin) in build::H743.iter().zip([map::APPLICATION, map::BANK_1]) {
        let image = Image::read(&places::image_h743(name))?;
        check::image(&image, origin).map_err(|why| format!("{name}: {why}"))?;
        images.push(image);
    }
    if let [behind, bare] = &images[..] {
        same::program(behind, bare)?;
        probe::agrees(
            &fs::read_to_string(places::root().join("memory.x")).map_err(|error| format!("memory.x: {error}"))?,
        )?;
        check::tell(behind, flown.map(|report| flight::number(report, "/ram_bytes") as u32))?;
    }
    Ok(())
}
