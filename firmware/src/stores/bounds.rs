//! How far the time in signatures has been reserved: records behind each other in a sector of flash that is erased no more.
//!
//! Nothing is signed or taken with a time at or beyond the newest bound, and after a lost power the time begins at it: so it never
//! goes back. A record is a word of flash, little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 0..4 | magic `PLBS` |
//! | 4..12 | u64: the bound, units of 10 us since 2015-01-01 |
//! | 12..28 | zeros |
//! | 28..32 | CRC-32 (ISO-HDLC) of bytes 0..28 |
//!
//! A word is written once. One whose writing lost its power may read as anything, or not at all; it is passed over, and so is
//! whatever else lies there.

use super::framing::checksum;
use crate::wire::signing::clock::SECOND;

/// Bytes of a word of the STM32H7's flash.
pub const WORD: usize = 32;
/// So far each record reserves: ten minutes. Less would wear more, and more would put the time further ahead at the next
/// start, where others that are new must not be more than a minute behind. Chosen.
pub const AHEAD: u64 = 600 * SECOND;
/// Words that may fail behind each other before a record is given up.
const TRIES: usize = 4;
const MAGIC: [u8; 4] = *b"PLBS";
const CHECKED: usize = WORD - 4;

/// Words of flash.
pub trait Area {
    /// How many.
    fn words(&self) -> usize;
    /// Reads one; nothing where its check bits say that it cannot be read.
    fn read(&self, index: usize) -> Option<[u8; WORD]>;
    /// Writes an erased one. Whether it took is found by reading.
    fn write(&mut self, index: usize, word: &[u8; WORD]);
}

/// What an area holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The farthest bound; 0 where there is none.
    bound: u64,
    /// The first word that nothing lies behind.
    free: usize,
}

impl Bounds {
    /// Reads an area. Anything may lie there.
    pub fn read(area: &impl Area) -> Self {
        let mut bounds = Bounds { bound: 0, free: 0 };
        for index in 0..area.words() {
            let word = area.read(index);
            if word != Some([0xff; WORD]) {
                bounds.free = index + 1;
            }
            bounds.bound = bounds.bound.max(word.and_then(|word| decode(&word)).unwrap_or(0));
        }
        bounds
    }

    /// The farthest bound; 0 where there is none.
    pub fn bound(&self) -> u64 {
        self.bound
    }

    /// Reserves until [`AHEAD`] of `stamp`, where it is not reserved yet; whether `stamp` is now.
    pub fn reserve(&mut self, area: &mut impl Area, stamp: u64) -> bool {
        let word = encode(stamp.saturating_add(AHEAD));
        for _ in 0..TRIES {
            if stamp < self.bound || self.free >= area.words() {
                break;
            }
            area.write(self.free, &word);
            if area.read(self.free) == Some(word) {
                self.bound = stamp.saturating_add(AHEAD);
            }
            self.free += 1;
        }
        stamp < self.bound
    }
}

fn encode(bound: u64) -> [u8; WORD] {
    let mut word = [0; WORD];
    word.iter_mut().zip(MAGIC.into_iter().chain(bound.to_le_bytes())).for_each(|(to, from)| *to = from);
    let (checked, own) = word.split_at_mut(CHECKED);
    own.copy_from_slice(&checksum(checked).to_le_bytes());
    word
}

