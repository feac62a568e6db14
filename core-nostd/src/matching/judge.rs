//! Whether a match deserves to become a fix. A wrong fix is worse than none.

use super::refine::SubPixel;
use super::search::Peak;

/// Why a match was not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Doubt {
    /// Fewer valid pixels than a distinctive template needs.
    FewPixels,
    /// The peak lies on the border of the search.
    OnBorder,
    /// The correlation is too low for the number of pixels.
    LowScore,
    /// Another place is almost as good.
    Ambiguous,
    /// The sub-pixel solution's own sigma is too large.
    Imprecise,
}

/// What a match must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AcceptRule {
    /// Valid pixels at least.
    pub valid_min: u32,
    /// Correlation at the peak at least.
    pub score_min: f32,
    /// Fisher-transformed lead of the peak over the second one, in its own standard deviations, below which the two
    /// have to contest.
    pub lead_min: f32,
    /// How much larger the rival's scale of residuals must be in a contest.
    pub contest_min: f32,
    /// Share of the valid pixels that must agree: the weight of the sub-pixel solution.
    pub agreement_min: f32,
    /// Largest residual as a share of the patch's own spread: above it the reference explains next to nothing.
    pub unexplained_max: f32,
    /// Largest sigma of the shift along either axis, pixels.
    pub sigma_max_px: f32,
}

impl Default for AcceptRule {
    fn default() -> Self {
        AcceptRule {
            valid_min: 100,
            score_min: 0.5,
            lead_min: 4.0,
            contest_min: 1.5,
            agreement_min: 0.5,
            unexplained_max: 0.8,
            sigma_max_px: 0.5,
        }
    }
}

/// Independent pixels per valid pixel: neighbours of an averaged picture share half of what they show.
const INDEPENDENT: f32 = 0.25;

impl AcceptRule {
    /// Accepts a peak by itself, or says what is wrong with it.
    ///
    /// # Errors
    /// [`Doubt`].
    pub fn peak(&self, peak: &Peak, valid: u32) -> Result<(), Doubt> {
        if valid < self.valid_min {
            return Err(Doubt::FewPixels);
        }
        if peak.on_border {
            return Err(Doubt::OnBorder);
        }
        if peak.score.is_nan() || peak.score < self.score_min {
            return Err(Doubt::LowScore);
        }
        Ok(())
    }

    /// Whether the peak leads the second one by so much that they need not contest.
    ///
    /// The lead is taken after Fisher's transformation atanh r, whose spread 1/√(n − 3) does not depend on the
    /// correlation itself: a plain ratio would be too lax for small patches and too strict for large ones.
    pub fn leads(&self, peak: &Peak, valid: u32) -> bool {
        let deviations = crate::math::sqrt((INDEPENDENT * valid as f32 - 3.0).max(1.0));
        (atanh(peak.score) - atanh(peak.second)) * deviations >= self.lead_min
    }

    /// Which of two solutions explains the picture clearly better: `true` for the first, `false` for the second.
    ///
    /// # Errors
    /// [`Doubt::Ambiguous`] when neither does.
    pub fn contest(&self, first: &SubPixel, second: &SubPixel) -> Result<bool, Doubt> {
        // Residuals per agreeing pixel: a solution must not win by calling most of the picture changed.
        let cost = |s: &SubPixel| s.residual / s.weight.max(1.0);
        let (first, second) = (cost(first), cost(second));
        if second >= self.contest_min * first {
            Ok(true)
        } else if first >= self.contest_min * second {
            Ok(false)
        } else {
            Err(Doubt::Ambiguous)
        }
    }

    /// Accepts a sub-pixel solution by itself.
    ///
    /// # Errors
    /// [`Doubt::Imprecise`].
    pub fn solution(&self, solution: &SubPixel, valid: u32) -> Result<(), Doubt> {
        let variance = solution.covariance[(0, 0)].max(solution.covariance[(1, 1)]);
        let agrees = solution.weight >= self.agreement_min * valid as f32;
        let explains = solution.residual <= self.unexplained_max * solution.texture;
        if variance.is_nan() || variance > self.sigma_max_px * self.sigma_max_px || !agrees || !explains {
            return Err(Doubt::Imprecise);
        }
        Ok(())
    }
}

fn atanh(r: f32) -> f32 {
    let r = r.clamp(-0.999, 0.999);
    0.5 * crate::math::ln((1.0 + r) / (1.0 - r))
}
