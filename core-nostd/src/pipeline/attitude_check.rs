//! Checks a doubted attitude against the perspective of the pictures.
//!
//! Once a match has jumped its position and the attitude are both in doubt, and on a straight leg no later match shows
//! which of them it was. The perspective of a picture does: it shows the tilt alone.

use super::register::{Matched, UNEXPLAINED_MAX_PX};
use super::{Pipeline, Situation};
use crate::matching::Matcher;
use crate::math::squared;
use crate::navigation::filter::{Measurement, ShownTilt};
use nalgebra::{Matrix2, Vector2};

/// One sigma of the ground's slope beyond the plane of rectification, along each axis. Chosen: half a metre over a
/// footprint of 100 m, as by an elevation model of 30 m posts, or over ground that is stated to be level.
const SLOPE_SIGMA: f32 = 0.005;

impl Pipeline<'_> {
    /// Whether the attitude of an accepted match's frame is in doubt. If it is, or was a moment ago, the filter is told
    /// which tilt the picture shows, for the next frames. `unexplained_rad`: by this match.
    #[inline(never)]
    pub(super) fn is_attitude_doubted(
        &mut self,
        situation: &Situation,
        unexplained_rad: f32,
        matched: &Matched,
        measurement: &Measurement,
    ) -> bool {
        let is_in_doubt = self.is_unexplained(situation, unexplained_rad);
        if !is_in_doubt && !self.navigation.filter.was_in_doubt() {
            self.navigation.filter.attitude_is_known();
            return false;
        }
        let Some(shown) = self.shown_tilt(situation, matched) else { return true };
        let known_rad = UNEXPLAINED_MAX_PX * self.tile.ground_resolution().0 / situation.height_m;
        let prior = self.prior_sigmas();
        self.navigation.filter.attitude_shown(&shown, (is_in_doubt, known_rad), measurement, &prior);
        is_in_doubt || self.is_unexplained(situation, unexplained_rad)
    }

    /// The tilt that the picture of a match shows beyond the one that it was corrected for.
    fn shown_tilt(&mut self, situation: &Situation, matched: &Matched) -> Option<ShownTilt> {
        if matched.by_decision {
            return None;
        }
        let height_px = situation.height_m / self.tile.ground_resolution().0;
        let (request, matcher, memory) = self.request(matched.corner, matched.search_px, matched.prior)?;
        let curvature = matcher.curvature(&request, &matched.found, memory)?;
        // Rows run south.
        let [east, north] = [curvature.per_px.x, -curvature.per_px.y].map(|per_px| per_px * height_px);
        let c = curvature.covariance;
        let covariance = Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]) * squared(height_px);
        Some(ShownTilt {
            along: Vector2::new(east, north),
            covariance: covariance + Matrix2::identity() * squared(SLOPE_SIGMA),
        })
    }
}
