//! The data cache of the STM32H743 before its external memory: 16 KiB, 4 ways, lines of 32 bytes, the least recently used
//! one replaced, allocated on reads and writes. What lies in tightly coupled memory goes past it.

/// Bytes of a line.
const LINE: u32 = 32;
const WAYS: usize = 4;
const SETS: usize = 16 * 1024 / (WAYS * LINE as usize);

/// External memory: where the emulated board has its PSRAM, which stands for the AXI SRAM and the flash of the real one.
pub const EXTERNAL: std::ops::Range<u32> = 0x6000_0000..0x6100_0000;

/// Which lines it holds.
#[derive(Clone, Debug)]
pub struct Cache {
    /// Lines of each set by their number, the last used one first.
    sets: Vec<[Option<u32>; WAYS]>,
}

impl Cache {
    /// Empty.
    pub fn new() -> Self {
        Cache { sets: vec![[None; WAYS]; SETS] }
    }

    /// Forgets all lines.
    pub fn clear(&mut self) {
        self.sets.fill([None; WAYS]);
    }

    /// Touches `bytes` from `address` on; the lines that had to be fetched.
    pub fn touch(&mut self, address: u32, bytes: u32) -> u64 {
        if !EXTERNAL.contains(&address) {
            return 0;
        }
        let (first, last) = (address / LINE, (address + bytes - 1) / LINE);
        (first..=last).map(|line| u64::from(!self.hits(line))).sum()
    }

    fn hits(&mut self, line: u32) -> bool {
        let set = &mut self.sets[line as usize % SETS];
        let found = set.iter().position(|way| *way == Some(line));
        // Moves it to the front, in the place of the last one if it was not there.
        set[..=found.unwrap_or(WAYS - 1)].rotate_right(1);
        set[0] = Some(line);
        found.is_some()
    }
}

impl Default for Cache {
    fn default() -> Self {
        Cache::new()
    }
}

#[cfg(test)]
mod tests {
    use super::{Cache, EXTERNAL};

    const BASE: u32 = EXTERNAL.start;
    /// Bytes between two addresses of the same set.
    const SAME_SET: u32 = 4096;

    #[test]
    fn a_line_is_fetched_once() {
        let mut cache = Cache::new();
        let misses: u64 = (0..64).map(|n| cache.touch(BASE + n, 1)).sum();
        assert_eq!(misses, 2);
        cache.clear();
        assert_eq!(cache.touch(BASE, 4), 1);
    }

    #[test]
    fn an_access_across_a_border_takes_two_lines() {
        let mut cache = Cache::new();
        assert_eq!(cache.touch(BASE + 30, 4), 2);
        assert_eq!(cache.touch(BASE + 30, 4), 0);
    }

    #[test]
    fn the_least_recently_used_of_four_goes() {
        let mut cache = Cache::new();
        for n in 0..4 {
            assert_eq!(cache.touch(BASE + n * SAME_SET, 4), 1);
        }
        assert_eq!(cache.touch(BASE, 4), 0);
        // The fifth takes the place of the second, the first having been used since.
        assert_eq!(cache.touch(BASE + 4 * SAME_SET, 4), 1);
        assert_eq!(cache.touch(BASE, 4), 0);
        assert_eq!(cache.touch(BASE + SAME_SET, 4), 1);
    }

    #[test]
    fn sixteen_kilobytes_fit_and_one_line_more_does_not() {
        let mut cache = Cache::new();
        let mut pass = |lines: u32| (0..lines).map(|n| cache.touch(BASE + 32 * n, 4)).sum::<u64>();
        assert_eq!([pass(512), pass(512)], [512, 0]);
        // Four ways of five lines in turn: none of them survives until it is wanted again.
        assert_eq!([pass(513), pass(513)], [1, 5]);
    }

    #[test]
    fn tightly_coupled_memory_is_not_cached() {
        assert_eq!(Cache::new().touch(0x2000_0000, 4), 0);
    }
}
