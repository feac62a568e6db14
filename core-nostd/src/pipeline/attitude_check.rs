//! Checks a doubted attitude against the perspective of the pictures.
//!
//! Once a match has jumped its position and the attitude are both in doubt, and on a straight leg no later match shows
//! which of them it was. The perspective of a picture does: it shows the tilt alone.

use super::register::{Matched, UNEXPLAINED_MAX_PX};
use super::{Pipeline, Situation};
use crate::matching::Matcher;
use crate::math::{hypot, squared};
use crate::navigation::filter::{Measurement, ShownTilt};
use nalgebra::{Matrix2, Vector2};

/// One sigma of the ground's slope beyond the plane of rectification, along each axis. Chosen: half a metre over a
/// footprint of 100 m, as by an elevation model of 30 m posts, or over ground that is stated to be level.
const SLOPE_SIGMA: f32 = 0.005;
/// Slope that relief about that plane passes for, as a share of relief over half of the patch's shorter side: the
/// curvature of displacements by random relief, of which a match has a share of 0.15 ([`crate::fix`]), is 1.8 times that.
const RELIEF_SHARE: f32 = 0.27;

/// Least share of frames with a valid least-squares match with which the map is of the ground's own year with little
/// doubt. Chosen: over such a map six to nine of ten have one, over one of another year up to two.
const OWN_YEAR_SHARE_MIN: f32 = 0.75;

impl Pipeline<'_> {
    /// Checks the attitude of an accepted match's frame. If it is in doubt, or has to be checked all the same, the filter
    /// is told which tilt the picture shows, for this frame and the next. `unexplained_rad`: by this match. Returns the
    /// sigma of a tilt beyond the situation's, radians, and whether the attitude is in doubt.
    #[inline(never)]
    pub(super) fn check_attitude(
        &mut self,
        situation: &Situation,
        unexplained_rad: f32,
        matched: &Matched,
        measurement: &Measurement,
    ) -> (f32, bool) {
        let prior = self.prior_sigmas();
        let filter = &self.navigation.filter;
        // A frame that was corrected for another tilt than the estimated one has no fix.
        let is_in_doubt = self.is_unexplained(situation, unexplained_rad) || filter.is_tilt_before_tried();
        if !is_in_doubt && !filter.is_attitude_checked(&prior) {
            self.navigation.filter.clear_shown_tilt();
            return (unexplained_rad, false);
        }
        let Some(shown) = self.shown_tilt(situation, matched) else {
            return (unexplained_rad, is_in_doubt || self.navigation.filter.was_attitude_in_doubt());
        };
        let known_rad = UNEXPLAINED_MAX_PX * self.tile.ground_resolution().0 / situation.height_m;
        let filter = &mut self.navigation.filter;
        let shown_rad = filter.tilt_shown(&shown, (is_in_doubt, known_rad), measurement, &prior);
        let unexplained_rad = hypot(unexplained_rad, shown_rad);
        (unexplained_rad, is_in_doubt || self.is_unexplained(situation, unexplained_rad))
    }

    /// Whether the map is of the ground's own year with little doubt.
    pub(super) fn is_own_year(&self) -> bool {
        self.navigation.surface.confirmed_share >= OWN_YEAR_SHARE_MIN
    }

    /// The tilt that the picture of a match shows beyond the one that it was corrected for; `None` if it is not determined,
    /// or the map may be of another year: changed ground makes a curvature of three times its sigma.
    fn shown_tilt(&mut self, situation: &Situation, matched: &Matched) -> Option<ShownTilt> {
        if matched.by_decision || !self.is_own_year() {
            return None;
        }
        let px_m = self.tile.ground_resolution().0;
        let (height_px, size) = (situation.height_m / px_m, self.placement.size);
        let (request, matcher, memory) = self.request(matched.corner, matched.search_px, matched.prior)?;
        let curvature = matcher.curvature(&request, &matched.found, memory)?;
        // Rows run south.
        let [east, north] = [curvature.per_px.x, -curvature.per_px.y].map(|per_px| per_px * height_px);
        let c = curvature.covariance;
        let covariance = Matrix2::new(c[(0, 0)], -c[(0, 1)], -c[(1, 0)], c[(1, 1)]) * squared(height_px);
        let relief = RELIEF_SHARE * situation.relief_m / (0.5 * size.0.min(size.1) as f32 * px_m);
        Some(ShownTilt {
            nadir_per_height: Vector2::new(east, north),
            covariance,
            common_variance: squared(SLOPE_SIGMA) + squared(relief),
        })
    }
}
