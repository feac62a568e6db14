//! Blocks in RAM between the application, which never waits, and a card, which sometimes does.

use super::block::{BLOCK, HEAD, Head, NONE, PAYLOAD, put_checksum, put_head};
use super::record::Record;
use postcard::ser_flavors::{Flavor, Size};
use postcard::serialize_with_flavor;

/// Bytes in front of each record: its length.
const LENGTH: usize = 2;
/// What a [`Record::Gap`] takes at most.
const GAP_MAX: usize = LENGTH + 6;

/// `N` blocks, which may lie in slow RAM: the newest is being filled, those before it wait to be written.
#[derive(Debug)]
pub struct BlockRing<'b, const N: usize> {
    blocks: &'b mut [[u8; BLOCK]; N],
    /// The oldest block.
    oldest: usize,
    /// Sealed blocks.
    sealed: usize,
    /// Payload bytes of the block that is being filled.
    used: usize,
    /// Where its first record begins.
    first: u16,
    log: u32,
    sequence: u32,
    /// Records dropped since the last gap was written, and since the start.
    lost: u32,
    lost_total: u32,
}

impl<'b, const N: usize> BlockRing<'b, N> {
    /// Free space that a loss waits for, half of all, so that what follows is a stretch and not a crumb.
    const AFTER_LOSS: usize = N * PAYLOAD / 2;

    /// An empty log of this number; what `blocks` held is written over.
    pub const fn new(log: u32, blocks: &'b mut [[u8; BLOCK]; N]) -> Self {
        BlockRing { blocks, oldest: 0, sealed: 0, used: 0, first: NONE, log, sequence: 0, lost: 0, lost_total: 0 }
    }

    /// Records dropped so far.
    pub fn lost_in_all(&self) -> u32 {
        self.lost_total
    }

    /// Whether the last record was dropped, so that others are until there is space again.
    pub fn is_losing(&self) -> bool {
        self.lost > 0
    }

    /// Payload bytes that still fit.
    pub fn free(&self) -> usize {
        ((N - self.sealed) * PAYLOAD).saturating_sub(self.used)
    }

    /// Appends a record, or counts it as lost. After a loss a record of it comes first.
    pub fn push(&mut self, record: &Record<'_>) {
        let Ok(size) = serialize_with_flavor(record, Size::default()) else { return self.lose() };
        let needed = if self.lost > 0 { (LENGTH + size + GAP_MAX).max(Self::AFTER_LOSS) } else { LENGTH + size };
        if size > u16::MAX as usize || needed > self.free() {
            return self.lose();
        }
        if self.lost > 0 {
            let gap = Record::Gap(core::mem::take(&mut self.lost));
            if let Ok(size) = serialize_with_flavor(&gap, Size::default()) {
                self.append(&gap, size);
            }
        }
        self.append(record, size);
    }

    fn lose(&mut self) {
        self.lost = self.lost.saturating_add(1);
        self.lost_total = self.lost_total.saturating_add(1);
    }

    /// For a record that fits.
    fn append(&mut self, record: &Record<'_>, size: usize) {
        if self.first == NONE {
            self.first = self.used as u16;
        }
        self.put(&(size as u16).to_le_bytes());
        // Cannot fail: `Into` takes everything.
        let _ = serialize_with_flavor(record, Into(self));
    }

    fn put(&mut self, bytes: &[u8]) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let index = (self.oldest + self.sealed) % N;
            let target = self.blocks.get_mut(index).and_then(|b| b.get_mut(HEAD + self.used..HEAD + PAYLOAD));
            let Some(target) = target else { return };
            let count = target.len().min(rest.len());
            let Some((now, later)) = rest.split_at_checked(count) else { return };
            target.iter_mut().zip(now).for_each(|(to, from)| *to = *from);
            rest = later;
            self.used += count;
            if self.used == PAYLOAD {
                self.seal();
            }
        }
    }

    /// Ends the block that is being filled, full or not; nothing where it is empty.
    pub fn seal(&mut self) {
        let index = (self.oldest + self.sealed) % N;
        let head = Head { used: self.used as u16, log: self.log, sequence: self.sequence, first: self.first };
        if let (1.., Some(block)) = (self.used, self.blocks.get_mut(index)) {
            let unused = block.get_mut(HEAD + self.used..).unwrap_or(&mut []);
            unused.fill(0);
            put_head(block, head);
            self.sealed += 1;
            self.sequence = self.sequence.wrapping_add(1);
            (self.used, self.first) = (0, NONE);
        }
    }

    /// Copies the oldest sealed blocks, as many as there are and `into` holds; how many. Their checksums are made here, by
    /// who writes them out: no frame pays for them.
    pub fn oldest(&self, into: &mut [[u8; BLOCK]]) -> usize {
        let count = self.sealed.min(into.len());
        let from = (0..count).filter_map(|k| self.blocks.get((self.oldest + k) % N));
        into.iter_mut().zip(from).for_each(|(to, from)| {
            *to = *from;
            put_checksum(to);
        });
        count
    }

    /// Frees the `count` oldest blocks: they have been written.
    pub fn release(&mut self, count: usize) {
        let count = count.min(self.sealed);
        self.oldest = (self.oldest + count) % N;
        self.sealed -= count;
    }
}

/// Postcard's way into the ring.
struct Into<'r, 'b, const N: usize>(&'r mut BlockRing<'b, N>);

impl<const N: usize> Flavor for Into<'_, '_, N> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.put(&[byte]);
        Ok(())
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.0.put(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}
