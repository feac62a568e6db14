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
    /// Fisher-transformed lead of the peak over the second one, in its own standard deviations.
    pub lead_min: f32,
    /// Largest sigma of the shift along either axis, pixels.
    pub sigma_max_px: f32,
}

impl Default for AcceptRule {
    fn default() -> Self {
        AcceptRule { valid_min: 100, score_min: 0.35, lead_min: 3.0, sigma_max_px: 0.5 }
    }
}

/// Independent pixels per valid pixel: neighbours of an averaged picture share half of what they show.
const INDEPENDENT: f32 = 0.25;

impl AcceptRule {
    /// Accepts a peak, or says what is wrong with it.
    ///
    /// The lead over the second peak is compared after Fisher's transformation atanh r, whose spread 1/√(n − 3) does
    /// not depend on the correlation itself: a plain ratio would be too lax for small patches and too strict for
    /// large ones.
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
        let deviations = crate::math::sqrt((INDEPENDENT * valid as f32 - 3.0).max(1.0));
        let lead = (atanh(peak.score) - atanh(peak.second)) * deviations;
        if lead.is_nan() || lead < self.lead_min {
            return Err(Doubt::Ambiguous);
        }
        Ok(())
    }

    /// Accepts a sub-pixel solution.
    ///
    /// # Errors
    /// [`Doubt::Imprecise`].
    pub fn solution(&self, solution: &SubPixel) -> Result<(), Doubt> {
        let variance = solution.covariance[(0, 0)].max(solution.covariance[(1, 1)]);
        if variance.is_nan() || variance > self.sigma_max_px * self.sigma_max_px {
            return Err(Doubt::Imprecise);
        }
        Ok(())
    }
}

fn atanh(r: f32) -> f32 {
    let r = r.clamp(-0.999, 0.999);
    0.5 * crate::math::ln((1.0 + r) / (1.0 - r))
}
