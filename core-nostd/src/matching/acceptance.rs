//! The acceptance test of a match. A wrong fix is worse than none.

use super::Rejection;
use super::refine::SubPixel;
use super::search::Peak;
use crate::budget::SEARCH_MAX_PX;
use crate::math::{ln, sqrt};

/// Limits of the acceptance test.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AcceptRule {
    /// Fewest valid pixels.
    pub valid_min: u32,
    /// Lowest correlation of the high-pass images at the peak, in the standard deviation that it has over unrelated
    /// ground: the highest of some hundred chance values reaches 3.5.
    pub score_min: f32,
    /// Smallest lead over the second peak, in that standard deviation.
    pub lead_min: f32,
    /// Smallest share of the picture that agrees with the sub-pixel solution.
    pub agreement_min: f32,
    /// Largest sigma of the shift along either axis, pixels.
    pub sigma_max_px: f32,
}

impl Default for AcceptRule {
    fn default() -> Self {
        AcceptRule { valid_min: 100, score_min: 4.5, lead_min: 2.0, agreement_min: 0.5, sigma_max_px: 0.25 }
    }
}

/// Independent high-pass values per valid pixel.
const INDEPENDENT: f32 = 0.5;

impl AcceptRule {
    /// The rule for a search of ±`radius`.
    ///
    /// The highest of M chance values of one deviation is expected at √(2 ln M): 3.49 over the shifts of the largest
    /// search around the prediction, which the rule itself is for, 4.41 over those of ±64. Score and lead limits rise
    /// by the difference, which keeps the margin over chance.
    pub fn among(&self, radius: u16) -> AcceptRule {
        let highest = |radius: f32| sqrt(4.0 * ln(2.0 * radius + 1.0));
        let more = (highest(radius as f32) - highest(SEARCH_MAX_PX as f32)).max(0.0);
        AcceptRule { score_min: self.score_min + more, lead_min: self.lead_min + more, ..*self }
    }

    /// Tests a peak over `valid` pixels.
    ///
    /// A correlation of chance values has the standard deviation 1/√n. Fisher's transformation, with which that of true
    /// ones would have the same, is not used on purpose: near 1 it would turn differences in the surroundings of two
    /// equal places into a clear lead.
    ///
    /// # Errors
    /// [`Rejection`].
    pub fn peak(&self, peak: &Peak, valid: u32) -> Result<(), Rejection> {
        let deviations = sqrt(INDEPENDENT * valid as f32);
        let (score, lead) = (deviations * peak.score, deviations * (peak.score - peak.second));
        if valid < self.valid_min {
            Err(Rejection::FewPixels)
        } else if peak.on_border {
            Err(Rejection::OnBorder)
        } else if score.is_nan() || score < self.score_min {
            Err(Rejection::LowScore)
        } else if lead.is_nan() || lead < self.lead_min {
            Err(Rejection::Ambiguous)
        } else {
            Ok(())
        }
    }

    /// Tests a sub-pixel solution.
    ///
    /// # Errors
    /// [`Rejection::Imprecise`].
    pub fn solution(&self, solution: &SubPixel) -> Result<(), Rejection> {
        // A comparison with NaN is false: an axis with an invalid variance is not precise.
        let is_precise = |axis: usize| solution.joint[(axis, axis)] <= self.sigma_max_px * self.sigma_max_px;
        let precise = is_precise(0) && is_precise(1);
        if precise && solution.agreement >= self.agreement_min { Ok(()) } else { Err(Rejection::Imprecise) }
    }
}
