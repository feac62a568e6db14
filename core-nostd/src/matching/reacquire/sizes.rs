//! The shifts of a search, the sizes of the reduced pictures, and their memory.

use crate::image::View;

/// Radius of the search around a candidate, pixels: a box, and two for the climb.
pub(crate) const FINE_PX: u16 = 3;
/// Shifts along a side of that search.
pub(super) const FINE: usize = 2 * FINE_PX as usize + 1;
/// Patches longer than this are reduced by boxes of 3 x 3, others by 2 x 2, pixels: 16 x 16 boxes of 3 x 3 are twice
/// the `RANKING` wanted.
pub(crate) const LONG_PX: u16 = 48;
/// Largest boxes: a candidate's error must stay within the fine search.
pub(super) const BOX_MAX: usize = 4;
/// Bytes after the reference's high-pass image that may be read: products are made four shifts at a time, up to three
/// beyond the last one, and are read by words of four. Rounded up to a pair of words.
const READ_AHEAD: usize = 8;

/// The shifts at which a fine search fits the tile: the smallest and the largest of columns and of rows.
pub(super) struct Span {
    pub(super) cols: (i16, i16),
    pub(super) rows: (i16, i16),
}

impl Span {
    /// `None` if there is none.
    pub(super) fn new(patch: &View<'_>, tile: &View<'_>, at: (i32, i32), radius: u16) -> Option<Self> {
        let fine = FINE_PX as i32;
        let radius = radius.min(i16::MAX as u16 / 2) as i32;
        let axis = |at: i32, patch: u16, tile: u16| {
            let last = (tile as i32 - patch as i32 - fine).saturating_sub(at).min(radius);
            let first = fine.saturating_sub(at).max(-radius);
            (first <= last).then_some((first as i16, last as i16))
        };
        let (own, other) = (patch.size(), tile.size());
        Some(Span { cols: axis(at.0, own.0, other.0)?, rows: axis(at.1, own.1, other.1)? })
    }

    /// The shift of the span that is nearest to `shift`.
    pub(super) fn nearest(&self, shift: (i16, i16)) -> (i16, i16) {
        (shift.0.clamp(self.cols.0, self.cols.1), shift.1.clamp(self.rows.0, self.rows.1))
    }
}

/// Sizes of the reduced pictures.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// Pixels along a side of a box.
    pub(super) factor: usize,
    /// The patch, (columns, rows).
    pub(super) own: (usize, usize),
    /// Shifts.
    pub(super) shifts: (usize, usize),
    /// The reference.
    pub(super) other: (usize, usize),
}

impl Sizes {
    pub(super) fn new(factor: usize, patch: (u16, u16), span: &Span) -> Self {
        let boxes = |pixels: u16| pixels as usize / factor;
        // Products come in fours; a column that would need another four alone is dropped.
        let cols = boxes(patch.0);
        let cols = if cols > 4 && cols % 4 == 1 { cols - 1 } else { cols };
        let count = |(first, last): (i16, i16)| (last - first) as usize / factor + 1;
        let (own, shifts) = ((cols, boxes(patch.1)), (count(span.cols), count(span.rows)));
        Sizes { factor, own, shifts, other: (own.0 + shifts.0 - 1, own.1 + shifts.1 - 1) }
    }

    /// Boxes of one pixel, around a candidate.
    pub(super) const fn fine(patch: (u16, u16)) -> Self {
        let own = (patch.0 as usize, patch.1 as usize);
        Sizes { factor: 1, own, shifts: (FINE, FINE), other: (own.0 + FINE - 1, own.1 + FINE - 1) }
    }

    /// Strides of the high-pass images of patch and reference.
    pub(super) const fn strides(&self) -> (usize, usize) {
        (self.own.0.next_multiple_of(4), (self.other.0 + 3).next_multiple_of(4))
    }

    /// Bytes of the patch's high-pass image, of the reference's, and of a buffer for the boxes' greys, later for
    /// energies by columns and scores.
    pub(super) const fn bytes(&self) -> [usize; 3] {
        let (own, other) = self.strides();
        let (grey, scores) = (self.other.0 * self.other.1, 4 * (self.other.0 + self.shifts.0 * self.shifts.1));
        [own * self.own.1, other * self.other.1 + READ_AHEAD, if grey > scores { grey } else { scores }]
    }

    /// Bytes of all of them; the last two are at first the patch with its gaps filled, and its boxes' greys and counts.
    pub(super) const fn working_bytes(&self, patch: (u16, u16)) -> usize {
        let [own, other, rest] = self.bytes();
        let filled = patch.0 as usize * patch.1 as usize + 2 * self.own.0 * self.own.1;
        own + if other + rest > filled { other + rest } else { filled }
    }
}

/// Bytes that a search of ±`radius` needs for a patch of `size`, with the smallest boxes.
pub const fn working_bytes(size: (u16, u16), radius: u16) -> usize {
    let factor = smallest_factor(size);
    let count = 2 * radius as usize / factor + 1;
    let own = (size.0 as usize / factor, size.1 as usize / factor);
    let other = (own.0 + count - 1, own.1 + count - 1);
    let coarse = Sizes { factor, own, shifts: (count, count), other }.working_bytes(size);
    let fine = Sizes::fine(size).working_bytes(size);
    3 + if coarse > fine { coarse } else { fine }
}

pub(super) const fn smallest_factor((cols, rows): (u16, u16)) -> usize {
    if cols > LONG_PX || rows > LONG_PX { 3 } else { 2 }
}