fn decode(word: &[u8; WORD]) -> Option<u64> {
    let bound = word.strip_prefix(&MAGIC)?.first_chunk().copied().map(u64::from_le_bytes)?;
    (encode(bound) == *word).then_some(bound)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{AHEAD, Area, Bounds, WORD};
    use std::vec;
    use std::vec::Vec;

    /// Flash whose power is cut while so many words are left to be written: of the word then, any part may be there, and it may
    /// not be readable.
    struct Flash {
        words: Vec<Option<[u8; WORD]>>,
        until_cut: usize,
        torn: Option<[u8; WORD]>,
    }

    impl Area for Flash {
        fn words(&self) -> usize {
            self.words.len()
        }

        fn read(&self, index: usize) -> Option<[u8; WORD]> {
            self.words[index]
        }

        fn write(&mut self, index: usize, word: &[u8; WORD]) {
            assert_eq!(self.words[index], Some([0xff; WORD]), "a word is written once");
            match self.until_cut {
                0 => {}
                1 => self.words[index] = self.torn,
                _ => self.words[index] = Some(*word),
            }
            self.until_cut = self.until_cut.saturating_sub(1);
        }
    }

    fn flash(words: usize) -> Flash {
        Flash { words: vec![Some([0xff; WORD]); words], until_cut: usize::MAX, torn: None }
    }

    /// What may be in a word whose writing lost its power.
    fn torn() -> Vec<Option<[u8; WORD]>> {
        let whole = super::encode(12_345_678_901 + AHEAD);
        let half = |from: usize| core::array::from_fn(|at| if at < from { whole[at] } else { 0xff });
        let mixed = core::array::from_fn(|at| whole[at] | (at as u8).wrapping_mul(37));
        let mut all: Vec<_> = (0..=WORD).map(|from| Some(half(from))).collect();
        all.extend([None, Some(mixed), Some([0; WORD])]);
        all
    }

    #[test]
    fn it_reserves_once_for_ten_minutes_and_is_read_back() {
        let mut flash = flash(16);
        let mut bounds = Bounds::read(&flash);
        assert_eq!(bounds.bound(), 0);
        assert!(bounds.reserve(&mut flash, 1000) && bounds.bound() == 1000 + AHEAD);
        assert!(bounds.reserve(&mut flash, 999 + AHEAD));
        assert_eq!(flash.words.iter().filter(|word| **word != Some([0xff; WORD])).count(), 1);
        assert!(bounds.reserve(&mut flash, 1000 + AHEAD));
        assert_eq!(Bounds::read(&flash), bounds);
        assert_eq!(bounds.bound(), 1000 + 2 * AHEAD);
    }

    #[test]
    fn a_power_that_is_lost_at_any_write_takes_nothing_back() {
        for cut in 1..6 {
            for torn in torn() {
                let mut flash = Flash { until_cut: cut, torn, ..flash(64) };
                let mut bounds = Bounds::read(&flash);
                // What was used last before the power went: a stamp is used when it is reserved.
                let (mut used, mut stamp) = (0, 12_345_678_901);
                while flash.until_cut > 0 {
                    let is_reserved = bounds.reserve(&mut flash, stamp);
                    // The cut is behind the write: nothing is used of what was being written.
                    if flash.until_cut > 0 && is_reserved {
                        used = stamp;
                    }
                    stamp += AHEAD / 3;
                }
                flash.until_cut = usize::MAX;
                let mut bounds = Bounds::read(&flash);
                assert!(bounds.bound() > used || used == 0, "cut at {cut}: {} after {used}", bounds.bound());
                let next = bounds.bound().max(stamp);
                assert!(bounds.reserve(&mut flash, next), "it goes on");
                assert_eq!(Bounds::read(&flash).bound(), next + AHEAD);
            }
        }
    }

    #[test]
    fn a_full_area_and_one_that_does_not_take_reserve_nothing_and_forget_nothing() {
        let mut full = flash(3);
        let mut bounds = Bounds::read(&full);
        for record in 0..3 {
            assert!(bounds.reserve(&mut full, record * AHEAD));
        }
        assert!(bounds.reserve(&mut full, 3 * AHEAD - 1) && !bounds.reserve(&mut full, 3 * AHEAD));
        assert_eq!(Bounds::read(&full).bound(), 3 * AHEAD);
        let mut dead = Flash { until_cut: 0, ..flash(8) };
        let mut bounds = Bounds::read(&dead);
        assert!(!bounds.reserve(&mut dead, 5));
        assert_eq!(bounds.bound(), 0);
    }

    #[test]
    fn words_that_fail_are_passed_over_and_garbage_is_no_record() {
        let mut flash = flash(8);
        (flash.until_cut, flash.torn) = (1, None);
        flash.words[0] = Some([0x5a; WORD]);
        let mut bounds = Bounds::read(&flash);
        assert!(!bounds.reserve(&mut flash, 7));
        flash.until_cut = usize::MAX;
        assert_eq!(Bounds::read(&flash).bound(), 0);
        let mut bounds = Bounds::read(&flash);
        assert!(bounds.reserve(&mut flash, 7));
        for bit in 0..WORD * 8 {
            let mut word = super::encode(99);
            word[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(super::decode(&word), None);
        }
    }
}
