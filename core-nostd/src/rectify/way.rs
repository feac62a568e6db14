//! Exact frame positions along a row of the patch.

use crate::homography::{AlongRow, FrameFromPatch};

/// A row.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way<'a> {
    /// A homography and nothing else.
    Straight(AlongRow),
    /// With lens distortion or a rolling shutter; the row.
    Bent(&'a FrameFromPatch<'a>, f32),
}

impl<'a> Way<'a> {
    /// Along `row`, which may be a fraction.
    pub(super) fn along(map: &'a FrameFromPatch<'a>, row: f32) -> Self {
        map.along_row(row).map_or(Way::Bent(map, row), Way::Straight)
    }

    /// Frame (col, row) of patch column `col`; `None` beyond the horizon guard and where the lens model folds back.
    // A few times a row, from many places.
    #[inline(never)]
    pub(super) fn position(&self, col: f32) -> Option<(f32, f32)> {
        match self {
            Way::Straight(along) => along.position(col),
            Way::Bent(map, row) => map.frame_position(col, *row),
        }
    }
}
