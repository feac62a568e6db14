//! The matcher that flies: correlation over whole pixels, then least squares around the peak, then the acceptance test.

use super::acceptance::AcceptRule;
use super::perspective::{Curvature, curvature};
use super::reacquire::{self, reacquire};
use super::refine::{RefineError, SubPixel, refine};
use super::search::{self, Peak, search};
use super::{Match, MatchError, Matcher, Prior, Rejection, Request, grey_correlation, valid};
use crate::budget::{PATCH_MAX_PX, REACQUIRE_PX, SCORES_MAX, SEARCH_MAX_PX};
use crate::image::{Run, View};

/// The matcher, with the scores of the shifts around the prediction as working space.
#[derive(Debug)]
pub struct Correlation {
    scores: [i16; SCORES_MAX],
}

impl Correlation {
    /// All zeros: costs no space in an image.
    pub const fn new() -> Self {
        Correlation { scores: [0; SCORES_MAX] }
    }
}

impl Default for Correlation {
    fn default() -> Self {
        Correlation::new()
    }
}

impl Matcher for Correlation {
    /// The high-pass image of the largest window around the prediction, or the pyramids of the longest patches that either
    /// size of boxes serves.
    const WORKING_BYTES: usize = {
        const LONGEST: u16 = PATCH_MAX_PX as u16;
        const FAR: u16 = REACQUIRE_PX as u16;
        const WINDOW: u16 = LONGEST + 2 * SEARCH_MAX_PX as u16;
        let window = search::working_bytes((WINDOW, WINDOW));
        let small = reacquire::working_bytes((LONGEST, LONGEST), FAR);
        let large = reacquire::working_bytes((reacquire::LONG_PX, reacquire::LONG_PX), FAR);
        let pyramid = if small > large { small } else { large };
        if pyramid > window { pyramid } else { window }
    };

    fn locate(&mut self, request: &Request<'_>, memory: &mut [u8]) -> Result<Match, MatchError> {
        let Request { patch, runs, tile, predicted, nadir, radius, prior, rule } = request;
        let located = if *radius as usize > SEARCH_MAX_PX {
            locate_far(patch, runs, (tile, *predicted), *radius, (*prior, rule), memory)?
        } else {
            let window = request.window().ok_or(MatchError::OutsideReference)?;
            locate(patch, runs, &window, *radius, (*prior, rule), (memory, &mut self.scores))?
        };
        Ok(located.at(*nadir, *prior))
    }

    fn curvature(&mut self, request: &Request<'_>, found: &Match, memory: &mut [u8]) -> Option<Curvature> {
        let Request { patch, runs, nadir, radius, prior, .. } = request;
        let refined = found.refined.filter(|_| *radius as usize <= SEARCH_MAX_PX)?;
        curvature((patch, runs), (&request.window()?, *radius), (found.peak, &refined), *nadir, *prior, memory)
    }
}

/// What [`locate`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The whole-pixel peak.
    pub peak: Peak,
    /// Normalised cross-correlation of the greys at the peak and at the second one, 0 where there is none.
    pub grey_correlation: [f32; 2],
    /// The sub-pixel match around the peak.
    pub refined: Result<SubPixel, RefineError>,
    /// The sub-pixel match where it deserves to become a fix, or why it does not.
    pub accepted: Result<SubPixel, Rejection>,
}

impl Located {
    /// Shift of the patch's centre, (columns to the right, rows downwards), pixels: sub-pixel where there is such a
    /// solution, accepted or not, the whole-pixel peak otherwise.
    pub fn shift(&self) -> (f32, f32) {
        self.refined.map_or((self.peak.d_col as f32, self.peak.d_row as f32), |s| (s.d_col, s.d_row))
    }

