//! That memory.x agrees, region by region, with what the debug probe's software knows of the chip.

use crate::Failure;

/// Name, first address and end of the chip's own memories in probe-rs 0.32.0: the addresses as `probe-rs chip info
/// STM32H743VITx` prints them, the names, which it does not print, from its target description `STM32H7_Series.yaml`,
/// variant STM32H743VI. It also prints three windows of external flash (0x6000_0000, 0x9000_0000, 0xa000_0000), which this
/// board has not.
pub const PROBE_RS: [(&str, u32, u32); 9] = [
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

/// Our names for them: one of ours may be several of theirs. The backup SRAM is ours alone: probe-rs has no name for it.
const NAMES: [(&str, &[&str]); 7] = [
    ("ITCM", &["ITCM"]),
    ("RAM", &["DTCM"]),
    ("AXISRAM", &["AXISRAM"]),
    ("SRAM123", &["SRAM1", "SRAM2", "SRAM3"]),
    ("SRAM4", &["SRAM4"]),
    ("FLASH", &["BANK_1"]),
    ("MISSION", &["BANK_2"]),
];
const UNKNOWN_TO_PROBE_RS: &str = "BACKUP";

/// Compares the text of memory.x. Flash begins at `_flash_origin`, which the bare profile sets to the bank's start.
///
/// # Errors
/// The region that differs.
pub fn agrees(memory_x: &str) -> Result<(), Failure> {
    let ours = regions(memory_x)?;
    for (name, theirs) in NAMES {
        let ours = ours.iter().find(|(n, ..)| n == name).ok_or_else(|| format!("memory.x has no region {name}"))?;
        let (start, end) = (ours.1, ours.2);
        let known = |n: &&str| PROBE_RS.iter().find(|(known, ..)| known == n);
        let first = theirs.first().and_then(known).map_or(0, |(_, start, _)| *start);
        let last = theirs.last().and_then(known).map_or(0, |(_, _, end)| *end);
        if (start, end) != (first, last) {
            return Err(format!(
                "memory.x has {name} at {start:#010x}..{end:#010x}, probe-rs at {first:#010x}..{last:#010x}"
            ));
        }
    }
    let stranger = |name: &str| name != UNKNOWN_TO_PROBE_RS && !NAMES.iter().any(|(known, _)| *known == name);
    match ours.iter().find(|(name, ..)| stranger(name)) {
        Some((name, ..)) => Err(format!("memory.x has a region {name} that probe-rs does not know")),
        None => Ok(()),
    }
}

/// Name, start and end of each region.
fn regions(memory_x: &str) -> Result<Vec<(String, u32, u32)>, Failure> {
    let mut regions = Vec::new();
    for line in memory_x.lines() {
        let Some((name, rest)) = line.split_once(" : ORIGIN = ") else { continue };
        let wrong = || format!("memory.x has a region that is not understood: {line}");
        let (origin, length) = rest.split_once(", LENGTH = ").ok_or_else(wrong)?;
        let start = value(origin).ok_or_else(wrong)?;
        let length = match length.split_once(" - ") {
            Some((end, origin)) => value(end).zip(value(origin)).map(|(end, origin)| end - origin),
            None => value(length),
        };
        regions.push((name.trim().to_owned(), start, start + length.ok_or_else(wrong)?));
    }
    Ok(regions)
}

/// A number of a linker script.
fn value(text: &str) -> Option<u32> {
    let text = text.trim();
    if text == "_flash_origin" {
        return Some(super::map::BANK_1);
    }
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
            ("0x08100000 -", "0x08120000 -"),
            ("  SRAM4 :", "  SRAM5 :"),
        ] {
            let changed = ours.replace(from, to);
            assert!(changed != ours && agrees(&changed).is_err(), "{from}");
        }
    }
}
