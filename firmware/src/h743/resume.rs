//! What outlives a reset beside the record of a fault: the time in signatures, and whether the autopilot was armed since
//! power-on. Words of the backup SRAM, which hold anything after power-on.

use crate::wire::signing::clock::SECOND;

/// Between two writes of the time at most, and as long again: what was signed meanwhile is not known. The board writes 40 times
/// a second, and its watchdog resets it after one. Chosen.
pub const MARGIN: u64 = 2 * SECOND;

/// Words of the time.
pub const WORDS: usize = 4;
const STAMP: u32 = 0x504c_5354;
const ARMED: u32 = 0x504c_4152;

/// The time, as it is kept.
pub fn stamp_words(stamp: u64) -> [u32; WORDS] {
    let (low, high) = (stamp as u32, (stamp >> 32) as u32);
    [STAMP, low, high, !(STAMP ^ low ^ high.rotate_left(16))]
}

/// The time that is kept in these words, if they hold one.
pub fn stamp_of(words: &[u32; WORDS]) -> Option<u64> {
    let [_, low, high, _] = *words;
    let stamp = u64::from(high) << 32 | u64::from(low);
    (*words == stamp_words(stamp)).then_some(stamp)
}

/// Where the time goes on: behind what the backup SRAM holds after a reset, else at the bound in flash.
pub fn resumed(kept: Option<u64>, bound: u64) -> u64 {
    kept.map_or(bound, |stamp| stamp.saturating_add(MARGIN))
}

/// Whether the autopilot was armed, as it is kept.
pub fn armed_words(was_armed: bool) -> [u32; 2] {
    if was_armed { [ARMED, !ARMED] } else { [0, 0] }
}

/// Whether the autopilot was armed. Words that were never written say no: they are what power-on leaves.
pub fn was_armed(words: [u32; 2]) -> bool {
    words == armed_words(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_comes_back_and_damaged_words_are_none() {
        for stamp in [0, 1, 34_715_520_000_000, (1 << 48) - 1] {
            let words = stamp_words(stamp);
            assert_eq!(stamp_of(&words), Some(stamp));
            for bit in 0..32 * WORDS {
                let mut damaged = words;
                damaged[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(stamp_of(&damaged), None, "bit {bit}");
            }
        }
        assert_eq!((stamp_of(&[0; WORDS]), stamp_of(&[u32::MAX; WORDS])), (None, None));
    }

    #[test]
    fn the_time_goes_on_behind_what_was_kept_or_at_the_bound() {
        assert_eq!(resumed(None, 77), 77);
        assert_eq!(resumed(Some(50), 77), 50 + MARGIN);
        assert_eq!(resumed(Some(u64::MAX), 0), u64::MAX);
    }

    #[test]
    fn that_the_autopilot_was_armed_is_kept_and_taken_from_nothing_else() {
        let armed = armed_words(true);
        assert!(was_armed(armed) && !was_armed(armed_words(false)));
        for other in [[armed[0], 0], [0, armed[1]], [u32::MAX; 2], [armed[0]; 2]] {
            assert!(!was_armed(other));
        }
    }
}