    /// The answer for the nadir, which lies so many columns to the right of the patch's centre and rows below it. Whether a
    /// solution is precise has been judged where its pixels are.
    fn at(self, nadir: (i16, i16), prior: Prior) -> Match {
        let refined = self.refined.map(|solution| solution.nadir(nadir, prior));
        let peak = (self.peak.d_col, self.peak.d_row);
        Match {
            shift: refined.map_or((peak.0 as f32, peak.1 as f32), |shift| (shift.d_col, shift.d_row)),
            peak,
            grey_correlation: self.grey_correlation,
            refined: self.refined.ok(),
            // What was accepted is what was refined.
            accepted: self.accepted.and_then(|_| refined.map_err(Rejection::from)),
        }
    }
}

/// Searches `patch` in `reference` within ±`radius` around its centre, refines the peak and tests both.
///
/// `bytes`: [`search::working_bytes`] or more, `scores`: space for (2 `radius` + 1)²; both are working space.
///
/// # Errors
/// [`MatchError`] where nothing could be searched.
pub fn locate(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    (prior, rule): (Prior, &AcceptRule),
    (bytes, scores): (&mut [u8], &mut [i16]),
) -> Result<Located, MatchError> {
    let peak = search(patch, runs, reference, radius, bytes, scores)?;
    let refined = refine(patch, runs, reference, radius, &peak, prior, bytes);
    let accepted = tested(rule, &peak, refined, runs);
    let score = |at| grey_correlation(patch, runs, reference, radius, at);
    let second = if peak.second > 0.0 { score(peak.second_at) } else { 0.0 };
    Ok(Located { peak, grey_correlation: [score((peak.d_col, peak.d_row)), second], refined, accepted })
}

/// Searches within ±`radius`, far more than [`locate`] can hold, of the position where the patch was predicted: `at`, the
/// tile's (column, row) under its upper left pixel. The search ends where the tile does. The more shifts there are, the more
/// the peak must reach: see [`AcceptRule::among`].
///
/// `bytes`: [`reacquire::working_bytes`], working space.
///
/// # Errors
/// [`MatchError`] where nothing could be searched.
pub fn locate_far(
    patch: &View<'_>,
    runs: &[Run],
    (tile, at): (&View<'_>, (i32, i32)),
    radius: u16,
    (prior, rule): (Prior, &AcceptRule),
    bytes: &mut [u8],
) -> Result<Located, MatchError> {
    let found = reacquire(patch, runs, tile, at, radius, bytes)?;
    let peak = found.peak;
    let around = reacquire::window(patch, tile, at, found.centre).ok_or(MatchError::OutsideReference)?;
    let refined = refine(patch, runs, &around, reacquire::FINE_PX, &found.local, prior, bytes);
    let refined = refined.map(|solution| SubPixel {
        d_col: solution.d_col + found.centre.0 as f32,
        d_row: solution.d_row + found.centre.1 as f32,
        ..solution
    });
    let accepted = tested(&rule.among(radius), &peak, refined, runs);
    let score = |(col, row): (i16, i16)| {
        let under = tile.window(at.0 + col as i32, at.1 + row as i32, patch.size());
        under.map_or(0.0, |under| grey_correlation(patch, runs, &under, 0, (0, 0)))
    };
    let second = if peak.second > 0.0 { score(peak.second_at) } else { 0.0 };
    Ok(Located { peak, grey_correlation: [score((peak.d_col, peak.d_row)), second], refined, accepted })
}

/// The solution where both it and its peak are good enough.
fn tested(
    rule: &AcceptRule,
    peak: &Peak,
    refined: Result<SubPixel, RefineError>,
    runs: &[Run],
) -> Result<SubPixel, Rejection> {
    rule.peak(peak, valid(runs) as u32)?;
    let solution = refined?;
    rule.solution(&solution)?;
    Ok(solution)
}

impl From<RefineError> for Rejection {
    fn from(error: RefineError) -> Self {
        match error {
            RefineError::TooLittle => Rejection::TooLittle,
            RefineError::Diverged => Rejection::Diverged,
        }
    }
}
