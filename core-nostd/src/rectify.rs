//! The frame resampled onto the ground plane, north-up, at the reference's resolution.
//!
//! Each output cell is the mean of `samples` x `samples` bilinear readings of the (reduced) frame, spread evenly over
//! the cell: an area average when the output is coarser than the frame, plain bilinear resampling when it is not.
//! A row of readings is cut into segments; the exact position (homography, then distortion) is computed at their ends and
//! middles only, and the parabola through them is followed in fixed point: two reciprocals a segment instead of two
//! divisions a pixel. Segments are as long as the position stays within a stated error of the exact one, usually a whole
//! row. Straight steps would need four to eight times as many, and their errors are all to one side.
//!
//! A cell is valid when all of its readings lie in the frame. Valid cells are returned as runs, which is what the
//! matcher iterates over: a footprint is convex, so there is about one run a row.

#[allow(unsafe_code, reason = "sums are read without a check each where the ends of a border have been checked")]
mod area;
mod nodes;
#[allow(unsafe_code, reason = "pixels are read without a check each where the ends of a line have been checked")]
mod sampler;
mod segment;

pub use crate::dsp::Node;
use crate::homography::FrameFromPatch;
use crate::reduce::Reduction;
use heapless::VecView;

/// A horizontal run of valid pixels of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// Row of the patch.
    pub row: u16,
    /// First valid column.
    pub start: u16,
    /// One past the last valid column.
    pub end: u16,
}

/// Why nothing was rectified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RectifyError {
    /// A buffer does not fit the patch, or the patch has no pixels.
    Capacity,
    /// The frame given is not the one the reduction describes.
    Size,
}

/// Position error allowed between segment ends: half a grey level at the steepest edge an 8-bit picture can have.
const BILINEAR_TOLERANCE_PX: f32 = 1.0 / 512.0;

/// Binary places of the reciprocal that makes means.
const MEAN_BITS: u32 = 32;

/// What a [`Reduction`] has kept of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a>(Kept<'a>);

#[derive(Clone, Copy, Debug)]
enum Kept<'a> {
    Sums(area::Table<'a>),
    Pixels(sampler::Frame<'a>),
}

impl<'a> Source<'a> {
    /// `kept`: exactly [`Reduction::bytes`].
    ///
    /// # Errors
    /// [`RectifyError::Size`] for another number of bytes or a frame of less than 2 x 2.
    pub fn new(kept: &'a [u8], reduction: Reduction) -> Result<Self, RectifyError> {
        Ok(Source(match area::Table::new(kept, reduction) {
            Some(table) => Kept::Sums(table),
            None if reduction.is_boxes() => return Err(RectifyError::Size),
            None => Kept::Pixels(sampler::Frame::new(kept, reduction)?),
        }))
    }
}

/// Rectifies into `patch`, row-major, `map.size()` pixels, row 0 north. Pixels outside every run are 0.
///
/// `runs` is cleared and filled; rows whose runs no longer fit count as invalid.
///
/// # Errors
/// [`RectifyError`] when buffers and sizes do not belong together. A patch without a single valid pixel is not an
/// error here: `runs` is empty then.
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
    let frame = match source.0 {
        Kept::Sums(table) => return area::rectify(map, table, patch, nodes, runs),
        Kept::Pixels(frame) => frame,
    };
    let mut sums = [0u32; 4096];
    let sums = sums.get_mut(..cols).ok_or(RectifyError::Capacity)?;
    let line = segment::Line::plan(map, &frame, 1, BILINEAR_TOLERANCE_PX);
    // A cell's mean without a division; rounded up, which a sum of 24 bits does not notice.
    let per_cell = (1u64 << MEAN_BITS).div_ceil(sampler::STEPS as u64);
    for (row, out) in patch.chunks_exact_mut(cols).enumerate() {
        sums.fill(0);
        line.accumulate(map, &frame, row as f32, sums);
        close_row(row as u16, per_cell, sums, out, runs);
    }
    Ok(())
}

/// Means of a row's sums, and its runs of valid cells.
fn close_row(row: u16, per_cell: u64, sums: &[u32], out: &mut [u8], runs: &mut VecView<Run>) {
    out.fill(0);
    let valid = |&sum: &u32| sum < sampler::INVALID;
    let mut col = 0;
    while let Some(first) = sums.get(col..).and_then(|rest| rest.iter().position(valid)).map(|skip| col + skip) {
        let length = sums.iter().skip(first).take_while(|sum| valid(sum)).count();
        col = first + length;
        // Invalid pixels are 0 without exception: a run that does not fit the list stays blank.
        if runs.push(Run { row, start: first as u16, end: col as u16 }).is_err() {
            return;
        }
        if let Some(pixels) = out.get_mut(first..col) {
            for (pixel, &sum) in pixels.iter_mut().zip(sums.iter().skip(first)) {
                *pixel = ((sum as u64 * per_cell + (1 << (MEAN_BITS - 1))) >> MEAN_BITS) as u8;
            }
        }
    }
}
