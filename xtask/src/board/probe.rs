//! The regions of memory.x, and that they agree with what the debug probe's software knows of the chip.

use crate::{Failure, places};
use std::fs;
use std::ops::Range;

/// Name, first address and end of the chip's own memories in probe-rs 0.32.0: the addresses as `probe-rs chip info
/// STM32H743VITx` prints them, the names, which it does not print, from its target description `STM32H7_Series.yaml`,
/// variant STM32H743VI. It also prints three windows of external flash (0x6000_0000, 0x9000_0000, 0xa000_0000), which this
/// board has not.
const PROBE_RS: [Region<'static>; 9] = [
    ("ITCM", 0x0000_0000, 0x0001_0000),
    ("BANK_1", 0x0800_0000, 0x0810_0000),
    ("BANK_2", 0x0810_0000, 0x0820_0000),
    ("DTCM", 0x2000_0000, 0x2002_0000),
    ("AXISRAM", 0x2400_0000, 0x2408_0000),
    ("SRAM1", 0x3000_0000, 0x3002_0000),
    ("SRAM2", 0x3002_0000, 0x3004_0000),
    ("SRAM3", 0x3004_0000, 0x3004_8000),
    ("SRAM4", 0x3800_0000, 0x3801_0000),
];

/// Our names for them, and theirs, in the order of addresses. The backup SRAM is ours alone: probe-rs has no name for it.
const NAMES: [(&[&str], &[&str]); 7] = [
    (&["ITCM"], &["ITCM"]),
    (&["RAM"], &["DTCM"]),
    (&["AXISRAM"], &["AXISRAM"]),
    (&["SRAM123"], &["SRAM1", "SRAM2", "SRAM3"]),
    (&["SRAM4"], &["SRAM4"]),
    (&["FLASH"], &["BANK_1"]),
    (&["CONFIGURATION", "KEY", "PLAN", "TILES", "STAMPS"], &["BANK_2"]),
];
const UNKNOWN_TO_PROBE_RS: &str = "BACKUP";

/// A region's name, first address and end.
type Region<'a> = (&'a str, u32, u32);

/// Where memory.x has a region.
///
/// # Errors
/// That it has none, or cannot be read.
pub fn region(name: &str) -> Result<Range<u32>, Failure> {
    let memory_x = fs::read_to_string(places::root().join("memory.x")).map_err(|error| format!("memory.x: {error}"))?;
    span(&regions(&memory_x)?, &[name])
}

/// Compares the text of memory.x.
///
/// # Errors
/// The region that differs.
pub fn agrees(memory_x: &str) -> Result<(), Failure> {
    let ours = regions(memory_x)?;
    for (names, theirs) in NAMES {
        let (ours, theirs) = (span(&ours, names)?, span(&PROBE_RS, theirs)?);
        if ours != theirs {
            return Err(format!("memory.x has {} at {ours:#010x?}, probe-rs at {theirs:#010x?}", names.join(", ")));
        }
    }
    let stranger = |name: &str| name != UNKNOWN_TO_PROBE_RS && !NAMES.iter().any(|(known, _)| known.contains(&name));
    match ours.iter().find(|(name, ..)| stranger(name)) {
        Some((name, ..)) => Err(format!("memory.x has a region {name} that probe-rs does not know")),
        None => Ok(()),
    }
}

/// What regions take together, each of which begins where the one before ends.
fn span(regions: &[Region<'_>], names: &[&str]) -> Result<Range<u32>, Failure> {
    let mut all: Option<Range<u32>> = None;
    for name in names {
        let found = regions.iter().find(|(known, ..)| known == name);
        let (_, start, end) = *found.ok_or_else(|| format!("memory.x has no region {name}"))?;
        if all.as_ref().is_some_and(|all| all.end != start) {
            return Err(format!("memory.x has a gap, or two regions at one address, before {name}"));
        }
        all = Some(all.map_or(start, |all| all.start)..end);
    }
    all.ok_or_else(|| "no region was named".into())
}

/// The regions of an image that does not lie behind the camera's bootloader.
fn regions(memory_x: &str) -> Result<Vec<Region<'_>>, Failure> {
    let mut regions = Vec::new();
    for line in memory_x.lines() {
        let Some((name, rest)) = line.split_once(" : ORIGIN = ") else { continue };
        let bounds = rest.split_once(", LENGTH = ").and_then(|(start, length)| value(start).zip(value(length)));
        let (start, length) = bounds.ok_or_else(|| format!("memory.x has a region that is not understood: {line}"))?;
        regions.push((name.trim(), start, start + length));
    }
    Ok(regions)
}

/// A number of a linker script, without what lying behind the bootloader adds to it or takes away.
fn value(text: &str) -> Option<u32> {
    let text = text.split(['+', '-']).next()?.trim();
    let scaled = |digits: &str, by: u32| digits.parse().ok().and_then(|n: u32| n.checked_mul(by));
    match (text.strip_prefix("0x"), text.strip_suffix('K'), text.strip_suffix('M')) {
        (Some(hex), ..) => u32::from_str_radix(hex, 16).ok(),
        (_, Some(kilo), _) => scaled(kilo, 1024),
        (.., Some(mega)) => scaled(mega, 1024 * 1024),
        _ => text.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::agrees;

    #[test]
    fn memory_x_agrees_and_every_change_of_it_does_not() {
        let ours = std::fs::read_to_string(crate::places::root().join("memory.x")).unwrap();
        assert_eq!(agrees(&ours), Ok(()));
        for (from, to) in [
            ("= 64K", "= 32K"),
            ("128K", "256K"),
            ("0x24000000", "0x24010000"),
            ("288K", "280K"),
            ("1M", "2M"),
            ("0x08110000", "0x08118000"),
            ("768K", "900K"),
            ("0x0810e000", "0x0810f000"),
            ("56K", "64K"),
            ("0x08000000 +", "0x08020000 +"),
            ("  SRAM4 :", "  SRAM5 :"),
        ] {
            let changed = ours.replace(from, to);
            assert!(changed != ours && agrees(&changed).is_err(), "{from}");
        }
    }
}
