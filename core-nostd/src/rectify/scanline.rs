//! Exact frame positions along a row of the patch.

use crate::homography::{AlongRow, FrameFromPatch};

/// The map along one row.
#[derive(Clone, Copy, Debug)]
pub(super) enum ScanlineMap<'a> {
    /// A homography and nothing else.
    Linear(AlongRow),
    /// With lens distortion or a rolling shutter; and the row.
    Nonlinear(&'a FrameFromPatch<'a>, f32),
}

impl<'a> ScanlineMap<'a> {
    /// Along `row`, which may be a fraction.
    pub(super) fn along(map: &'a FrameFromPatch<'a>, row: f32) -> Self {
        map.along_row(row).map_or(ScanlineMap::Nonlinear(map, row), ScanlineMap::Linear)
    }

    /// Frame (col, row) of patch column `col`; `None` beyond the horizon guard and where the lens model folds back.
    // A few times a row, from many places.
    #[inline(never)]
    pub(super) fn position(&self, col: f32) -> Option<(f32, f32)> {
        match self {
            ScanlineMap::Linear(along) => along.position(col),
            ScanlineMap::Nonlinear(map, row) => map.frame_position(col, *row),
        }
    }
}
