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

#[allow(unsafe_code, reason = "pixels are read without a check each where a stretch of positions has been checked")]
mod bilinear;
#[allow(unsafe_code, reason = "pixels are read without a check each where the ends of a line have been checked")]
mod sampler;
mod segment;

use crate::homography::FrameFromPatch;
use crate::reduce::Reduction;
use heapless::VecView;
pub use sampler::Source;

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

/// How a patch is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sampling {
    /// Readings along each side of a cell.
    pub samples: u16,
}

/// Most readings along the side of a cell; 255 x 16 x 16 readings fit the sums with room.
const SAMPLES_MAX: u16 = 16;
/// Reduced pixels from one reading to the next at most. A reading blends two pixels along each axis, so closer ones only
/// blur: the root mean square to the exact average is smallest between 1 and 1.35.
const APART: f32 = 1.35;
/// Position error allowed between segment ends, in pixels of the reduced frame, when a cell averages an area.
const AREA_TOLERANCE_PX: f32 = 1.0 / 16.0;

impl Sampling {
    /// Enough readings that neighbours are at most 1.35 reduced pixels apart at nadir; one where the output is finer.
    pub fn choose(ratio: f32, reduction: &Reduction) -> Self {
        let apart = ratio / reduction.factor() as f32;
        let samples = crate::math::ceil(apart / APART).clamp(1.0, SAMPLES_MAX as f32);
        Sampling { samples: samples as u16 }
    }
}

/// Binary places of the reciprocal that makes means.
const MEAN_BITS: u32 = 32;

/// Rectifies into `patch`, row-major, `map.size()` pixels, row 0 north. Pixels outside every run are 0.
///
/// `sums`: scratch of at least one entry a patch column. `runs` is cleared and filled; rows whose runs no longer fit
/// count as invalid.
///
/// # Errors
/// [`RectifyError`] when buffers and sizes do not belong together. A patch without a single valid pixel is not an
/// error here: `runs` is empty then.
pub fn rectify_into(
    map: &FrameFromPatch<'_>,
    source: Source<'_>,
    sampling: Sampling,
    patch: &mut [u8],
    sums: &mut [u32],
    runs: &mut VecView<Run>,
) -> Result<(), RectifyError> {
    let (cols, rows) = (map.size().0 as usize, map.size().1 as usize);
    runs.clear();
    if cols == 0 || rows == 0 || !(1..=SAMPLES_MAX).contains(&sampling.samples) {
        return Err(RectifyError::Capacity);
    }
    let patch = patch.get_mut(..cols * rows).ok_or(RectifyError::Capacity)?;
    let sums = sums.get_mut(..cols).ok_or(RectifyError::Capacity)?;
    if sampling.samples == 1 && source.reduction().factor() == 1 {
        return bilinear::rectify(map, &source, patch, runs);
    }
    let tolerance = AREA_TOLERANCE_PX * source.reduction().factor() as f32;
    let line = segment::Line::plan(map, &source, sampling.samples, tolerance);
    // A cell's mean without a division; rounded up, which a sum of 24 bits does not notice.
    let per_cell = (1u64 << MEAN_BITS).div_ceil((sampling.samples * sampling.samples) as u64 * sampler::STEPS as u64);
    for (row, out) in patch.chunks_exact_mut(cols).enumerate() {
        sums.fill(0);
        for sub in 0..sampling.samples {
            let at = row as f32 + (sub as f32 + 0.5) / sampling.samples as f32 - 0.5;
            line.accumulate(map, &source, at, sums);
        }
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
