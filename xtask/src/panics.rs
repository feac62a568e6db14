//! That nothing in a frame's way can panic: which functions of an image can reach its panic handler.
//!
//! Every panic ends in `rust_begin_unwind`. From there the branches of the machine code are followed backwards, as far
//! as direct calls go, so what remains is the set of functions that may panic, themselves or by what they call. Whoever is
//! in it must be named here with the reason.

use super::elf::{self, Function};
use super::thumb::branches;
use super::{Failure, places};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Where every panic ends.
const HANDLER: &str = "rust_begin_unwind";

/// Not panics that can happen: the states of a finished future, which `.await` and the executor never poll again. The
/// compiler writes this branch into every async function.
const UNREACHABLE: &str = "panic_const_async_fn_resumed";

/// Who may panic, and why that is no frame's business: symbols as they are, and parts of mangled ones.
const ALLOWED: [(&str, &str); 5] = [
    ("Reset", "start-up: calls main"),
    ("main", "boot: each task and buffer is taken once, before the first frame"),
    ("_HardFault", "calls the next"),
    ("HardFault", "tells of the fault, then ends"),
    ("DefaultHandler", "tells of an interrupt without a handler, then ends"),
];
const ALLOWED_PARTS: [(&str, &str); 5] = [
    ("4core", "the library's own panics: who calls them is in these lists or is not"),
    ("__cortex_m_rt_", "the bodies of the above"),
    ("5board4boot", "boot"),
    ("_defmt_", "the emulator's log, which no flight computer has"),
    ("semihosting", "the emulator's console"),
];

/// Who of ours may panic on the flight computer, by parts of mangled names, and by what. Its code is made small, so that the
/// compiler does not prove postcard's bounds away as it does on the emulated board.
const ALLOWED_H743: [(&str, &str); 22] = [
    ("4chip5start", "start-up: drivers' settings"),
    ("4chip6clocks", "start-up: drivers' settings"),
    ("6timing4Plan", "start-up: dividers"),
    ("4chip4boot4boot", "start-up: each buffer is taken once"),
    ("4chip7logging3log", "start-up: the log's first record, by postcard"),
    ("4chip5tasks", "start-up: a driver is dropped where its task cannot be spawned"),
    ("chip..simulator..Board", "the simulator's boot: each buffer is taken once"),
    ("4chip6sensor", "embassy's I2C, before the first frame and between frames"),
    ("7mt9v0347Setting", "before the first frame: divides by a clock"),
    ("4chip7capture5until", "embassy's alarm, beyond the end of its time"),
    ("chip..capture..CaptureTimer", "calls the last"),
    ("chip..port..", "embassy's serial port with its DMA"),
    ("chip..usb..", "embassy's USB"),
    ("4chip4card", "embassy's alarm"),
    ("chip..card..", "calls the last"),
    ("3log4card", "calls the last"),
    ("3log10block_ring", "postcard's numbers; in flight only with a card"),
    ("3log7journal", "calls the last"),
    ("8outgoing6tunnel", "postcard's numbers"),
    ("6serial", "postcard's numbers, and borrowed cells; in the simulator's mode only"),
    ("..log..", "calls the log's ring"),
    ("drop_in_place$LT$", "drivers: what ends with them"),
];

/// Checks the emulated board's image, and tells: nothing but boot and the emulator's console may panic.
pub fn emulated() -> Result<(), Failure> {
    tell("an500", None, "none of them in a frame's way")
}

/// Checks the flight computer's image, and tells. Its tasks hold drivers of others, which check by panics, and it restarts
/// when one happens; there all that bears our name is held to its list. The polls of its tasks bear the executor's.
pub fn flight_computer() -> Result<(), Failure> {
    tell("h743-dfu", Some(OWN), "of ours start-up and what wraps drivers or postcard alone")
}

fn tell(board: &str, own: Option<(&str, &[(&str, &str)])>, whose: &str) -> Result<(), Failure> {
    let (all, some) = check(board, own)?;
    println!("{board}: {some} of {all} functions may panic, {whose}");
    Ok(())
}

/// Ours: a part of mangled names, and who may.
const OWN: (&str, &[(&str, &str)]) = ("plumbline_", &ALLOWED_H743);

/// Checks the image of a board, where `own` is given only functions with that part in their names, of which some may; how many
/// functions there are, and how many of them may panic.
fn check(board: &str, own: Option<(&str, &[(&str, &str)])>) -> Result<(usize, usize), Failure> {
    let path = if board.starts_with("h743") { places::image_h743(board) } else { places::image(board) };
    let file = fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let functions = elf::functions(&file).map_err(|why| format!("{}: {why}", path.display()))?;
    if !functions.iter().any(|function| function.name.contains(HANDLER)) {
        return Err(format!("{}: there is no panic handler to be found", path.display()));
    }
    let panicking = panicking(&functions);
    let others = match own {
        None => others(&panicking, "", &ALLOWED_PARTS),
        Some((part, allowed)) => {
            // A reason that nobody needs any more would hide the next who does.
            let is_needed = |(name, _): &&(&str, &str)| panicking.iter().flatten().any(|other| other.contains(name));
            if let Some((name, _)) = allowed.iter().find(|entry| !is_needed(entry)) {
                return Err(format!(
                    "{board}: no function with {name} in its name may panic any more: take it off the list"
                ));
            }
            others(&panicking, part, allowed)
        }
    };
    match others.as_slice() {
        [] => Ok((functions.len(), panicking.len())),
        _ => Err(format!("{board}: these may panic: {}", others.join(", "))),
    }
}

