//! Statistics of a peak: its lead, in how many parts of the patch it leads, and its curvature.

use crate::math::sqrt;
use nalgebra::Matrix2;

/// Parts of a patch, three by three.
pub(super) const PARTS: usize = 9;

/// Statistics of the scores at a peak and at its rivals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evidence {
    /// Score of the peak, −1 to 1.
    pub score: f32,
    /// Least lead over a rival; the score itself without one.
    pub lead: f32,
    /// Least lead over its own sigma by the scatter of the parts: a paired t of nine differences.
    pub steadiness: f32,
    /// Four times the peak's score less its four neighbours.
    pub curvature: f32,
}

/// Added to the sigma of a lead: nine equal parts are no infinite t. Chosen: a tenth of a usual lead.
const SIGMA_MIN: f32 = 0.02;

impl Evidence {
    /// From the parts' shares in the scores of the peak and of its rivals.
    pub(super) fn new(peak: &[f32; PARTS], rivals: &[[f32; PARTS]]) -> Self {
        let score = peak.iter().sum();
        let mut evidence = Evidence { score, lead: score, steadiness: f32::MAX, ..Evidence::default() };
        for rival in rivals {
            let ahead: [f32; PARTS] = core::array::from_fn(|part| peak[part] - rival[part]);
            let lead: f32 = ahead.iter().sum();
            let mean = lead / PARTS as f32;
            let squares: f32 = ahead.iter().map(|part| (part - mean) * (part - mean)).sum();
            let sigma = sqrt(PARTS as f32 * squares / (PARTS - 1) as f32);
            evidence.lead = evidence.lead.min(lead);
            evidence.steadiness = evidence.steadiness.min(lead / (sigma + SIGMA_MIN));
        }
        evidence
    }
}

/// Sub-pixel vertex of the parabolas through a peak and its neighbours (left, right, above, below), pixels, and its covariance by leaving
/// out one part at a time (jackknife), square pixels.
pub(super) fn vertex(peak: &[f32; PARTS], beside: &[[f32; PARTS]; 4]) -> ((f32, f32), Matrix2<f32>) {
    let sum = |shares: &[f32; PARTS]| shares.iter().sum::<f32>();
    let all = (sum(peak), beside.each_ref().map(sum));
    let top = |top: f32, [left, right, above, below]: [f32; 4]| {
        use crate::matching::local_maximum::vertex;
        (vertex(left, top, right), vertex(above, top, below))
    };
    let at = top(all.0, all.1);
    let mut covariance = Matrix2::zeros();
    for part in 0..PARTS {
        let beside: [f32; 4] = core::array::from_fn(|side| all.1[side] - beside[side][part]);
        let (col, row) = top(all.0 - peak[part], beside);
        let (col, row) = (col - at.0, row - at.1);
        covariance += Matrix2::new(col * col, col * row, col * row, row * row);
    }
    (at, covariance * ((PARTS - 1) as f32 / PARTS as f32))
}
