//! How probable it is that a peak is a wrong place, and whether a match is to be believed.

use super::Peak;
use super::evidence::Evidence;
use crate::matching::Rejection;
use crate::matching::refine::SubPixel;
use crate::math::{exp, ln, sqrt};

/// What a match must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Valid pixels at least.
    pub valid_min: u32,
    /// Largest [`risk`].
    pub risk_max: f32,
    /// Least [steadiness](Evidence::steadiness) of a peak's lead. Where ground repeats one copy leads by chance, in some parts of the patch and
    /// not in others. Of the matches that are accepted between years one in twenty is below 1.5, in the same year one in a hundred.
    pub steadiness_min: f32,
}

impl Default for Rule {
    fn default() -> Self {
        Rule { valid_min: 100, risk_max: 1e-4, steadiness_min: 1.5 }
    }
}

/// The log-odds of a wrong place are `ALWAYS` − `EVIDENCE` (n l c u²)^¾ + `PER_SHIFT` ln(shifts/441): n valid pixels, l the lead, c the
/// curvature of the peak, u how [clear](CLEAR_LEAD) the lead is.
///
/// Learnt by logistic regression over 57,000 patches of 21 to 65 pixels a side, each year of eight looked for in every other (5 m a pixel,
/// farmland and lakes), ±4 to ±40 pixels, with half a degree of turn, half a percent of scale and two grey levels of noise; wrong is
/// more than 3 pixels off, and the place is within the search: that it may lie beyond is for the caller to weigh. On halves of the area and
/// years that they were not learnt from the stated is 0.9, 1.2, 1.5 and 2.4 times what was observed at 0.2, 0.06, 0.02 and 0.006, and below
/// 0.003 one of 3,000 patches was wrong, less than stated. Of the powers 3/4, 7/8, 1 and 5/4 the smallest: at the others up to 2, 8 and 16
/// times as many are wrong as stated below 0.001. `cargo xtask compare --matching --features FILE.csv` writes what they were learnt from.
const ALWAYS: f32 = 0.353;
const EVIDENCE: f32 = 0.551;
/// Each shift may be the wrong one, but the lead is over the highest of them all, so that most of their number is in it.
const PER_SHIFT: f32 = 0.235;
/// A lead is clear from this share of the score on, and less so in proportion. Ground that repeats has sharp peaks of which one leads by
/// chance; those patches have next to none, so it is chosen: none that is accepted leads by less than 0.18.
const CLEAR_LEAD: f32 = 0.15;
/// Shifts of a search of ±10 pixels.
const LEARNT_SHIFTS: f32 = 441.0;
/// Least risk that is stated. Of 4,000 patches that were stated below 1e-4, from areas and years that the odds were not learnt from, none was
/// wrong; what lies below a tenth of that nothing has shown.
pub const RISK_MIN: f32 = 1e-5;
/// By how much the log-odds fall where least squares over the greys [hold](holds). Of the 23,000 wrong peaks among those patches
/// one had such a solution (fewer than 2.1 in 10,000, 19 times of 20), of the right ones 100 in 10,000, and 8,900 of those that were looked
/// for in the picture of their own year: 50 times as many, and 4,200. Chosen between them: 400.
const HOLDS: f32 = 6.0;

/// All numbers that a risk is made of, for whoever keeps a record of which they were.
pub const COEFFICIENTS: [f32; 11] = [
    ALWAYS,
    EVIDENCE,
    PER_SHIFT,
    CLEAR_LEAD,
    LEARNT_SHIFTS,
    RISK_MIN,
    HOLDS,
    HELD_PX,
    HELD_SIGMA_PX,
    HELD_SIGMA_MAX_PX,
    AGREEMENT_MIN,
];

/// The probability that the peak of a search over so many shifts is a wrong place, for `valid` pixels; `holds`: whether least
/// squares hold there and at no rival.
pub fn risk(evidence: &Evidence, valid: u32, shifts: u32, holds: bool) -> f32 {
    let Evidence { score, lead, curvature, .. } = *evidence;
    if !(lead > 0.0 && curvature > 0.0) {
        return 1.0;
    }
    let clear = (lead / (CLEAR_LEAD * score)).min(1.0);
    let root = sqrt(valid as f32 * lead * curvature * clear * clear);
    let holds = if holds { HOLDS * clear } else { 0.0 };
    let log_odds = ALWAYS - EVIDENCE * root * sqrt(root) + PER_SHIFT * ln(shifts as f32 / LEARNT_SHIFTS) - holds;
    (1.0 / (1.0 + exp(-log_odds))).max(RISK_MIN)
}

/// Share of the score that its lead must have for the peak to be called weak instead of ambiguous.
const CLEAR: f32 = 0.5;

impl Rule {
    /// Accepts a peak of such a [`risk`] by itself, over `valid` pixels.
    ///
    /// # Errors
    /// [`Rejection`].
    pub fn accepts(&self, peak: &Peak, valid: u32, risk: f32) -> Result<(), Rejection> {
        let Evidence { score, lead, steadiness, .. } = peak.evidence;
        if valid < self.valid_min {
            Err(Rejection::FewPixels)
        } else if peak.on_border {
            Err(Rejection::OnBorder)
        } else if risk <= self.risk_max && steadiness >= self.steadiness_min {
            Ok(())
        } else if risk <= self.risk_max || lead <= CLEAR * score {
            Err(Rejection::Ambiguous)
        } else {
            Err(Rejection::LowScore)
        }
    }
}

/// How far least squares and the peak's top are apart at most along either axis, pixels, and the largest sigma of the former for a curvature of
/// 1. In its own year nine of ten patches are within both, in another year one of 100.
pub(super) const HELD_PX: f32 = 0.5;
const HELD_SIGMA_PX: f32 = 0.5;
/// Largest sigma whatever the curvature, and least share of the picture that agrees. Chosen with them.
const HELD_SIGMA_MAX_PX: f32 = 0.12;
const AGREEMENT_MIN: f32 = 0.5;
/// Largest sigma of a shift along either axis, pixels. Chosen: a third of what is a wrong match.
const SIGMA_MAX_PX: f32 = 1.0;

/// Whether a solution by least squares over the greys, within so many pixels of `top`, is one. Where the ground has changed it is not: its
/// residuals say less than it is off (0.5 pixels between years, where it states 0.16), and the peak itself says better where it lies (0.34).
pub(super) fn holds(solution: &SubPixel, top: (f32, f32), within_px: f32, curvature: f32) -> bool {
    (solution.d_col - top.0).abs() <= within_px
        && (solution.d_row - top.1).abs() <= within_px
        && solution.agreement >= AGREEMENT_MIN
        && is_within(solution, HELD_SIGMA_MAX_PX.min(HELD_SIGMA_PX * curvature))
}

/// Accepts a solution by itself.
///
/// # Errors
/// [`Rejection::Imprecise`].
pub(super) fn precise(solution: &SubPixel) -> Result<(), Rejection> {
    if is_within(solution, SIGMA_MAX_PX) { Ok(()) } else { Err(Rejection::Imprecise) }
}

/// Whether the sigmas of a solution along both axes are at most so many pixels.
pub(super) fn is_within(solution: &SubPixel, sigma_px: f32) -> bool {
    // A comparison with NaN is false: an axis without a variance is not precise.
    (0..2).all(|axis| solution.joint[(axis, axis)] <= sigma_px * sigma_px)
}