/// Those with `part` in a name that are not allowed to. Several names may stand for the same code: handlers that nobody wrote
/// are all the default one.
fn others(panicking: &[Vec<String>], part: &str, allowed: &[(&str, &str)]) -> Vec<String> {
    let is_allowed = |name: &String| {
        let is_part = |(part, _): &(&str, &str)| name.contains(part);
        name.contains(HANDLER) || ALLOWED.iter().any(|(whole, _)| name == whole) || allowed.iter().any(is_part)
    };
    panicking
        .iter()
        .filter(|names| !names.iter().any(is_allowed) && names.iter().any(|name| name.contains(part)))
        .map(|names| names.join(" = "))
        .collect()
}

/// The functions from which branches lead to the panic handler, all names of each.
fn panicking(functions: &[Function]) -> Vec<Vec<String>> {
    let starts: BTreeMap<u32, &Function> = functions.iter().map(|function| (function.address, function)).collect();
    let at = |address: u32| {
        let (_, function) = starts.range(..=address).next_back()?;
        (address < function.address + function.size.max(1)).then_some(*function)
    };
    // Callers of each function, by its address.
    let mut callers: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for function in functions {
        for (base, code) in &function.code {
            for (_, target) in branches(*base, code) {
                if let Some(called) = at(target).filter(|called| called.address != function.address) {
                    callers.entry(called.address).or_default().insert(function.address);
                }
            }
        }
    }
    let mut found: BTreeSet<u32> = BTreeSet::new();
    let mut next: Vec<u32> =
        functions.iter().filter(|function| function.name.contains(HANDLER)).map(|function| function.address).collect();
    // The linker's own steps to what is too far for a branch; their target stands in their name.
    for function in functions {
        let target = function.name.strip_prefix("__Thumbv7ABSLongThunk_");
        if let Some(called) = target.and_then(|name| functions.iter().find(|function| function.name == name)) {
            callers.entry(called.address).or_default().insert(function.address);
        }
    }
    while let Some(address) = next.pop() {
        let is_reachable = starts.get(&address).is_some_and(|function| !function.name.contains(UNREACHABLE));
        if is_reachable && found.insert(address) {
            next.extend(callers.get(&address).into_iter().flatten());
        }
    }
    let names = |address: &u32| {
        let same = functions.iter().filter(|function| function.address == *address);
        same.map(|function| function.name.clone()).collect()
    };
    found.iter().map(names).collect()
}

#[cfg(test)]
mod tests {
    use super::{others, panicking};
    use crate::elf::Function;

    /// A function that calls (BL) another one, `offset` bytes from its start.
    fn calls(name: &str, address: u32, target: Option<u32>) -> Function {
        let code = target.map_or(vec![0x70, 0x47, 0x00, 0xbf], |target| {
            let half = target.wrapping_sub(address + 4) >> 1;
            let (high, low) =
                (0xf000 | (half >> 11 & 0x3ff) | ((target < address) as u32 * 0x400), 0xf800 | (half & 0x7ff));
            [high as u16, low as u16].iter().flat_map(|word| word.to_le_bytes()).collect()
        });
        Function { name: name.into(), address, size: 4, code: vec![(address, code)] }
    }

    #[test]
    fn ours_are_held_to_their_list() {
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let all = [names(&["rust_begin_unwind"]), names(&["ours_a"]), names(&["theirs", "ours_b"]), names(&["theirs"])];
        assert_eq!(others(&all, "ours", &[]), ["ours_a", "theirs = ours_b"]);
        assert_eq!(others(&all, "ours", &[("_a", "")]), ["theirs = ours_b"]);
        assert_eq!(others(&all, "", &[("ours", "")]), ["theirs"]);
    }

    #[test]
    fn callers_of_callers_are_found_and_others_are_not() {
        let functions = [
            calls("rust_begin_unwind", 0x100, None),
            calls("a", 0x104, Some(0x100)),
            calls("b", 0x108, Some(0x104)),
            calls("quiet", 0x10c, None),
            calls("calls_quiet", 0x110, Some(0x10c)),
            calls("panic_const_async_fn_resumed", 0x114, Some(0x104)),
            calls("task", 0x118, Some(0x114)),
        ];
        assert_eq!(panicking(&functions), [["rust_begin_unwind"], ["a"], ["b"]]);
    }
}
