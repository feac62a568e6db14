//! Inputs that follow from a seed: every length of 0 to 31 with every kind of content.

/// Seeds of all lengths and kinds.
pub(super) const SEEDS: u32 = 32 * KINDS;
/// Kinds of content: half of them random.
const KINDS: u32 = 8;

/// Random numbers of one seed (xorshift of 32 bits, Marsaglia 2003).
#[derive(Debug)]
pub(super) struct Inputs {
    seed: u32,
    state: u32,
}

impl Inputs {
    #[inline]
    pub(super) fn new(seed: u32) -> Self {
        // Seeds that follow each other begin far apart (the golden ratio in 32 bits), none of them at 0.
        Inputs { seed, state: (seed + 1).wrapping_mul(0x9e37_79b9) }
    }

    /// The next random word.
    #[inline]
    pub(super) fn word(&mut self) -> u32 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 17;
        self.state ^= self.state << 5;
        self.state
    }

    /// A random number below `limit`.
    #[inline]
    pub(super) fn below(&mut self, limit: usize) -> usize {
        (self.word() >> 8) as usize % limit
    }

    /// A random number between -`most` and `most`.
    #[inline]
    pub(super) fn around_zero(&mut self, most: i32) -> i32 {
        self.below(2 * most as usize + 1) as i32 - most
    }

    /// This seed's length, 0 to 31.
    #[inline]
    pub(super) fn length(&self) -> usize {
        (self.seed / KINDS) as usize % 32
    }

    /// A byte of this seed's kind of content.
    #[inline]
    pub(super) fn byte(&mut self) -> u8 {
        let random = self.word().to_le_bytes()[2];
        match self.seed % KINDS {
            0 => 0,
            1 => 0xff,
            2 => 0x80,
            3 => [0, 0x7f, 0x80, 0xff][random as usize % 4],
            _ => random,
        }
    }

    /// Bytes of this seed's kind of content.
    #[inline]
    pub(super) fn bytes<const N: usize>(&mut self) -> Aligned<N> {
        Aligned(core::array::from_fn(|_| self.byte()))
    }

    /// A word of such bytes.
    #[inline]
    pub(super) fn four(&mut self) -> u32 {
        u32::from_le_bytes(core::array::from_fn(|_| self.byte()))
    }
}

/// Bytes that begin at a word of the memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(4))]
pub(super) struct Aligned<const N: usize>(pub(super) [u8; N]);
