//! A quantity as one picture measures it, and its gate.

use crate::math::squared;

/// A measurement by one picture alone, without prior information.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// Measured value less the one that the picture was rectified with.
    pub off: f32,
    /// Its variance.
    pub variance: f32,
}

/// Gate: largest squared normalised innovation, one degree of freedom; normal errors are beyond once in 100,000.
pub const GATE: f32 = 19.5;

impl Observed {
    /// With the variance of a further error, one sigma, added.
    #[must_use]
    pub fn with_sigma(self, sigma: f32) -> Self {
        Observed { variance: self.variance + squared(sigma), ..self }
    }

    /// Whether it is within the gate of an expected value with this variance; never for invalid numbers.
    pub fn is_plausible(&self, variance: f32) -> bool {
        squared(self.off) <= GATE * (self.variance + variance)
    }
}
