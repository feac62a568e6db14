//! Counting between the markers.
//!
//! A *stretch* is a piece of a block of translated code without a marker inside: it is entered at its first instruction
//! and left after its last. What it costs by itself is known when it is translated; counting how often it is entered is
//! all that is left to do while the program runs, besides looking where it goes from there and at its loads.

use crate::cache::Cache;
use crate::decode::{Class, Instruction, Marker, NAMES};
use crate::model::Counts;
use std::collections::HashMap;

/// Number of a stretch.
pub type StretchId = usize;

#[derive(Clone, Copy, Debug)]
struct Stretch {
    begin: u32,
    /// One past its last byte.
    end: u32,
    counts: Counts,
    entered: u64,
    /// The last instruction's history, and whether that is a branch.
    branch: usize,
    ends_in_branch: bool,
}

/// Which way an instruction went the last time, and in which region that was.
#[derive(Clone, Copy, Debug, Default)]
struct History {
    region: u64,
    was_taken: bool,
}

/// The state of the count.
#[derive(Clone, Debug, Default)]
pub struct Regions {
    stretches: Vec<Stretch>,
    histories: Vec<History>,
    history_of: HashMap<u32, usize>,
    cache: Cache,
    /// The region's number from 1; what happened in it apart from the stretches' own counts.
    region: u64,
    is_open: bool,
    events: Counts,
    previous: Option<StretchId>,
}

impl Regions {
    /// Takes up a stretch: its instructions with their addresses, at least one.
    pub fn stretch(&mut self, instructions: &[(u32, Instruction)]) -> StretchId {
        let mut counts = Counts::default();
        for (_, instruction) in instructions {
            counts.add(instruction);
        }
        let (begin, _) = instructions[0];
        let (last, instruction) = instructions[instructions.len() - 1];
        let new = self.histories.len();
        let branch = *self.history_of.entry(last).or_insert(new);
        if branch == new {
            self.histories.push(History::default());
        }
        let ends_in_branch = instruction.class == Class::Branch;
        let end = last + instruction.bytes;
        self.stretches.push(Stretch { begin, end, counts, entered: 0, branch, ends_in_branch });
        self.stretches.len() - 1
    }

    /// A stretch is executed.
    pub fn enter(&mut self, id: StretchId) {
        if !self.is_open {
            return;
        }
        let stretch = &mut self.stretches[id];
        stretch.entered += 1;
        let begin = stretch.begin;
        if let Some(previous) = self.previous.replace(id) {
            self.leave(previous, begin);
        }
    }

    /// Where a stretch went on.
    fn leave(&mut self, id: StretchId, next: u32) {
        let stretch = &self.stretches[id];
        let was_taken = next != stretch.end;
        self.events.taken += u64::from(was_taken);
        if was_taken || stretch.ends_in_branch {
            let now = History { region: self.region, was_taken };
            let last = std::mem::replace(&mut self.histories[stretch.branch], now);
            self.events.flips += u64::from(last.region != now.region || last.was_taken != now.was_taken);
        }
    }

    /// `bytes` at `address` are read or written.
    pub fn access(&mut self, address: u32, bytes: u32, is_store: bool) {
        if self.is_open {
            // A pair of registers is two words, whether or not they are fetched at once.
            let is_misaligned = !address.is_multiple_of(bytes.min(4));
            self.events.misaligned_loads += u64::from(is_misaligned && !is_store);
            self.events.lines += self.cache.touch(address, bytes);
        }
    }

    /// A marker is executed; the region's line where it ends.
    ///
    /// # Errors
    /// A sentence where the markers do not come in turn.
    pub fn mark(&mut self, marker: Marker) -> Result<Option<String>, &'static str> {
        match (marker, self.is_open) {
            (Marker::Begin, true) => Err("a region begins inside another one"),
            (Marker::End, false) => Err("a region ends that has not begun"),
            (Marker::Begin, false) => {
                self.stretches.iter_mut().for_each(|stretch| stretch.entered = 0);
                self.cache.clear();
                (self.region, self.is_open, self.previous) = (self.region + 1, true, None);
                self.events = Counts::default();
                Ok(None)
            }
            (Marker::End, true) => {
                self.is_open = false;
                Ok(Some(self.line()))
            }
        }
    }

    /// What the region has cost so far.
    pub fn counts(&self) -> Counts {
        let mut counts = self.events;
        for stretch in &self.stretches {
            counts.add_times(&stretch.counts, stretch.entered);
        }
        counts
    }

    fn line(&self) -> String {
        let counts = self.counts();
        let sums = [self.region, counts.instructions(), counts.floor(), counts.serial(), counts.lines];
        let events = [counts.taken, counts.flips, counts.misaligned_loads, counts.narrow_stores];
        let numbers: Vec<String> =
            sums.iter().chain(&events).chain(&counts.classes).map(|number| number.to_string()).collect();
        numbers.join(",")
    }
}

