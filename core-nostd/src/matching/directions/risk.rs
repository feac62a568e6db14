//! Probability that a peak is a wrong match, and the acceptance test.

use super::Peak;
use super::evidence::Evidence;
use crate::matching::Rejection;
use crate::matching::refine::SubPixel;
use crate::math::{exp, ln, sqrt};

/// Thresholds of the acceptance test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Least number of valid pixels.
    pub valid_min: u32,
    /// Largest [`risk`].
    pub risk_max: f32,
    /// Least [steadiness](Evidence::steadiness) of the peak's lead. Over repetitive ground one copy leads by chance, in some parts of the
    /// patch and not in others. Of the matches that are accepted between years one in twenty is below 1.5, in the same year one in a
    /// hundred.
    pub steadiness_min: f32,
}

impl Default for Rule {
    fn default() -> Self {
        Rule { valid_min: 100, risk_max: 1e-4, steadiness_min: 1.5 }
    }
}

/// Log-odds of a wrong match: `INTERCEPT` − `SLOPE` (n l c u²)^¾ + `PER_SHIFT` ln(shifts/441), with n the valid pixels, l the lead, c the
/// curvature of the peak and u how [clear](CLEAR_LEAD) the lead is.
///
/// Fitted by logistic regression over 57,000 patches of 21 to 65 pixels a side, each of eight years matched against every other (5 m a
/// pixel, farmland and lakes), ±4 to ±40 pixels, with half a degree of rotation, half a percent of scale and two grey levels of noise;
/// wrong is more than 3 pixels off, given that the true shift is within the search: the caller has to weigh that it may lie beyond. On
/// halves of the area and of the years that were not used for the fit the stated risk is 0.9, 1.2, 1.5 and 2.4 times the observed one at
/// 0.2, 0.06, 0.02 and 0.006, and below 0.003 one of 3,000 patches was wrong, less than stated. Of the exponents 3/4, 7/8, 1 and 5/4 the
/// smallest: with the others up to 2, 8 and 16 times as many are wrong as stated below 0.001. `cargo xtask compare --matching --features
/// FILE.csv` writes the data of the fit.
const INTERCEPT: f32 = 0.353;
const SLOPE: f32 = 0.551;
/// Each shift is a chance of a wrong peak, but the lead is over the highest of them all, so that most of their number is in it.
const PER_SHIFT: f32 = 0.235;
/// A lead is clear from this share of the score on, and proportionally less below. Repetitive ground has sharp peaks of which one leads by
/// chance; the patches of the fit have next to none, so it is chosen: no accepted one leads by less than 0.18.
const CLEAR_LEAD: f32 = 0.15;
/// Shifts of a search of ±10 pixels.
const LEARNT_SHIFTS: f32 = 441.0;
/// Least risk that is stated. Of 4,000 patches with less than 1e-4, from areas and years that were not used for the fit, none was wrong;
/// nothing supports values below a tenth of that.
pub const RISK_MIN: f32 = 1e-5;
/// Decrease of the log-odds by a [valid](holds) least-squares solution. Of the 23,000 wrong peaks among those patches one had such a
/// solution (fewer than 2.1 in 10,000 with 95 % confidence), of the right ones 100 in 10,000, and 8,900 of those that were matched in the
/// picture of their own year: likelihood ratios of 50 and 4,200. Chosen between them: 400.
const VALID_LOG_ODDS: f32 = 6.0;

/// All constants behind a risk, for a record of which ones were in use.
pub const COEFFICIENTS: [f32; 11] = [
    INTERCEPT,
    SLOPE,
    PER_SHIFT,
    CLEAR_LEAD,
    LEARNT_SHIFTS,
    RISK_MIN,
    VALID_LOG_ODDS,
    VALID_OFFSET_PX,
    VALID_SIGMA_PX,
    VALID_SIGMA_MAX_PX,
    AGREEMENT_MIN,
];

