//! Matches whose errors are those of their neighbours: over a map of another year they count for less.

use super::Filter;
use super::estimate::{Estimate, Innovation};
use super::found::Found;
use nalgebra::Matrix2;

/// Time constant of what a map of another year makes matches off by, seconds. Measured over 28 flights between eight years: the errors of two matches
/// are correlated by 0.5 and 0.67 after 1.5 s (patches of 35 and 64 pixels), 0.15 and 0.38 after 6 s, 0.1 and 0.24 after 10 s.
const BY_PLACE_S: f32 = 4.0;

impl Filter {
    /// The covariance of a match by which an estimate takes it.
    pub(super) fn counted(&self, found: &Found) -> Matrix2<f32> {
        self.white(found) + Matrix2::identity() * found.alike_m2
    }

    /// By how much less a match of the newest frame counts, of which each axis has such a variance that neighbours share, square metres: as
    /// many as lie in twice the time constant of their error say what one says.
    pub fn alike_m2(&self, map_variance_m2: f32) -> f32 {
        let apart_s = self.moment.at.since(self.matched_at).max(1) as f32 * 1e-6;
        ((2.0 * BY_PLACE_S / apart_s).max(1.0) - 1.0) * map_variance_m2
    }

    /// The innovation by which an estimate takes a match that was expected, which counts less the more matches before it are off alike.
    pub(super) fn counting(&self, estimate: &Estimate, found: &Found, innovation: Innovation) -> Innovation {
        if found.alike_m2 > 0.0 { estimate.innovation(found, self.counted(found)) } else { innovation }
    }
}
