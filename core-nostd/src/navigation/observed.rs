//! What one picture says of a quantity, and whether that may be.

use crate::math::squared;

/// A quantity as one picture alone has it, without what was known of it before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// How far it is off what the picture was rectified with.
    pub off: f32,
    /// Variance of that.
    pub variance: f32,
}

/// What is seen may be, where it is within so many sigmas squared of what was expected, of one degree of freedom: normal errors lie
/// beyond once in a hundred thousand.
pub const GATE: f32 = 19.5;

impl Observed {
    /// With one sigma beside its own.
    #[must_use]
    pub fn beside(self, sigma: f32) -> Self {
        Observed { variance: self.variance + squared(sigma), ..self }
    }

    /// Whether it may be, where no more than this variance was expected; not where it is no number.
    pub fn may_be(&self, variance: f32) -> bool {
        squared(self.off) <= GATE * (self.variance + variance)
    }
}