/// Names of the line's columns.
pub fn header() -> String {
    format!("region,instructions,floor,serial,lines,taken,flips,misaligned_loads,narrow_stores,{}", NAMES.join(","))
}

#[cfg(test)]
mod tests {
    use super::{Regions, header};
    use crate::cache::EXTERNAL;
    use crate::decode::{Marker, decode};

    /// adds; and a loop at 0x102: subs, bne.
    fn program(regions: &mut Regions) -> [usize; 3] {
        let adds = decode(0x3001, 0);
        let bne = decode(0xd1fd, 0);
        let before = regions.stretch(&[(0x100, adds)]);
        let body = regions.stretch(&[(0x102, adds), (0x104, bne)]);
        let after = regions.stretch(&[(0x106, adds)]);
        [before, body, after]
    }

    fn run(regions: &mut Regions, ids: &[usize]) {
        ids.iter().for_each(|&id| regions.enter(id));
    }

    #[test]
    fn a_loop_is_counted_with_its_branches() {
        let mut regions = Regions::default();
        let [before, body, after] = program(&mut regions);
        run(&mut regions, &[before, body]);
        assert_eq!(regions.mark(Marker::Begin), Ok(None));
        run(&mut regions, &[before, body, body, body, after]);
        let counts = regions.counts();
        assert_eq!((counts.instructions(), counts.taken), (8, 2));
        // The first time it is met, and when it falls through.
        assert_eq!(counts.flips, 2);
        // 5 additions, 3 branches, 2 taken, 2 flips.
        assert_eq!(counts.serial(), 5 + 3 + 2 + 16);
        assert!(matches!(regions.mark(Marker::End), Ok(Some(line)) if line.starts_with("1,8,4,26,0,2,2,0,0,5,")));
        run(&mut regions, &[before]);
    }

    #[test]
    fn every_region_begins_anew() {
        let mut regions = Regions::default();
        let [before, body, _] = program(&mut regions);
        let mut region = || {
            regions.mark(Marker::Begin).expect("closed");
            // It ends as it began, which must not make it known to the next one.
            run(&mut regions, &[before, body, body]);
            regions.access(EXTERNAL.start, 4, false);
            regions.mark(Marker::End).expect("open").expect("a line")
        };
        let tail = |line: String| line.split_once(',').expect("numbers").1.to_owned();
        assert_eq!(tail(region()), tail(region()));
    }

    #[test]
    fn an_instruction_keeps_its_history_over_translations() {
        let mut regions = Regions::default();
        let [before, body, _] = program(&mut regions);
        let again = regions.stretch(&[(0x104, decode(0xd1fd, 0))]);
        regions.mark(Marker::Begin).expect("closed");
        run(&mut regions, &[before, body, body, again, body, body]);
        // Taken every time: only the first is new.
        assert_eq!(regions.counts().flips, 1);
    }

    #[test]
    fn misaligned_loads_count_and_stores_do_not() {
        let mut regions = Regions::default();
        regions.access(EXTERNAL.start, 4, false);
        regions.mark(Marker::Begin).expect("closed");
        regions.access(EXTERNAL.start + 2, 4, false);
        regions.access(EXTERNAL.start + 2, 4, true);
        regions.access(EXTERNAL.start + 2, 2, false);
        regions.access(EXTERNAL.start + 4, 8, false);
        regions.access(EXTERNAL.start + 3, 1, false);
        let counts = regions.counts();
        assert_eq!((counts.misaligned_loads, counts.lines), (1, 1));
    }

    #[test]
    fn markers_out_of_turn_are_refused() {
        let mut regions = Regions::default();
        assert!(regions.mark(Marker::End).is_err());
        assert!(regions.mark(Marker::Begin).is_ok());
        assert!(regions.mark(Marker::Begin).is_err());
        let line = regions.mark(Marker::End).expect("open").expect("a line");
        assert_eq!(line.split(',').count(), header().split(',').count());
    }
}
