//! The posts of an elevation model as its file has them.

use std::path::Path;

use super::Scaling;

/// Samples with what makes heights of them.
#[expect(missing_debug_implementations, reason = "it holds a function")]
pub struct Posts<'a> {
    /// The file.
    pub path: &'a Path,
    /// Row by row, whichever comes first; NaN where unknown.
    pub samples: &'a [f64],
    /// Posts of a row.
    pub cols: usize,
    /// Metres from a post to the next one, along a row and from row to row.
    pub step_m: [f64; 2],
    /// How samples become heights.
    pub scaling: Scaling,
    /// Metres of a unit of these heights.
    pub unit_m: f64,
    /// Whether a number stands for no data already.
    pub has_nodata: bool,
    /// Whether it says that they are heights: a unit of heights, a vertical system, a scale.
    pub are_declared_heights: bool,
    /// Whether it is an ESRI ASCII grid instead of a GeoTIFF.
    pub is_ascii: bool,
    /// x and y of the post of an index.
    pub place: &'a dyn Fn(usize) -> (f64, f64),
}

impl Posts<'_> {
    /// Metres of a sample.
    #[must_use]
    pub fn height_m(&self, sample: f64) -> f64 {
        self.scaling.value(sample) * self.unit_m
    }
}
