//! Where the camera's DMA stands in the ring of rows, by arithmetic: which rows are there, and whether they still are.
//!
//! The controller reports how many words are left of the lap it is on, never which lap; the camera interface reports each row's
//! end by an interrupt, which may come late. Together they give the position since the frame began: the count nearest to
//! the rows counted that agrees with what is left. That holds while the interrupt is less than half a ring late.

use core::num::NonZeroU32;

/// A ring of `rows` rows of `row_bytes` bytes, a multiple of four. What is divided by is not zero by its type, so that no
/// division can panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowRing {
    row_bytes: u32,
    rows: NonZeroU32,
    /// Bytes of a lap.
    lap: NonZeroU32,
}

impl RowRing {
    /// `None` where rows are no whole words, or the ring is larger than a counter of 16 bits holds.
    pub fn new(row_bytes: u16, rows: u16) -> Option<RowRing> {
        let (row_bytes, rows) = (row_bytes as u32, rows as u32);
        let fits = row_bytes > 0 && row_bytes.is_multiple_of(4) && rows >= 4 && row_bytes * rows / 4 <= u16::MAX as u32;
        let (rows, lap) = (NonZeroU32::new(rows)?, NonZeroU32::new(row_bytes * rows)?);
        fits.then_some(RowRing { row_bytes, rows, lap })
    }

    /// Words of a lap: what the controller counts down from.
    pub fn words(&self) -> u16 {
        (self.lap.get() / 4) as u16
    }

    /// Bytes written since the frame began, from the words left of this lap and the rows that have ended.
    pub fn written(&self, words_left: u16, rows_ended: u32) -> u32 {
        let lap = self.lap.get();
        let at = lap.saturating_sub(words_left as u32 * 4) % self.lap;
        let expected = rows_ended * self.row_bytes;
        let behind = (expected % self.lap + lap - at) % self.lap;
        // Behind what was counted by less than half a ring, or ahead of it by the rest.
        if behind <= lap / 2 { expected.saturating_sub(behind) } else { expected + (lap - behind) }
    }

    /// Whether rows up to `end` (not included) are whole.
    pub fn has(&self, end: u32, written: u32) -> bool {
        written >= end * self.row_bytes
    }

    /// Whether row `first` and those after it have not been overwritten. The controller's own buffer may be ahead of its
    /// count, so the last row before the overwriting counts as lost.
    pub fn holds(&self, first: u32, written: u32) -> bool {
        written <= (first + self.rows.get() - 1) * self.row_bytes
    }

    /// Where row `row` begins in the ring, bytes; and how many rows from it on follow each other before the ring's end.
    pub fn slot(&self, row: u32) -> (u32, u32) {
        let slot = row % self.rows;
        (slot * self.row_bytes, self.rows.get() - slot)
    }

    /// Bytes of a row.
    pub fn row_bytes(&self) -> u32 {
        self.row_bytes
    }

    /// Most rows that may be asked for at once: what arrives meanwhile must not overwrite them.
    pub fn rows_at_once(&self) -> u32 {
        self.rows.get() / 2
    }
}

#[cfg(test)]
mod tests {
    use super::RowRing;

    /// The controller after `bytes`: the words left of its lap, reloaded when they reach none.
    fn words_left(ring: &RowRing, bytes: u32) -> u16 {
        ring.words() - (bytes / 4 % ring.words() as u32) as u16
    }

    #[test]
    fn the_position_is_found_from_a_count_up_to_half_a_ring_late() {
        let ring = RowRing::new(512, 32).unwrap();
        for bytes in (0..480 * 512).step_by(4) {
            for late in 0..15 {
                let ended = (bytes / 512u32).saturating_sub(late);
                assert_eq!(ring.written(words_left(&ring, bytes), ended), bytes, "{late} rows late");
            }
        }
    }

    #[test]
    fn a_row_that_ended_before_its_last_words_were_written_is_not_there_yet() {
        let ring = RowRing::new(512, 32).unwrap();
        // The interface holds 16 bytes back: row 40 has ended, its last four words are on their way.
        let written = ring.written(words_left(&ring, 40 * 512 - 16), 40);
        assert_eq!(written, 40 * 512 - 16);
        assert!(ring.has(39, written) && !ring.has(40, written));
    }

    #[test]
    fn rows_are_lost_one_row_before_they_are_overwritten() {
        let ring = RowRing::new(100, 8).unwrap();
        assert!(ring.holds(3, 1000) && !ring.holds(3, 1001) && !ring.holds(2, 1000));
    }

    #[test]
    fn rows_lie_behind_each_other_up_to_the_rings_end() {
        let ring = RowRing::new(100, 8).unwrap();
        assert_eq!(ring.slot(0), (0, 8));
        assert_eq!(ring.slot(15), (700, 1));
        assert_eq!(ring.slot(16), (0, 8));
    }

    #[test]
    fn a_ring_that_the_counter_cannot_hold_is_refused() {
        assert!(RowRing::new(752, 32).is_some());
        assert_eq!(RowRing::new(750, 32), None);
        assert_eq!(RowRing::new(752, 400), None);
        assert_eq!(RowRing::new(0, 32), None);
    }
}