/// The probability that the peak of a search over so many `shifts` is a wrong match, 1e-5 to 1. `valid`: number of valid pixels. `holds`:
/// whether least squares is valid there and at no rival.
pub fn risk(evidence: &Evidence, valid: u32, shifts: u32, holds: bool) -> f32 {
    let Evidence { score, lead, curvature, .. } = *evidence;
    if !(lead > 0.0 && curvature > 0.0) {
        return 1.0;
    }
    let clear = (lead / (CLEAR_LEAD * score)).min(1.0);
    let root = sqrt(valid as f32 * lead * curvature * clear * clear);
    let holds = if holds { VALID_LOG_ODDS * clear } else { 0.0 };
    let log_odds = INTERCEPT - SLOPE * root * sqrt(root) + PER_SHIFT * ln(shifts as f32 / LEARNT_SHIFTS) - holds;
    (1.0 / (1.0 + exp(-log_odds))).max(RISK_MIN)
}

/// A lead above this share of the score with too large a risk is a weak peak, not an ambiguous one.
const WEAK_LEAD: f32 = 0.5;

impl Rule {
    /// The acceptance test of a single match: a peak of such a [`risk`], over `valid` pixels.
    ///
    /// # Errors
    /// [`Rejection`]: the reason.
    pub fn accepts(&self, peak: &Peak, valid: u32, risk: f32) -> Result<(), Rejection> {
        let Evidence { score, lead, steadiness, .. } = peak.evidence;
        if valid < self.valid_min {
            Err(Rejection::FewPixels)
        } else if peak.on_border {
            Err(Rejection::OnBorder)
        } else if risk <= self.risk_max && steadiness >= self.steadiness_min {
            Ok(())
        } else if risk <= self.risk_max || lead <= WEAK_LEAD * score {
            Err(Rejection::Ambiguous)
        } else {
            Err(Rejection::LowScore)
        }
    }
}

/// Tolerances of a valid least-squares solution: largest distance from the peak's vertex along either axis, pixels, and largest sigma for a
/// curvature of 1, pixels. In its own year nine of ten patches are within both, in another year one of 100.
pub(super) const VALID_OFFSET_PX: f32 = 0.5;
const VALID_SIGMA_PX: f32 = 0.5;
/// Largest sigma whatever the curvature, pixels, and least share of agreeing pixels. Chosen with them.
const VALID_SIGMA_MAX_PX: f32 = 0.12;
const AGREEMENT_MIN: f32 = 0.5;
/// Largest sigma of an accepted shift along either axis, pixels. Chosen: a third of what is a wrong match.
const SIGMA_MAX_PX: f32 = 1.0;

/// Whether a least-squares solution over the greys is valid: within `within_px` of the peak at `top`, precise, and in agreement. Where the
/// ground has changed it is not: its residuals understate its error (0.5 pixels between years, where it states 0.16), and the peak's vertex
/// is more accurate (0.34).
pub(super) fn holds(solution: &SubPixel, top: (f32, f32), within_px: f32, curvature: f32) -> bool {
    (solution.d_col - top.0).abs() <= within_px
        && (solution.d_row - top.1).abs() <= within_px
        && solution.agreement >= AGREEMENT_MIN
        && is_within(solution, VALID_SIGMA_MAX_PX.min(VALID_SIGMA_PX * curvature))
}

/// Whether a solution is precise enough for a single match.
///
/// # Errors
/// [`Rejection::Imprecise`].
pub(super) fn precise(solution: &SubPixel) -> Result<(), Rejection> {
    if is_within(solution, SIGMA_MAX_PX) { Ok(()) } else { Err(Rejection::Imprecise) }
}

/// Whether the sigmas of a solution along both axes are at most `sigma_px`.
pub(super) fn is_within(solution: &SubPixel, sigma_px: f32) -> bool {
    // A comparison with NaN is false: an axis without a variance is not precise.
    (0..2).all(|axis| solution.joint[(axis, axis)] <= sigma_px * sigma_px)
}
