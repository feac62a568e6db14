//! The core's kernels beside OpenCV's on the same frames: error against the exact area average, and time on the host.
//!
//! | module | what |
//! |---|---|
//! | [`pictures`] | what the frames show |
//! | [`view`] | a camera over level ground: for the core, for the oracle, and as one 3 x 3 matrix for others |
//! | [`case`] | a frame and what is asked of its resampling |
//! | [`cases`] | which frames, sizes and attitudes |
//! | [`matched`] | frames of known ground, to see what a kernel costs the matching |
//! | [`ours`] | every call of the core's kernels |
//! | [`theirs`] | OpenCV's part, done by `tests/timing/compare.py` |
//! | [`score`] | a patch against the exact average |
//! | [`run`] | all of it, in rounds that take turns |
//! | [`tell`] | the table, its JSON and the limits |
//! | [`front`] | accuracy against cost: what is worth its instructions |
//! | [`drawing`] | the front as a picture |
//!
//! The truth of a cell is the oracle's [`exact_area`](plumbline_sim::oracle::exact_area): the frame as piecewise constant
//! pixels, each weighed by the area that the cell's outline, projected into the frame, cuts out of it; polygons clipped in
//! `f64`. Times are minima over repetitions in this run, and only their ratios are judged.

pub mod case;
pub mod cases;
pub mod drawing;
pub mod front;
pub mod matched;
pub mod ours;
pub mod pictures;
pub mod run;
pub mod score;
pub mod tell;
pub mod theirs;
pub mod view;

/// Why it could not be done: one sentence.
pub type Failure = String;

/// Grey pixels, row by row from the top, and their (cols, rows).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grey {
    /// Pixels, `size.0 * size.1`.
    pub pixels: Vec<u8>,
    /// (cols, rows).
    pub size: (u16, u16),
}
