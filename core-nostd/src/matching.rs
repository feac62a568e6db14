//! Where a rectified patch lies in the reference.
//!
//! [`mod@search`]: masked normalised cross-correlation of details over whole-pixel shifts, [`mod@refine`]: least-squares
//! matching around the peak to hundredths of a pixel with its covariance, [`judge`]: what both must reach to become a
//! fix; [`locate`] does the three. [`mod@reacquire`] searches far from the predicted place, for [`locate_far`].

mod detail;
mod histogram;
pub mod judge;
mod look;
pub mod reacquire;
pub mod refine;
pub mod search;
mod segment;
mod smooth;
mod state;
mod sums;

use crate::rectify::Run;
use judge::{AcceptRule, Doubt};
use reacquire::{FINE_PX, reacquire, window};
use refine::{Prior, RefineError, SubPixel, refine};
use search::{Peak, SearchError, correlation, search};

/// What [`locate`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The whole-pixel peak.
    pub peak: Peak,
    /// Normalised cross-correlation of the greys at the peak and at the second place, 0 where there is none.
    pub scores: [f32; 2],
    /// The sub-pixel match around the peak.
    pub refined: Result<SubPixel, RefineError>,
    /// The same where it deserves to become a fix, or why it does not.
    pub accepted: Result<SubPixel, Rejection>,
}

impl Located {
    /// Shift of the patch's centre, (columns to the right, rows downwards), pixels: sub-pixel where there is such a
    /// solution, accepted or not, the whole-pixel peak otherwise.
    pub fn shift(&self) -> (f32, f32) {
        self.refined.map_or((self.peak.d_col as f32, self.peak.d_row as f32), |s| (s.d_col, s.d_row))
    }
}

/// Why a match is not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// It is doubtful.
    Doubt(Doubt),
    /// It could not be refined.
    Refine(RefineError),
}

/// Searches `patch` in `reference` within ±`radius` around its centre, refines the peak and judges it.
///
/// `bytes`: [`search::room`] or more, `scores`: room for (2 `radius` + 1)²; both are working space.
///
/// # Errors
/// [`SearchError`] where nothing could be searched.
pub fn locate(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    (prior, rule): (Prior, &AcceptRule),
    (bytes, scores): (&mut [u8], &mut [i16]),
) -> Result<Located, SearchError> {
    let peak = search(patch, runs, reference, radius, bytes, scores)?;
    let refined = refine(patch, runs, reference, radius, &peak, prior, bytes);
    let accepted = judged(rule, &peak, refined, runs);
    let score = |at| correlation(patch, runs, reference, radius, at);
    let second = if peak.second > 0.0 { score(peak.second_at) } else { 0.0 };
    Ok(Located { peak, scores: [score((peak.d_col, peak.d_row)), second], refined, accepted })
}

/// The same within ±`radius`, far more than [`locate`] can hold, of the place where the patch was predicted: `at`, the tile's
/// (column, row) under its upper left pixel. The search ends where the tile does. The more shifts there are, the more the
/// peak must reach: see [`AcceptRule::among`].
///
/// `bytes`: [`reacquire::room`], working space.
///
/// # Errors
/// [`SearchError`] where nothing could be searched.
pub fn locate_far(
    patch: &View<'_>,
    runs: &[Run],
    (tile, at): (&View<'_>, (i32, i32)),
    radius: u16,
    (prior, rule): (Prior, &AcceptRule),
    bytes: &mut [u8],
) -> Result<Located, SearchError> {
    let found = reacquire(patch, runs, tile, at, radius, bytes)?;
    let peak = found.peak;
    let around = window(patch, tile, at, found.centre).ok_or(SearchError::ReferenceTooSmall)?;
    let refined = refine(patch, runs, &around, FINE_PX, &found.local, prior, bytes).map(|solution| SubPixel {
        d_col: solution.d_col + found.centre.0 as f32,
        d_row: solution.d_row + found.centre.1 as f32,
        ..solution
    });
    let accepted = judged(&rule.among(radius), &peak, refined, runs);
    let score = |(col, row): (i16, i16)| {
        let under = tile.window(at.0 + col as i32, at.1 + row as i32, patch.size());
        under.map_or(0.0, |under| correlation(patch, runs, &under, 0, (0, 0)))
    };
    let second = if peak.second > 0.0 { score(peak.second_at) } else { 0.0 };
    Ok(Located { peak, scores: [score((peak.d_col, peak.d_row)), second], refined, accepted })
}

/// The solution where both it and its peak are good enough.
fn judged(
    rule: &AcceptRule,
    peak: &Peak,
    refined: Result<SubPixel, RefineError>,
    runs: &[Run],
) -> Result<SubPixel, Rejection> {
    rule.peak(peak, valid(runs) as u32).map_err(Rejection::Doubt)?;
    let solution = refined.map_err(Rejection::Refine)?;
    rule.solution(&solution).map_err(Rejection::Doubt)?;
    Ok(solution)
}

/// Valid pixels of a patch.
fn valid(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.end.saturating_sub(run.start) as usize).sum()
}

/// A grey picture, or a window of one, as the matcher reads it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    pixels: &'a [u8],
    size: (u16, u16),
    stride: usize,
}

impl<'a> View<'a> {
    /// Row-major picture of `size` (cols, rows); `None` when there are fewer pixels than that.
    pub fn new(pixels: &'a [u8], size: (u16, u16)) -> Option<Self> {
        let stride = size.0 as usize;
        (pixels.len() >= stride * size.1 as usize).then_some(View { pixels, size, stride })
    }

    /// The window of `size` whose top left pixel is (`col`, `row`); `None` when it does not lie wholly inside.
    pub fn window(&self, col: i32, row: i32, size: (u16, u16)) -> Option<View<'a>> {
        let fits = |at: i32, length: u16, limit: u16| at >= 0 && at.saturating_add(length as i32) <= limit as i32;
        if size.0 == 0 || size.1 == 0 || !fits(col, size.0, self.size.0) || !fits(row, size.1, self.size.1) {
            return None;
        }
        let first = row as usize * self.stride + col as usize;
        Some(View { pixels: self.pixels.get(first..)?, size, stride: self.stride })
    }

    /// (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// `length` pixels of `row` from `col` on; `None` outside the view.
    #[inline]
    pub fn run(&self, row: usize, col: usize, length: usize) -> Option<&'a [u8]> {
        if row >= self.size.1 as usize || col.checked_add(length).is_none_or(|end| end > self.size.0 as usize) {
            return None;
        }
        self.pixels.get(row * self.stride + col..row * self.stride + col + length)
    }

    /// The pixels of `row` from `col` on, then those of the rows behind it and whatever follows; empty outside.
    #[inline]
    fn from(&self, row: usize, col: usize) -> &'a [u8] {
        self.pixels.get(row * self.stride + col..).unwrap_or(&[])
    }
}
