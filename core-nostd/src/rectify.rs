//! The frame resampled onto the ground plane, north-up, at the reference's resolution.
//!
//! Two kernels behind one function, chosen by what the reducer kept (module [`reduce`](crate::reduce)), that is by the
//! ratio of a patch pixel to a frame pixel: from 2 on each cell is the exact average of its area, by integrals along its
//! borders over sums of boxes; below, one bilinear reading of the frame.
//!
//! Exact positions (homography, then distortion) are computed at the ends and middles of stretches only, and the
//! parabola through them is followed in fixed point: two reciprocals a stretch instead of two divisions a pixel.
//! Stretches are as long as the position stays within a stated error of the exact one, of cells' corners usually a whole
//! row. Linear interpolation would need four to eight times as many, and their errors are all to one side.
//!
//! A cell is valid when all of it, or its reading, lies in the frame. Valid cells are returned as runs, which is what the
//! matcher iterates over: a footprint is convex, so there is about one run a row.

mod scanline;
mod curvature;
pub(crate) mod nodes;
pub(crate) mod table;
pub(crate) mod stretch;
pub(crate) mod kernels;
mod area;
mod bilinear;

use crate::homography::FrameFromPatch;
use crate::image::Run;
use crate::reduce::Reduction;
use heapless::VecView;
pub use nodes::Node;

/// Why nothing was rectified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RectifyError {
    /// A buffer does not fit the patch, or the patch has no pixels.
    Capacity,
    /// The frame given is not the one the reduction describes.
    Size,
}

/// What a [`Reduction`] has kept of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a>(Kept<'a>);

#[derive(Clone, Copy, Debug)]
enum Kept<'a> {
    Sums(table::Table<'a>),
    Pixels(stretch::Frame<'a>),
}

impl<'a> Source<'a> {
    /// `kept`: exactly [`Reduction::bytes`].
    ///
    /// # Errors
    /// [`RectifyError::Size`] for another number of bytes or a frame of less than 2 x 2.
    pub fn new(kept: &'a [u8], reduction: Reduction) -> Result<Self, RectifyError> {
        Ok(Source(match table::Table::new(kept, reduction) {
            Some(table) => Kept::Sums(table),
            None if reduction.is_boxes() => return Err(RectifyError::Size),
            None => Kept::Pixels(stretch::Frame::new(kept, reduction)?),
        }))
    }
}

/// Rectifies into `patch`, row-major, `map.size()` pixels, row 0 north. Pixels outside every run are 0.
///
/// `runs` is cleared and filled; rows whose runs no longer fit count as invalid. `nodes`: scratch, for averages two a
/// patch column and two more.
///
/// # Errors
/// [`RectifyError`] when buffers and sizes do not belong together. A patch without a single valid pixel is not an
/// error here: `runs` is empty then.
// Not inlined into its caller, whose place in memory is not this module's.
#[inline(never)]
pub fn rectify_into(
    map: &FrameFromPatch<'_>,
    source: Source<'_>,
    patch: &mut [u8],
    nodes: &mut [Node],
    runs: &mut VecView<Run>,
) -> Result<(), RectifyError> {
    let (cols, rows) = (map.size().0 as usize, map.size().1 as usize);
    runs.clear();
    if cols == 0 || rows == 0 {
        return Err(RectifyError::Capacity);
    }
    let patch = patch.get_mut(..cols * rows).ok_or(RectifyError::Capacity)?;
    match source.0 {
        Kept::Sums(table) => area::rectify(map, table, patch, nodes, runs),
        Kept::Pixels(frame) => bilinear::rectify(map, &frame, patch, runs),
    }
}
