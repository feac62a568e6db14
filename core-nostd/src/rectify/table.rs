//! The reducer's table of sums as the integrals read it.

use crate::reduce::Reduction;

/// For every row of boxes, the sums of the boxes left of each border between two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table<'a> {
    /// Exactly [`Reduction::bytes`].
    sums: &'a [u8],
    reduction: Reduction,
}

impl<'a> Table<'a> {
    /// `None` where `reduction` does not leave sums, or another number of them.
    pub(crate) fn new(sums: &'a [u8], reduction: Reduction) -> Option<Self> {
        (reduction.is_boxes() && sums.len() == reduction.bytes()).then_some(Table { sums, reduction })
    }

    /// What the reducer made it by.
    pub(super) fn reduction(&self) -> Reduction {
        self.reduction
    }

    /// The first byte, and bytes from one row to the next.
    #[cfg(feature = "dsp")]
    #[inline(always)]
    pub(super) fn start(&self) -> (*const u8, usize) {
        (self.sums.as_ptr(), self.reduction.stride())
    }

    /// The sums of row `row` from the one left of border `border` on.
    #[inline(always)]
    pub(super) fn sums_from(&self, row: usize, border: usize) -> &'a [u8] {
        self.sums.get(row * self.reduction.stride() + 2 * (border + 1)..).unwrap_or(&[])
    }
}
